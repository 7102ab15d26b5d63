//! The thin principled model (Mitsuba 3's `principledthin`): a sheet, the same from both sides.
//!
//! With t = spec_trans, d = diff_trans/2, ωᵢ' = ωᵢ mirrored to the side of ωₒ, m between ωₒ and
//! ωᵢ', and the parts of [`super::parts`]:
//!
//! ```text
//! reflection    f |cos θᵢ| = t [F_d, [hue R₀, 1]_s]_tint D G₂ / (4 |cos θₒ|)              (1)
//! transmission  f |cos θᵢ| = t base (1 - F_d) D' G₂' / (4 |cos θₒ|)                       (2)
//! diffuse       f = (1-t)(1-d) (base/π [f_d + f_r, f_s]_flatness + sheen s(cos θ_d) [1, hue]_sheen_tint)  (3)
//! through       f = (1-t) d base/π                                                       (4)
//! choice        reflection : transmission : diffuse : through = t/2 : t/2 : (1-t)(1-d) : (1-t) d  (5)
//! ```
//!
//! D' and G₂' are of roughness (0.65 η - 0.35) roughness (Burley 2015, fig. 15). Where -ωᵢ would see the
//! facet m from behind, (2) is zero; that condition is not symmetric, and importance mode takes
//! the one of its adjoint.

use super::super::albedo::microfacet_albedo;
use super::super::fresnel::{fresnel_dielectric, reflect};
use super::super::{BsdfSample, Lobes, Microfacet, Mode, Scatter};
use super::parts::{
    self, hue, normal_reflectance, schlick_weight, schlick_weight_from_above, sheen_albedo,
};
use kaustika_math::{INV_PI, Vec2, Vec3, warp};
use kaustika_spectra::Spectrum;

/// Mitsuba's parameters at a point; all scalars in [0,1] but `eta` and `diff_trans`. A zero is
/// the same as an absent parameter.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledThinParameters {
    /// Colour of the diffuse parts and of specular transmission.
    pub base_color: Spectrum,
    /// Its luminance, for the tints.
    pub base_luminance: f32,
    /// Roughness of the specular lobes; the facets' α is its square.
    pub roughness: f32,
    /// Anisotropy of the specular lobes.
    pub anisotropic: f32,
    /// Diffuse or specular.
    pub spec_trans: f32,
    /// In [0,2]: from diffuse reflection to diffuse transmission.
    pub diff_trans: f32,
    /// Index of the sheet over that around it.
    pub eta: f32,
    /// How far the specular reflection takes the base colour's hue.
    pub spec_tint: f32,
    /// Sheen.
    pub sheen: f32,
    /// How far the sheen takes the base colour's hue.
    pub sheen_tint: f32,
    /// From Burley's diffuse to the flattened reflection of thin subsurface scattering.
    pub flatness: f32,
}

impl Default for PrincipledThinParameters {
    /// Mitsuba's: a grey, matte sheet.
    fn default() -> Self {
        PrincipledThinParameters {
            base_color: Spectrum::splat(0.5),
            base_luminance: 0.5,
            roughness: 0.5,
            anisotropic: 0.0,
            spec_trans: 0.0,
            diff_trans: 0.0,
            eta: 1.5,
            spec_tint: 0.0,
            sheen: 0.0,
            sheen_tint: 0.0,
            flatness: 0.0,
        }
    }
}

/// The thin principled model at a point.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledThin {
    base: Spectrum,
    /// Factor of the sheen's weight in (3).
    sheen: Spectrum,
    /// Reflectance at normal incidence of the tinted part.
    tinted: Spectrum,
    spec_tint: f32,
    spec_trans: f32,
    /// (1-t)(1-d) and (1-t) d.
    reflected: f32,
    through: f32,
    roughness: f32,
    flatness: f32,
    eta: f32,
    surface: Microfacet,
    /// The facets of transmission.
    surface_through: Microfacet,
}

/// Both directions as if `wo` were above, and their facet.
struct Fold {
    wo: Vec3,
    /// On the side it is relative to `wo`.
    wi: Vec3,
    /// Mirrored to the side of `wo`.
    wi_up: Vec3,
    wm: Vec3,
}

impl Fold {
    #[inline]
    fn new(wo: Vec3, wi: Vec3) -> Option<Fold> {
        if wo.z == 0.0 || wi.z == 0.0 {
            return None;
        }
        let sign = wo.z.signum();
        let (wo, wi) = (wo * sign, wi * sign);
        let wi_up = Vec3::new(wi.x, wi.y, wi.z.abs());
        let wm = (wo + wi_up).try_normalize()?;
        Some(Fold { wo, wi, wi_up, wm })
    }

    #[inline]
    fn reflects(&self) -> bool {
        self.wi.z > 0.0
    }
}

