//! Radiance from photons nearby (Jensen 1996; 2001, ch. 7).
//!
//! ```text
//! L ≈ Σ_p f(ω_p, ωₒ) Φ_p w(d_p/r) / (c π r²)                                          (3)
//! box    w = 1                                                     c = 1
//! cone   w = 1 - x/k                                               c = 1 - 2/(3k),  k = 1.1
//! gauss  w = α (1 - (1 - e^{-βx²/2}) / (1 - e^{-β}))               c = mean of w over the disk
//! ```
//!
//! r reaches to the farthest of the K photons found, which is itself left out: K - 1 photons lie
//! in a disk that the K-th bounds, so that the mean is right where they lie evenly. From pass to pass
//! r shrinks as in progressive photon mapping. f is without its cosine, which is in the density
//! of the photons on the surface.

use super::params::Filter;
use super::photon::PhotonMap;
use super::tracing::sum;
use crate::nearest::Nearest;
use kaustika_math::Vec3;
use kaustika_scene::Surface;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode, Model};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// k of the cone.
const CONE: f32 = 1.1;
/// α and β of the bell.
const BELL: (f32, f32) = (0.918, 1.953);
/// Photons lie within this share of r above or below the tangent plane, or on another surface.
const FLAT: f32 = 0.4;
/// Photons before differential checking begins, and changes in one direction that end it.
const CHECK: (usize, usize) = (10, 8);

impl Filter {
    /// w / c at d²/r².
    #[inline]
    fn weight(self, x2: f32) -> f32 {
        let (alpha, beta) = BELL;
        match self {
            Filter::Box => 1.0,
            Filter::Cone => (1.0 - x2.sqrt() / CONE) / (1.0 - 2.0 / (3.0 * CONE)),
            Filter::Gauss => {
                let edge = 1.0 - (-beta).exp();
                let w = alpha * (1.0 - (1.0 - (-0.5 * beta * x2).exp()) / edge);
                // ∫₀¹ w d(x²), in closed form.
                let half = 0.5 * beta;
                let mean = alpha * (1.0 - (1.0 - (1.0 - (-half).exp()) / half) / edge);
                w / mean
            }
        }
    }
}

/// How a map is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// K.
    pub(super) nearest: usize,
    /// Photons farther away are not asked for.
    pub(super) radius: f32,
    /// r is multiplied by this.
    pub(super) shrink: f32,
    pub(super) filter: Filter,
    pub(super) checking: bool,
}

/// What an estimate is of.
#[derive(Clone, Copy)]
pub(super) struct Place<'s, 'a> {
    pub(super) surface: &'s Surface,
    pub(super) bsdf: &'s Bsdf<'a>,
    pub(super) wo: Vec3,
    /// The part of the scattering that is asked for.
    pub(super) lobes: Lobes,
    pub(super) lambda: &'s Wavelengths,
    /// What radiance from here is worth to the picture, for those who learn; else nothing.
    pub(super) worth: Spectrum,
}

/// An estimate and how far it reached.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    pub(super) radiance: Spectrum,
    pub(super) radius: f32,
}

impl Reading {
    /// (3), of the photons whose depth `counts`.
    pub(super) fn radiance(
        &self,
        map: &PhotonMap,
        at: &Place,
        counts: impl Fn(u32) -> bool,
        found: &mut Nearest,
    ) -> Estimate {
        let p = at.surface.p;
        found.begin(self.nearest, self.radius * self.radius);
        map.nearest(p, found);
        // Where fewer photons lie, the disk is the largest there is.
        let full = found.len() >= self.nearest;
        let mut r2 = if full { found.farthest() } else { self.radius * self.radius };
        if self.checking {
            r2 = self.checked(map, r2, found);
        }
        r2 *= self.shrink * self.shrink;
        let (radius, area) = (r2.sqrt(), PI * r2);
        let (n, thickness) = (at.surface.facing(at.wo), FLAT * radius);
        let matte = at.lambert();
        let credits = map.credits().filter(|_| !at.worth.is_black());
        let mut radiance = Spectrum::ZERO;
        for (i, d2) in found.iter() {
            let photon = map.photon(i);
            if d2 >= r2 || !counts(photon.depth()) {
                continue;
            }
            if (map.at(i) - p).dot(n).abs() > thickness {
                continue;
            }
            let wi = photon.wi();
            let f = match matte {
                Some(f) if n.dot(wi) > 0.0 => f,
                Some(_) => continue,
                None => at.value(wi),
            };
            let mut power = photon.power();
            if photon.dispersed() {
                let mut hero = *at.lambda;
                hero.terminate_secondary();
                power = read_at(power, &hero, at.lambda);
            }
            let part = f * power * self.filter.weight(d2 / r2);
            if let Some(credits) = credits {
                credits.add(i, sum(part * at.worth) / area);
            }
            radiance += part;
        }
        Estimate { radiance: if area > 0.0 { radiance / area } else { Spectrum::ZERO }, radius }
    }

