//! [`F32x16`] on AVX-512.
#![allow(unsafe_code, reason = "the intrinsics of a SIMD kernel; `pair` is their twin")]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::avx2::F32x8;
use super::{Lanes, WIDE};

/// Sixteen `f32`, lane by lane.
#[derive(Clone, Copy)]
pub(crate) struct F32x16(__m512);

impl F32x16 {
    /// The lanes of `low`, then those of `high`.
    #[inline(always)]
    pub(crate) fn join(low: F32x8, high: F32x8) -> Self {
        // SAFETY: this module is compiled only where the build enables AVX-512F and DQ.
        unsafe {
            let low = _mm512_castps256_ps512(low.register());
            F32x16(_mm512_insertf32x8::<1>(low, high.register()))
        }
    }

    /// One lane in eight.
    #[inline(always)]
    pub(crate) fn broadcast(self, lane: usize) -> F32x8 {
        // SAFETY: AVX-512F is enabled; the permutation takes the low four bits of an index.
        unsafe {
            let all = _mm512_permutexvar_ps(_mm512_set1_epi32(lane as i32), self.0);
            F32x8::from_register(_mm512_castps512_ps256(all))
        }
    }
}

impl Lanes for F32x16 {
    const ALL: u32 = 0xffff;
    type Array = [f32; WIDE];

    #[inline(always)]
    fn splat(v: f32) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_set1_ps(v) })
    }

    #[inline(always)]
    fn load(a: &[f32; WIDE]) -> Self {
        // SAFETY: AVX-512F is enabled; `a` is 64 readable bytes, and `loadu` needs no alignment.
        F32x16(unsafe { _mm512_loadu_ps(a.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDE] {
        let mut a = [0.0; WIDE];
        // SAFETY: AVX-512F is enabled; `a` is 64 writable bytes, and `storeu` needs no alignment.
        unsafe { _mm512_storeu_ps(a.as_mut_ptr(), self.0) };
        a
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_fmadd_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_fmsub_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_fnmadd_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_min_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_max_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_abs_ps(self.0) })
    }

    #[inline(always)]
    fn select(self, mask: u32, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_mask_blend_ps(mask as u16, self.0, o.0) })
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        // SAFETY: AVX-512F is enabled.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, o.0) })
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        // SAFETY: AVX-512F is enabled.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, o.0) })
    }

    #[inline(always)]
    fn differing_signs(self, b: Self, c: Self) -> u32 {
        // SAFETY: AVX-512F and DQ are enabled.
        unsafe {
            let [a, b, c] = [self, b, c].map(|v| _mm512_castps_si512(v.0));
            let differ = _mm512_or_si512(_mm512_xor_si512(a, b), _mm512_xor_si512(a, c));
            u32::from(_mm512_movepi32_mask(differ))
        }
    }
}

impl Add for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_add_ps(self.0, o.0) })
    }
}

impl Sub for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_sub_ps(self.0, o.0) })
    }
}

impl Mul for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_mul_ps(self.0, o.0) })
    }
}

impl Div for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        // SAFETY: AVX-512F is enabled.
        F32x16(unsafe { _mm512_div_ps(self.0, o.0) })
    }
}
