//! Traversal stacks on AVX2, with AVX-512's compression where there is one.
#![allow(unsafe_code, reason = "the intrinsics of a SIMD kernel; `stack_portable` is its twin")]

use std::arch::x86_64::*;

use super::LANES;
use super::avx2::F32x8;
use crate::node::ChildRef;

/// Writes the children of `mask` to the front of `refs`, in the order of the slots. What is written
/// after them has no meaning.
#[inline(always)]
pub(crate) fn push_hits(mask: u32, children: &[ChildRef; LANES], refs: &mut [ChildRef; LANES]) {
    let hits = compress(mask, load(children));
    store(refs, hits);
}

/// Writes the children of `mask` to the front of `refs`, the farthest first, and the bits of their
/// entries, less the last three, to `keys`. Of equal ones the later slot comes first. What is
/// written after them has no meaning. No entry may have its sign bit set.
#[inline(always)]
pub(crate) fn push_sorted(
    mask: u32,
    entry: F32x8,
    children: &[ChildRef; LANES],
    keys: &mut [u32; LANES],
    refs: &mut [ChildRef; LANES],
) {
    // SAFETY: this module is compiled only where the build enables AVX2.
    let (sorted, sort_bits) = unsafe {
        let slots = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let low = _mm256_set1_epi32(7);
        let bits = _mm256_andnot_si256(low, _mm256_castps_si256(entry.register()));
        // Misses become 0 and sink.
        let hits = compress(mask, _mm256_or_si256(bits, slots));
        let few = mask.count_ones() <= 4;
        (if few { descending_4(hits) } else { descending_8(hits) }, low)
    };
    // SAFETY: AVX2 is enabled; the permutation takes the low three bits of an index.
    unsafe {
        store(refs, _mm256_permutevar8x32_epi32(load(children), sorted));
        store(keys, _mm256_andnot_si256(sort_bits, sorted));
    }
}

/// Closes the gaps that entries with keys above `limit` leave among the first `size`, and returns
/// how many are left. What comes after them has no meaning.
#[inline(always)]
pub(crate) fn keep_below<const N: usize>(
    keys: &mut [u32; N],
    refs: &mut [ChildRef; N],
    size: usize,
    limit: u32,
) -> usize {
    const { assert!(N.is_multiple_of(LANES)) };
    let mut kept = 0;
    for at in (0..size.min(N)).step_by(LANES) {
        let k = load::<u32>(keys[at..at + LANES].try_into().expect("eight lanes"));
        let r = load::<ChildRef>(refs[at..at + LANES].try_into().expect("eight lanes"));
        let live = (1u32 << (size - at).min(LANES)) - 1;
        let mask = at_most(k, limit) & live;
        // What was read at `at` may be overwritten: `kept` is not beyond it.
        let to = kept.min(N - LANES);
        store((&mut keys[to..to + LANES]).try_into().expect("eight lanes"), compress(mask, k));
        store((&mut refs[to..to + LANES]).try_into().expect("eight lanes"), compress(mask, r));
        kept += mask.count_ones() as usize;
    }
    kept
}

#[inline(always)]
fn load<T: Word>(a: &[T; LANES]) -> __m256i {
    // SAFETY: AVX is enabled; `a` is 32 readable bytes, and `loadu` needs no alignment.
    unsafe { _mm256_loadu_si256(a.as_ptr().cast()) }
}

#[inline(always)]
fn store<T: Word>(a: &mut [T; LANES], v: __m256i) {
    // SAFETY: AVX is enabled; `a` is 32 writable bytes, `storeu` needs no alignment, and a `Word`
    // may have any bits.
    unsafe { _mm256_storeu_si256(a.as_mut_ptr().cast(), v) }
}

/// 32 bits of any value.
trait Word {}
impl Word for u32 {}
impl Word for ChildRef {}

/// One bit a lane: `v <= limit`, of numbers without sign.
#[inline(always)]
fn at_most(v: __m256i, limit: u32) -> u32 {
    // SAFETY: AVX2 is enabled.
    unsafe {
        let limit = _mm256_set1_epi32(limit as i32);
        let at_most = _mm256_cmpeq_epi32(_mm256_min_epu32(v, limit), v);
        _mm256_movemask_ps(_mm256_castsi256_ps(at_most)) as u32
    }
}

