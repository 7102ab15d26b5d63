//! The densities from which a layered surface draws directions: a mixture of
//!
//! * the Dirac lobe of a smooth coat,
//! * the visible normals of a rough coat,
//! * the base's lobe: through a smooth coat exactly,
//!
//! ```text
//! pdf(ωᵢ) = pdf_base(w₁, w₂) cos θᵢ/(η² cos θ₂)                                          (1)
//! ```
//!
//!   through a rough one a lobe as wide as, by Snell's law, small tilts of the facets make it: a
//!   tilt δ of the base's turns the light outside as one of κ δ would, one of the coat's, which
//!   is passed twice, by (κ-1) δ/2 each time:
//!
//! ```text
//! κ = η cos θ₁/cos θₒ,   α² = κ² α_base² + (κ-1)² α_coat²/2                             (2)
//! ```
//!
//! * a cosine, for a matte base and for what was scattered often.

use super::{Base, Layered};
use crate::bsdf::fresnel::{fresnel_dielectric, reflect, refract};
use crate::bsdf::{Lobes, Microfacet, Mode};
use crate::description::Distribution;
use kaustika_math::{Vec2, Vec3, sqr, warp};

/// Added to the coat's share: at grazing exits it reflects more than seen from `wo`.
const COAT_LEAST: f32 = 0.1;
/// The cosine's part of the light from below over a metal, and if the coat scatters.
const COSINE_METAL: f32 = 0.15;
const COSINE_SCATTERING: f32 = 0.4;

/// The mixture for one known direction.
pub(super) struct Proxy<'a, B> {
    layered: &'a Layered<B>,
    /// Probabilities: Dirac lobe, the coat's facets, the base's lobe, cosine.
    mirror: f32,
    coat: f32,
    lobe: f32,
    cosine: f32,
}

impl<B: Base> Proxy<'_, B> {
    /// The mixture seen from `wo`, from above, restricted to `lobes`; `None` if nothing is left.
    pub fn new<'a>(layered: &'a Layered<B>, wo: Vec3, lobes: Lobes) -> Option<Proxy<'a, B>> {
        let (mut mirror, mut coat, mut lobe, mut cosine) = (0.0, 0.0, 0.0, 0.0);
        let f = fresnel_dielectric(wo.z, layered.coat.ior);
        if layered.is_smooth() {
            if lobes.has(Lobes::DELTA_REFLECTION) {
                mirror = layered.mirror(wo).max_component();
            }
        } else if lobes.has(Lobes::GLOSSY_REFLECTION) {
            coat = f.reflectance + COAT_LEAST;
        }
        if lobes.has(B::CLASS) && layered.has_below() {
            let scatters = !layered.coat.albedo.is_black();
            let below = (1.0 - f.reflectance) * layered.base.albedo(Vec3::Z).max_component();
            let share = match layered.base.facets() {
                None => 1.0,
                // Nothing to draw of a mirror's Dirac lobe.
                Some(_) if layered.is_smooth() && layered.has_mirror() => 1.0,
                Some(_) if scatters => COSINE_SCATTERING,
                Some(_) => COSINE_METAL,
            };
            let below = below.max(0.05);
            lobe = below * (1.0 - share);
            cosine = below * share;
        }
        let total = mirror + coat + lobe + cosine;
        (total > 0.0).then(|| Proxy {
            layered,
            mirror: mirror / total,
            coat: coat / total,
            lobe: lobe / total,
            cosine: cosine / total,
        })
    }

    /// Probability of the Dirac lobe.
    pub fn mirror_probability(&self) -> f32 {
        self.mirror
    }

    /// (2), the base's lobe through a rough coat, seen from `wo`.
    fn wide(&self, wo: Vec3) -> Microfacet {
        let alpha = |m: Microfacet| if m.is_smooth() { 0.0 } else { m.alpha() };
        let coat = &self.layered.coat;
        let kappa = coat.ior * fresnel_dielectric(wo.z, coat.ior).cos_t / wo.z;
        let base = self.layered.base.facets().map_or(0.0, alpha);
        let square = sqr(kappa * base) + 0.5 * sqr((kappa - 1.0) * alpha(coat.surface));
        let alpha = square.sqrt().clamp(Microfacet::SMOOTH, 1.0);
        Microfacet::new(Distribution::Ggx, alpha, alpha)
    }

    /// Density of `wi` given `wo`, both above.
    pub fn density(&self, wo: Vec3, wi: Vec3) -> f32 {
        let mut sum = self.cosine * warp::cosine_hemisphere_pdf_w(wi.z);
        let wm = (wo + wi).normalize();
        if self.coat > 0.0 {
            sum += self.coat * self.layered.coat.surface.pdf_reflection(wo, wi, wm).0;
        }
        if self.lobe > 0.0 {
            sum += self.lobe
                * if self.layered.is_smooth() {
                    self.through(wo, wi)
                } else {
                    self.wide(wo).pdf_reflection(wo, wi, wm).0
                };
        }
        sum
    }

    /// (1).
    fn through(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (Some((a, _)), Some((b, _))) = (self.layered.enter(wo), self.layered.enter(wi)) else {
            return 0.0;
        };
        let base = self.layered.base.pdf(-a, -b, Mode::Radiance, Lobes::ALL).0;
        base * wi.z / (sqr(self.layered.coat.ior) * -b.z)
    }

    /// Draws a direction and says of which class.
    pub fn sample(&self, wo: Vec3, uc: f32, u2: Vec2) -> Option<(Vec3, Lobes)> {
        if uc < self.mirror {
            return Some((Vec3::new(-wo.x, -wo.y, wo.z), Lobes::DELTA_REFLECTION));
        }
        let uc = uc - self.mirror;
        if uc < self.coat {
            let wm = self.layered.coat.surface.sample_visible(wo, u2);
            return Some((reflect(wo, wm), Lobes::GLOSSY_REFLECTION));
        }
        let uc = uc - self.coat;
        if uc >= self.lobe {
            // Rounding may lead here where there is no cosine.
            return (self.cosine > 0.0).then(|| (warp::cosine_hemisphere(u2), B::CLASS));
        }
        if !self.layered.is_smooth() {
            return Some((reflect(wo, self.wide(wo).sample_visible(wo, u2)), B::CLASS));
        }
        let (w, _) = self.layered.enter(wo)?;
        let u = uc / self.lobe;
        let up = self.layered.base.sample(-w, u, u2, Mode::Radiance, Lobes::ALL)?.wi;
        let f = fresnel_dielectric(-up.z, self.layered.coat.ior);
        (f.cos_t > 0.0).then(|| (refract(-up, -Vec3::Z, up.z, f.cos_t, f.eta), B::CLASS))
    }
}
