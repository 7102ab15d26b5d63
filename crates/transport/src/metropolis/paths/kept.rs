//! Paths between passes: what finds all of a path again.

use super::path::{Path, Sensed, Source, Turn};
use super::tracer::Tracer;
use crate::path_space::{CameraEnd, LightEnd};
use crate::saved::saved;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::LightId;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A path as numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kept {
    u_lambda: f32,
    time: f32,
    light: u32,
    /// Place, normal and direction of x₀, and what it emits.
    place: [Vec3; 3],
    le: [f32; 4],
    vertices: Vec<Found>,
    /// Film and lens.
    numbers: [f32; 4],
    /// Origin and direction of the camera's ray.
    ray: [Vec3; 2],
}
saved!(Kept { u_lambda, time, light, place, le, vertices, numbers, ray });

/// The ray that found a vertex, and the class of the Dirac lobe by which the path goes on, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    ray: [Vec3; 2],
    t_max: f32,
    lobe: u8,
}
saved!(Found { ray, t_max, lobe });

impl Kept {
    pub(super) fn new(path: &Path) -> Kept {
        let end = &path.source.end;
        let found = |t: &Turn| Found {
            ray: [t.node.ray.o, t.node.ray.d],
            t_max: t.node.t_max,
            lobe: t.dirac.map_or(Lobes::NONE, |d| d.lobe).0,
        };
        let Sensed { film, lens, ray, .. } = path.sensed;
        Kept {
            u_lambda: path.u_lambda,
            time: path.time,
            light: end.light.0,
            place: [end.p, end.n, end.w],
            le: path.source.le.0,
            vertices: path.turns.iter().map(found).collect(),
            numbers: [film.x, film.y, lens.x, lens.y],
            ray: [ray.o, ray.d],
        }
    }

    /// The path; `None` if it is not there in this scene.
    pub(super) fn path<'a>(&self, tracer: &mut Tracer<'a>) -> Option<Path<'a>> {
        let (scene, time) = (tracer.scene, self.time);
        let lambda = Wavelengths::sample_for(scene.mode, self.u_lambda);
        if self.light as usize >= scene.lights.len() || self.vertices.is_empty() {
            return None;
        }
        let mut turns = Vec::with_capacity(self.vertices.len());
        for found in &self.vertices {
            let ray = Ray { o: found.ray[0], d: found.ray[1], time };
            turns.push(Turn { node: tracer.node(ray, found.t_max, &lambda)?, dirac: None });
        }
        let [p, n, w] = self.place;
        let end = LightEnd::new(scene, tracer.emission, LightId(self.light), p, n, w);
        let source = Source { end, le: Spectrum(self.le) };
        let [x, y, u, v] = self.numbers;
        let ray = Ray { o: self.ray[0], d: self.ray[1], time };
        let end = CameraEnd::new(scene, &ray);
        let sensed = Sensed { film: Vec2::new(x, y), lens: Vec2::new(u, v), ray, end };
        // Dirac lobes are turned from the eye's side.
        for i in 0..turns.len() {
            let lobe = Lobes(self.vertices[i].lobe);
            if !lobe.is_empty() {
                let node = turns[i].node.clone();
                let to_eye = match turns.get(i + 1) {
                    Some(next) => super::path::toward(node.p(), next.node.p()),
                    None => -ray.d,
                };
                turns[i].dirac = tracer.turn(&node, to_eye, lobe, Mode::Radiance)?.dirac;
            }
        }
        let measure = tracer.measure;
        Path::new(&measure, (self.u_lambda, time), source, turns, sensed)
    }
}
