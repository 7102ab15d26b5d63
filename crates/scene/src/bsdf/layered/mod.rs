//! A dielectric coat over a matte or metallic base, as pbrt-v4 layers them (its `coateddiffuse`
//! and `coatedconductor`, materials `LayeredBxDF` of Guo, Hašan & Zhao 2018, "Position-free
//! Monte Carlo simulation for arbitrary layered BSDFs").
//!
//! The coat has a rough or smooth surface and a thickness; the matter in it has extinction 1 per
//! unit of thickness, an albedo and Henyey and Greenstein's phase function. With ωₐ, ω_b
//! refracted to w₁, w₂ and K what the light does below the surface:
//!
//! ```text
//! f(ωₐ, ω_b) = f_coat + 1/η² ∫∫ f_t(ωₐ, w₁)|cos w₁| K(w₁, w₂) |cos w₂| f_t(ω_b, w₂)      (1)
//! K: paths of 1 to `max_depth` events: reflections by the base, scattering in the coat,
//!    reflections back from the coat's surface                                           (2)
//! ```
//!
//! (2) is pbrt's truncation. What is computed how:
//!
//! * a smooth clear coat over a matte base in closed form ([`slab`]);
//! * all else by [`walk`]: a random walk whose numbers come from a hash of the unordered pair of
//!   directions and a salt. So f is a pure and symmetric function whose **average over directions
//!   or salts** is right, but which is rough like the noise that it stands for;
//! * the light of paths that are ideally reflected only, one Dirac lobe, in closed form.
//!
//! Directions are drawn from a mixture of simple densities, which `pdf` gives exactly: the coat's
//! visible normals, the base's lobe as seen from outside, and a cosine. (pbrt draws by a walk and
//! weights with a stochastic estimate of its density; f is the same.)

mod proxy;
mod slab;
#[cfg(test)]
mod tests;
mod walk;

use super::albedo::microfacet_albedo;
use super::fresnel::{fresnel_dielectric, refract};
use super::{
    BsdfSample, Conductor, ConductorFresnel, Dielectric, Diffuse, Lobes, Microfacet, Mode, Scatter,
};
use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::Spectrum;
use proxy::Proxy;
use slab::Slab;

/// The coat of a layered surface; parameters as pbrt's.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// Index of the coat over that outside; 0 is taken as 1.
    pub ior: f32,
    /// Facets of its surface.
    pub surface: Microfacet,
    /// Thickness in mean free paths, >= 0. Absorbs even if `albedo` is zero.
    pub thickness: f32,
    /// Albedo of the matter inside in [0,1]; zero in every lane is a medium without scattering.
    pub albedo: Spectrum,
    /// Its asymmetry in (-1,1), Henyey and Greenstein's.
    pub g: f32,
    /// Most events of a path below the surface.
    pub max_depth: u32,
    /// Walks per evaluation, at least 1.
    pub samples: u32,
    /// Added to the hash of the directions. A hash of the hit point decorrelates the noise of
    /// neighbouring points under parallel light; it must be the same for every evaluation of a
    /// hit.
    pub salt: u64,
}

/// What can lie under a coat.
pub trait Base: Scatter + Copy {
    /// Class of the light that comes back through the coat.
    const CLASS: Lobes;

    /// The base's facets; `None` if it is matte.
    fn facets(&self) -> Option<Microfacet>;
}

impl Base for Diffuse {
    const CLASS: Lobes = Lobes::DIFFUSE_REFLECTION;

    #[inline]
    fn facets(&self) -> Option<Microfacet> {
        None
    }
}

impl Base for Conductor {
    const CLASS: Lobes = Lobes::GLOSSY_REFLECTION;

    #[inline]
    fn facets(&self) -> Option<Microfacet> {
        Some(self.surface)
    }
}

/// A coat over a base, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Layered<B> {
    base: B,
    coat: Coat,
    /// The coat's surface.
    surface: Dielectric,
    /// The closed form for a smooth clear coat over a matte base.
    slab: Option<Slab>,
}

/// A matte base under a coat.
pub type CoatedDiffuse = Layered<Diffuse>;
/// A metal under a coat.
pub type CoatedConductor = Layered<Conductor>;

