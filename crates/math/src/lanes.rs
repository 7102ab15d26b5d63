//! Sixteen numbers side by side, for code that does the same for sixteen paths at once.
//!
//! A lane is a path. What differs between paths is chosen with masks, lanes whose bits are all
//! set or all clear, so that there are no branches. The operations of a lane are those of the
//! scalar twins in this crate, in the same order, but for products and sums that are fused.

use crate::gamma;
use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

/// Lanes of a [`Lanes`].
pub const LANES: usize = 16;

/// Sixteen `f32`: one AVX-512 register, or two of AVX, or four of whatever there is.
pub type Lanes = wide::f32x16;

/// Sixteen numbers in memory, to be read and written one by one.
pub type Row = [f32; LANES];

/// A mask of the lanes whose bits are set in `bits`.
#[inline(always)]
pub fn mask_of(bits: u32) -> Lanes {
    Lanes::new(from_fn(|i| f32::from_bits(0u32.wrapping_sub(bits >> i & 1))))
}

/// √max(x, 0).
#[inline(always)]
pub fn safe_sqrt(x: Lanes) -> Lanes {
    x.fast_max(Lanes::splat(0.0)).sqrt()
}

/// True where the number is neither infinite nor NaN.
#[inline(always)]
pub fn is_finite(x: Lanes) -> Lanes {
    x.abs().simd_lt(Lanes::splat(f32::INFINITY))
}

/// Sixteen vectors.
#[derive(Clone, Copy, Debug)]
pub struct Vec3s {
    /// First coordinates.
    pub x: Lanes,
    /// Second coordinates.
    pub y: Lanes,
    /// Third coordinates.
    pub z: Lanes,
}