impl PrincipledThin {
    /// The model of these parameters.
    pub fn new(p: PrincipledThinParameters) -> PrincipledThin {
        let hue = hue(p.base_color, p.base_luminance);
        let d = 0.5 * p.diff_trans;
        let reflected = (1.0 - p.spec_trans) * (1.0 - d);
        PrincipledThin {
            base: p.base_color,
            sheen: Spectrum::ONE.lerp(hue, p.sheen_tint) * (p.sheen * reflected),
            tinted: hue * normal_reflectance(p.eta),
            spec_tint: p.spec_tint,
            spec_trans: p.spec_trans,
            reflected,
            through: (1.0 - p.spec_trans) * d,
            roughness: p.roughness,
            flatness: p.flatness,
            eta: p.eta,
            surface: parts::facets(p.roughness, p.anisotropic),
            surface_through: parts::facets((0.65 * p.eta - 0.35) * p.roughness, p.anisotropic),
        }
    }

    /// Weights (5) of reflection, transmission, diffuse, through.
    #[inline]
    fn weights(&self, lobes: Lobes) -> [f32; 4] {
        let on = |class, weight: f32| if lobes.has(class) { weight } else { 0.0 };
        [
            on(Lobes::GLOSSY_REFLECTION, 0.5 * self.spec_trans),
            on(Lobes::GLOSSY_TRANSMISSION, 0.5 * self.spec_trans),
            on(Lobes::DIFFUSE_REFLECTION, self.reflected),
            on(Lobes::DIFFUSE_TRANSMISSION, self.through),
        ]
    }

    /// F of (1).
    #[inline]
    fn reflectance(&self, cos: f32) -> Spectrum {
        let plain = Spectrum::splat(fresnel_dielectric(cos, self.eta).reflectance);
        if self.spec_tint == 0.0 {
            return plain;
        }
        let s = schlick_weight_from_above(cos, self.eta);
        plain.lerp(self.tinted.lerp(Spectrum::ONE, s), self.spec_tint)
    }
}

