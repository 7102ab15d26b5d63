//! The estimator of one pass.
//!
//! ```text
//! L ≈ Σ w_c C_{s,t}  +  Σ_{|y - z| < r} w_m βᴸ f(z) βᴱ / (π r² N)                       (1)
//! ```
//!
//! C_{s,t} are the connections of bidirectional path tracing; the second sum merges a vertex z of
//! the eye path with the vertices y of all N light paths of the pass. f is without its cosine: that
//! is in the density of the y on the surface. All weights are 1 / (1 + w_L + w_E), from
//! [`super::recursion`].

use super::params::{Mode, VcmParams};
use super::photons::{Photon, Photons};
use super::recursion::{Carried, Weights};
use crate::features::describe_vertex;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::path_space::{
    self, CameraEnd, Closing, LightEnd, OfPass, Passage, Splat, Subpath, Tracks, Vertex, Walker,
    splat,
};
use crate::workers::Workers;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::bsdf::{Lobes, Mode as Carrying};
use kaustika_scene::{LightId, LightSelection, Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Branch of the sampler for light paths.
const LIGHT_BRANCH: u64 = 0x006c_6967_6874;
/// Light paths of a chunk.
const CHUNK: usize = 2048;

/// Estimates one pass of a picture.
pub(super) struct Estimator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    params: &'a VcmParams,
    lights: &'a LightSelection,
    emission: &'a LightSelection,
    weights: Weights,
    /// Where rooms begin, if there are layers of classes of paths.
    tracks: Option<Tracks<'a>>,
    index: u64,
    radius: f32,
    max_depth: usize,
    only_depth: Option<usize>,
    /// N.
    count: f32,
    /// Light is shared between pixels, so all paths of a pass have the same wavelengths and time.
    of_pass: OfPass,
}

/// Room for one pair of paths.
#[derive(Default)]
pub(super) struct Room<'a> {
    light: Subpath<'a>,
    eye: Subpath<'a>,
    of_light: Vec<Carried>,
    of_eye: Vec<Carried>,
    /// The classes of paths, if there are layers of them.
    tracks: Option<Tracks<'a>>,
}

impl Room<'_> {
    /// What the layers by path got of the last sample.
    pub(super) fn layers(&self) -> &[[f32; 3]] {
        self.tracks.as_ref().map_or(&[], Tracks::found)
    }
}

/// What a pixel's sample has found.
struct Found<'r, 'f> {
    frame: &'r Frame,
    rgb: [f32; 3],
    tracks: &'r mut Option<Tracks<'f>>,
}

impl Found<'_, '_> {
    fn add(&mut self, l: Spectrum, lambda: &Wavelengths, how: &Closing, stats: &mut PassStats) {
        self.add_to_picture(l, lambda, stats);
        if let Some(tracks) = self.tracks {
            tracks.add(how, l, lambda, &self.frame.sensor);
        }
    }

    fn add_to_picture(&mut self, l: Spectrum, lambda: &Wavelengths, stats: &mut PassStats) {
        self.frame.add(&mut self.rgb, l, lambda, stats);
    }
}