impl CoatedDiffuse {
    /// A base of albedo `reflectance` in [0,1].
    pub fn new(reflectance: Spectrum, coat: Coat) -> CoatedDiffuse {
        let mut layered = Layered::with_base(Diffuse { reflectance }, coat);
        if layered.is_smooth() && coat.albedo.is_black() {
            layered.slab = Some(Slab::new(reflectance, &layered.coat));
        }
        layered
    }
}

impl CoatedConductor {
    /// A metal with `fresnel` relative to the outside (the coat's index is divided out here, also
    /// where it was made from a reflectance, as in pbrt) and facets `surface`.
    pub fn new(fresnel: ConductorFresnel, surface: Microfacet, coat: Coat) -> CoatedConductor {
        let ior = if coat.ior > 0.0 { coat.ior } else { 1.0 };
        let fresnel = match fresnel {
            ConductorFresnel::EtaK { eta, k } => {
                ConductorFresnel::EtaK { eta: eta / ior, k: k / ior }
            }
            ConductorFresnel::Mirror => ConductorFresnel::Mirror,
        };
        Layered::with_base(Conductor { fresnel, tint: Spectrum::ONE, surface }, coat)
    }
}

impl<B: Base> Layered<B> {
    fn with_base(base: B, coat: Coat) -> Layered<B> {
        let coat = Coat {
            ior: if coat.ior > 0.0 { coat.ior } else { 1.0 },
            thickness: coat.thickness.max(0.0),
            albedo: coat.albedo.clamp(0.0, 1.0),
            g: coat.g.clamp(-0.999, 0.999),
            samples: coat.samples.max(1),
            ..coat
        };
        let surface = Dielectric {
            eta: coat.ior,
            reflectance: Spectrum::ONE,
            transmittance: Spectrum::ONE,
            surface: coat.surface,
        };
        Layered { base, coat, surface, slab: None }
    }

    /// True if the coat's surface is ideal.
    #[inline]
    fn is_smooth(&self) -> bool {
        self.surface.lobes().has(Lobes::DELTA)
    }

    /// True if the base is an ideal mirror.
    #[inline]
    fn has_mirror(&self) -> bool {
        self.base.lobes().has(Lobes::DELTA)
    }

    /// True if there is anything with a density below the coat.
    #[inline]
    fn has_below(&self) -> bool {
        let scatters = !self.coat.albedo.is_black();
        let rough = !self.is_smooth() || !self.has_mirror();
        self.coat.max_depth > 0 && (scatters || rough && !self.base.lobes().is_empty())
    }

    /// Direction inside, pointing down, of `w` from above refracted at a smooth surface, and the
    /// transmittance; `None` under total reflection.
    #[inline]
    fn enter(&self, w: Vec3) -> Option<(Vec3, f32)> {
        let f = fresnel_dielectric(w.z, self.coat.ior);
        (f.cos_t > 0.0).then(|| (refract(w, Vec3::Z, w.z, f.cos_t, f.eta), 1.0 - f.reflectance))
    }

    /// What is left of light that goes from the coat's surface to a mirror and back along `up`.
    #[inline]
    fn mirrored(&self, up: Vec3) -> Spectrum {
        let mirror = Lobes::DELTA_REFLECTION;
        let base = self.base.sample(up, 0.5, Vec2::ZERO, Mode::Radiance, mirror);
        let passage = (-2.0 * self.coat.thickness / up.z).exp();
        base.map_or(Spectrum::ZERO, |s| s.weight * passage)
    }

    /// The Dirac lobe: reflection by a smooth coat, and all paths between it and a mirror.
    fn mirror(&self, wo: Vec3) -> Spectrum {
        let f = fresnel_dielectric(wo.z, self.coat.ior).reflectance;
        let mut value = Spectrum::splat(f);
        let Some((w, t)) = self.enter(wo) else { return value };
        if self.has_mirror() {
            let once = self.mirrored(-w);
            // Reflections by the base alternate with those by the coat.
            value += once * sqr(t) * geometric(once * f, self.coat.max_depth.div_ceil(2));
        }
        value
    }

