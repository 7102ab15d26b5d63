//! A ray made ready for traversal, and why no box test loses a hit.
//!
//! z is the axis along which the direction is longest, x any of the two others; u = 2⁻²⁴.
//!
//! The triangle test shears a vertex `p` to `x = (p-o)ₓ - (dₓ/d_z)(p-o)_z` and takes the signs of
//! its edge functions exactly, so it answers for a triangle whose corners are off by
//! `u(2|p-o|ₓ + 3|dₓ/d_z||p-o|_z)` along x and not at all along z. Divided by `|dₓ|` and averaged
//! with the barycentric weights at the hit `t`, with `z⁻` how far the triangle reaches behind the
//! origin along z (in units of t): the slab's entry t₀ and exit t₁ obey
//!
//! ```text
//! t₀ (1 - 2u) ≤ t + 3u (t + 2z⁻),    t₁ (1 + 2u) ≥ t - 3u (t + 2z⁻)
//! ```
//!
//! **z⁻** is paid for by the boxes: each is wider, at both ends of each axis, by 32u of its longest
//! side ([`widened`]). That is 32u z⁻ or more in units of t, since no component of the direction
//! is larger than that along z. So nothing has to be paid by the test of a node, and a tree that
//! is large does not make its small boxes less tight.
//!
//! **Rounding.** Slab distances, `fma(plane, 1/d, -o/d)`, are off by 3u of their value (`1/d`, the
//! sum, the widened plane), for which a factor pays, and by 3u|o/d| (`-o/d`, its change to `near_c`
//! or `far_c`, the widened plane), for which these constants pay with 4u|o/d|. In all
//!
//! ```text
//! max(0, t₀ of all slabs) ≤ (1 + 32u) min(t₁ of all slabs)                        (1)
//! ```
//!
//! holds for the widened box of a triangle that the triangle test accepts: either side is off by
//! (2 + 3 + 3)u of t.
//!
//! **All boxes above** pass as well: a larger box is widened to one that is larger, has earlier
//! entries and later exits, and all roundings on the way are monotone. For the same reason a ray
//! enters no box above a triangle after it enters the triangle's own, to which `t` is clamped: a
//! node that is culled by its entry holds no better hit.
//!
//! A direction component below 2⁻⁴⁰ of the longest is taken as that; the ray is then off by less
//! than 2⁻³⁹ of the distance to the far end of the scene, for which `near_c` and `far_c` pay too.

use std::array::from_fn;
use std::ops::Range;

use kaustika_math::{Bounds3, Ray, Vec3};

use crate::simd::{F32x8, Lanes};

/// Coordinates above this magnitude are treated as not finite.
pub(crate) const MAX_COORDINATE: f32 = 1.152_921_5e18; // 2⁶⁰
/// 32u of equation (1).
const SLACK: f32 = 1.0 / (1 << 19) as f32;
/// What exits are multiplied by before entries are held against them, for equation (1).
pub(crate) const LATER: f32 = 1.0 + SLACK;
/// Up to this magnitude of coordinates no product of the triangle test overflows.
const MAX_SINGLE_PRECISION: f32 = 1.099_511_6e12; // 2⁴⁰
/// An edge function above this is a difference of products that did not underflow.
const MIN_EDGE_FUNCTION: f32 = 1.262_177_4e-29; // 2⁻⁹⁶
/// Least ratio of direction components, 2⁻⁴⁰.
const MIN_SLOPE: f32 = 1.0 / (1u64 << 40) as f32;

