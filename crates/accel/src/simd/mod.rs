//! Eight or sixteen `f32` in a register, and what is done with traversal stacks by eight entries at
//! a time.
//!
//! Two implementations of each: `avx2` where the build may use AVX2 and FMA, `portable`
//! everywhere else; for sixteen `avx512`, or else a `pair` of eight. They agree bit for bit (tests
//! below compare them), so images do not depend on the instruction set. Fused multiply-add is always fused: the triangle test relies on it.

#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
mod avx2;
#[cfg(all(target_arch = "x86_64", target_feature = "avx512f", target_feature = "avx512dq"))]
mod avx512;
mod lanes;
#[cfg(any(
    test,
    not(all(target_arch = "x86_64", target_feature = "avx512f", target_feature = "avx512dq"))
))]
mod pair;
#[cfg(any(
    test,
    not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))
))]
mod portable;
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
mod stack_avx2;
#[cfg(any(
    test,
    not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))
))]
mod stack_portable;

#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
pub(crate) use avx2::{F32x8, prefetch, prefetch_either};
#[cfg(all(target_arch = "x86_64", target_feature = "avx512f", target_feature = "avx512dq"))]
pub(crate) use avx512::F32x16;
pub(crate) use lanes::Lanes;
#[cfg(not(all(
    target_arch = "x86_64",
    target_feature = "avx512f",
    target_feature = "avx512dq"
)))]
pub(crate) use pair::F32x16;
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub(crate) use portable::F32x8;
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
pub(crate) use stack_avx2::{keep_below, push_hits, push_sorted};
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub(crate) use stack_portable::{keep_below, push_hits, push_sorted};

/// A hint that this target does not take.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub(crate) fn prefetch<T>(_slice: &[T], _index: usize) {}

/// A hint that this target does not take.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub(crate) fn prefetch_either<A, B>(_a: &[A], _b: &[B], _second: bool, _index: usize) {}

/// Lanes of [`F32x8`].
pub(crate) const LANES: usize = 8;
/// Lanes of [`F32x16`].
pub(crate) const WIDE: usize = 16;

#[cfg(all(test, target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
mod tests {
    use super::{LANES, Lanes, avx2, portable, stack_avx2, stack_portable};
    use crate::node::ChildRef;
    use kaustika_math::mix_bits;

    /// Random bit patterns: all exponents, NaNs, infinities, denormals and both zeros.
    fn pattern(seed: u64) -> [f32; LANES] {
        std::array::from_fn(|i| {
            let h = mix_bits(seed * 31 + i as u64 + 1);
            match h % 11 {
                0 => 0.0,
                1 => -0.0,
                2 => f32::NAN,
                3 => f32::INFINITY,
                4..=7 => (h >> 40) as f32 / 1e6 - 8.0,
                _ => f32::from_bits((h >> 32) as u32),
            }
        })
    }

    /// Equal bits, but for the payload of a NaN.
    fn same(a: [f32; LANES], b: [f32; LANES]) -> bool {
        a.iter().zip(&b).all(|(a, b)| is_same(*a, *b))
    }

    fn is_same(a: f32, b: f32) -> bool {
        a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
    }

