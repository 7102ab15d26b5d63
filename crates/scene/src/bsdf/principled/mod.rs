//! Disney's principled model as Mitsuba 3 defines it (its `principled`).
//!
//! With a = (1 - metallic)(1 - spec_trans), t = (1 - metallic) spec_trans, m the facet's normal,
//! η the index on the side of ωᵢ over that of ωₒ, and the parts of [`parts`]:
//!
//! ```text
//! diffuse      f = a base/π [f_d + f_r, f_s]_flatness                                  (1)
//! sheen        f = sheen (1 - metallic) s(cos θ_d) [1, hue]_sheen_tint                 (2)
//! main         f |cos θᵢ| = F D G₂ / (4 |cos θₒ|)                                       (3)
//!   from above F = (1-metallic)(1-tint) F_d + metallic [base, 1]_s + (1-metallic) tint [hue R₀, 1]_s
//!   from below F = t F_d                                                               (4)
//! transmission f |cos θᵢ| = √base t (1-F_d) D G₂ |ωₒ·m ωᵢ·m| / (|cos θₒ| (ωᵢ·m + ωₒ·m/η)²) / η²  (5)
//! clear coat   f = clearcoat/4 [0.04, 1]_s D_c G_c                                      (6)
//! choice       diffuse : clear coat : main = a : clearcoat/4 : 1, from below main only;
//!              main transmits with probability t (1 - F_d), from below 1 - F_d          (7)
//! ```
//!
//! [x, y]_w is a mix, the factor 1/η² of (5) radiance's only, [x, 1]_s Schlick's approximation.
//! The diffuse part, sheen and clear coat are seen from above only; where t = 0 all is. What is
//! not physical about it is kept: the clear coat's reflection does not dim what lies below, the
//! diffuse part and the sheen come on top of the main reflection, and albedos reach 1.2.
//! Burley 2012, 2015; facts of the composition from Mitsuba 3.

#[cfg(test)]
mod mitsuba;
mod parts;
#[cfg(test)]
mod tests;
mod thin;

pub(crate) use parts::facets;
pub use thin::{PrincipledThin, PrincipledThinParameters};

use super::albedo::microfacet_albedo;
use super::fresnel::{fresnel_dielectric, fresnel_of_cosines, reflect, refract};
use super::{BsdfSample, Lobes, Microfacet, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, sqr, warp};
use kaustika_spectra::Spectrum;
use parts::{ClearCoat, hue, normal_reflectance, schlick_weight, schlick_weight_from_above};

/// Mitsuba's parameters at a point; all scalars but `eta` in [0,1]. A zero is the same as an
/// absent parameter.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledParameters {
    /// Colour of the diffuse part, of metal, and squared of what is transmitted.
    pub base_color: Spectrum,
    /// Its luminance, for the tints.
    pub base_luminance: f32,
    /// Roughness of the main lobe; the facets' α is its square.
    pub roughness: f32,
    /// Anisotropy of the main lobe.
    pub anisotropic: f32,
    /// Dielectric or metal.
    pub metallic: f32,
    /// Matte or transparent.
    pub spec_trans: f32,
    /// Index inside over index outside; see [`eta_from_specular`].
    pub eta: f32,
    /// How far the dielectric reflection takes the base colour's hue.
    pub spec_tint: f32,
    /// Sheen.
    pub sheen: f32,
    /// How far the sheen takes the base colour's hue.
    pub sheen_tint: f32,
    /// From Burley's diffuse to the flattened reflection of thin subsurface scattering.
    pub flatness: f32,
    /// Strength of the clear coat.
    pub clearcoat: f32,
    /// Its gloss.
    pub clearcoat_gloss: f32,
}

impl Default for PrincipledParameters {
    /// Mitsuba's: a grey, half rough dielectric of `specular` 0.5, η = 1.5.
    fn default() -> Self {
        PrincipledParameters {
            base_color: Spectrum::splat(0.5),
            base_luminance: 0.5,
            roughness: 0.5,
            anisotropic: 0.0,
            metallic: 0.0,
            spec_trans: 0.0,
            eta: eta_from_specular(0.5),
            spec_tint: 0.0,
            sheen: 0.0,
            sheen_tint: 0.0,
            flatness: 0.0,
            clearcoat: 0.0,
            clearcoat_gloss: 0.0,
        }
    }
}