/// Directions whose longest component is in this range are taken as they are.
const MODERATE: Range<f32> = 1e-6..1e6;
/// By the axis of the longest component, which comes last.
pub(crate) const AXES: [[u8; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The box with which a tree replaces that of a triangle or of a node.
pub(crate) fn widened(bounds: &Bounds3) -> Bounds3 {
    let by = margin(bounds.max - bounds.min);
    Bounds3 { min: bounds.min - Vec3::splat(by), max: bounds.max + Vec3::splat(by) }
}

/// How much wider a box of these sides is made.
#[inline(always)]
pub(crate) fn margin(sides: Vec3) -> f32 {
    sides.max_component() * SLACK
}

/// As [`margin`], of eight boxes.
#[inline(always)]
pub(crate) fn margins([x, y, z]: [F32x8; 3]) -> F32x8 {
    x.max(y).max(z) * F32x8::splat(SLACK)
}

/// What box and triangle tests need of a ray.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct PreparedRay {
    /// 1/d, bounded.
    pub(crate) inv_d: [f32; 3],
    /// -o/d, lowered so that entries come out early.
    pub(crate) near_c: [f32; 3],
    /// -o/d, raised so that exits come out late.
    pub(crate) far_c: [f32; 3],
    /// The origin along `axes`.
    pub(crate) o: [f32; 3],
    /// dₓ/d_z, d_y/d_z, 1/d_z.
    pub(crate) shear: [f32; 3],
    /// Edge functions must exceed this to be trusted in single precision.
    pub(crate) min_edge: f32,
    /// Distances of the caller = `scale` × distances here; a power of two.
    pub(crate) scale: f32,
    /// The axes in the order (x, y, z) of the triangle test: that of the longest component last.
    pub(crate) axes: [u8; 3],
    /// For each axis 1 where the direction is negative, so that upper planes are met first.
    pub(crate) negative: [u8; 3],
}

impl PreparedRay {
    /// In the place of a ray that is not there yet.
    pub(crate) const NONE: PreparedRay = PreparedRay {
        inv_d: [1.0; 3],
        near_c: [0.0; 3],
        far_c: [0.0; 3],
        o: [0.0; 3],
        shear: [1.0; 3],
        min_edge: 0.0,
        scale: 1.0,
        axes: [0, 1, 2],
        negative: [0; 3],
    };

    /// `None` if the ray is no half-line: not finite, or without direction.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, bounds: &Bounds3) -> Option<PreparedRay> {
        let longest = ray.d.abs().max_axis();
        let (d, scale) = moderate(ray.d, ray.d[longest].abs())?;
        let o = ray.o;
        let reach = o.abs().max_component();
        // A NaN in the origin must not pass: min and max may drop it.
        if !(reach <= 16.0 * MAX_COORDINATE && o.is_finite() && d.is_finite()) {
            return None;
        }
        let inv_dz = 1.0 / d[longest];
        let least = d[longest].abs() * MIN_SLOPE;
        let mut inv_d = [1.0 / d.x, 1.0 / d.y, 1.0 / d.z];
        let mut slack = [0.0; 3];
        for i in 0..3 {
            if d[i].abs() < least {
                inv_d[i] = (1.0 / least).copysign(d[i]);
                let (lo, hi) = (bounds.min[longest], bounds.max[longest]);
                let far = (lo - o[longest]).abs().max((hi - o[longest]).abs());
                slack[i] = 4.0 * far * inv_dz.abs();
            }
        }
        let c: [f32; 3] = from_fn(|i| -o[i] * inv_d[i]);
        let slack: [f32; 3] = from_fn(|i| c[i].abs() * (1.0 / (1 << 22) as f32) + slack[i]);
        let extent = bounds.min.abs().max(bounds.max.abs()).max_component().max(reach);
        let min_edge =
            if extent <= MAX_SINGLE_PRECISION { MIN_EDGE_FUNCTION } else { f32::INFINITY };
        let axes = AXES[longest];
        let [kx, ky, kz] = axes.map(usize::from);
        Some(PreparedRay {
            inv_d,
            near_c: from_fn(|i| c[i] - slack[i]),
            far_c: from_fn(|i| c[i] + slack[i]),
            o: [o[kx], o[ky], o[kz]],
            shear: [d[kx] / d[kz], d[ky] / d[kz], inv_dz],
            min_edge,
            scale,
            axes,
            negative: inv_d.map(|v| u8::from(v.is_sign_negative())),
        })
    }

    /// This ray in all lanes.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> RayLanes<F32x8> {
        RayLanes {
            inv_d: self.inv_d.map(F32x8::splat),
            near_c: self.near_c.map(F32x8::splat),
            far_c: self.far_c.map(F32x8::splat),
            o: self.o.map(F32x8::splat),
            shear: self.shear.map(F32x8::splat),
            min_edge: F32x8::splat(self.min_edge),
        }
    }
}

/// The numbers of [`PreparedRay`] lane by lane: of one ray, or of several that share `axes` and
/// `negative`.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<V> {
    pub(crate) inv_d: [V; 3],
    pub(crate) near_c: [V; 3],
    pub(crate) far_c: [V; 3],
    pub(crate) o: [V; 3],
    pub(crate) shear: [V; 3],
    pub(crate) min_edge: V,
}