    /// r² where farther photons begin to change the estimate in one direction only.
    fn checked(&self, map: &PhotonMap, r2: f32, found: &mut Nearest) -> f32 {
        found.sort();
        let (mut flux, mut density, mut last_d2) = (0.0, 0.0, r2);
        let (mut rising, mut run, mut before) = (true, 0, r2);
        for (count, (i, d2)) in found.iter().enumerate() {
            let now = flux / d2;
            if count >= CHECK.0 {
                match (now > density) == rising {
                    true => run += 1,
                    false => (rising, run, before) = (!rising, 1, last_d2),
                }
                if run == CHECK.1 {
                    return before;
                }
            }
            (density, last_d2) = (now, d2);
            flux += sum(map.photon(i).power());
        }
        r2
    }
}

/// Radiance at the wavelengths `from` as it is read at those of `to`, which may have ended less.
#[inline]
pub(super) fn read_at(l: Spectrum, from: &Wavelengths, to: &Wavelengths) -> Spectrum {
    match from.secondary_terminated() && !to.secondary_terminated() {
        // All four stand for the one that is left.
        true => Spectrum([4.0 * l[0], 0.0, 0.0, 0.0]),
        false => l,
    }
}

impl Place<'_, '_> {
    /// f if it is the same for all directions: of matte surfaces without relief.
    fn lambert(&self) -> Option<Spectrum> {
        let [part] = self.bsdf.parts() else { return None };
        let flat = part.guard.is_none() && self.surface.ns.abs_dot(self.surface.ng) > 0.9999;
        match &part.model {
            Model::Diffuse(m) if flat && self.lobes.has(Lobes::DIFFUSE_REFLECTION) => {
                let lit = part.frame.to_local(self.wo).z > 0.0;
                Some(if lit { m.reflectance * (part.weight / PI) } else { Spectrum::ZERO })
            }
            _ => None,
        }
    }

    /// f, and the shading normal toward the eye, of a surface that only Lambert's law rules.
    pub(super) fn matte(&self) -> Option<(Spectrum, Vec3)> {
        let [part] = self.bsdf.parts() else { return None };
        match &part.model {
            Model::Diffuse(m) if part.guard.is_none() && part.frame.n.dot(self.wo) > 0.0 => {
                Some((m.reflectance * (part.weight / PI), part.frame.n))
            }
            _ => None,
        }
    }

    /// f without its cosine.
    fn value(&self, wi: Vec3) -> Spectrum {
        let f = self.bsdf.eval(self.wo, wi, Mode::Radiance, self.lobes);
        // Grazing photons are few and heavy; below this cosine the surface is its own edge.
        f / self.surface.ng.abs_dot(wi).max(1e-2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_have_a_mean_of_one_over_the_disk() {
        for filter in [Filter::Box, Filter::Cone, Filter::Gauss] {
            let n = 10_000;
            let mean = (0..n).map(|i| f64::from(filter.weight((i as f32 + 0.5) / n as f32)));
            let mean = mean.sum::<f64>() / f64::from(n);
            assert!((mean - 1.0).abs() < 1e-4, "{filter:?}: {mean}");
        }
    }
}
