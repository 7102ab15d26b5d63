//! The estimator of one camera path with layers by path: (1) of [`super::integrate`] over the
//! vertices of a whole subpath, whose classes are known at each of them.
//!
//! Slower than without layers, and other samples of the same picture.

use super::integrate::Integrator;
use crate::features::describe;
use crate::method::PassStats;
use crate::path_space::{
    self, CameraEnd, Closing, LightEnd, Start, Subpath, Tracks, Vertex, Walker, emission_table,
};
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_film::path_expression::PathClasses;
use kaustika_math::Vec3;
use kaustika_scene::bsdf::Mode;
use kaustika_scene::{LightId, LightSelection};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Room for one path.
pub(super) struct ClassRoom<'a> {
    eye: Subpath<'a>,
    tracks: Tracks<'a>,
    emission: LightSelection,
}

impl<'a> ClassRoom<'a> {
    /// For a picture with layers of these classes.
    pub(super) fn new(integrator: &Integrator<'a>, classes: &'a PathClasses) -> ClassRoom<'a> {
        let scene = integrator.scene();
        let tracks = Tracks::new(classes, scene);
        ClassRoom { eye: Subpath::default(), tracks, emission: emission_table(scene) }
    }
}

/// Estimates the pixels of a band.
pub(super) fn trace_classes<'a>(
    integrator: &Integrator<'a>,
    index: u64,
    room: &mut ClassRoom<'a>,
    band: &mut PixelBand,
) -> PassStats {
    let mut stats = PassStats::default();
    let region = integrator.frame().region;
    for y in 0..band.height() {
        for x in 0..band.width() {
            let pixel = [region[0] + x, region[1] + band.y + y];
            let record = integrator.sample_classes(pixel, index, room, &mut stats);
            band.add(x, y, &record);
            band.add_paths(x, y, record.weight, room.tracks.found());
        }
    }
    stats
}

impl<'a> Integrator<'a> {
    fn sample_classes(
        &self,
        pixel: [u32; 2],
        index: u64,
        room: &mut ClassRoom<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let scene = self.scene();
        let (walk, mut sampler) = self.start(pixel, index);
        let ClassRoom { eye, tracks, emission } = room;
        let start = Start {
            ray: walk.segment.ray,
            t_max: walk.segment.t_max,
            beta: walk.beta,
            lambda: walk.lambda,
            departure: CameraEnd::new(scene, &walk.segment.ray).departure,
            medium: scene.camera_medium,
            footprint: walk.footprint,
            spread: walk.spread,
        };
        let walker =
            Walker { scene, roulette: self.roulette, mode: Mode::Radiance, until_smooth: false };
        let most = self.max_depth.saturating_add(1) as usize;
        let escape = walker.walk(&start, most, &mut sampler, eye, stats);
        tracks.follow_eye(eye);

        let mut rgb = [0.0; 3];
        let sensor = &self.frame().sensor;
        let mut add = |l: Spectrum, lambda: &Wavelengths, how: &Closing, stats: &mut PassStats| {
            if l.is_black() {
                return;
            }
            let c = self.rgb(l, lambda, stats);
            rgb.iter_mut().zip(c).for_each(|(sum, v)| *sum += v);
            tracks.add(how, l, lambda, sensor);
        };
        for glow in eye.glows.iter().filter(|g| self.counts(g.depth as u32)) {
            add(glow.value, &glow.lambda, &Closing::Glow(glow.depth), stats);
        }
        for (i, z) in eye.iter().enumerate() {
            if let Some(id) = z.surface.light {
                let le = scene.light(id).le(scene, &z.surface, z.wo, &z.lambda);
                let end = |_: &Vertex| {
                    LightEnd::new(scene, emission, id, z.surface.p, z.surface.ng, z.wo)
                };
                let w = self.found(&eye[..i], z.passing, end);
                add(z.beta * le * w, &z.lambda, &Closing::Found(i, id), stats);
            }
            if z.connects() && self.counts(i as u32 + 1) {
                let Some((l, d, id)) = self.next_event(z, emission, stats) else { continue };
                add(l, &z.lambda, &Closing::NextEvent(i, z, d, id), stats);
            }
        }
        if let Some(escape) = escape {
            for &id in &scene.environments {
                let le = scene.light(id).escaped(escape.o, escape.d, &escape.lambda).le;
                let far = (Vec3::ZERO, Vec3::ZERO);
                let end = |_: &Vertex| LightEnd::new(scene, emission, id, far.0, far.1, -escape.d);
                let w = self.found(eye, escape.passing, end);
                let how = Closing::Found(eye.len(), id);
                add(escape.beta * le * w, &escape.lambda, &how, stats);
            }
        }
        let mut record = PixelRecord { rgb, weight: walk.film_weight, ..PixelRecord::default() };
        if let Some(z) = eye.first().filter(|z| z.inside.is_none()) {
            describe(scene, &z.surface, &z.bsdf, z.wo, &z.lambda, &mut record);
        }
        record
    }

    /// w_b of the light that a path found after `eye`.
    fn found(&self, eye: &[Vertex], passing: f64, end: impl Fn(&Vertex) -> LightEnd) -> f32 {
        if !self.shows(eye.len() as u32) {
            return 0.0;
        }
        // What went straight through has not been asked for lights, nor have mirrors.
        let Some(last) = eye.last().filter(|v| !v.delta) else { return 1.0 };
        let end = end(last);
        let chosen = end.next_event(self.scene(), self.lights, last);
        let walked = last.pdf * end.area(last.surface.p) * passing;
        self.mis.bsdf((chosen / walked) as f32, 1.0)
    }

    /// The light's term at `z`, weighted, with the direction and number of the light.
    fn next_event(
        &self,
        z: &Vertex,
        emission: &LightSelection,
        stats: &mut PassStats,
    ) -> Option<(Spectrum, Vec3, LightId)> {
        let scene = self.scene();
        let e = z.next_event(scene, self.lights, emission)?;
        let end = &e.end;
        if end.hittable && !self.mis.samples_lights() {
            return None;
        }
        let far = end.infinite;
        let passage = path_space::passage(scene, z, &e.segment, far, &z.lambda, stats)?;
        let w = match end.hittable {
            true => {
                let chosen = end.next_event(scene, self.lights, z);
                let walked = e.pdf.0 * end.area(z.surface.p) * passage.passing;
                self.mis.light(1.0, (walked / chosen) as f32)
            }
            false => 1.0,
        };
        Some((e.value * passage.value * w, -end.w, end.light))
    }
}