/// The lanes of `mask` side by side, then zeros.
#[cfg(all(target_feature = "avx512f", target_feature = "avx512vl"))]
#[inline(always)]
fn compress(mask: u32, v: __m256i) -> __m256i {
    // SAFETY: AVX-512F and VL are enabled.
    unsafe { _mm256_maskz_compress_epi32(mask as u8, v) }
}

/// The lanes of `mask` side by side, then zeros.
#[cfg(not(all(target_feature = "avx512f", target_feature = "avx512vl")))]
#[inline(always)]
fn compress(mask: u32, v: __m256i) -> __m256i {
    compress_by_table(mask, v)
}

#[cfg(any(test, not(all(target_feature = "avx512f", target_feature = "avx512vl"))))]
#[inline(always)]
fn compress_by_table(mask: u32, v: __m256i) -> __m256i {
    let order = ORDER[(mask & 0xff) as usize];
    // SAFETY: AVX2 is enabled. Zeros: bytes of `order` with the top bit set become negative
    // indices.
    unsafe {
        let order = _mm256_cvtepi8_epi32(_mm_cvtsi64_si128(order as i64));
        let lanes = _mm256_permutevar8x32_epi32(v, order);
        _mm256_andnot_si256(_mm256_srai_epi32::<31>(order), lanes)
    }
}

/// For each mask its bits in rising order, a byte each from the lowest, then 0x80.
#[cfg(any(test, not(all(target_feature = "avx512f", target_feature = "avx512vl"))))]
static ORDER: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut order = [0x80; 8];
        let (mut bit, mut n) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                order[n] = bit;
                n += 1;
            }
            bit += 1;
        }
        table[mask] = u64::from_le_bytes(order);
        mask += 1;
    }
    table
};

/// Sorts the lower four lanes, by a network.
#[inline(always)]
fn descending_4(v: __m256i) -> __m256i {
    // SAFETY: AVX2 is enabled.
    unsafe {
        let v = _mm256_castsi256_si128(v);
        let w = _mm_shuffle_epi32::<0b10_11_00_01>(v);
        let v = _mm_blend_epi32::<0b1010>(_mm_max_epu32(v, w), _mm_min_epu32(v, w));
        let w = _mm_shuffle_epi32::<0b00_01_10_11>(v);
        let v = _mm_blend_epi32::<0b1100>(_mm_max_epu32(v, w), _mm_min_epu32(v, w));
        let w = _mm_shuffle_epi32::<0b10_11_00_01>(v);
        let v = _mm_blend_epi32::<0b1010>(_mm_max_epu32(v, w), _mm_min_epu32(v, w));
        _mm256_castsi128_si256(v)
    }
}

/// Sorts eight lanes, by a bitonic network (Batcher 1968).
#[inline(always)]
fn descending_8(v: __m256i) -> __m256i {
    // SAFETY: AVX2 is enabled.
    unsafe {
        let w = _mm256_shuffle_epi32::<0b10_11_00_01>(v);
        let v = _mm256_blend_epi32::<0b1010_1010>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w));
        let w = _mm256_shuffle_epi32::<0b00_01_10_11>(v);
        let v = _mm256_blend_epi32::<0b1100_1100>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w));
        let w = _mm256_shuffle_epi32::<0b10_11_00_01>(v);
        let v = _mm256_blend_epi32::<0b1010_1010>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w));
        let w = _mm256_permutevar8x32_epi32(v, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
        let v = _mm256_blend_epi32::<0b1111_0000>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w));
        let w = _mm256_shuffle_epi32::<0b01_00_11_10>(v);
        let v = _mm256_blend_epi32::<0b1100_1100>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w));
        let w = _mm256_shuffle_epi32::<0b10_11_00_01>(v);
        _mm256_blend_epi32::<0b1010_1010>(_mm256_max_epu32(v, w), _mm256_min_epu32(v, w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;

    #[test]
    fn compression_has_its_lanes_in_order_then_zeros() {
        for mask in 0..256u32 {
            let v: [u32; LANES] =
                std::array::from_fn(|i| mix_bits(u64::from(mask) + i as u64) as u32);
            let mut expected = [0; LANES];
            let lanes = (0..LANES).filter(|i| mask >> i & 1 != 0);
            lanes.enumerate().for_each(|(to, from)| expected[to] = v[from]);
            let mut got = [[1; LANES]; 2];
            store(&mut got[0], compress(mask, load(&v)));
            store(&mut got[1], compress_by_table(mask, load(&v)));
            assert_eq!(got, [expected; 2], "{mask:#b}");
        }
    }
}