    /// f of the light that went below the coat's surface: the second part of (1).
    fn below(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if !self.has_below() {
            return Spectrum::ZERO;
        }
        match &self.slab {
            Some(slab) => slab.value(wo.z, wi.z),
            None => walk::average(self, wo, wi),
        }
    }
}

/// Σ_{k<n} qᵏ.
#[inline]
fn geometric(q: Spectrum, n: u32) -> Spectrum {
    let (mut sum, mut term) = (Spectrum::ZERO, Spectrum::ONE);
    for _ in 0..n {
        sum += term;
        term *= q;
        if term.max_component() < 1e-7 {
            break;
        }
    }
    sum
}

impl<B: Base> Scatter for Layered<B> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let mut value = self.surface.eval(wo, wi, mode, lobes & Lobes::GLOSSY_REFLECTION);
        if lobes.has(B::CLASS) {
            value += self.below(wo, wi) * wi.z;
        }
        value
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return (0.0, 0.0);
        }
        // Dirac lobes have a share of `lobes` only where they are among them.
        let density = |a, b| Proxy::new(self, a, lobes).map_or(0.0, |p| p.density(a, b));
        (density(wo, wi), density(wi, wo))
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let proxy = Proxy::new(self, wo, lobes)?;
        let (wi, lobe) = proxy.sample(wo, uc, u2)?;
        if lobe == Lobes::DELTA_REFLECTION {
            let pdf = proxy.mirror_probability();
            // The same from both ends: it depends on the cosine only.
            let weight = self.mirror(wo) / pdf;
            return Some(BsdfSample { wi, weight, pdf, pdf_rev: pdf, eta: 1.0, lobe });
        }
        if wi.z <= 0.0 {
            return None;
        }
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// Exact for a smooth clear coat over a matte base or a mirror. Otherwise the light between
    /// coat and base as a geometric series of mean reflectances, with a fit of what rough facets
    /// and the medium lose: within 0.2.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        if let Some(slab) = &self.slab {
            let f = fresnel_dielectric(wo.z, self.coat.ior).reflectance;
            return slab.albedo(wo.z) + Spectrum::splat(f);
        }
        if self.is_smooth() && !self.has_below() {
            return self.mirror(wo);
        }
        let r0 = Spectrum::splat(sqr((self.coat.ior - 1.0) / (self.coat.ior + 1.0)));
        let reflected = microfacet_albedo(&self.coat.surface, r0, wo)[0].min(1.0);
        let Some((w, _)) = self.enter(wo) else { return Spectrum::splat(reflected) };
        let alpha = if self.is_smooth() { 0.0 } else { self.coat.surface.alpha() };
        // What is left after the facets of the coat, once; steeper for grazing light.
        let facets = |cos: f32| (-0.5 * alpha * cos.powf(-0.8)).exp();
        // A part of the scattered light takes longer ways and is absorbed after all.
        let absorption = Spectrum::ONE - self.coat.albedo * 0.75;
        let passage = (absorption * (self.coat.thickness / w.z)).exp();
        let once = self.base.albedo(-w) * passage * passage;
        let (back, out) = match self.base.facets() {
            None => {
                let kept = Slab::new(Spectrum::ONE, &Coat { thickness: 0.0, ..self.coat }).kept();
                (kept, (1.0 - kept) * facets(1.0))
            }
            Some(_) => (reflected, (1.0 - reflected) * facets(wo.z)),
        };
        let series = once.zip(once * back, |a, b| a / (1.0 - b).max(1e-3));
        Spectrum::splat(reflected) + series * ((1.0 - reflected) * facets(wo.z) * out)
    }

    /// Of the coat, or of the base if that is a rougher metal.
    fn roughness(&self) -> f32 {
        let coat = if self.is_smooth() { 0.0 } else { self.coat.surface.roughness() };
        self.base.facets().map_or(coat, |f| f.roughness().max(coat))
    }

    fn lobes(&self) -> Lobes {
        let surface =
            if self.is_smooth() { Lobes::DELTA_REFLECTION } else { Lobes::GLOSSY_REFLECTION };
        if self.has_below() { surface | B::CLASS } else { surface }
    }
}
