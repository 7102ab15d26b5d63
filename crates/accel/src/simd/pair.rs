//! [`F32x16`] as two vectors of eight: without AVX-512, and the twin it is tested against.

use std::ops::{Add, Div, Mul, Sub};

use super::{F32x8, LANES, Lanes, WIDE};

/// Sixteen `f32`, lane by lane.
#[derive(Clone, Copy)]
pub(crate) struct F32x16([F32x8; 2]);

impl F32x16 {
    /// The lanes of `low`, then those of `high`.
    #[inline(always)]
    pub(crate) fn join(low: F32x8, high: F32x8) -> Self {
        F32x16([low, high])
    }

    /// One lane in eight.
    #[inline(always)]
    pub(crate) fn broadcast(self, lane: usize) -> F32x8 {
        self.0[lane / LANES % 2].broadcast(lane % LANES)
    }

    #[inline(always)]
    fn halves(self, b: Self, c: Self, op: impl Fn(F32x8, F32x8, F32x8) -> F32x8) -> Self {
        let ([a0, a1], [b0, b1], [c0, c1]) = (self.0, b.0, c.0);
        F32x16([op(a0, b0, c0), op(a1, b1, c1)])
    }

    #[inline(always)]
    fn masks(self, b: Self, c: Self, test: impl Fn(F32x8, F32x8, F32x8) -> u32) -> u32 {
        let ([a0, a1], [b0, b1], [c0, c1]) = (self.0, b.0, c.0);
        test(a0, b0, c0) | test(a1, b1, c1) << LANES
    }
}

impl Lanes for F32x16 {
    const ALL: u32 = 0xffff;
    type Array = [f32; WIDE];

    #[inline(always)]
    fn splat(v: f32) -> Self {
        F32x16([F32x8::splat(v); 2])
    }

    #[inline(always)]
    fn load(a: &[f32; WIDE]) -> Self {
        let (eights, _) = a.as_chunks();
        F32x16([F32x8::load(&eights[0]), F32x8::load(&eights[1])])
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDE] {
        let mut a = [0.0; WIDE];
        let (eights, _) = a.as_chunks_mut();
        (eights[0], eights[1]) = (self.0[0].to_array(), self.0[1].to_array());
        a
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.halves(b, c, F32x8::mul_add)
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.halves(b, c, F32x8::mul_sub)
    }

    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        self.halves(b, c, F32x8::neg_mul_add)
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a.min(o))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a.max(o))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        F32x16(self.0.map(F32x8::abs))
    }

    #[inline(always)]
    fn select(self, mask: u32, o: Self) -> Self {
        let ([a0, a1], [b0, b1]) = (self.0, o.0);
        F32x16([a0.select(mask, b0), a1.select(mask >> LANES, b1)])
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        self.masks(o, o, |a, o, _| a.le(o))
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        self.masks(o, o, |a, o, _| a.lt(o))
    }

    #[inline(always)]
    fn differing_signs(self, b: Self, c: Self) -> u32 {
        self.masks(b, c, F32x8::differing_signs)
    }
}

impl Add for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a + o)
    }
}

impl Sub for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a - o)
    }
}

impl Mul for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a * o)
    }
}

impl Div for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        self.halves(o, o, |a, o, _| a / o)
    }
}