impl<'a> Estimator<'a> {
    /// For pass `index`; `lights` are those for surfaces and those for emission.
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &'a VcmParams,
        lights: (&'a LightSelection, &'a LightSelection),
        index: u64,
    ) -> Estimator<'a> {
        let pixels = |[w, h]: [u32; 2]| f64::from(w) * f64::from(h);
        let count = pixels(frame.size());
        let radius = params.radius(scene.radius, index);
        let light_paths = count / pixels(frame.resolution);
        let (connects, merges) = (params.mode.connects(), params.mode.merges());
        let power = params.mis == super::params::Heuristic::Power;
        Estimator {
            scene,
            frame,
            params,
            lights: lights.0,
            emission: lights.1,
            weights: Weights::new(power, radius, count, light_paths, connects, merges),
            tracks: frame.paths.as_ref().map(|classes| Tracks::new(classes, scene)),
            index,
            radius,
            max_depth: params.max_bounces() as usize,
            only_depth: usize::try_from(params.only_depth).ok(),
            count: count as f32,
            of_pass: OfPass::new(scene, frame, index),
        }
    }

    pub(super) fn room(&self) -> Room<'a> {
        Room { tracks: self.tracks.clone(), ..Room::default() }
    }

    /// All vertices of light paths that can be merged.
    pub(super) fn photons(
        &self,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Photons, RenderError> {
        if !self.params.mode.merges() {
            return Ok(Photons::default());
        }
        let [width, height] = self.frame.size();
        let count = width as usize * height as usize;
        let chunk = |chunk: usize| {
            let mut room = self.room();
            let (mut photons, mut classes) = (Vec::new(), Vec::new());
            let mut stats = PassStats::default();
            if workers.cancelled() {
                return (photons, classes, stats);
            }
            for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                let [x, y] = [i as u32 % width, i as u32 / width];
                let pixel = [self.frame.region[0] + x, self.frame.region[1] + y];
                if self.light_path(pixel, &mut room, &mut stats).is_some() {
                    for (i, (v, c)) in room.light.iter().zip(&room.of_light).enumerate() {
                        let Some(photon) = photon(i, v, c) else { continue };
                        photons.push(photon);
                        classes.extend(room.tracks.as_ref().map(|t| t.back(i).to_vec()));
                    }
                }
            }
            (photons, classes, stats)
        };
        let chunks: Vec<_> =
            workers.install(|| (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect());
        if workers.cancelled() {
            return Err(RenderError::Cancelled);
        }
        let (mut all, mut all_classes) = (Vec::new(), Vec::new());
        for (photons, classes, s) in chunks {
            all.extend(photons);
            all_classes.extend(classes);
            *stats += s;
        }
        Ok(Photons::new(all, all_classes, self.radius))
    }

    /// The light path that goes with a pixel.
    fn light_path(
        &self,
        pixel: [u32; 2],
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> Option<LightEnd> {
        room.light.clear();
        room.of_light.clear();
        let mut root = self.frame.sampler.start(pixel, self.index);
        let mut sampler = root.fork(LIGHT_BRANCH);
        let OfPass { lambda, time } = self.of_pass;
        let (end, start) = LightEnd::emit(self.scene, self.emission, &lambda, time, &mut sampler)?;
        let roulette = self.params.roulette();
        let walker = Walker::new(self.scene, roulette, Carrying::Importance);
        walker.walk(&start, self.max_depth, &mut sampler, &mut room.light, stats);
        self.weights.of_light(self.scene, self.lights, &end, &room.light, &mut room.of_light);
        if let Some(tracks) = &mut room.tracks {
            tracks.follow_light(&room.light, end.light);
        }
        Some(end)
    }

    /// One sample of one pixel: what the pixel gets, and what others get.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        features: bool,
        photons: &Photons,
        room: &mut Room<'a>,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame, mode) = (self.scene, self.frame, self.params.mode);
        let mut sampler = frame.sampler.start(pixel, self.index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), self.of_pass.time);
        let camera_end = CameraEnd { aperture: None, ..CameraEnd::new(scene, &camera.ray) };
        let start = camera_end.start(scene, &camera, self.of_pass.lambda);
        let walker = Walker {
            until_smooth: mode == Mode::Ppm,
            ..Walker::new(scene, self.params.roulette(), Carrying::Radiance)
        };
        let most = self.max_depth.saturating_add(1);
        let escape = walker.walk(&start, most, &mut sampler, &mut room.eye, stats);
        self.weights.of_eye(&camera_end, &room.eye, &mut room.of_eye);
        if let Some(tracks) = &mut room.tracks {
            tracks.follow_eye(&room.eye);
        }
        let end = match mode.connects() {
            true => self.light_path(pixel, room, stats),
            false => None,
        };
        let Room { light, eye, of_light, of_eye, tracks } = room;

        let mut sum = Found { frame, rgb: [0.0; 3], tracks };
        let mut record = PixelRecord::default();
        for glow in eye.glows.iter().filter(|g| self.counts(g.depth)) {
            sum.add(glow.value, &glow.lambda, &Closing::Glow(glow.depth), stats);
        }
        for (i, (z, c)) in eye.iter().zip(&*of_eye).enumerate() {
            if let (0, true) = (i, features) {
                describe_vertex(scene, z, &mut record);
            }
            if let Some(id) = z.surface.light {
                let le = scene.light(id).le(scene, &z.surface, z.wo, &z.lambda);
                let found = (id, z.surface.p, z.surface.ng, z.wo);
                let w = self.found((&eye[..i], z.passing), of_eye, found, le);
                sum.add(z.beta * le * w, &z.lambda, &Closing::Found(i, id), stats);
            }
            if !z.connects() {
                continue;
            }
            if mode.merges() && z.inside.is_none() {
                self.merge(i, z, c, photons, &mut sum, stats);
            }
            if !mode.connects() {
                continue;
            }
            if let Some((l, end)) = self.next_event(i, z, c, stats) {
                let how = Closing::NextEvent(i, z, -end.w, end.light);
                sum.add(l, &z.lambda, &how, stats);
            }
            for (j, y) in light.iter().enumerate() {
                if let Some((l, lambda)) = self.join((j, y, &of_light[j]), (i, z, c), stats) {
                    sum.add(l, &lambda, &Closing::Join((j, y), (i, z)), stats);
                }
            }
        }
        if let Some(escape) = escape {
            for &id in &scene.environments {
                let le = scene.light(id).escaped(escape.o, escape.d, &escape.lambda).le;
                let found = (id, Vec3::ZERO, Vec3::ZERO, -escape.d);
                let w = self.found((eye, escape.passing), of_eye, found, le);
                let how = Closing::Found(eye.len(), id);
                sum.add(escape.beta * le * w, &escape.lambda, &how, stats);
            }
        }
        if end.is_some() {
            for (j, (y, c)) in light.iter().zip(&*of_light).enumerate() {
                self.connect_lens(j, y, c, sum.tracks.as_ref(), splats, stats);
            }
        }
        PixelRecord { rgb: frame.clamp(sum.rgb), weight: film.weight, ..record }
    }

    /// True if paths of this many bounces are wanted.
    fn counts(&self, depth: usize) -> bool {
        depth <= self.max_depth && self.only_depth.is_none_or(|d| d == depth)
    }

    /// Weight of the light that an eye path found which had met `eye`.
    fn found(
        &self,
        (eye, passing): (&[Vertex], f64),
        carried: &[Carried],
        (id, p, n, w): (LightId, Vec3, Vec3, Vec3),
        le: Spectrum,
    ) -> f32 {
        let depth = eye.len();
        if le.is_black() || !self.counts(depth) || (depth == 0 && self.params.hide_emitters) {
            return 0.0;
        }
        let Some(z) = eye.last() else { return 1.0 };
        if !self.params.mode.connects() {
            // What is not pure mirrors and glass is the photons'.
            let pure = eye.iter().all(|v| v.delta);
            return if pure { 1.0 } else { 0.0 };
        }
        let (m, c) = (|x| self.weights.m(x), &carried[depth - 1]);
        let end = LightEnd::new(self.scene, self.emission, id, p, n, w);
        let arrival = z.pdf * end.area(z.surface.p) * passing;
        let emitted = m(end.emission / arrival) * m(end.departure.density(z) * passing);
        let back = m(z.pdf_rev) * c.vc;
        let others = match z.delta {
            true => emitted * back,
            false => {
                m(end.next_event(self.scene, self.lights, z) / arrival)
                    + emitted * (self.weights.eta_m_at(z) + c.vcm + back)
            }
        };
        1.0 / (1.0 + others)
    }

    fn next_event(
        &self,
        i: usize,
        z: &Vertex,
        c: &Carried,
        stats: &mut PassStats,
    ) -> Option<(Spectrum, LightEnd)> {
        if !self.counts(i + 1) {
            return None;
        }
        let e = z.next_event(self.scene, self.lights, self.emission)?;
        let (weights, end) = (&self.weights, &e.end);
        let passage = self.open(z, &e.segment, end.infinite, &z.lambda, stats)?;
        let chosen = end.next_event(self.scene, self.lights, z);
        let found = match end.hittable {
            true => weights.m(e.pdf.0 * end.area(z.surface.p) * passage.passing / chosen),
            false => 0.0,
        };
        let emitted = end.emission * end.departure.density(z) * passage.passing / chosen;
        let w = 1.0 / (1.0 + found + weights.side(z, c, emitted, e.pdf.1));
        Some((e.value * passage.value * w, e.end))
    }

    fn join(
        &self,
        (j, y, c_y): (usize, &Vertex, &Carried),
        (i, z, c_z): (usize, &Vertex, &Carried),
        stats: &mut PassStats,
    ) -> Option<(Spectrum, Wavelengths)> {
        if !self.counts(i + j + 2) || !y.connects() {
            return None;
        }
        let joined = path_space::join(y, z)?;
        let (pdf_y, pdf_z) = (joined.pdf, joined.end.pdf_eye);
        let passage = self.open(z, &joined.segment, false, &joined.end.lambda, stats)?;
        let g = |from: &Vertex, to: &Vertex| to.arriving_from(from.surface.p) * passage.passing;
        let light = self.weights.side(y, c_y, pdf_z.0 * g(z, y), pdf_y.1);
        let eye = self.weights.side(z, c_z, pdf_y.0 * g(y, z), pdf_z.1);
        let w = 1.0 / (1.0 + light + eye);
        Some((joined.value * passage.value * w, joined.end.lambda))
    }

    fn connect_lens(
        &self,
        j: usize,
        y: &Vertex,
        c: &Carried,
        tracks: Option<&Tracks>,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        if !self.counts(j + 1) || !y.connects() {
            return;
        }
        let Some(l) = path_space::to_lens(self.scene, y) else { return };
        let Some(passage) = self.open(y, &l.segment, false, &y.lambda, stats) else { return };
        let camera = &l.end.camera;
        let seen = camera.lens * camera.departure.density(y) * passage.passing
            / (self.weights.light_paths * camera.connection);
        let w = 1.0 / (1.0 + self.weights.side(y, c, seen, l.pdf.1));
        let value = l.value * passage.value * (w / self.count);
        let how = Closing::ToLens(j, y, l.segment.ray.d.normalize());
        splat(self.frame, tracks, &how, value, l.end.film, &y.lambda, splats, stats);
    }

    /// The second sum of (1).
    fn merge(
        &self,
        i: usize,
        z: &Vertex,
        c: &Carried,
        photons: &Photons,
        found: &mut Found,
        stats: &mut PassStats,
    ) {
        let kernel = 1.0 / (PI * self.radius * self.radius * self.count);
        let (mut sum, mut hero) = (Spectrum::ZERO, Spectrum::ZERO);
        photons.near(z.surface.p, |number, photon| {
            if !self.counts(i + photon.depth as usize) {
                return;
            }
            let (f, (pdf, pdf_rev)) =
                z.bsdf.eval_pdf(z.wo, photon.wo, Carrying::Radiance, Lobes::ALL);
            if f.is_black() {
                return;
            }
            let w = match self.params.mode {
                Mode::Ppm => 1.0,
                _ => {
                    let light = self.weights.merged_side(&photon.carried(), pdf.into());
                    1.0 / (1.0 + light + self.weights.merged_side(c, pdf_rev.into()))
                }
            };
            // Grazing photons are few and heavy; below this cosine the surface is its own edge.
            let cos = z.surface.ng.abs_dot(photon.wo).max(1e-3);
            let l = f * photon.beta * (w / cos);
            if let Some(tracks) = found.tracks {
                let mut lambda = z.lambda;
                if photon.dispersed {
                    lambda.terminate_secondary();
                }
                let (l, back) = (l * z.beta * kernel, photons.back(number));
                let at = (i, z, photon.wo);
                tracks.add_merged(at, back, l, &lambda, &self.frame.sensor);
            }
            match photon.dispersed {
                true => hero += l,
                false => sum += l,
            }
        });
        if !sum.is_black() {
            found.add_to_picture(sum * z.beta * kernel, &z.lambda, stats);
        }
        if !hero.is_black() {
            let mut lambda = z.lambda;
            lambda.terminate_secondary();
            found.add_to_picture(hero * z.beta * kernel, &lambda, stats);
        }
    }

    /// What passes along a connection's segment, which begins at `from`.
    fn open(
        &self,
        from: &Vertex,
        segment: &Segment,
        far: bool,
        lambda: &Wavelengths,
        stats: &mut PassStats,
    ) -> Option<Passage> {
        path_space::passage(self.scene, from, segment, far, lambda, stats)
    }
}

/// The photon of the light path's vertex number `i`, where light can be merged.
fn photon(i: usize, v: &Vertex, c: &Carried) -> Option<Photon> {
    v.bsdf.lobes().has(Lobes::SMOOTH).then(|| Photon {
        p: v.surface.p,
        wo: v.wo,
        beta: v.beta,
        vcm: c.vcm,
        vm: c.vm,
        depth: i as u32 + 1,
        dispersed: v.lambda.secondary_terminated(),
    })
}