    #[test]
    fn both_implementations_agree_on_every_bit() {
        for seed in 0..20_000 {
            let [a, b, c] = [0, 1, 2].map(|k| pattern(3 * seed + k));
            let (va, vb, vc) =
                (avx2::F32x8::load(&a), avx2::F32x8::load(&b), avx2::F32x8::load(&c));
            let (pa, pb, pc) =
                (portable::F32x8::load(&a), portable::F32x8::load(&b), portable::F32x8::load(&c));
            macro_rules! check {
                ($what:literal, $v:expr, $p:expr) => {
                    let (v, p) = ($v.to_array(), $p.to_array());
                    assert!(same(v, p), "{}: {a:?} {b:?} {c:?}: {v:?} {p:?}", $what);
                };
            }
            check!("+", va + vb, pa + pb);
            check!("-", va - vb, pa - pb);
            check!("*", va * vb, pa * pb);
            check!("/", va / vb, pa / pb);
            check!("mul_add", va.mul_add(vb, vc), pa.mul_add(pb, pc));
            check!("mul_sub", va.mul_sub(vb, vc), pa.mul_sub(pb, pc));
            check!("neg_mul_add", va.neg_mul_add(vb, vc), pa.neg_mul_add(pb, pc));
            check!("min", va.min(vb), pa.min(pb));
            check!("max", va.max(vb), pa.max(pb));
            check!("abs", va.abs(), pa.abs());
            let mask = (mix_bits(seed) & 0xff) as u32;
            check!("select", va.select(mask, vb), pa.select(mask, pb));
            let lane = (mix_bits(seed) >> 8 & 7) as usize;
            check!("broadcast", va.broadcast(lane), pa.broadcast(lane));
            check!("splat", avx2::F32x8::splat(a[3]), portable::F32x8::splat(a[3]));
            assert_eq!(va.le(vb), pa.le(pb), "{a:?} <= {b:?}");
            assert_eq!(va.lt(vb), pa.lt(pb), "{a:?} < {b:?}");
            let ordered = a.map(|x| if x.is_nan() { 1.0 } else { x });
            let (v, p) = (avx2::F32x8::load(&ordered), portable::F32x8::load(&ordered));
            // The sign of a NaN made by an operation is not defined; those the tests make are.
            assert_eq!((v.least(), v.greatest()), (p.least(), p.greatest()), "{ordered:?}");
            assert_eq!(v.differing_signs(v, va.abs()), p.differing_signs(p, pa.abs()));
        }
    }

