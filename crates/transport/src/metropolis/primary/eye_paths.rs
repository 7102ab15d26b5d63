//! Path tracing from any numbers: what paths from the eye find, and what their vertices ask for.

use super::super::film::Field;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::path_space::{CameraEnd, Closing, Direct, Guides, Splat, Subpath, Tracks, Walker};
use crate::strategies::Settings;
use kaustika_math::Vec2;
use kaustika_sampling::{MisHeuristic, Sampler};
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{LightSelection, Scene};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Makes paths from the eye.
pub(super) struct EyePaths<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    settings: Settings,
    lights: &'a LightSelection,
    emission: &'a LightSelection,
    guides: Option<&'a Guides>,
    field: Field,
    eye: Subpath<'a>,
    tracks: Option<Tracks<'a>>,
}

impl<'a> EyePaths<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        settings: Settings,
        (lights, emission): (&'a LightSelection, &'a LightSelection),
        guides: Option<&'a Guides>,
    ) -> EyePaths<'a> {
        EyePaths {
            scene,
            frame,
            settings,
            lights,
            emission,
            guides,
            field: Field::new(frame),
            eye: Subpath::default(),
            tracks: frame.paths.as_ref().map(|classes| Tracks::new(classes, scene)),
        }
    }

    /// What one path finds, as splats.
    pub(super) fn trace(
        &mut self,
        sampler: &mut Sampler,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let (scene, frame, eye) = (self.scene, self.frame, &mut self.eye);
        let u = sampler.get_vertex();
        let film = self.field.place(Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film, Vec2::new(u[2], u[3]), u[4]);
        let lambda = Wavelengths::sample_for(scene.mode, u[5]);
        let start = CameraEnd::new(scene, &camera.ray).start(scene, &camera, lambda);
        let walker = Walker {
            guides: self.guides,
            ..Walker::new(scene, self.settings.roulette, Mode::Radiance)
        };
        let [fewest, most] = self.settings.depths.map(|d| d as usize);
        let escape = walker.walk(&start, most.saturating_add(1), sampler, eye, stats);
        if let Some(tracks) = &mut self.tracks {
            tracks.follow_eye(eye);
        }
        let counts = |depth: usize| (fewest..=most).contains(&depth);
        let shows = |depth: usize| counts(depth) && (depth > 0 || !self.settings.hide_emitters);
        let mut rgb = [0.0; 3];
        let tracks = &mut self.tracks;
        let mut add = |l: Spectrum, lambda: &Wavelengths, how: &Closing, stats: &mut PassStats| {
            if l.is_black() {
                return;
            }
            frame.add(&mut rgb, l, lambda, stats);
            if let Some(tracks) = tracks {
                tracks.add(how, l, lambda, &frame.sensor);
            }
        };
        for glow in eye.glows.iter().filter(|g| counts(g.depth)) {
            add(glow.value, &glow.lambda, &Closing::Glow(glow.depth), stats);
        }
        let (lights, emission) = (self.lights, self.emission);
        let mis = MisHeuristic::default();
        let direct = Direct { scene, lights, emission, mis, walked: Lobes::ALL };
        for (i, z) in eye.iter().enumerate() {
            if let (true, Some((l, id))) = (shows(i), direct.met(eye, i)) {
                add(l, &z.lambda, &Closing::Found(i, id), stats);
            }
            if z.connects() && counts(i + 1) {
                let Some((l, d, id)) = direct.asked(z, stats) else { continue };
                add(l, &z.lambda, &Closing::NextEvent(i, z, d, id), stats);
            }
        }
        if let Some(escape) = escape.filter(|_| shows(eye.len())) {
            direct.escaped(eye, &escape, |l, id| {
                add(l, &escape.lambda, &Closing::Found(eye.len(), id), stats);
            });
        }
        let found = self.tracks.as_ref().map_or(&[][..], Tracks::found);
        let layers = found.iter().enumerate().map(|(k, c)| (Some(k), *c));
        for (layer, rgb) in std::iter::once((None, frame.clamp(rgb))).chain(layers) {
            if rgb != [0.0; 3] {
                splats.push(Splat { film, layer, rgb });
            }
        }
    }
}