/// The index η of Mitsuba's parameter `specular` in [0,1]: normal reflectance 0.08 `specular`.
#[inline]
pub fn eta_from_specular(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular.max(0.0)).sqrt()) - 1.0
}

/// The principled model at a point.
#[derive(Clone, Copy, Debug)]
pub struct Principled {
    base: Spectrum,
    /// Factor of the sheen's weight.
    sheen: Spectrum,
    /// F of (4) at normal incidence, without F_d's part.
    schlick: Spectrum,
    /// Part of F that Schlick's approximation makes.
    schlick_part: f32,
    /// a of (1).
    brdf: f32,
    /// t of (4).
    bsdf: f32,
    roughness: f32,
    flatness: f32,
    eta: f32,
    surface: Microfacet,
    clearcoat: f32,
    coat: ClearCoat,
}

/// A pair of directions with the main lobe's facet between them.
struct Facet {
    reflects: bool,
    /// Index on the side of `wi` over that on the side of `wo`; as if refracted.
    eta: f32,
    /// Normal, on the side of z > 0.
    wm: Vec3,
    /// Cosines to it, positive.
    cos_o: f32,
    cos_i: f32,
    /// F_d.
    fresnel: f32,
}

/// Weights of (7).
struct Choice {
    diffuse: f32,
    coat: f32,
    main: f32,
}

impl Choice {
    #[inline]
    fn total(&self) -> f32 {
        self.diffuse + self.coat + self.main
    }
}

impl Principled {
    /// The model of these parameters. Transparent matter of index 1 gets 1.001, as in Mitsuba.
    pub fn new(p: PrincipledParameters) -> Principled {
        let eta = if p.eta == 1.0 && p.spec_trans > 0.0 { 1.001 } else { p.eta };
        let hue = hue(p.base_color, p.base_luminance);
        let dielectric = 1.0 - p.metallic;
        let tint = dielectric * p.spec_tint;
        Principled {
            base: p.base_color,
            sheen: Spectrum::ONE.lerp(hue, p.sheen_tint) * (p.sheen * dielectric),
            schlick: p.base_color * p.metallic + hue * (tint * normal_reflectance(eta)),
            schlick_part: p.metallic + tint,
            brdf: dielectric * (1.0 - p.spec_trans),
            bsdf: dielectric * p.spec_trans,
            roughness: p.roughness,
            flatness: p.flatness,
            eta,
            surface: parts::facets(p.roughness, p.anisotropic),
            clearcoat: p.clearcoat,
            coat: ClearCoat::new(p.clearcoat_gloss),
        }
    }

    /// False from below unless light comes through.
    #[inline]
    fn is_seen_from(&self, w: Vec3) -> bool {
        w.z > 0.0 || w.z < 0.0 && self.bsdf > 0.0
    }

    /// Index on the far side over that on the side of `w`.
    #[inline]
    fn eta_from(&self, w: Vec3) -> f32 {
        if w.z > 0.0 { self.eta } else { 1.0 / self.eta }
    }

