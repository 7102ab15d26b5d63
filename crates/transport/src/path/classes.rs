//! The estimator of one camera path with layers by path: (1) of [`super::integrate`] over the
//! vertices of a whole subpath, whose classes are known at each of them.
//!
//! Slower than without layers, and other samples of the same picture.

use super::integrate::Integrator;
use crate::features::describe_vertex;
use crate::method::PassStats;
use crate::path_space::{CameraEnd, Closing, Direct, Start, Subpath, Tracks, Walker};
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_film::path_expression::PathClasses;
use kaustika_scene::LightSelection;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Room for one path.
pub(super) struct ClassRoom<'a> {
    eye: Subpath<'a>,
    tracks: Tracks<'a>,
    emission: &'a LightSelection,
}

impl<'a> ClassRoom<'a> {
    /// For a picture with layers of these classes; `emission` is how lights are chosen to emit.
    pub(super) fn new(
        integrator: &Integrator<'a>,
        classes: &'a PathClasses,
        emission: &'a LightSelection,
    ) -> ClassRoom<'a> {
        let tracks = Tracks::new(classes, integrator.scene());
        ClassRoom { eye: Subpath::default(), tracks, emission }
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
            let features = band.wants_features();
            let record = integrator.sample_classes(pixel, index, features, room, &mut stats);
            band.add(x, y, &record);
            band.add_paths(x, y, record.weight, 0, room.tracks.found());
        }
    }
    stats
}

impl<'a> Integrator<'a> {
    fn sample_classes(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
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
        let walker = Walker::new(scene, self.roulette, Mode::Radiance);
        let most = self.max_depth.saturating_add(1) as usize;
        let escape = walker.walk(&start, most, &mut sampler, eye, stats);
        tracks.follow_eye(eye);

        let mut rgb = [0.0; 3];
        let sensor = &self.frame().sensor;
        let mut add = |l: Spectrum, lambda: &Wavelengths, how: &Closing, stats: &mut PassStats| {
            if l.is_black() {
                return;
            }
            let c = self.frame().rgb(l, lambda, stats);
            rgb.iter_mut().zip(c).for_each(|(sum, v)| *sum += v);
            tracks.add(how, l, lambda, sensor);
        };
        for glow in eye.glows.iter().filter(|g| self.counts(g.depth as u32)) {
            add(glow.value, &glow.lambda, &Closing::Glow(glow.depth), stats);
        }
        let lights = self.lights;
        let direct = Direct { scene, lights, emission, mis: self.mis, walked: Lobes::ALL };
        for (i, z) in eye.iter().enumerate() {
            if let (true, Some((l, id))) = (self.shows(i as u32), direct.met(eye, i)) {
                add(l, &z.lambda, &Closing::Found(i, id), stats);
            }
            if z.connects() && self.counts(i as u32 + 1) {
                let Some((l, d, id)) = direct.asked(z, stats) else { continue };
                add(l, &z.lambda, &Closing::NextEvent(i, z, d, id), stats);
            }
        }
        if let Some(escape) = escape.filter(|_| self.shows(eye.len() as u32)) {
            direct.escaped(eye, &escape, |l, id| {
                add(l, &escape.lambda, &Closing::Found(eye.len(), id), stats);
            });
        }
        let mut record = PixelRecord { rgb, weight: walk.film_weight, ..PixelRecord::default() };
        if let Some(z) = eye.first().filter(|_| features) {
            describe_vertex(scene, z, &mut record);
        }
        record
    }
}
