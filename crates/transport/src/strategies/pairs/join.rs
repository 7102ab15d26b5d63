//! What the weight of a pair's path depends on: densities along both sides, and where they are joined.

use super::Pairs;
use crate::path_space::{CameraEnd, Departure, LightEnd, Vertex};
use crate::strategies::weight::{Joint, Link, strategy_weight};

/// How the two sides of a path are joined, seen from the joint: densities per solid angle (on
/// to the other side, back on its own) at the last vertices.
#[derive(Clone, Copy)]
pub(super) struct Join {
    pub(super) at_light: (f64, f64),
    pub(super) at_eye: (f64, f64),
    /// Whether the last vertices scatter by Dirac lobes: only where nothing is joined.
    pub(super) light_delta: bool,
    pub(super) eye_delta: bool,
    /// That nothing happens on the way between them, as [`Vertex::passing`].
    pub(super) passing: f64,
}

impl Default for Join {
    fn default() -> Join {
        let none = (0.0, 0.0);
        Join { at_light: none, at_eye: none, light_delta: false, eye_delta: false, passing: 1.0 }
    }
}

impl Pairs<'_> {
    /// w_{s,t} of the path end, `light`, `eye` (from the lens on), camera.
    pub(super) fn weight(
        &mut self,
        s: usize,
        (light, eye): (&[Vertex], &[Vertex]),
        end: &LightEnd,
        camera: &CameraEnd,
        join: &Join,
    ) -> f32 {
        if !self.settings.weighted {
            return 1.0;
        }
        let (scene, lights) = (self.scene, self.lights);
        let (a, b) = (light.len(), eye.len());
        let Some(x1) = light.first().or(eye.last()) else { return 1.0 };
        // Back from vertex i toward the one before it, as the path goes there.
        let back = |path: &[Vertex], i: usize, at_join: f64| match i + 1 == path.len() {
            true => at_join,
            false => path[i].pdf_rev,
        };
        // To a vertex over the segment of `way`.
        let g = |from: &Vertex, to: &Vertex, way: f64| to.arriving_from(from.surface.p) * way;
        let arrival = |d: &Departure, v: &Vertex| d.density(v) * join.passing;
        let first = light.first().map_or(join.passing, |y| y.passing);
        let last_way = eye.first().map_or(join.passing, |z| z.passing);

        self.links.clear();
        let to_light = match a {
            0 => join.at_eye.0,
            _ => back(light, 0, join.at_light.1),
        };
        let eye_0 = to_light * end.area(x1.surface.p) * first;
        self.links.push(Link { light: end.emission, eye: eye_0, delta: false });
        for (i, y) in light.iter().enumerate() {
            let from_eye = match (light.get(i + 1), eye.last()) {
                (Some(next), _) => back(light, i + 1, join.at_light.1) * g(next, y, next.passing),
                (None, Some(z)) => join.at_eye.0 * g(z, y, join.passing),
                (None, None) => arrival(&camera.departure, y),
            };
            let delta = if i + 1 == a { join.light_delta } else { y.delta };
            self.links.push(Link { light: y.arrival, eye: from_eye, delta });
        }
        for (i, z) in eye.iter().enumerate().rev() {
            let from_light = match (eye.get(i + 1), light.last()) {
                (Some(next), _) => back(eye, i + 1, join.at_eye.1) * g(next, z, next.passing),
                (None, Some(y)) => join.at_light.0 * g(y, z, join.passing),
                (None, None) => arrival(&end.departure, z),
            };
            let delta = if i + 1 == b { join.eye_delta } else { z.delta };
            self.links.push(Link { light: from_light, eye: z.arrival, delta });
        }
        let (last, to_lens) = match (eye.first(), light.last()) {
            (Some(z), _) => (z, back(eye, 0, join.at_eye.1)),
            (None, Some(y)) => (y, join.at_light.0),
            (None, None) => return 1.0,
        };
        let lens_light = to_lens * camera.area(last.surface.p) * last_way;
        self.links.push(Link { light: lens_light, eye: camera.lens, delta: false });

        let joint = Joint {
            next_event: end.next_event(scene, lights, x1),
            connection: camera.connection,
            hittable_light: end.hittable,
            hittable_lens: camera.aperture.is_some(),
            seen: camera.seen,
            light_paths: self.light_paths,
        };
        strategy_weight(&self.links, &joint, s, self.settings.mis, &mut self.densities)
    }
}
