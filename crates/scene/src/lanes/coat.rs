//! Rough clear coats over the matte bases of sixteen surfaces: the twin of
//! [`RoughPlastic`](crate::bsdf::RoughPlastic), whose numbers the formulas have, for isotropic
//! facets of the GGX distribution.

use crate::bsdf::{AlphaIndex, Masking, RoughPlastic, RoughTransmittance};
use crate::description::{Distribution, MaterialId, MaterialModel};
use crate::material::Materials;
use crate::texture::Textures;
use kaustika_math::INV_PI;
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s, mask_of, safe_sqrt, sin_cos_turn};
use kaustika_spectra::Spectrum;
use std::sync::Arc;

/// A coat that is the same all over its shape.
#[derive(Clone, Debug)]
pub struct Coat {
    tables: Arc<RoughTransmittance>,
    at: AlphaIndex,
    alpha: f32,
    specular: Spectrum,
    nonlinear: bool,
    /// True if masking and shadowing are correlated.
    correlated: bool,
}

impl Coat {
    pub(super) fn of(
        materials: &Materials,
        textures: &Textures,
        id: MaterialId,
        specular: Spectrum,
    ) -> Option<Coat> {
        let MaterialModel::Plastic { roughness: Some(r), nonlinear, .. } = materials.model(id)
        else {
            return None;
        };
        let alpha = textures.constant(r.alpha_u)?;
        let alpha = if r.remap { alpha.max(0.0).sqrt() } else { alpha };
        let alike = textures.constant(r.alpha_u) == textures.constant(r.alpha_v);
        if r.distribution != Distribution::Ggx || !alike || alpha <= 0.0 {
            return None;
        }
        let tables = materials.rough_coat(id)?;
        let alpha = alpha.max(crate::bsdf::Microfacet::ALPHA_MIN);
        let correlated = materials.masking() == Masking::HeightCorrelated;
        let at = tables.index(alpha);
        Some(Coat { tables, at, alpha, specular, nonlinear: *nonlinear, correlated })
    }

    #[inline]
    fn transmittance(&self, cos: f32) -> f32 {
        self.tables.transmittance(self.at, cos)
    }
}

/// The coats of sixteen surfaces, gathered lane by lane.
#[repr(C, align(64))]
#[derive(Debug, Default)]
pub struct Coats<'a> {
    /// Lanes that have one.
    pub lanes: u32,
    of: [Option<&'a Coat>; LANES],
    alpha: Row,
    eta: Row,
    weight: Row,
    specular: [Row; 4],
    correlated: u32,
}

/// Sixteen coats seen from their directions ωₒ, which are in the shading frames.
#[derive(Clone, Copy, Debug)]
pub struct SeenCoats {
    mask: Lanes,
    wo: Vec3s,
    /// T(ωₒ); 1 without a coat.
    t: Lanes,
    /// Probability of the coat's reflection, (3); 0 without a coat.
    choice: Lanes,
    /// Λ(ωₒ).
    lambda: Lanes,
    alpha: Lanes,
    correlated: Lanes,
}

impl<'a> Coats<'a> {
    /// Puts a coat over the base of albedo `rho` in a lane; what is left of the base, ρ'/η².
    #[inline]
    pub fn set(&mut self, lane: usize, coat: &'a Coat, rho: Spectrum) -> Spectrum {
        let lane = lane % LANES;
        let bit = 1 << lane;
        let (base, weight) =
            RoughPlastic::base(&coat.tables, coat.at, rho, coat.specular, coat.nonlinear);
        self.lanes |= bit;
        self.of[lane] = Some(coat);
        self.alpha[lane] = coat.alpha;
        self.eta[lane] = coat.tables.eta();
        self.weight[lane] = weight;
        self.specular.iter_mut().zip(coat.specular.0).for_each(|(row, s)| row[lane] = s);
        self.correlated = self.correlated & !bit | if coat.correlated { bit } else { 0 };
        base
    }

    /// T at the angles of these cosines; 1 without a coat.
    #[inline]
    fn transmittances(&self, cos: Lanes) -> Lanes {
        let mut t = cos.to_array();
        for (i, t) in t.iter_mut().enumerate() {
            *t = match self.of[i] {
                Some(coat) if self.lanes >> i & 1 != 0 => coat.transmittance(*t),
                _ => 1.0,
            };
        }
        Lanes::new(t)
    }

    /// The coats as `wo` see them, from above.
    #[inline(always)]
    pub fn seen(&self, wo: Vec3s) -> SeenCoats {
        let (zero, one) = (Lanes::splat(0.0), Lanes::splat(1.0));
        let mask = mask_of(self.lanes);
        let t = self.transmittances(wo.z);
        let weight = Lanes::new(self.weight);
        let (coat, base) = ((one - t) * weight, t * (one - weight));
        let sum = coat + base;
        let choice = sum.simd_gt(zero).select(coat / sum, one);
        let alpha = Lanes::new(self.alpha);
        SeenCoats {
            mask,
            wo,
            t,
            choice: mask.select(choice, zero),
            lambda: lambda(wo, alpha),
            alpha,
            correlated: mask_of(self.correlated),
        }
    }

