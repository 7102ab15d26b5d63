//! glTF 2.0's metallic-roughness model with the layers that its extensions add.
//!
//! With m metallic, t transmission, d diffuse transmission, s specular, c the facet's cosine on
//! the thinner side, and S(r, g) = r + (g - r)(1 - c)⁵:
//!
//! ```text
//! dielectric    F_d = S(s min(R tint, 1), s),   R = ((n-1)/(n+1))²                        (1)
//! facets        F   = (1-m) F_d + m S(base, 1)                                            (2)
//! reflected     f |cos θᵢ| = F D G₂ / (4 |cos θₒ|)                                         (3)
//! matte         f = (1-m)(1-t) K/π [(1-d) base  or, on the other side,  d color]          (4)
//!               K = (1-E(θₒ))(1-E(θᵢ))/(1-Ē),  E the albedo of F_d's facets, Ē its mean
//! transmitted   f |cos θᵢ| = (1-m) t base (1-F_d) D G₂ |ωₒ·h ωᵢ·h|
//!                            / (|cos θₒ| (ωᵢ·h + ωₒ·h/n)²) / n²                           (5)
//!               sheet: as (3), ωᵢ mirrored at the surface, (1-m) t base (1-F_d) for F
//! sheen         f = color D_s / (4 cos θₒ cos θᵢ (1 + Λ(θₒ) + Λ(θᵢ)))                      (6)
//! clear coat    f |cos θᵢ| = w F_c D_c G₂ / (4 |cos θₒ|),  F_c = S(0.04, 1)                (7)
//! layers        f = C(sheen + B(2..5)) + clear coat,
//!               B = min over ωₒ, ωᵢ of 1 - max(color) E_s(θ),  C of 1 - w F_c(θ)          (8)
//! ```
//!
//! Khronos Group 2021, "glTF 2.0 Specification", appendix B, and the README of each KHR_materials
//! extension. Where those formulas gain energy or depend on the order of the directions, the
//! layers are coupled as their notes allow: the matte part as Kelemen & Szirmay-Kalos 2001 (the
//! specification's 1 - F sends up to 1.9 times the light back at grazing angles), the coat as the
//! sheen, by the smaller of both directions' factors. (5) reflects totally where it must.
//!
//! An opaque surface and the outside of a solid have these layers, a sheet has them on both
//! sides. The inside of a solid reflects (1-m) t F_d.

mod choice;
mod coat;
mod facets;
mod film;
mod sheen;
#[cfg(test)]
mod tests;

pub use coat::Clearcoat;
pub use film::Film;

use super::albedo::{microfacet_albedo, microfacet_albedo_terms, microfacet_mean_terms};
use super::fresnel::{fresnel_dielectric, reflect, refract};
use super::{BsdfSample, Lobes, Microfacet, Mode, Scatter};
use crate::description::Distribution;
use facets::{mirrored, schlick};
use kaustika_math::{INV_PI, Vec2, Vec3, sqr, warp};
use kaustika_spectra::Spectrum;
use sheen::Sheen;

/// Least roughness α of the facets: what is smoother looks the same.
const ALPHA_LEAST: f32 = 1e-3;
/// Least index of a solid: at 1 no facet bends light.
const ETA_LEAST: f32 = 1.001;

/// Which sides a surface has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Only its front reflects.
    Opaque,
    /// The same from both sides; what goes through is not bent.
    Sheet,
    /// Behind it lies another medium.
    Solid,
}

/// glTF's parameters at a point, in [0,1] where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughnessParameters {
    /// Colour of the matte part, of metal, and of what is transmitted.
    pub base_color: Spectrum,
    /// Dielectric or metal.
    pub metallic: f32,
    /// α along the tangents.
    pub alpha: (f32, f32),
    /// Index of refraction, or 0 for a reflectance R of 1.
    pub ior: f32,
    /// s.
    pub specular: f32,
    /// Tint of the dielectric at normal incidence; may exceed 1.
    pub specular_color: Spectrum,
    /// Colour and perceptual roughness of the sheen.
    pub sheen: Option<(Spectrum, f32)>,
    /// The coat.
    pub clearcoat: Option<Clearcoat>,
    /// t.
    pub transmission: f32,
    /// d and its colour.
    pub diffuse_transmission: (f32, Spectrum),
    /// Thin film over dielectric and metal.
    pub film: Option<Film>,
    /// Which sides there are.
    pub boundary: Boundary,
    /// What the way through the inside to this point leaves of the light, seen from there.
    pub interior: Spectrum,
}

