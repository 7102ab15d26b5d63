//! The estimator of one pass.
//!
//! ```text
//! L ≈ Σ_k βᴱ_k [ L_d(z_k) + Σ_± f_D(ωₒ,n_±) E_±(z_k) ]                               (2)
//! E from photons of flux  βᴸ q,   q = f_D(n,ωᵢ) |cos| / (f_D(n,n) |n_g·ωᵢ|)            (3)
//! ```
//!
//! The z_k are where an eye path goes that only mirrors, clear and glossy surfaces turn; L_d is
//! direct light there. The second term is what light brings that the same kinds of surfaces have turned
//! first: E_± are the maps of both sides, n_± the shading normals there, f_D the diffuse part of f.
//!
//! A map forgets directions. For Lambert's f_D this is nothing, and q only turns the flux across
//! the surface into one across the shaded one. For diffuse scattering that is a product of a
//! function of each direction, such as that under a clear coat, q makes it exact too. For others
//! (Oren & Nayar 1994) light counts as it would for an eye above the surface.

use super::maps::{Light, Maps};
use super::params::BackwardParams;
use crate::features::describe_vertex;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::path_space::{CameraEnd, Direct, LightEnd, OfPass, Subpath, Vertex, Walker};
use crate::workers::Workers;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Vec2, Vec3};
use kaustika_sampling::MisHeuristic;
use kaustika_sampling::hash::combine;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{LightSelection, Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;

/// Branch of the sampler for light paths.
const LIGHT_BRANCH: u64 = 0x006c_6967_6874;
/// Light paths of a chunk.
const CHUNK: u64 = 2048;
/// Chunks whose photons are kept at the same time.
const WINDOW: u64 = 64;

/// Estimates one pass of a picture.
pub(super) struct Estimator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    direct: Direct<'a>,
    walker: Walker<'a>,
    index: u64,
    of_pass: OfPass,
    /// Light paths.
    photons: u64,
    /// Of a texel.
    width: f32,
    max_depth: usize,
    hide_emitters: bool,
}

/// Light that arrived on a surface.
struct Photon {
    surface: Surface,
    front: bool,
    flux: Spectrum,
    /// True if only the hero wavelength is left.
    dispersed: bool,
}

