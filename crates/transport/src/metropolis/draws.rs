//! Where a chain's own numbers come from.

use crate::saved::saved;
use kaustika_math::mix_bits;
use kaustika_sampling::hash::{GOLDEN, combine};

/// A stream of random numbers that is two words to keep: number n is a hash of key and n
/// (SplitMix64, Steele, Lea & Flood 2014).
#[derive(Clone, Debug, PartialEq)]
pub struct Draws {
    key: u64,
    n: u64,
}
saved!(Draws { key, n });

impl Draws {
    /// The stream of this seed and number.
    pub fn new(seed: u64, number: u64) -> Draws {
        Draws { key: combine(combine(seed, 0x6472_6177), number), n: 0 }
    }

    /// The next number in [0, 1), of 24 bits.
    #[inline]
    pub fn f32(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// The next number in [0, 1), of 53 bits.
    #[inline]
    pub fn f64(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next of `n` equally likely numbers 0..n.
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        ((self.f64() * n as f64) as usize).min(n.saturating_sub(1))
    }

    #[inline]
    fn bits(&mut self) -> u64 {
        self.n += 1;
        mix_bits(self.key.wrapping_add(self.n.wrapping_mul(GOLDEN)))
    }
}