    /// The facet between two directions; `None` if one of them sees it from behind.
    #[inline]
    fn facet(&self, wo: Vec3, wi: Vec3) -> Option<Facet> {
        let reflects = wo.z * wi.z > 0.0;
        let eta = self.eta_from(wo);
        let h = wo + if reflects { wi } else { wi * eta };
        let wm = h.try_normalize()?.face_forward(Vec3::Z);
        let (cos_o, cos_i) = (wo.dot(wm) * wo.z.signum(), wi.dot(wm) * wi.z.signum());
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return None;
        }
        let fresnel = if reflects {
            fresnel_dielectric(cos_o, eta).reflectance
        } else {
            fresnel_of_cosines(cos_o, cos_i, eta)
        };
        Some(Facet { reflects, eta, wm, cos_o, cos_i, fresnel })
    }

    /// F of (4).
    #[inline]
    fn main_fresnel(&self, from_above: bool, cos_o: f32, fresnel: f32) -> Spectrum {
        // Mitsuba leaves the main reflection out where the dielectric's vanishes, metal's too.
        if self.eta == 1.0 {
            return Spectrum::ZERO;
        }
        if !from_above {
            return Spectrum::splat(self.bsdf * fresnel);
        }
        let dielectric = Spectrum::splat((1.0 - self.schlick_part) * fresnel);
        if self.schlick_part == 0.0 {
            return dielectric;
        }
        let s = schlick_weight_from_above(cos_o, self.eta);
        dielectric + self.schlick * (1.0 - s) + Spectrum::splat(self.schlick_part * s)
    }

    #[inline]
    fn choice(&self, wo: Vec3, lobes: Lobes) -> Choice {
        let on = |class, weight: f32| if lobes.has(class) { weight } else { 0.0 };
        let above = wo.z > 0.0;
        let main = on(Lobes::GLOSSY_REFLECTION, 1.0).max(if self.bsdf > 0.0 {
            on(Lobes::GLOSSY_TRANSMISSION, 1.0)
        } else {
            0.0
        });
        Choice {
            diffuse: if above { on(Lobes::DIFFUSE_REFLECTION, self.brdf) } else { 0.0 },
            coat: if above { on(Lobes::GLOSSY_REFLECTION, 0.25 * self.clearcoat) } else { 0.0 },
            main,
        }
    }

    /// Probability that the main lobe reflects at a facet.
    #[inline]
    fn reflects(&self, wo: Vec3, fresnel: f32, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::GLOSSY_TRANSMISSION) || self.bsdf == 0.0 {
            return 1.0;
        }
        if !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return 0.0;
        }
        1.0 - (1.0 - fresnel) * if wo.z > 0.0 { self.bsdf } else { 1.0 }
    }

    /// Density of `wi` given `wo`.
    fn density(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> f32 {
        let choice = self.choice(wo, lobes);
        if choice.total() == 0.0 || !self.is_seen_from(wo) {
            return 0.0;
        }
        let mut sum = 0.0;
        if wo.z > 0.0 && wi.z > 0.0 {
            sum += choice.diffuse * warp::cosine_hemisphere_pdf_w(wi.z);
        }
        if let Some(f) = self.facet(wo, wi) {
            let reflects = self.reflects(wo, f.fresnel, lobes);
            let visible = choice.main * self.surface.pdf_visible(wo, f.wm);
            if f.reflects {
                let coat = choice.coat * self.coat.d(f.wm) * f.wm.z;
                sum += (visible * reflects + coat) / (4.0 * f.cos_o);
            } else if self.bsdf > 0.0 {
                sum += visible * (1.0 - reflects) * f.cos_i / sqr(f.cos_o / f.eta - f.cos_i);
            }
        }
        sum / choice.total()
    }
}