    #[test]
    fn columns_are_the_rows_turned() {
        let rows: [[f32; LANES]; LANES] = std::array::from_fn(|i| pattern(i as u64));
        let turned = std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i]));
        let v = avx2::F32x8::transpose(rows.map(|row| avx2::F32x8::load(&row)));
        let p = portable::F32x8::transpose(rows.map(|row| portable::F32x8::load(&row)));
        let bits = |a: [[f32; LANES]; LANES]| a.map(|row| row.map(f32::to_bits));
        assert_eq!(bits(v.map(avx2::F32x8::to_array)), bits(turned));
        assert_eq!(bits(p.map(portable::F32x8::to_array)), bits(turned));
    }

    #[cfg(all(target_feature = "avx512f", target_feature = "avx512dq"))]
    #[test]
    fn sixteen_lanes_agree_with_two_times_eight() {
        use super::{F32x8, WIDE, avx512, pair};
        let wide = |seed: u64| -> [f32; WIDE] {
            let halves = [pattern(2 * seed), pattern(2 * seed + 1)];
            std::array::from_fn(|i| halves[i / LANES][i % LANES])
        };
        let same = |a: [f32; WIDE], b: [f32; WIDE]| a.iter().zip(&b).all(|(a, b)| is_same(*a, *b));
        for seed in 0..20_000 {
            let [a, b, c] = [0, 1, 2].map(|k| wide(3 * seed + k));
            let [va, vb, vc] = [a, b, c].map(|a| avx512::F32x16::load(&a));
            let [pa, pb, pc] = [a, b, c].map(|a| pair::F32x16::load(&a));
            macro_rules! check {
                ($what:literal, $v:expr, $p:expr) => {
                    let (v, p) = ($v.to_array(), $p.to_array());
                    assert!(same(v, p), "{}: {a:?} {b:?} {c:?}: {v:?} {p:?}", $what);
                };
            }
            check!("+", va + vb, pa + pb);
            check!("-", va - vb, pa - pb);
            check!("*", va * vb, pa * pb);
            check!("/", va / vb, pa / pb);
            check!("mul_add", va.mul_add(vb, vc), pa.mul_add(pb, pc));
            check!("mul_sub", va.mul_sub(vb, vc), pa.mul_sub(pb, pc));
            check!("neg_mul_add", va.neg_mul_add(vb, vc), pa.neg_mul_add(pb, pc));
            check!("min", va.min(vb), pa.min(pb));
            check!("max", va.max(vb), pa.max(pb));
            check!("abs", va.abs(), pa.abs());
            check!("splat", avx512::F32x16::splat(a[3]), pair::F32x16::splat(a[3]));
            let mask = (mix_bits(seed) & 0xffff) as u32;
            check!("select", va.select(mask, vb), pa.select(mask, pb));
            let [low, high] = [0, 1].map(|k| F32x8::load(&pattern(2 * seed + k)));
            check!("join", avx512::F32x16::join(low, high), pair::F32x16::join(low, high));
            let lane = (mix_bits(seed) >> 16 & 15) as usize;
            let one = [va.broadcast(lane).to_array(), pa.broadcast(lane).to_array()];
            assert!(one.as_flattened().iter().all(|v| is_same(*v, a[lane])), "{a:?} at {lane}");
            assert_eq!(va.le(vb), pa.le(pb), "{a:?} <= {b:?}");
            assert_eq!(va.lt(vb), pa.lt(pb), "{a:?} < {b:?}");
            // The sign of a NaN made by an operation is not defined; those the tests make are.
            assert_eq!(va.differing_signs(vb, va.abs()), pa.differing_signs(pb, pa.abs()));
        }
    }

    #[test]
    fn both_implementations_of_stacks_agree() {
        const SIZE: usize = 40;
        for seed in 0..20_000 {
            let bits = |i: usize| mix_bits(seed * 64 + i as u64 + 1);
            let mask = (bits(0) & 0xff) as u32;
            // Small numbers, so that some are equal but for their last three bits.
            let entry: [f32; LANES] =
                std::array::from_fn(|i| f32::from_bits((bits(i + 1) % 100) as u32));
            let entry = if seed % 2 == 0 { entry } else { pattern(seed).map(f32::abs) };
            let children = std::array::from_fn(|i| ChildRef(bits(i + 9) as u32));
            let count = mask.count_ones() as usize;
            let (mut keys, mut refs) = ([[0; LANES]; 2], [[ChildRef(0); LANES]; 2]);
            let (v, p) = (avx2::F32x8::load(&entry), portable::F32x8::load(&entry));
            stack_avx2::push_sorted(mask, v, &children, &mut keys[0], &mut refs[0]);
            stack_portable::push_sorted(mask, p, &children, &mut keys[1], &mut refs[1]);
            assert_eq!(keys[0][..count], keys[1][..count], "{mask:#b} {entry:?}");
            assert_eq!(refs[0][..count], refs[1][..count], "{mask:#b} {entry:?}");
            assert!(keys[0][..count].is_sorted_by(|a, b| a >= b), "{mask:#b} {entry:?}");

            stack_avx2::push_hits(mask, &children, &mut refs[0]);
            stack_portable::push_hits(mask, &children, &mut refs[1]);
            assert_eq!(refs[0][..count], refs[1][..count], "{mask:#b}");

            let mut keys = [std::array::from_fn::<_, SIZE, _>(|i| bits(i) as u32 >> 3); 2];
            let mut refs = [std::array::from_fn(|i| ChildRef(i as u32)); 2];
            let size = (bits(50) % (SIZE as u64 + 1)) as usize;
            let limit = bits(51) as u32 >> 3;
            let kept = [
                stack_avx2::keep_below(&mut keys[0], &mut refs[0], size, limit),
                stack_portable::keep_below(&mut keys[1], &mut refs[1], size, limit),
            ];
            assert_eq!(kept[0], kept[1], "{limit} of {size}");
            assert_eq!(keys[0][..kept[0]], keys[1][..kept[0]], "{limit} of {size}");
            assert_eq!(refs[0][..kept[0]], refs[1][..kept[0]], "{limit} of {size}");
        }
    }
}