impl Scatter for PrincipledThin {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        let (wo, wi, cos_i) = match mode {
            Mode::Radiance => (wo, wi, wi.z.abs()),
            Mode::Importance => (wi, wo, wi.z.abs()),
        };
        let Some(f) = Fold::new(wo, wi) else { return Spectrum::ZERO };
        let [specular, specular_through, diffuse, through] = self.weights(lobes);
        // The common factor D G₂/(4 cos cos) of (1) and (2), without cosines of the mode.
        let shape = |s: &Microfacet| s.d(f.wm) * s.g2(f.wo, f.wi_up) / (4.0 * f.wo.z * f.wi_up.z);
        let cos_d = f.wo.dot(f.wm);
        let mut value = Spectrum::ZERO;
        if f.reflects() {
            if specular > 0.0 {
                let t = self.spec_trans * shape(&self.surface);
                value += self.reflectance(cos_d) * t; // (1)
            }
            if diffuse > 0.0 {
                let g = parts::diffuse(f.wo.z, f.wi.z, cos_d, self.roughness, self.flatness);
                value += self.base * (self.reflected * INV_PI * g); // (3)
                value += self.sheen * schlick_weight(cos_d);
            }
        } else {
            if specular_through > 0.0 && f.wi.dot(f.wm) < 0.0 {
                let fresnel = fresnel_dielectric(cos_d, self.eta).reflectance;
                let t = self.spec_trans * (1.0 - fresnel) * shape(&self.surface_through);
                value += self.base * t; // (2)
            }
            if through > 0.0 {
                value += self.base * (self.through * INV_PI); // (4)
            }
        }
        value * cos_i
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        let Some(f) = Fold::new(wo, wi) else { return (0.0, 0.0) };
        let [specular, specular_through, diffuse, through] = self.weights(lobes);
        let total = specular + specular_through + diffuse + through;
        if total == 0.0 {
            return (0.0, 0.0);
        }
        let (glossy, surface, matte) = if f.reflects() {
            (specular, &self.surface, diffuse)
        } else {
            (specular_through, &self.surface_through, through)
        };
        let (mut forward, mut reverse) = (matte * INV_PI * f.wi_up.z, matte * INV_PI * f.wo.z);
        if glossy > 0.0 {
            let (a, b) = surface.pdf_reflection(f.wo, f.wi_up, f.wm);
            (forward, reverse) = (forward + glossy * a, reverse + glossy * b);
        }
        (forward / total, reverse / total)
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        const CLASSES: [Lobes; 4] = [
            Lobes::GLOSSY_REFLECTION,
            Lobes::GLOSSY_TRANSMISSION,
            Lobes::DIFFUSE_REFLECTION,
            Lobes::DIFFUSE_TRANSMISSION,
        ];
        let weights = self.weights(lobes);
        let total: f32 = weights.iter().sum();
        if wo.z == 0.0 || total == 0.0 {
            return None;
        }
        let mut u = uc * total;
        let mut chosen = None;
        for (weight, class) in weights.into_iter().zip(CLASSES) {
            if weight > 0.0 {
                chosen = Some(class);
                if u < weight {
                    break;
                }
                u -= weight;
            }
        }
        let lobe = chosen?;
        let sign = wo.z.signum();
        let up = wo * sign;
        let mut wi = match lobe {
            Lobes::GLOSSY_REFLECTION => reflect(up, self.surface.sample_visible(up, u2)),
            Lobes::GLOSSY_TRANSMISSION => reflect(up, self.surface_through.sample_visible(up, u2)),
            _ => warp::cosine_hemisphere(u2),
        };
        // Some facets send light on to other facets, which is lost.
        if wi.z <= 0.0 {
            return None;
        }
        if Lobes::TRANSMISSION.has(lobe) {
            wi.z = -wi.z;
        }
        wi *= sign;
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// A sum of approximate parts: facets by tables, Lambert for the diffuse ones, a fit of the
    /// sheen. In radiance mode, within 0.2.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let plain = Spectrum::splat(normal_reflectance(self.eta));
        let reflected =
            microfacet_albedo(&self.surface, plain.lerp(self.tinted, self.spec_tint), up);
        let mirror = microfacet_albedo(&self.surface_through, Spectrum::ONE, up);
        let passed = mirror - microfacet_albedo(&self.surface_through, plain, up);
        (reflected + self.base * passed) * self.spec_trans
            + self.base * (self.reflected + self.through)
            + self.sheen * sheen_albedo(up.z)
    }

    /// Of the specular lobes; 1 without them.
    #[inline]
    fn roughness(&self) -> f32 {
        if self.spec_trans > 0.0 { self.surface.roughness() } else { 1.0 }
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        let on = |class, weight: f32| if weight > 0.0 { class } else { Lobes::NONE };
        on(Lobes::GLOSSY, self.spec_trans)
            | on(Lobes::DIFFUSE_REFLECTION, self.reflected)
            | on(Lobes::DIFFUSE_TRANSMISSION, self.through)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::testing::{Expect, check_model};
    use super::*;
    use std::f32::consts::PI;

    fn colored() -> PrincipledThinParameters {
        let base_color = Spectrum([0.7, 0.1, 0.1, 0.0]);
        let base_luminance = 0.2126 * 0.7 + 0.7874 * 0.1;
        PrincipledThinParameters { base_color, base_luminance, eta: 1.33, ..Default::default() }
    }

    #[test]
    fn holds_the_contract() {
        let cases = [
            PrincipledThinParameters::default(),
            PrincipledThinParameters { spec_trans: 1.0, roughness: 0.6, ..colored() },
            PrincipledThinParameters {
                spec_trans: 0.4,
                diff_trans: 1.4,
                anisotropic: 0.8,
                sheen: 0.8,
                ..colored()
            },
            PrincipledThinParameters {
                spec_trans: 0.8,
                diff_trans: 0.4,
                roughness: 0.2,
                spec_tint: 0.6,
                sheen: 0.5,
                sheen_tint: 0.5,
                flatness: 0.7,
                ..colored()
            },
            PrincipledThinParameters { diff_trans: 2.0, ..colored() },
        ];
        for p in cases {
            let expect = Expect {
                both_sides: true,
                albedo_max: 1.25,
                // Importance mode, which is measured, is darker where (2)'s condition bites.
                albedo_error: 0.5,
                samples: 20_000,
                ..Expect::default()
            };
            check_model(&format!("{p:?}"), &PrincipledThin::new(p), expect);
        }
    }

    /// At normal incidence by hand: α of transmission ((0.65·1.5 - 0.35)·0.5)².
    #[test]
    fn has_its_known_values() {
        let p = PrincipledThinParameters { spec_trans: 0.5, diff_trans: 0.6, ..Default::default() };
        let model = PrincipledThin::new(p);
        let at = |wi| model.eval(Vec3::Z, wi, Mode::Radiance, Lobes::ALL)[0];
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5 * b, "{a} {b}");
        let shape = |alpha: f32| 0.25 / (PI * alpha * alpha);
        near(at(Vec3::Z), 0.5 * 0.04 * shape(0.25) + 0.35 * 0.5 * INV_PI);
        let alpha = (0.625f32 * 0.5).powi(2);
        near(at(-Vec3::Z), 0.5 * 0.5 * 0.96 * shape(alpha) + 0.15 * 0.5 * INV_PI);
    }
}