impl Scatter for Principled {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if !self.is_seen_from(wo) || !self.is_seen_from(wi) {
            return Spectrum::ZERO;
        }
        let above = wo.z > 0.0 && wi.z > 0.0;
        let mut value = Spectrum::ZERO;
        if above && self.brdf > 0.0 && lobes.has(Lobes::DIFFUSE_REFLECTION) {
            let cos_d = wi.dot((wo + wi).normalize());
            let f = parts::diffuse(wo.z, wi.z, cos_d, self.roughness, self.flatness);
            value += self.base * (self.brdf * INV_PI * f * wi.z); // (1)
            value += self.sheen * (schlick_weight(cos_d) * wi.z); // (2)
        }
        let Some(f) = self.facet(wo, wi) else { return value };
        if f.reflects && lobes.has(Lobes::GLOSSY_REFLECTION) {
            let shape = self.surface.d(f.wm) * self.surface.g2(wo, wi) / (4.0 * wo.z.abs());
            value += self.main_fresnel(above, f.cos_o, f.fresnel) * shape; // (3)
            if above && self.clearcoat > 0.0 {
                let s = schlick_weight_from_above(f.cos_o, self.eta);
                let coat = (0.04 + 0.96 * s) * self.coat.d(f.wm) * ClearCoat::g2(wo, wi);
                value += Spectrum::splat(0.25 * self.clearcoat * coat * wi.z); // (6)
            }
        }
        if !f.reflects && self.bsdf > 0.0 && lobes.has(Lobes::GLOSSY_TRANSMISSION) {
            let shape = self.surface.d(f.wm) * self.surface.g2(wo, wi) / wo.z.abs();
            let bend = f.cos_o * f.cos_i / sqr(f.cos_o / f.eta - f.cos_i);
            let scale = if mode == Mode::Radiance { 1.0 / sqr(f.eta) } else { 1.0 };
            value += self.base.sqrt() * (self.bsdf * (1.0 - f.fresnel) * shape * bend * scale); // (5)
        }
        value
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !self.is_seen_from(wo) || !self.is_seen_from(wi) {
            return (0.0, 0.0);
        }
        (self.density(wo, wi, lobes), self.density(wi, wo, lobes))
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let choice = self.choice(wo, lobes);
        if choice.total() == 0.0 || !self.is_seen_from(wo) {
            return None;
        }
        let uc = uc * choice.total();
        let (wi, eta, lobe) = if uc < choice.diffuse {
            (warp::cosine_hemisphere(u2), 1.0, Lobes::DIFFUSE_REFLECTION)
        } else if uc < choice.diffuse + choice.coat {
            (reflect(wo, self.coat.sample(u2)), 1.0, Lobes::GLOSSY_REFLECTION)
        } else {
            let n = self.surface.sample_visible(wo, u2) * wo.z.signum();
            let cos_o = wo.dot(n);
            if cos_o <= 0.0 {
                return None;
            }
            let i = fresnel_dielectric(cos_o, self.eta_from(wo));
            let u = (uc - choice.diffuse - choice.coat) / choice.main;
            if u < self.reflects(wo, i.reflectance, lobes) {
                (reflect(wo, n), 1.0, Lobes::GLOSSY_REFLECTION)
            } else if i.cos_t > 0.0 {
                (refract(wo, n, cos_o, i.cos_t, i.eta), i.eta, Lobes::GLOSSY_TRANSMISSION)
            } else {
                return None;
            }
        };
        // Some facets send light on to other facets, which is lost.
        if (wo.z * wi.z > 0.0) != Lobes::REFLECTION.has(lobe) || wi.z == 0.0 {
            return None;
        }
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta, lobe })
    }

    /// A sum of approximate parts: facets by tables, fits of the diffuse part and the sheen; the
    /// clear coat as if smooth. Within 0.1 for opaque models, 0.3 for others.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let reflected = |r0| microfacet_albedo(&self.surface, r0, up);
        let mirror = reflected(Spectrum::ONE);
        let smooth = fresnel_dielectric(wo.z, self.eta).reflectance;
        // From the denser side total reflection is beyond the tables: as if smooth.
        let plain = if self.eta_from(wo) > 1.0 {
            reflected(Spectrum::splat(normal_reflectance(self.eta)))
        } else {
            mirror * smooth
        };
        let passed = self.base.sqrt() * (mirror - plain) * self.bsdf;
        if wo.z <= 0.0 {
            return passed + plain * self.bsdf;
        }
        let main = if self.eta > 1.0 {
            // Schlick's term (1 - F₀) s belongs to its part only.
            let rest = 1.0 - self.schlick_part;
            plain * rest + reflected(self.schlick) - reflected(Spectrum::ZERO) * rest
        } else {
            mirror * self.main_fresnel(true, wo.z, smooth)
        };
        let s = schlick_weight(wo.z);
        let coat = 0.25 * self.clearcoat * (0.04 + 0.96 * s) * ClearCoat::g2(up, up);
        let diffuse = self.brdf * (0.98 - 0.5 * s + 1.2 * self.roughness * (s + 0.05));
        let sheen = if self.brdf > 0.0 { self.sheen } else { Spectrum::ZERO };
        main + Spectrum::splat(coat)
            + self.base * diffuse
            + sheen * parts::sheen_albedo(wo.z)
            + passed
    }

    /// Of the main lobe.
    #[inline]
    fn roughness(&self) -> f32 {
        self.surface.roughness()
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        let on = |class, weight: f32| if weight > 0.0 { class } else { Lobes::NONE };
        Lobes::GLOSSY_REFLECTION
            | on(Lobes::DIFFUSE_REFLECTION, self.brdf)
            | on(Lobes::GLOSSY_TRANSMISSION, self.bsdf)
    }
}