impl Add for Vec3s {
    type Output = Vec3s;
    #[inline(always)]
    fn add(self, o: Vec3s) -> Vec3s {
        Vec3s { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Vec3s {
    type Output = Vec3s;
    #[inline(always)]
    fn sub(self, o: Vec3s) -> Vec3s {
        Vec3s { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Mul<Lanes> for Vec3s {
    type Output = Vec3s;
    #[inline(always)]
    fn mul(self, k: Lanes) -> Vec3s {
        Vec3s { x: self.x * k, y: self.y * k, z: self.z * k }
    }
}

impl Neg for Vec3s {
    type Output = Vec3s;
    #[inline(always)]
    fn neg(self) -> Vec3s {
        Vec3s { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl Vec3s {
    /// From rows of coordinates.
    #[inline(always)]
    pub fn load(rows: &[Row; 3]) -> Vec3s {
        Vec3s { x: Lanes::new(rows[0]), y: Lanes::new(rows[1]), z: Lanes::new(rows[2]) }
    }

    /// To rows of coordinates.
    #[inline(always)]
    pub fn to_rows(self) -> [Row; 3] {
        [self.x.to_array(), self.y.to_array(), self.z.to_array()]
    }

    /// The vectors of `self` where the mask is set, else of `o`.
    #[inline(always)]
    pub fn or(self, mask: Lanes, o: Vec3s) -> Vec3s {
        Vec3s {
            x: mask.select(self.x, o.x),
            y: mask.select(self.y, o.y),
            z: mask.select(self.z, o.z),
        }
    }

    /// `self + v k`.
    #[inline(always)]
    pub fn plus(self, v: Vec3s, k: Lanes) -> Vec3s {
        Vec3s { x: v.x.mul_add(k, self.x), y: v.y.mul_add(k, self.y), z: v.z.mul_add(k, self.z) }
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, o: Vec3s) -> Lanes {
        self.x.mul_add(o.x, self.y.mul_add(o.y, self.z * o.z))
    }

    /// Vector products, without catastrophic cancellation
    /// ([`diff_of_products`](crate::diff_of_products)).
    #[inline(always)]
    pub fn cross(self, o: Vec3s) -> Vec3s {
        let dop = |a: Lanes, b: Lanes, c: Lanes, d: Lanes| {
            let cd = c * d;
            a.mul_sub(b, cd) + c.mul_neg_add(d, cd)
        };
        Vec3s {
            x: dop(self.y, o.z, self.z, o.y),
            y: dop(self.z, o.x, self.x, o.z),
            z: dop(self.x, o.y, self.y, o.x),
        }
    }

    /// Unit vectors; NaN for zero vectors.
    #[inline(always)]
    pub fn normalize(self) -> Vec3s {
        self * (Lanes::splat(1.0) / self.dot(self).sqrt())
    }

    /// Magnitudes of the coordinates.
    #[inline(always)]
    pub fn abs(self) -> Vec3s {
        Vec3s { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// The vectors, turned into the hemispheres of `v`.
    #[inline(always)]
    pub fn face_forward(self, v: Vec3s) -> Vec3s {
        (-self).or(self.dot(v).simd_lt(Lanes::splat(0.0)), self)
    }

    /// Bases (s, t, self) as [`Vec3::coordinate_system`](crate::Vec3::coordinate_system) has them.
    #[inline(always)]
    pub fn coordinate_system(self) -> (Vec3s, Vec3s) {
        let one = Lanes::splat(1.0);
        let sign = one.copysign(self.z);
        let a = Lanes::splat(-1.0) / (sign + self.z);
        let b = self.x * self.y * a;
        let s =
            Vec3s { x: (sign * self.x * self.x).mul_add(a, one), y: sign * b, z: -(sign * self.x) };
        (s, Vec3s { x: b, y: (self.y * self.y).mul_add(a, sign), z: -self.y })
    }
}

/// Twin of [`ray::offset_origin`](crate::ray::offset_origin).
#[inline(always)]
pub fn offset_origin(p: Vec3s, p_error: Vec3s, n: Vec3s, d: Vec3s) -> Vec3s {
    offset_by(p, n.abs().dot(p_error), n, d)
}

/// As [`offset_origin`], given how far along the normal the errors reach.
#[inline(always)]
pub fn offset_by(p: Vec3s, reach: Lanes, n: Vec3s, d: Vec3s) -> Vec3s {
    let offset = n * reach.flip_signs(d.dot(n));
    let away = |p: Lanes, o: Lanes| {
        let q = p + o;
        let moved = q + (q.abs() * Lanes::splat(f32::EPSILON)).copysign(o);
        o.simd_eq(Lanes::splat(0.0)).select(q, moved)
    };
    Vec3s { x: away(p.x, offset.x), y: away(p.y, offset.y), z: away(p.z, offset.z) }
}

/// Twin of [`ray::triangle_point_error`](crate::ray::triangle_point_error).
#[inline(always)]
pub fn triangle_point_error(p: [Vec3s; 3], b: [Lanes; 3]) -> Vec3s {
    let terms = |a: Lanes, b: Lanes, c: Lanes| a.abs() + b.abs() + c.abs();
    let [u, v, w] = [p[0] * b[0], p[1] * b[1], p[2] * b[2]];
    let [e, f] = [(p[1] - p[0]).abs(), (p[2] - p[0]).abs()];
    let largest = |v: Vec3s| v.x.fast_max(v.y).fast_max(v.z);
    let extent = largest(e).fast_max(largest(f)) * Lanes::splat(gamma(6));
    let k = Lanes::splat(gamma(7));
    Vec3s {
        x: terms(u.x, v.x, w.x).mul_add(k, extent),
        y: terms(u.y, v.y, w.y).mul_add(k, extent),
        z: terms(u.z, v.z, w.z).mul_add(k, extent),
    }
}

/// Twin of [`warp::disk`](crate::warp::disk).
#[inline(always)]
pub fn disk(u: [Lanes; 2]) -> [Lanes; 2] {
    let [x, y] = u.map(|u| u.mul_sub(Lanes::splat(2.0), Lanes::splat(1.0)));
    let along_x = x.abs().simd_gt(y.abs());
    let (r, other) = (along_x.select(x, y), along_x.select(y, x));
    let zero = Lanes::splat(0.0);
    let q = r.simd_eq(zero).select(zero, other / r);
    let (sin, cos) = sin_cos_eighth(q);
    let (near, far) = (r * cos, r * sin);
    [along_x.select(near, far), along_x.select(far, near)]
}

/// Twin of [`special::sin_cos_eighth`](crate::special::sin_cos_eighth).
#[inline(always)]
pub fn sin_cos_eighth(q: Lanes) -> (Lanes, Lanes) {
    let x = q * q;
    let horner = |c: &[f32; 4]| {
        let [c0, c1, c2, c3] = c.map(Lanes::splat);
        c3.mul_add(x, c2).mul_add(x, c1).mul_add(x, c0)
    };
    (horner(&crate::special::SIN) * q, horner(&crate::special::COS))
}

/// Twin of [`special::sin_cos_turn`](crate::special::sin_cos_turn).
#[inline(always)]
pub fn sin_cos_turn(u: Lanes) -> (Lanes, Lanes) {
    let (half, one) = (Lanes::splat(0.5), Lanes::splat(1.0));
    let quarters = u * Lanes::splat(4.0);
    let nearest = (quarters + half).floor();
    let (s, c) = sin_cos_eighth((quarters - nearest) * Lanes::splat(2.0));
    // What is left of `nearest` modulo 2, and half of it modulo 2.
    let odd = |n: Lanes| (n - (n * half).floor() * Lanes::splat(2.0)).simd_ge(one);
    let swapped = odd(nearest);
    let (sin, cos) = (swapped.select(c, s), swapped.select(s, c));
    let sin_negative = odd((nearest * half).floor());
    let cos_negative = odd(((nearest + one) * half).floor());
    (sin_negative.select(-sin, sin), cos_negative.select(-cos, cos))
}

/// Twin of [`warp::cosine_hemisphere`](crate::warp::cosine_hemisphere).
#[inline(always)]
pub fn cosine_hemisphere(u: [Lanes; 2]) -> Vec3s {
    let [x, y] = disk(u);
    Vec3s { x, y, z: safe_sqrt(x.mul_neg_add(x, y.mul_neg_add(y, Lanes::splat(1.0)))) }
}

/// Twin of [`warp::triangle`](crate::warp::triangle): the weights of corners 1 and 2, the second
/// and third of its result.
#[inline(always)]
pub fn triangle(u: [Lanes; 2]) -> [Lanes; 3] {
    let half = Lanes::splat(0.5);
    let [x, y] = u;
    let below = x.simd_lt(y);
    let (hx, hy) = (x * half, y * half);
    let b0 = below.select(hx, x - hy);
    let b1 = below.select(y - hx, hy);
    [b0, b1, Lanes::splat(1.0) - b0 - b1]
}