impl Default for MetallicRoughnessParameters {
    /// A white, rough, opaque dielectric of index 1.5.
    fn default() -> Self {
        MetallicRoughnessParameters {
            base_color: Spectrum::ONE,
            metallic: 0.0,
            alpha: (1.0, 1.0),
            ior: 1.5,
            specular: 1.0,
            specular_color: Spectrum::ONE,
            sheen: None,
            clearcoat: None,
            transmission: 0.0,
            diffuse_transmission: (0.0, Spectrum::ONE),
            film: None,
            boundary: Boundary::Opaque,
            interior: Spectrum::ONE,
        }
    }
}

/// The metallic-roughness model at a point.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughness {
    /// (1-m)(1-t)(1-d) base and (1-m)(1-t) d color.
    matte: [Spectrum; 2],
    /// (1-m) t base.
    clear: Spectrum,
    /// S's ends of (2).
    r0: Spectrum,
    r90: f32,
    /// S's ends of (1): the greatest component.
    dielectric: (f32, f32),
    /// The same for E, which knows no film.
    under_film: f32,
    /// (1-m) t.
    through: f32,
    surface: Microfacet,
    /// 1 - Ē.
    mean_passed: f32,
    sheen: Option<Sheen>,
    coat: Option<Clearcoat>,
    film: Option<Film>,
    eta: f32,
    boundary: Boundary,
    interior: Spectrum,
}

/// Ē of (4) for S(r0, r90).
fn facets_mean(surface: &Microfacet, r0: f32, r90: f32) -> f32 {
    let [a, b] = microfacet_mean_terms(surface);
    r0 * a + r90 * b
}

impl MetallicRoughness {
    /// The model of these parameters.
    pub fn new(p: MetallicRoughnessParameters) -> MetallicRoughness {
        let dielectric = 1.0 - p.metallic;
        let normal = if p.ior == 0.0 { 1.0 } else { sqr((p.ior - 1.0) / (p.ior + 1.0)) };
        let f0 = p.specular_color.map(|c| p.specular * (normal * c).min(1.0)); // (1)
        let alpha = |a: f32| a.clamp(ALPHA_LEAST, 1.0);
        let surface = Microfacet::new(Distribution::Ggx, alpha(p.alpha.0), alpha(p.alpha.1));
        let transmission = if p.boundary == Boundary::Opaque { 0.0 } else { p.transmission };
        let through = dielectric * transmission;
        let matte = dielectric * (1.0 - transmission);
        let (d, color) = p.diffuse_transmission;
        let d = if p.boundary == Boundary::Opaque { 0.0 } else { d };
        let mut model = MetallicRoughness {
            matte: [p.base_color * (matte * (1.0 - d)), color * (matte * d)],
            clear: p.base_color * through,
            r0: f0 * dielectric + p.base_color * p.metallic, // (2)
            r90: p.specular * dielectric + p.metallic,
            dielectric: (f0.max_component(), p.specular),
            under_film: f0.max_component(),
            through,
            surface,
            mean_passed: 1.0,
            sheen: p.sheen.filter(|s| !s.0.is_black()).map(|(c, r)| Sheen::new(c, r)),
            coat: p.clearcoat.filter(|c| c.factor > 0.0),
            film: p.film.filter(|f| f.factor > 0.0),
            eta: p.ior.max(ETA_LEAST),
            boundary: p.boundary,
            interior: p.interior,
        };
        if !model.matte[0].is_black() || !model.matte[1].is_black() {
            model.under_film = model.dielectric_reflected(1.0);
            let (r0, r90) = (model.under_film, p.specular);
            model.mean_passed = 1.0 - facets_mean(&surface, r0, r90);
        }
        model
    }

    /// True where the layers lie on the side of `w`.
    #[inline]
    fn is_outside(&self, w: Vec3) -> bool {
        w.z > 0.0 || self.boundary == Boundary::Sheet
    }

