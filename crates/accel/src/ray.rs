//! A ray made ready for traversal, and why no box test loses a hit.
//!
//! Axes are permuted so that the last, `kz`, is where the direction is longest. u = 2⁻²⁴.
//!
//! The triangle test shears a vertex `p` to `x = (p-o)ₓ - (dₓ/d_z)(p-o)_z` and takes the signs of
//! its edge functions exactly, so it answers for a triangle whose corners are off by
//! `u(2|p-o|ₓ + 3|dₓ/d_z||p-o|_z)` along x (and so along y) and not at all along z. Divided by
//! `|dₓ|` and averaged with the barycentric weights at the hit `t`, with `z⁻` how far the triangle
//! reaches behind the origin along z (in units of t): the slab's entry t₀ and exit t₁ obey
//!
//! ```text
//! t₀ (1 - 2u) ≤ t + 3u (t + 2z⁻),    t₁ (1 + 2u) ≥ t - 3u (t + 2z⁻)
//! ```
//!
//! The slab distances themselves, `fma(plane, 1/d, -o/d)`, are off by 2u of their value, for which
//! a factor pays, and by 2u|o/d|, for which the constants `near_c` and `far_c` pay. In all
//!
//! ```text
//! max(0, t₀ of all slabs) ≤ (1 + 16u) min(t₁ of all slabs) + 16u z⁻               (1)
//! ```
//!
//! holds for the box of a triangle that the triangle test accepts. All roundings are monotone, and
//! a larger box has earlier entries, later exits and a larger z⁻: (1) holds for every box above.
//!
//! A direction component below 2⁻⁴⁰ of the longest is taken as that; the ray is then off by less
//! than 2⁻³⁹ of the distance to the far end of the scene, for which `near_c` and `far_c` pay too.

use kaustika_math::{Bounds3, Ray, Vec3};

use crate::simd::F32x8;

/// Coordinates above this magnitude are treated as not finite.
pub(crate) const MAX_COORDINATE: f32 = 1.152_921_5e18; // 2⁶⁰
/// 16u of equation (1).
pub(crate) const SLACK: f32 = 1.0 / (1 << 20) as f32;
/// Up to this magnitude of coordinates no product of the triangle test overflows.
const MAX_SINGLE_PRECISION: f32 = 1.099_511_6e12; // 2⁴⁰
/// An edge function above this is a difference of products that did not underflow.
const MIN_EDGE_FUNCTION: f32 = 1.262_177_4e-29; // 2⁻⁹⁶
/// Least ratio of direction components, 2⁻⁴⁰.
const MIN_SLOPE: f32 = 1.0 / (1u64 << 40) as f32;

/// What box and triangle tests need of a ray, each number in all eight lanes.
pub(crate) struct PreparedRay {
    /// The axes (kx, ky, kz).
    pub(crate) axes: [usize; 3],
    /// Whether the direction is negative along each of `axes`.
    pub(crate) negative: [bool; 3],
    /// The origin along `axes`.
    pub(crate) o: [F32x8; 3],
    /// dₓ/d_z, d_y/d_z, 1/d_z.
    pub(crate) shear: [F32x8; 3],
    /// 1/d along `axes`, bounded.
    pub(crate) inv_d: [F32x8; 3],
    /// -o/d along `axes`, lowered so that entries come out early.
    pub(crate) near_c: [F32x8; 3],
    /// -o/d along `axes`, raised so that exits come out late.
    pub(crate) far_c: [F32x8; 3],
    /// Edge functions must exceed this to be trusted in single precision.
    pub(crate) min_edge: F32x8,
    /// Distances of the caller = `scale` × distances here; a power of two.
    pub(crate) scale: f32,
}

impl PreparedRay {
    /// `None` if the ray is no half-line: not finite, or without direction.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, bounds: &Bounds3) -> Option<PreparedRay> {
        let longest = ray.d.abs().max_axis();
        let (d, scale) = moderate(ray.d, ray.d[longest].abs())?;
        let reach = ray.o.abs().max_component();
        // A NaN in the origin must not pass: min and max may drop it.
        if !(reach <= 16.0 * MAX_COORDINATE && ray.o.is_finite() && d.is_finite()) {
            return None;
        }
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][longest];
        let [kx, ky, kz] = axes;
        let d = [d[kx], d[ky], d[kz]];
        let o = [ray.o[kx], ray.o[ky], ray.o[kz]];
        let inv_dz = 1.0 / d[2];
        let least = d[2].abs() * MIN_SLOPE;
        let mut inv_d = [1.0 / d[0], 1.0 / d[1], inv_dz];
        let mut slack = [0.0; 3];
        for i in 0..2 {
            if d[i].abs() < least {
                inv_d[i] = (1.0 / least).copysign(d[i]);
                let far = (bounds.min[kz] - o[2]).abs().max((bounds.max[kz] - o[2]).abs());
                slack[i] = 4.0 * far * inv_dz.abs();
            }
        }
        let c: [f32; 3] = std::array::from_fn(|i| -o[i] * inv_d[i]);
        let slack: [f32; 3] =
            std::array::from_fn(|i| c[i].abs() * (1.0 / (1 << 22) as f32) + slack[i]);
        let extent = bounds.min.abs().max(bounds.max.abs()).max_component().max(reach);
        let min_edge =
            if extent <= MAX_SINGLE_PRECISION { MIN_EDGE_FUNCTION } else { f32::INFINITY };
        Some(PreparedRay {
            axes,
            negative: inv_d.map(|v| v.is_sign_negative()),
            o: o.map(F32x8::splat),
            shear: [d[0] / d[2], d[1] / d[2], inv_dz].map(F32x8::splat),
            inv_d: inv_d.map(F32x8::splat),
            near_c: std::array::from_fn(|i| F32x8::splat(c[i] - slack[i])),
            far_c: std::array::from_fn(|i| F32x8::splat(c[i] + slack[i])),
            min_edge: F32x8::splat(min_edge),
            scale,
        })
    }
}

/// The direction scaled by a power of two if its longest component is far from one, and what
/// to multiply distances by afterwards. Shorter than 1e-30 counts as no direction.
#[inline(always)]
fn moderate(d: Vec3, longest: f32) -> Option<(Vec3, f32)> {
    if (1e-6..1e6).contains(&longest) {
        return Some((d, 1.0));
    }
    if !(longest > 1e-30 && longest < f32::INFINITY) {
        return None;
    }
    let exponent = (longest.to_bits() >> 23) as i32 - 127;
    let scale = 2f32.powi(-exponent);
    Some((d * scale, scale))
}
