//! The estimator of one camera path that carries polarization.
//!
//! ```text
//! S ≈ R Σₖ Tₖ [ w_b Lₑ(xₖ→xₖ₋₁)  +  w_l M(ωₒ,ω_l)|cos θ_l| Lₑ(y→xₖ) V / (p p_l) ] e₀      (1)
//! Tₖ₊₁ = Tₖ M(ωₒ,ω_b)|cos θ_b| / p_b                                                  (2)
//! T ← T / q  with survival probability q, of m₀₀(T)                                   (3)
//! R:  from the frame of -d to that with x = d × up, along the picture's rows           (4)
//! ```
//!
//! T and M are Mueller matrices: the light comes last in the product and the camera first (Wolff &
//! Kurlander 1990; Wilkie, Tobler & Purgathofer 2001). Lights are unpolarized, e₀ = (1, 0, 0, 0). All else,
//! directions, densities, weights and random numbers, is that of the unpolarized path
//! ([`super::integrate`]); m₀₀ bounds every element, so it is what roulette asks. Every path is taken alone:
//! polarization is rare, and the fast ways ([`super::wave`]) do not know of it.

use super::integrate::{Integrator, MAX_PASSAGES};
use super::walk::{Previous, Walk};
use crate::features::describe;
use crate::method::PassStats;
use crate::roulette::WalkState;
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, Lobes};
use kaustika_scene::polarization::{Mueller, Stokes, Turn, stokes_basis};
use kaustika_scene::{Segment, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A path between two vertices.
struct PolarizedWalk {
    /// All but its throughput and what it found: `beta` is m₀₀ of `throughput`.
    walk: Walk,
    /// T.
    throughput: Mueller,
    /// Found so far, in the frame of the camera ray.
    found: Stokes,
}

impl<'a> Integrator<'a> {
    /// Stokes vector of the light that one sample of one pixel sees, S₀ to S₃ as linear RGB each,
    /// in the picture's frame: (4).
    pub fn stokes(&self, pixel: [u32; 2], index: u64, stats: &mut PassStats) -> [[f32; 3]; 4] {
        self.polarized(pixel, index, &mut Bsdf::default(), None, stats).0
    }

    /// The Stokes vector and the weight of the sample on the film.
    fn polarized(
        &self,
        pixel: [u32; 2],
        index: u64,
        bsdf: &mut Bsdf<'a>,
        mut record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> ([[f32; 3]; 4], f32) {
        let (walk, mut sampler) = self.start(pixel, index);
        let Ray { d, time, .. } = walk.segment.ray;
        // A meter's weight, and what it has found at its own surface.
        let throughput = Mueller::IDENTITY * walk.beta;
        let found = Mueller::depolarizer(walk.radiance).of_unpolarized();
        let mut path = PolarizedWalk { walk, throughput, found };
        while self.onward(&mut path, &mut sampler, bsdf, record.as_deref_mut(), stats) {}
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
        let across = d.cross(self.scene().camera.up(film, time));
        let seen = path.found.turned(Turn::between(-d, stokes_basis(-d), across)); // (4)
        let rgb = seen.0.map(|s| self.frame().sensor.rgb(s, &path.walk.lambda));
        if rgb.as_flattened().iter().all(|v| v.is_finite()) {
            return (rgb, walk.film_weight);
        }
        stats.bad_samples += 1;
        ([[0.0; 3]; 4], walk.film_weight)
    }

    /// Takes a path on to its next vertex; false if it ends there.
    fn onward(
        &self,
        path: &mut PolarizedWalk,
        sampler: &mut Sampler<'a>,
        bsdf: &mut Bsdf<'a>,
        record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> bool {
        let (scene, walk) = (self.scene(), &mut path.walk);
        let ray = walk.segment.ray;
        let wo = -ray.d;
        stats.closest_rays += 1;

        // Add what it emits toward the path: the BSDF's term of (1).
        let hit = scene.hit(&ray, walk.segment.t_max);
        let surface = hit.map(|hit| scene.geometry.surface(&hit, &ray));
        if self.shows(walk.depth) {
            let le = match &surface {
                None => self.escaped(&ray, &walk.previous, &walk.lambda),
                Some(s) => s.light.map_or(Spectrum::ZERO, |id| {
                    self.emitted(id, s, &ray, &walk.previous, &walk.lambda)
                }),
            };
            if !le.is_black() {
                path.found += path.throughput.of_unpolarized() * le;
            }
        }
        let Some(mut surface) = surface else { return false };
        walk.footprint += walk.spread * surface.t;
        surface.footprint = walk.footprint;

        // What is there?
        if !scene.bsdf_into(&surface, wo, &mut walk.lambda, bsdf) {
            walk.passages += 1;
            walk.segment = Segment { ray: surface.spawn(ray.d), t_max: f32::INFINITY };
            return walk.passages <= MAX_PASSAGES;
        }
        if let (Some(record), 0) = (record, walk.depth) {
            describe(scene, &surface, bsdf, wo, &walk.lambda, record);
        }
        if walk.depth >= self.max_depth {
            return false;
        }
        let u = sampler.get_vertex();
        let (u2_light, u2) = (Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3]));
        let [u_light, uc, u_survive] = [u[4], u[5], u[6]];

        // Sample a light: its term of (1).
        if self.counts(walk.depth + 1)
            && bsdf.lobes().has(Lobes::SMOOTH)
            && let Some((segment, light)) =
                self.polarized_direct(&surface, bsdf, wo, u_light, u2_light, &walk.lambda)
        {
            stats.shadow_rays += 1;
            if !scene.occluded(&segment) {
                path.found += path.throughput * light;
            }
        }

        // Sample the BSDF for the next direction.
        let Some((s, m)) = bsdf.sample_mueller(wo, uc, u2, Lobes::ALL) else { return false };
        path.throughput = path.throughput * m; // (2)
        walk.beta = path.throughput.m00();
        walk.eta_scale *= s.eta * s.eta;
        walk.depth += 1;
        if walk.beta.is_black() {
            return false;
        }
        let delta = s.lobe.has(Lobes::DELTA);
        if !s.lobe.has(Lobes::NULL) {
            let n = surface.facing(wo);
            walk.previous = Previous { p: surface.p, n, pdf_w: s.pdf, delta };
        } else {
            walk.previous.delta = true;
        }
        walk.segment = Segment { ray: surface.spawn(s.wi), t_max: f32::INFINITY };

        // Russian roulette.
        let (beta, eta_scale, depth) = (walk.beta, walk.eta_scale, walk.depth);
        let q = self.roulette.q(&WalkState { beta, eta_scale, weight: s.weight, depth });
        if q < 1.0 {
            if u_survive >= q {
                return false;
            }
            path.throughput = path.throughput * Spectrum::splat(1.0 / q); // (3)
            walk.beta /= q;
        }
        true
    }

    /// The light's term of (1) at a surface, without T and V, and the ray that V asks for.
    fn polarized_direct(
        &self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        u: f32,
        u2: Vec2,
        lambda: &Wavelengths,
    ) -> Option<(Segment, Stokes)> {
        let scene = self.scene();
        let choice = self.lights.sample(surface.p, surface.facing(wo), u, u2)?;
        let (light, p) = (scene.light(choice.light), choice.p);
        if !light.is_delta() && !self.mis.samples_lights() {
            return None;
        }
        let l = light.sample_li_in(scene, surface.p, choice.region, choice.u, lambda)?;
        let (m, pdf_b) = bsdf.eval_mueller(wo, l.wi, Lobes::ALL);
        if m.m00().is_black() || l.le.is_black() {
            return None;
        }
        let w = if l.delta { 1.0 } else { self.mis.light(p * l.pdf_w, pdf_b) };
        let stokes = m.of_unpolarized() * (l.le * (w / (p * l.pdf_w)));
        (w > 0.0).then(|| (scene.shadow_ray(surface, &l), stokes))
    }
}

/// One sample of every pixel of a band.
pub(super) fn trace_polarized<'a>(
    integrator: &Integrator<'a>,
    index: u64,
    bsdf: &mut Bsdf<'a>,
    band: &mut PixelBand,
) -> PassStats {
    let mut stats = PassStats::default();
    let region = integrator.frame().region;
    for pixel in 0..band.width() * band.height() {
        let (x, y) = (pixel % band.width(), pixel / band.width());
        let at = [region[0] + x, region[1] + band.y + y];
        let mut record = PixelRecord::default();
        let features = band.wants_features().then_some(&mut record);
        let (stokes, weight) = integrator.polarized(at, index, bsdf, features, &mut stats);
        let rgb = integrator.frame().clamp(stokes[0]);
        band.add(x, y, &PixelRecord { rgb, weight, ..record });
        band.add_stokes(x, y, weight, &stokes);
    }
    stats
}