    /// True if light at `w` can be scattered.
    #[inline]
    fn is_seen_from(&self, w: Vec3) -> bool {
        w.z > 0.0 || w.z < 0.0 && self.boundary != Boundary::Opaque
    }

    /// True if the matte part is seen from `w`.
    #[inline]
    fn is_matte_from(&self, w: Vec3) -> bool {
        self.is_outside(w) || !self.matte[1].is_black()
    }

    /// The pair as seen from above, if the surface is a sheet.
    #[inline]
    fn unfolded(&self, wo: Vec3, wi: Vec3) -> (Vec3, Vec3) {
        match self.boundary {
            Boundary::Sheet if wo.z < 0.0 => (mirrored(wo), mirrored(wi)),
            _ => (wo, wi),
        }
    }

    /// 1 - E: what of the light at `w` passes the dielectric's facets.
    #[inline]
    fn matte_passed(&self, w: Vec3) -> f32 {
        let up = Vec3::new(w.x, w.y, w.z.abs());
        let [a, b] = microfacet_albedo_terms(&self.surface, up);
        (1.0 - self.under_film * a - self.dielectric.1 * b).max(0.0)
    }

    /// What the layers leave of light at `w`: the factors of (8).
    #[inline]
    fn layers_passed(&self, w: Vec3) -> (f32, f32) {
        if !self.is_outside(w) {
            return (1.0, 1.0);
        }
        let sheen = self.sheen.map_or(1.0, |s| s.passed(w.z.abs()));
        (self.coat.map_or(1.0, |c| c.passed(w)), sheen)
    }

    /// The value under the coat and the sheen.
    fn base(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        let same_side = wo.z * wi.z > 0.0;
        let mut value = Spectrum::ZERO;
        let (class, color) = match same_side {
            true => (Lobes::DIFFUSE_REFLECTION, self.matte[0]),
            false => (Lobes::DIFFUSE_TRANSMISSION, self.matte[1]),
        };
        if lobes.has(class) && !color.is_black() && self.is_matte_from(wo) {
            let k = self.matte_passed(wo) * self.matte_passed(wi) / self.mean_passed.max(1e-3);
            value += color * (k * INV_PI * wi.z.abs()); // (4)
        }
        let (glossy, clear) = match same_side {
            true => (Lobes::GLOSSY_REFLECTION, false),
            false => (Lobes::GLOSSY_TRANSMISSION, true),
        };
        if !lobes.has(glossy) || clear && self.clear.is_black() {
            return value;
        }
        let Some(f) = self.facet(wo, wi) else { return value };
        if clear && self.boundary == Boundary::Solid {
            return value + self.clear * (self.passed(f.cos) * self.bent(wo, wi, &f, mode)); // (5)
        }
        let shape = 0.25 * self.surface.d(f.wm) * self.surface.g2(wo, wi) / wo.z.abs();
        value
            + match clear {
                true => self.clear * (self.passed(f.cos) * shape),
                false => self.reflected(self.is_outside(wo), f.cos) * shape, // (3)
            }
    }
}