    /// Values f |cos θᵢ| of (1) and densities of `wi` above the surfaces, whose bases are
    /// `base`; without a coat those of the bare base.
    #[inline(always)]
    pub fn eval_pdf(&self, seen: &SeenCoats, base: &[Lanes; 4], wi: Vec3s) -> ([Lanes; 4], Lanes) {
        let (zero, one, quarter) = (Lanes::splat(0.0), Lanes::splat(1.0), Lanes::splat(0.25));
        let inv_pi = Lanes::splat(INV_PI);
        let wo = seen.wo;
        let wm = (wo + wi).normalize();
        let facets = ggx(wm, seen.alpha) * quarter / wo.z;
        let lambda_i = lambda(wi, seen.alpha);
        let (go, gi) = (one + seen.lambda, one + lambda_i);
        let g2 = one / seen.correlated.select(go + lambda_i, go * gi);
        let f = fresnel(wo.dot(wm), Lanes::new(self.eta));
        let coat = seen.mask.select(f * facets * g2, zero);
        let through = seen.t * self.transmittances(wi.z) * inv_pi * wi.z;
        let value =
            std::array::from_fn(|i| Lanes::new(self.specular[i]).mul_add(coat, base[i] * through));
        let of_coat = seen.mask.select(seen.choice * facets / go, zero);
        (value, (one - seen.choice).mul_add(wi.z * inv_pi, of_coat))
    }

    /// Directions: mirrored at visible facets where `uc` chooses the coat, elsewhere `matte`.
    /// They may point below the surface.
    #[inline(always)]
    pub fn sample(&self, seen: &SeenCoats, uc: Lanes, u: [Lanes; 2], matte: Vec3s) -> Vec3s {
        let wo = seen.wo;
        let wm = visible_facet(wo, seen.alpha, u);
        let mirrored = wm * (Lanes::splat(2.0) * wo.dot(wm)) - wo;
        mirrored.or(uc.simd_lt(seen.choice), matte)
    }
}

/// D(m): [`Microfacet`](crate::bsdf::Microfacet), (1).
#[inline(always)]
fn ggx(wm: Vec3s, alpha: Lanes) -> Lanes {
    let a2 = alpha * alpha;
    let slope = wm.x.mul_add(wm.x, wm.y * wm.y) / a2;
    let sum = wm.z.mul_add(wm.z, slope);
    Lanes::splat(INV_PI) / (a2 * sum * sum)
}

/// Λ(ω): there, (3).
#[inline(always)]
fn lambda(w: Vec3s, alpha: Lanes) -> Lanes {
    let one = Lanes::splat(1.0);
    let s = alpha * alpha * w.x.mul_add(w.x, w.y * w.y) / (w.z * w.z);
    Lanes::splat(0.5) * s / (one + (one + s).sqrt())
}

/// A facet that `w` sees: the twin of
/// [`Microfacet::sample_visible`](crate::bsdf::Microfacet::sample_visible).
#[inline(always)]
fn visible_facet(w: Vec3s, alpha: Lanes, u: [Lanes; 2]) -> Vec3s {
    let one = Lanes::splat(1.0);
    let v = Vec3s { x: alpha * w.x, y: alpha * w.y, z: w.z }.normalize();
    let (s, c) = sin_cos_turn(u[0]);
    let height = u[1] * (one + v.z);
    let r = safe_sqrt(height * (Lanes::splat(2.0) - height));
    let m = Vec3s { x: r.mul_add(c, v.x), y: r.mul_add(s, v.y), z: one - height + v.z };
    let z = m.z.fast_max(Lanes::splat(1e-7));
    Vec3s { x: alpha * m.x, y: alpha * m.y, z }.normalize()
}

/// Reflectance of dielectrics: the twin of
/// [`fresnel_dielectric`](crate::bsdf::fresnel::fresnel_dielectric) for `cos` in [0, 1].
#[inline(always)]
fn fresnel(cos: Lanes, eta: Lanes) -> Lanes {
    let one = Lanes::splat(1.0);
    let cos = cos.fast_min(one);
    let sin2_t = cos.mul_neg_add(cos, one) / (eta * eta);
    let cos_t = safe_sqrt(one - sin2_t);
    let parallel = eta.mul_sub(cos, cos_t) / eta.mul_add(cos, cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    let f = Lanes::splat(0.5) * parallel.mul_add(parallel, perpendicular * perpendicular);
    sin2_t.simd_ge(one).select(one, f)
}