impl<V: Lanes> RayLanes<V> {
    /// Rays that have the same `axes` and `negative`, which are returned with them, and which are
    /// [plain](PlainRays); otherwise `None`.
    #[inline(always)]
    pub(crate) fn alike(
        o: [V; 3],
        d: [V; 3],
        bounds: &Bounds3,
    ) -> Option<(RayLanes<V>, [u8; 3], [u8; 3])> {
        let rays = PlainRays::new(o, d);
        let longest = rays.longest.iter().position(|mask| *mask == V::ALL)?;
        if rays.negative.iter().any(|mask| ![0, V::ALL].contains(mask)) || !is_moderate(bounds) {
            return None;
        }
        let axes = AXES[longest];
        Some((RayLanes::plain(o, d, axes), axes, rays.negative.map(|mask| (mask & 1) as u8)))
    }

    /// The numbers that [`PreparedRay::new`] would give to [plain](PlainRays) rays with these
    /// `axes`; `scale` would be 1.
    #[inline(always)]
    pub(crate) fn plain(o: [V; 3], d: [V; 3], axes: [u8; 3]) -> RayLanes<V> {
        let [kx, ky, kz] = axes.map(usize::from);
        let inv_d = d.map(|d| V::splat(1.0) / d);
        let c: [V; 3] = from_fn(|i| V::splat(0.0) - o[i] * inv_d[i]);
        let slack = c.map(|c| c.abs() * V::splat(1.0 / (1 << 22) as f32));
        RayLanes {
            inv_d,
            near_c: from_fn(|i| c[i] - slack[i]),
            far_c: from_fn(|i| c[i] + slack[i]),
            o: [o[kx], o[ky], o[kz]],
            shear: [d[kx] / d[kz], d[ky] / d[kz], inv_d[kz]],
            min_edge: V::splat(MIN_EDGE_FUNCTION),
        }
    }

    /// The same of other vectors.
    #[inline(always)]
    pub(crate) fn map<W>(&self, f: impl Fn(V) -> W) -> RayLanes<W> {
        RayLanes {
            inv_d: self.inv_d.map(&f),
            near_c: self.near_c.map(&f),
            far_c: self.far_c.map(&f),
            o: self.o.map(&f),
            shear: self.shear.map(&f),
            min_edge: f(self.min_edge),
        }
    }
}

/// Which rays are plain, that is need none of the special care of [`PreparedRay::new`] in a tree
/// that [is moderate](is_moderate), and how they lie.
pub(crate) struct PlainRays {
    /// By the axis of the longest component: the plain rays of which it is that.
    pub(crate) longest: [u32; 3],
    /// For each axis: the rays, plain or not, whose direction is negative.
    pub(crate) negative: [u32; 3],
}

impl PlainRays {
    #[inline(always)]
    pub(crate) fn new<V: Lanes>(o: [V; 3], d: [V; 3]) -> PlainRays {
        let [x, y, z] = d.map(V::abs);
        let longest = x.max(y).max(z);
        let least = longest * V::splat(MIN_SLOPE);
        let slopes = least.le(x) & least.le(y) & least.le(z);
        let moderate = V::splat(MODERATE.start).le(longest) & longest.lt(V::splat(MODERATE.end));
        // An origin that is NaN is not near.
        let limit = V::splat(MAX_SINGLE_PRECISION);
        let [near_x, near_y, near_z] = o.map(|o| o.abs().le(limit));
        let plain = slopes & moderate & near_x & near_y & near_z;
        PlainRays {
            longest: [
                y.lt(x) & z.lt(x) & plain,
                x.lt(y) & z.lt(y) & plain,
                x.lt(z) & y.lt(z) & plain,
            ],
            negative: d.map(|d| d.lt(V::splat(0.0))),
        }
    }
}

/// Whether no product of the triangle test overflows in a tree with these bounds.
pub(crate) fn is_moderate(bounds: &Bounds3) -> bool {
    bounds.min.abs().max(bounds.max.abs()).max_component() <= MAX_SINGLE_PRECISION
}

/// The direction scaled by a power of two if its longest component is far from one, and what
/// to multiply distances by afterwards. Shorter than 1e-30 counts as no direction.
#[inline(always)]
fn moderate(d: Vec3, longest: f32) -> Option<(Vec3, f32)> {
    if MODERATE.contains(&longest) {
        return Some((d, 1.0));
    }
    if !(longest > 1e-30 && longest < f32::INFINITY) {
        return None;
    }
    let exponent = (longest.to_bits() >> 23) as i32 - 127;
    let scale = 2f32.powi(-exponent);
    Some((d * scale, scale))
}
