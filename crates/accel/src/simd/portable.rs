//! [`F32x8`] in plain Rust: the fallback, and the twin the intrinsics are tested against.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use super::LANES;

/// Eight `f32`, lane by lane.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(crate) struct F32x8([f32; LANES]);

fn mask(test: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).fold(0, |m, i| m | (u32::from(test(i)) << i))
}

impl F32x8 {
    #[inline(always)]
    pub(crate) fn splat(v: f32) -> Self {
        F32x8([v; LANES])
    }

    #[inline(always)]
    pub(crate) fn load(a: &[f32; LANES]) -> Self {
        F32x8(*a)
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; LANES] {
        self.0
    }

    /// `self * b + c`, rounded once.
    #[inline(always)]
    pub(crate) fn mul_add(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| self.0[i].mul_add(b.0[i], c.0[i])))
    }

    /// `self * b - c`, rounded once.
    #[inline(always)]
    pub(crate) fn mul_sub(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| self.0[i].mul_add(b.0[i], -c.0[i])))
    }

    /// `c - self * b`, rounded once.
    #[inline(always)]
    pub(crate) fn neg_mul_add(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| (-self.0[i]).mul_add(b.0[i], c.0[i])))
    }

    /// The lesser; `o` where either is NaN.
    #[inline(always)]
    pub(crate) fn min(self, o: Self) -> Self {
        F32x8(from_fn(|i| if self.0[i] < o.0[i] { self.0[i] } else { o.0[i] }))
    }

    /// The greater; `o` where either is NaN.
    #[inline(always)]
    pub(crate) fn max(self, o: Self) -> Self {
        F32x8(from_fn(|i| if self.0[i] > o.0[i] { self.0[i] } else { o.0[i] }))
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        F32x8(self.0.map(f32::abs))
    }

    /// One lane in all.
    #[inline(always)]
    pub(crate) fn broadcast(self, lane: usize) -> Self {
        Self::splat(self.0[lane % LANES])
    }

    /// The least lane. None may be NaN.
    #[inline(always)]
    pub(crate) fn least(self) -> f32 {
        self.0.into_iter().fold(f32::INFINITY, f32::min)
    }

    /// The greatest lane. None may be NaN.
    #[inline(always)]
    pub(crate) fn greatest(self) -> f32 {
        self.0.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }

    /// With infinity in the lanes of `mask`.
    #[inline(always)]
    pub(crate) fn or_infinity(self, mask: u32) -> Self {
        F32x8(from_fn(|i| if mask >> i & 1 != 0 { f32::INFINITY } else { self.0[i] }))
    }

    /// One bit a lane: `self <= o`.
    #[inline(always)]
    pub(crate) fn le(self, o: Self) -> u32 {
        mask(|i| self.0[i] <= o.0[i])
    }

    /// One bit a lane: `self < o`.
    #[inline(always)]
    pub(crate) fn lt(self, o: Self) -> u32 {
        mask(|i| self.0[i] < o.0[i])
    }

    /// One bit a lane: the sign bits of the three are not all the same.
    #[inline(always)]
    pub(crate) fn differing_signs(self, b: Self, c: Self) -> u32 {
        mask(|i| {
            let sign = self.0[i].is_sign_negative();
            b.0[i].is_sign_negative() != sign || c.0[i].is_sign_negative() != sign
        })
    }
}

impl Add for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        F32x8(from_fn(|i| self.0[i] + o.0[i]))
    }
}

impl Sub for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        F32x8(from_fn(|i| self.0[i] - o.0[i]))
    }
}

impl Mul for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        F32x8(from_fn(|i| self.0[i] * o.0[i]))
    }
}

impl Div for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        F32x8(from_fn(|i| self.0[i] / o.0[i]))
    }
}