impl<'a> Estimator<'a> {
    /// For pass `index`; `lights` are those for surfaces and those for emission.
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &BackwardParams,
        (lights, emission): (&'a LightSelection, &'a LightSelection),
        index: u64,
    ) -> Estimator<'a> {
        let (mis, walked) = (MisHeuristic::default(), Lobes::SPECULAR);
        let [w, h] = frame.resolution;
        let roulette = params.roulette();
        // Grids of all sizes, one a pass, so that none of them shows.
        let random = combine(combine(frame.sampler.config().seed, 0x6d61_7073), index);
        let size = 0.75 + 0.5 * (random >> 40) as f32 / (1u32 << 24) as f32;
        Estimator {
            scene,
            frame,
            direct: Direct { scene, lights, emission, mis, walked },
            walker: Walker {
                lobes: Lobes::SPECULAR,
                ..Walker::new(scene, roulette, Mode::Radiance)
            },
            index,
            of_pass: OfPass::new(scene, frame, index),
            photons: match params.photons {
                0 => u64::from(w) * u64::from(h),
                n => n.into(),
            },
            width: params.width(scene.radius, index) * size,
            max_depth: params.max_bounces() as usize,
            hide_emitters: params.hide_emitters,
        }
    }

    /// The illumination maps of the pass: the same whatever part of the picture is rendered.
    pub(super) fn maps(
        &self,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Maps, RenderError> {
        let mut maps = Maps::new(self.width);
        let chunks = self.photons.div_ceil(CHUNK);
        for first in (0..chunks).step_by(WINDOW as usize) {
            if workers.cancelled() {
                return Err(RenderError::Cancelled);
            }
            let window = first..chunks.min(first + WINDOW);
            let filled: Vec<_> =
                workers.install(|| window.into_par_iter().map(|c| self.photons(c)).collect());
            for (photons, s) in filled {
                for p in photons {
                    maps.add(self.scene, &p.surface, p.front, p.flux, p.dispersed);
                }
                *stats += s;
            }
        }
        Ok(maps)
    }

    /// The photons of a chunk of the light paths.
    fn photons(&self, chunk: u64) -> (Vec<Photon>, PassStats) {
        let walker = Walker { mode: Mode::Importance, ..self.walker };
        let (mut photons, mut stats) = (Vec::new(), PassStats::default());
        let mut path = Subpath::default();
        let OfPass { lambda, time } = self.of_pass;
        for i in chunk * CHUNK..self.photons.min((chunk + 1) * CHUNK) {
            // One sequence through all passes, so that the photons of a pass are stratified.
            let number = self.index.wrapping_mul(self.photons).wrapping_add(i);
            let mut root = self.frame.sampler.start([0, 0], number);
            let mut sampler = root.fork(LIGHT_BRANCH);
            let emission = self.direct.emission;
            let emitted = LightEnd::emit(self.scene, emission, &lambda, time, &mut sampler);
            let Some((end, start)) = emitted else { continue };
            walker.walk(&start, self.max_depth, &mut sampler, &mut path, &mut stats);
            // What comes straight from the light is direct light, if the eye can ask for it.
            let direct = usize::from(self.scene.light(end.light).connects());
            photons.extend(path.iter().skip(direct).filter_map(|y| self.photon(y)));
        }
        (photons, stats)
    }

    /// (3): what a vertex leaves in the maps.
    fn photon(&self, y: &Vertex) -> Option<Photon> {
        if !y.bsdf.lobes().has(Lobes::DIFFUSE) {
            return None;
        }
        let s = &y.surface;
        let front = s.ng.dot(y.wo) > 0.0;
        let n = normal(&y.bsdf, s, front);
        let diffuse = |wi: Vec3| y.bsdf.eval(n, wi, Mode::Radiance, Lobes::DIFFUSE);
        // Grazing light is rare and heavy; below this cosine the surface is its own edge.
        let arriving = diffuse(y.wo) / s.ng.abs_dot(y.wo).max(1e-3);
        let above = diffuse(n);
        // What only shines through is not seen from here.
        let q = std::array::from_fn(|k| match above.0[k] > 0.0 {
            true => arriving.0[k] / above.0[k],
            false => 1.0,
        });
        let flux = y.beta * Spectrum(q) / self.photons as f32;
        let dispersed = y.lambda.secondary_terminated();
        (!flux.is_black()).then_some(Photon { surface: *s, front, flux, dispersed })
    }

    /// One sample of one pixel.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        features: bool,
        maps: &Maps,
        eye: &mut Subpath<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut sampler = frame.sampler.start(pixel, self.index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let OfPass { lambda, time } = self.of_pass;
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), time);
        let start = CameraEnd::new(scene, &camera.ray).start(scene, &camera, lambda);
        let most = self.max_depth.saturating_add(1);
        let escape = self.walker.walk(&start, most, &mut sampler, eye, stats);

        // (2)
        let mut record = PixelRecord::default();
        let mut rgb = [0.0; 3];
        let mut add = |l: Spectrum, lambda: &Wavelengths, stats: &mut PassStats| {
            frame.add(&mut rgb, l, lambda, stats);
        };
        for (i, z) in eye.iter().enumerate() {
            if let (0, true) = (i, features) {
                describe_vertex(scene, z, &mut record);
            }
            if let (true, Some((l, _))) = (self.shows(i), self.direct.met(eye, i)) {
                add(l, &z.lambda, stats);
            }
            if i >= self.max_depth || !z.connects() {
                continue;
            }
            if let Some((l, ..)) = self.direct.asked(z, stats) {
                add(l, &z.lambda, stats);
            }
            let Light { all, hero } = self.caustic(maps, z);
            add(z.beta * all, &z.lambda, stats);
            if !hero.is_black() {
                let mut lambda = z.lambda;
                lambda.terminate_secondary();
                add(z.beta * hero, &lambda, stats);
            }
        }
        if let Some(escape) = escape.filter(|_| self.shows(eye.len())) {
            self.direct.escaped(eye, &escape, |l, _| add(l, &escape.lambda, stats));
        }
        PixelRecord { rgb: frame.clamp(rgb), weight: film.weight, ..record }
    }

    /// What a surface scatters to the eye of the light in its maps.
    fn caustic(&self, maps: &Maps, z: &Vertex) -> Light {
        let mut light = Light::default();
        if !z.bsdf.lobes().has(Lobes::DIFFUSE) {
            return light;
        }
        for front in [true, false] {
            let n = normal(&z.bsdf, &z.surface, front);
            let f = z.bsdf.eval(z.wo, n, Mode::Radiance, Lobes::DIFFUSE);
            if !f.is_black() {
                let e = maps.irradiance(self.scene, &z.surface, front);
                light.all += f * e.all;
                light.hero += f * e.hero;
            }
        }
        light
    }

    /// True if lights found after as many bounces are wanted.
    fn shows(&self, depth: usize) -> bool {
        depth <= self.max_depth && !(depth == 0 && self.hide_emitters)
    }
}

/// The shading normal on the front or the back of a surface.
fn normal(bsdf: &Bsdf, s: &Surface, front: bool) -> Vec3 {
    let ns = bsdf.shading_normal();
    if (ns.dot(s.ng) > 0.0) == front { ns } else { -ns }
}
