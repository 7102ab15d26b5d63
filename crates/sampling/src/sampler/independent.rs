//! Pseudo-random numbers.

use crate::hash::{GOLDEN, combine, halves, unit};
use kaustika_math::{Vec2, mix_bits};

/// xoroshiro128++ 1.0 (Blackman & Vigna, "Scrambled Linear Pseudorandom Number Generators",
/// 2021). All 128 bits of its state are hashed from the address of the sample, so that two of
/// 2⁴⁰ paths overlap with probability about 2⁻⁴⁰.
#[derive(Clone, Copy, Debug)]
pub(super) struct Independent {
    s0: u64,
    s1: u64,
    /// The first state word: what `seek` starts from.
    origin: u64,
}

impl Independent {
    #[inline]
    pub(super) fn new(pixel_key: u64, index: u64) -> Self {
        Self::from_hashes(combine(pixel_key, index), combine(!pixel_key, index.rotate_left(32)))
    }

    /// The all-zero state is the generator's only fixed point.
    #[inline]
    fn from_hashes(s0: u64, s1: u64) -> Self {
        Independent { s0, s1: if s0 | s1 == 0 { GOLDEN } else { s1 }, origin: s0 }
    }

    #[inline]
    fn next(&mut self) -> u64 {
        let (s0, s1) = (self.s0, self.s1);
        let result = s0.wrapping_add(s1).rotate_left(17).wrapping_add(s0);
        let t = s0 ^ s1;
        self.s0 = s0.rotate_left(49) ^ t ^ (t << 21);
        self.s1 = t.rotate_left(28);
        result
    }

    #[inline]
    pub(super) fn get_1d(&mut self) -> f32 {
        unit(halves(self.next()).0)
    }

    #[inline]
    pub(super) fn get_2d(&mut self) -> Vec2 {
        let (x, y) = halves(self.next());
        Vec2::new(unit(x), unit(y))
    }
}

impl Independent {
    /// A stream that depends on what has been drawn so far and on `salt`.
    pub(super) fn fork(&self, salt: u64) -> Self {
        Self::from_hashes(combine(self.s0, salt), combine(self.s1, mix_bits(salt)))
    }

    /// The stream that belongs to `dimension`, whatever has been drawn so far.
    pub(super) fn seek(&mut self, dimension: u32) {
        let origin = self.origin;
        let d = u64::from(dimension);
        *self = Self::from_hashes(combine(origin, d), combine(!origin, d));
        self.origin = origin;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_vector() {
        // The first outputs of the authors' generator from the state (1, 2).
        let mut g = Independent { s0: 1, s1: 2, origin: 1 };
        assert_eq!(g.next(), 393_217);
        assert_eq!(g.next(), 669_327_710_093_319);
        assert_eq!(g.next(), 1_732_421_326_133_921_491);
        assert_eq!(g.next(), 11_394_790_081_659_126_983);
    }
}
