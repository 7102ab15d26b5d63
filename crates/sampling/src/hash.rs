//! Hashes that random numbers are made of: keys, nested uniform (Owen) scrambling and
//! permutations of any length.

use kaustika_math::mix_bits;

/// 2⁶⁴ divided by the golden ratio, the odd step of a Weyl sequence of keys.
pub const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A key that depends on `key` and `value`; for a given key, different values give different
/// results.
#[inline]
pub const fn combine(key: u64, value: u64) -> u64 {
    mix_bits(key.wrapping_add(GOLDEN) ^ value)
}

/// The `n`-th key of the stream that belongs to a well-mixed `key`.
#[inline]
pub const fn nth(key: u64, n: u32) -> u64 {
    mix_bits(key.wrapping_add((n as u64 + 1).wrapping_mul(GOLDEN)))
}

/// A 32-bit finaliser with good avalanche, for lanes that are computed together (Wellons,
/// "Prospecting for Hash Functions", 2018: lowbias32).
#[inline]
pub const fn mix_bits_32(mut v: u32) -> u32 {
    v ^= v >> 16;
    v = v.wrapping_mul(0x7feb_352d);
    v ^= v >> 15;
    v = v.wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

/// Both halves of a 64-bit hash: high, low.
#[inline]
pub const fn halves(h: u64) -> (u32, u32) {
    ((h >> 32) as u32, h as u32)
}

/// A third 32-bit number out of a 64-bit hash whose halves serve already.
#[inline]
pub const fn third(h: u64) -> u32 {
    (h.wrapping_mul(GOLDEN) >> 32) as u32
}

/// The upper 24 bits of `x` as a fraction in [0, 1), at most
/// [`ONE_MINUS_EPSILON`](kaustika_math::ONE_MINUS_EPSILON).
#[inline]
pub const fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Nested uniform scrambling in base 2 of bits in **reversed** order: whether bit k is flipped
/// depends on `seed` and on the bits below k only.
///
/// Applied to the reversed digits of a radical inverse it is Owen's scrambling (1995); applied
/// to a reversed index it shuffles so that each aligned block of 2ᵏ indices stays an aligned
/// block. The idea is Laine and Karras' (2011), its use Burley's ("Practical Hash-based Owen
/// Scrambling", 2020); the constants are Vegdahl's ("Building a better LK hash", 2021), which
/// remove the visible bias of the first ones. `seed` must be well mixed already.
#[inline]
pub const fn owen_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Nested uniform scrambling in base 4 of digits in **reversed** order (plain bit reversal, so
/// a digit's upper bit comes first): how a digit is permuted depends on `seed` and on the
/// digits before it only.
///
/// Even multiples carry information upwards only, as in [`owen_reversed`]; between them the
/// upper bit of each digit is made to depend on the lower one, which turns the 8 nested
/// permutations of four things into all 24 (Vegdahl, "A fast hash for base-4 Owen scrambling",
/// 2022, gives the idea for 32 bits; this one is ours). The 24 are not quite equally likely,
/// which bits alone cannot give: tests hold each between 1/2 and 2 times its share.
#[inline]
pub const fn owen4_reversed(mut x: u64, seed: u64) -> u64 {
    let second = seed.wrapping_mul(GOLDEN).rotate_left(32);
    x ^= x.wrapping_mul(0x9c3b_51f6_3d20_adea);
    x ^= swap_digits(x, second);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(second | 1);
    x ^= swap_digits(x, seed >> 7);
    x ^= x.wrapping_mul(0x2f1e_9d43_0552_6c56);
    x ^ x.wrapping_mul(0xd1a5_7c2b_53a2_2864)
}

/// The upper bits of the base-4 digits that flip: where the lower bit is set, by a bit of
/// `seed` and the digit before.
#[inline]
const fn swap_digits(x: u64, seed: u64) -> u64 {
    (x >> 1) & ((x << 1) ^ seed) & 0x5555_5555_5555_5555
}

/// The image of `i` under a pseudo-random permutation of 0..n chosen by `key`.
///
/// An invertible hash on the next power of two, repeated until it lands below n ("cycle
/// walking", as in Kensler, "Correlated Multi-Jittered Sampling", 2013). Each round adds, multiplies
/// by an odd number, both chosen by the key, and folds the upper half onto the lower.
/// `i < n` is required, and n ≤ 2³¹.
#[inline]
pub const fn permute(mut i: u32, n: u32, key: u64) -> u32 {
    debug_assert!(i < n && n <= 1 << 31);
    let bits = 32 - (n - 1).leading_zeros();
    let mask = ((1u64 << bits) - 1) as u32;
    let shift = bits.div_ceil(2);
    let (a, b) = halves(key);
    let (c, d) = halves(mix_bits(key));
    loop {
        i = i.wrapping_add(a).wrapping_mul(b | 1) & mask;
        i ^= i >> shift;
        i = i.wrapping_add(c).wrapping_mul(d | 1) & mask;
        i ^= i >> shift;
        i = i.wrapping_add(b >> 7).wrapping_mul(a >> 5 | 1) & mask;
        i ^= i >> shift;
        i = i.wrapping_add(d >> 7).wrapping_mul(c >> 5 | 1) & mask;
        if i < n {
            return i;
        }
    }
}

#[cfg(test)]
mod tests;