impl Scatter for MetallicRoughness {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if !self.is_seen_from(wo) || !self.is_seen_from(wi) {
            return Spectrum::ZERO;
        }
        let arrival = if wo.z < 0.0 { self.interior } else { Spectrum::ONE };
        let (wo, wi) = self.unfolded(wo, wi);
        let ((coat_o, sheen_o), (coat_i, sheen_i)) =
            (self.layers_passed(wo), self.layers_passed(wi));
        let mut value = self.base(wo, wi, mode, lobes) * sheen_o.min(sheen_i);
        let layered = wo.z > 0.0 && wi.z > 0.0;
        if let (true, Some(sheen)) = (layered && lobes.has(Lobes::DIFFUSE_REFLECTION), &self.sheen)
        {
            value += sheen.value(wo, wi); // (6)
        }
        value *= coat_o.min(coat_i); // (8)
        if let (true, Some(coat)) = (layered && lobes.has(Lobes::GLOSSY_REFLECTION), &self.coat) {
            value += Spectrum::splat(coat.value(wo, wi, mode)); // (7)
        }
        value * arrival
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !self.is_seen_from(wo) || !self.is_seen_from(wi) {
            return (0.0, 0.0);
        }
        (self.density(wo, wi, lobes), self.density(wi, wo, lobes))
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if !self.is_seen_from(wo) {
            return None;
        }
        let (up, _) = self.unfolded(wo, wo);
        let choice = self.choice(up, lobes);
        let total = choice.total();
        if total == 0.0 {
            return None;
        }
        let mut u = uc * total;
        let mut chosen = |weight: f32| {
            let here = u < weight;
            u -= if here { 0.0 } else { weight };
            here
        };
        let (wi, eta, lobe) = if chosen(choice.matte) {
            let wi = warp::cosine_hemisphere(u2) * up.z.signum();
            (wi, 1.0, Lobes::DIFFUSE_REFLECTION)
        } else if chosen(choice.matte_through) {
            let wi = warp::cosine_hemisphere(u2) * -up.z.signum();
            (wi, 1.0, Lobes::DIFFUSE_TRANSMISSION)
        } else if chosen(choice.coat) {
            (self.coat?.sample(up, u2)?, 1.0, Lobes::GLOSSY_REFLECTION)
        } else {
            let n = self.surface.sample_visible(up, u2) * up.z.signum();
            let cos_o = up.dot(n);
            if cos_o <= 0.0 {
                return None;
            }
            let inside = up.z < 0.0;
            let cos = if inside { self.cos_outside(cos_o) } else { Some(cos_o) };
            if u < self.reflects(!inside, cos, lobes) * choice.facets {
                (reflect(up, n), 1.0, Lobes::GLOSSY_REFLECTION)
            } else if self.boundary == Boundary::Sheet {
                (mirrored(reflect(up, n)), 1.0, Lobes::GLOSSY_TRANSMISSION)
            } else {
                let i = fresnel_dielectric(cos_o * up.z.signum(), self.eta);
                if i.cos_t == 0.0 {
                    return None;
                }
                (refract(up, n, cos_o, i.cos_t, i.eta), i.eta, Lobes::GLOSSY_TRANSMISSION)
            }
        };
        // Some facets send light on to other facets, which is lost.
        if wi.z == 0.0 || (up.z * wi.z > 0.0) != Lobes::REFLECTION.has(lobe) {
            return None;
        }
        let wi = if up == wo { wi } else { mirrored(wi) };
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta, lobe })
    }

    /// By the tables of facets and sheen, light between the layers left out; of solids as if
    /// smooth. Within 0.1 for opaque surfaces and sheets, 0.15 under a coat, 0.4 for rough
    /// solids.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let (wo, _) = self.unfolded(wo, wo);
        let (coat, sheen) = self.layers_passed(wo);
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let mirror = microfacet_albedo(&self.surface, Spectrum::ONE, up);
        if wo.z < 0.0 {
            let reflected = self.reflected(false, self.cos_outside(up.z));
            let passed = self.clear * self.passed(self.cos_outside(up.z));
            let matte = (self.matte[0] + self.matte[1]) * self.matte_passed(wo);
            let matte = if self.is_matte_from(wo) { matte } else { Spectrum::ZERO };
            return ((reflected + passed) * mirror + matte) * self.interior;
        }
        let facets = self.facets_albedo(up);
        let clear = self.clear * (mirror - Spectrum::splat(1.0 - self.matte_passed(wo)));
        let matte = (self.matte[0] + self.matte[1]) * self.matte_passed(wo);
        let fibres = self.sheen.map_or(Spectrum::ZERO, |s| s.albedo(wo.z));
        ((facets + clear.clamp_zero() + matte) * sheen + fibres) * coat
            + Spectrum::splat(self.coat.map_or(0.0, |c| c.albedo(wo)))
    }

    /// Of the facets.
    #[inline]
    fn roughness(&self) -> f32 {
        self.surface.roughness()
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        let on = |class, is_there: bool| if is_there { class } else { Lobes::NONE };
        Lobes::GLOSSY_REFLECTION
            | on(Lobes::DIFFUSE_REFLECTION, !self.matte[0].is_black() || self.sheen.is_some())
            | on(Lobes::DIFFUSE_TRANSMISSION, !self.matte[1].is_black())
            | on(Lobes::GLOSSY_TRANSMISSION, !self.clear.is_black())
    }
}
