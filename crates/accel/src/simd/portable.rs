//! [`F32x8`] in plain Rust: the fallback, and the twin the intrinsics are tested against.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use super::{LANES, Lanes};

/// Eight `f32`, lane by lane.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(crate) struct F32x8([f32; LANES]);

fn mask(test: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).fold(0, |m, i| m | (u32::from(test(i)) << i))
}

impl F32x8 {
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

    /// Columns of the rows that are given.
    #[inline(always)]
    pub(crate) fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        from_fn(|i| F32x8(from_fn(|j| rows[j].0[i])))
    }
}

impl Lanes for F32x8 {
    const ALL: u32 = 0xff;
    type Array = [f32; LANES];

    #[inline(always)]
    fn splat(v: f32) -> Self {
        F32x8([v; LANES])
    }

    #[inline(always)]
    fn load(a: &[f32; LANES]) -> Self {
        F32x8(*a)
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        self.0
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| self.0[i].mul_add(b.0[i], c.0[i])))
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| self.0[i].mul_add(b.0[i], -c.0[i])))
    }

    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        F32x8(from_fn(|i| (-self.0[i]).mul_add(b.0[i], c.0[i])))
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        F32x8(from_fn(|i| if self.0[i] < o.0[i] { self.0[i] } else { o.0[i] }))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        F32x8(from_fn(|i| if self.0[i] > o.0[i] { self.0[i] } else { o.0[i] }))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        F32x8(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn select(self, mask: u32, o: Self) -> Self {
        F32x8(from_fn(|i| if mask >> i & 1 != 0 { o.0[i] } else { self.0[i] }))
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        mask(|i| self.0[i] <= o.0[i])
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        mask(|i| self.0[i] < o.0[i])
    }

    #[inline(always)]
    fn differing_signs(self, b: Self, c: Self) -> u32 {
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
