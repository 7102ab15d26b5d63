//! Facets of sixteen rough surfaces: isotropic, of the GGX distribution, between dielectrics.

use kaustika_math::INV_PI;
use kaustika_math::lanes::{Lanes, Vec3s, safe_sqrt, sin_cos_turn};

/// D(m): [`Microfacet`](crate::bsdf::Microfacet), (1).
#[inline(always)]
pub(super) fn ggx(wm: Vec3s, alpha: Lanes) -> Lanes {
    let a2 = alpha * alpha;
    let slope = wm.x.mul_add(wm.x, wm.y * wm.y) / a2;
    let sum = wm.z.mul_add(wm.z, slope);
    Lanes::splat(INV_PI) / (a2 * sum * sum)
}

/// Λ(ω): there, (3).
#[inline(always)]
pub(super) fn lambda(w: Vec3s, alpha: Lanes) -> Lanes {
    let one = Lanes::splat(1.0);
    let s = alpha * alpha * w.x.mul_add(w.x, w.y * w.y) / (w.z * w.z);
    Lanes::splat(0.5) * s / (one + (one + s).sqrt())
}

/// A facet that `w` sees: the twin of
/// [`Microfacet::sample_visible`](crate::bsdf::Microfacet::sample_visible).
#[inline(always)]
pub(super) fn visible_facet(w: Vec3s, alpha: Lanes, u: [Lanes; 2]) -> Vec3s {
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
pub(super) fn fresnel(cos: Lanes, eta: Lanes) -> Lanes {
    let one = Lanes::splat(1.0);
    let cos = cos.fast_min(one);
    let sin2_t = cos.mul_neg_add(cos, one) / (eta * eta);
    let cos_t = safe_sqrt(one - sin2_t);
    let parallel = eta.mul_sub(cos, cos_t) / eta.mul_add(cos, cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    let f = Lanes::splat(0.5) * parallel.mul_add(parallel, perpendicular * perpendicular);
    sin2_t.simd_ge(one).select(one, f)
}
