//! [`F32x8`] on AVX2 and FMA.
#![allow(unsafe_code, reason = "the intrinsics of a SIMD kernel; `portable` is their safe twin")]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::{LANES, Lanes};

/// Eight `f32`, lane by lane.
#[derive(Clone, Copy)]
pub(crate) struct F32x8(__m256);

impl F32x8 {
    #[cfg(target_feature = "avx512f")]
    #[inline(always)]
    pub(super) fn from_register(register: __m256) -> Self {
        F32x8(register)
    }

    #[inline(always)]
    pub(super) fn register(self) -> __m256 {
        self.0
    }

    /// One lane in all.
    #[inline(always)]
    pub(crate) fn broadcast(self, lane: usize) -> Self {
        // SAFETY: AVX2 is enabled; the permutation takes the low three bits of an index.
        unsafe { F32x8(_mm256_permutevar8x32_ps(self.0, _mm256_set1_epi32(lane as i32))) }
    }

    /// The least lane. None may be NaN.
    #[inline(always)]
    pub(crate) fn least(self) -> f32 {
        // SAFETY: AVX is enabled.
        unsafe {
            let v = _mm_min_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let v = _mm_min_ps(v, _mm_movehl_ps(v, v));
            _mm_cvtss_f32(_mm_min_ss(v, _mm_movehdup_ps(v)))
        }
    }

    /// The greatest lane. None may be NaN.
    #[inline(always)]
    pub(crate) fn greatest(self) -> f32 {
        // SAFETY: AVX is enabled.
        unsafe {
            let v = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let v = _mm_max_ps(v, _mm_movehl_ps(v, v));
            _mm_cvtss_f32(_mm_max_ss(v, _mm_movehdup_ps(v)))
        }
    }

    /// Columns of the rows that are given.
    #[inline(always)]
    pub(crate) fn transpose(rows: [F32x8; LANES]) -> [F32x8; LANES] {
        let [a, b, c, d, e, f, g, h] = rows.map(|row| row.0);
        // SAFETY: AVX is enabled.
        unsafe {
            let pairs = |a, b| (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let quads = |(a, b), (c, d)| {
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(a, c),
                    _mm256_shuffle_ps::<0b11_10_11_10>(a, c),
                    _mm256_shuffle_ps::<0b01_00_01_00>(b, d),
                    _mm256_shuffle_ps::<0b11_10_11_10>(b, d),
                ]
            };
            let upper = quads(pairs(a, b), pairs(c, d));
            let lower = quads(pairs(e, f), pairs(g, h));
            std::array::from_fn(|i| {
                let (u, l) = (upper[i % 4], lower[i % 4]);
                F32x8(if i < 4 {
                    _mm256_permute2f128_ps::<0x20>(u, l)
                } else {
                    _mm256_permute2f128_ps::<0x31>(u, l)
                })
            })
        }
    }
}

impl Lanes for F32x8 {
    const ALL: u32 = 0xff;
    type Array = [f32; LANES];

    #[inline(always)]
    fn splat(v: f32) -> Self {
        // SAFETY: this module is compiled only where the build enables AVX2 and FMA.
        F32x8(unsafe { _mm256_set1_ps(v) })
    }

    #[inline(always)]
    fn load(a: &[f32; LANES]) -> Self {
        // SAFETY: AVX is enabled; `a` is 32 readable bytes, and `loadu` needs no alignment.
        F32x8(unsafe { _mm256_loadu_ps(a.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let mut a = [0.0; LANES];
        // SAFETY: AVX is enabled; `a` is 32 writable bytes, and `storeu` needs no alignment.
        unsafe { _mm256_storeu_ps(a.as_mut_ptr(), self.0) };
        a
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: FMA is enabled.
        F32x8(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        // SAFETY: FMA is enabled.
        F32x8(unsafe { _mm256_fmsub_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: FMA is enabled.
        F32x8(unsafe { _mm256_fnmadd_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_min_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_max_ps(self.0, o.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn select(self, mask: u32, o: Self) -> Self {
        // SAFETY: AVX2 is enabled.
        unsafe {
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let lanes = _mm256_and_si256(_mm256_set1_epi32(mask as i32), bits);
            let lanes = _mm256_castsi256_ps(_mm256_cmpeq_epi32(lanes, bits));
            F32x8(_mm256_blendv_ps(self.0, o.0, lanes))
        }
    }

    #[inline(always)]
    fn le(self, o: Self) -> u32 {
        // SAFETY: AVX is enabled.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, o.0)) as u32 }
    }

    #[inline(always)]
    fn lt(self, o: Self) -> u32 {
        // SAFETY: AVX is enabled.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0)) as u32 }
    }

    #[inline(always)]
    fn differing_signs(self, b: Self, c: Self) -> u32 {
        // SAFETY: AVX is enabled.
        unsafe {
            let ab = _mm256_xor_ps(self.0, b.0);
            let ac = _mm256_xor_ps(self.0, c.0);
            _mm256_movemask_ps(_mm256_or_ps(ab, ac)) as u32
        }
    }
}

/// Asks for the cache lines of an element; nothing where there is none.
#[inline(always)]
pub(crate) fn prefetch<T>(slice: &[T], index: usize) {
    let start = slice.as_ptr().wrapping_add(index).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64) {
        // SAFETY: SSE is enabled; a prefetch of any address is a hint and never faults.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line)) };
    }
}

/// Asks for the cache lines of an element of `a`, or of `b` if `second`, without a branch; elements
/// of `a` have at most four lines, those of `b` five.
#[inline(always)]
pub(crate) fn prefetch_either<A, B>(a: &[A], b: &[B], second: bool, index: usize) {
    const { assert!(size_of::<A>() <= 4 * 64 && size_of::<B>() <= 5 * 64) };
    let [a, b] = [a.as_ptr().wrapping_add(index).cast(), b.as_ptr().wrapping_add(index).cast()];
    let start: *const i8 = if second { b } else { a };
    let last = 3 + usize::from(second);
    for line in [0, 1, 2, 3, last] {
        // SAFETY: SSE is enabled; a prefetch of any address is a hint and never faults.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line)) };
    }
}

impl Add for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_add_ps(self.0, o.0) })
    }
}

impl Sub for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_sub_ps(self.0, o.0) })
    }
}

impl Mul for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_mul_ps(self.0, o.0) })
    }
}

impl Div for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        // SAFETY: AVX is enabled.
        F32x8(unsafe { _mm256_div_ps(self.0, o.0) })
    }
}
