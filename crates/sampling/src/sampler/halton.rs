//! Halton's sequence with random digit permutations and a rotation per pixel and dimension.
//!
//! Dimension d uses base b = the d-th prime. The digits of the index are replaced by one random
//! permutation of 0..b (Braaten & Weller 1979 permute so; theirs were searched for), mirrored
//! about the radix point, and shifted modulo 1 (Cranley & Patterson 1976) by a hash of
//! (pixel, dimension), which makes each number uniform and different pixels independent.
//! Past the last base numbers are random: the radical inverses of large primes are no better
//! at any practical number of samples.

use crate::hash::{combine, halves, nth, permute, unit};
use kaustika_math::Vec2;

/// The number of dimensions that have a base of their own.
const DIMENSIONS: usize = 64;

#[derive(Clone, Debug)]
pub(super) struct HaltonTables {
    bases: Vec<Base>,
    /// The permutations of all bases, one after the other.
    permutations: Vec<u16>,
}

#[derive(Clone, Copy, Debug)]
struct Base {
    b: u32,
    /// Where its permutation begins.
    first: u32,
    /// ⌈2⁴⁰/b⌉: n/b = n·reciprocal >> 40 for n < 2²⁴.
    reciprocal: u64,
    inv: f64,
    /// π(0)·b/(b-1): what the endless leading zeros of an index add, in units of the first of
    /// them.
    tail: f64,
}

impl HaltonTables {
    pub(super) fn new(key: u64) -> Self {
        let mut bases = Vec::with_capacity(DIMENSIONS);
        let mut permutations = Vec::new();
        let primes = (2u32..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0));
        for (i, b) in primes.take(DIMENSIONS).enumerate() {
            let first = permutations.len();
            let key = nth(key, i as u32);
            permutations.extend((0..b).map(|digit| permute(digit, b, key) as u16));
            bases.push(Base {
                b,
                first: first as u32,
                reciprocal: (1u64 << 40).div_ceil(u64::from(b)),
                inv: 1.0 / f64::from(b),
                tail: f64::from(permutations[first]) * f64::from(b) / f64::from(b - 1),
            });
        }
        HaltonTables { bases, permutations }
    }

    /// The permuted radical inverse of `index`, as a fraction of 2³² rounded down.
    #[inline]
    fn radical_inverse(&self, dimension: usize, index: u64) -> u32 {
        if dimension == 0 {
            return (index.reverse_bits() >> 32) as u32;
        }
        let base = &self.bases[dimension];
        let b = u64::from(base.b);
        let permutation = &self.permutations[base.first as usize..];
        let (mut value, mut scale) = (0.0f64, base.inv);
        let mut n = index;
        while n >= 1 << 24 {
            let q = n / b;
            value += f64::from(permutation[(n - q * b) as usize]) * scale;
            scale *= base.inv;
            n = q;
        }
        while n > 0 {
            let q = (n * base.reciprocal) >> 40;
            value += f64::from(permutation[(n - q * b) as usize]) * scale;
            scale *= base.inv;
            n = q;
        }
        // `as` saturates, which takes care of a sum that rounds to 1.
        ((value + base.tail * scale) * 4_294_967_296.0) as u32
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Halton<'a> {
    tables: &'a HaltonTables,
    pixel_key: u64,
    index: u64,
}

impl<'a> Halton<'a> {
    #[inline]
    pub(super) fn new(tables: &'a HaltonTables, pixel_key: u64, index: u64) -> Self {
        Halton { tables, pixel_key, index }
    }

    #[inline]
    pub(super) fn fork(&self, salt: u64) -> Self {
        Halton { pixel_key: combine(self.pixel_key, salt), ..*self }
    }

    #[inline]
    fn component(&self, dimension: u32, rotation: u32, random: u32) -> f32 {
        let d = dimension as usize;
        if d < DIMENSIONS {
            unit(self.tables.radical_inverse(d, self.index).wrapping_add(rotation))
        } else {
            unit(random)
        }
    }

    #[inline(never)]
    pub(super) fn get_1d(&self, dimension: u32) -> f32 {
        let h = nth(self.pixel_key, dimension);
        let (rotation, _) = halves(h);
        let (random, _) = halves(combine(h, self.index));
        self.component(dimension, rotation, random)
    }

    #[inline(never)]
    pub(super) fn get_2d(&self, dimension: u32) -> Vec2 {
        let h = nth(self.pixel_key, dimension);
        let (rx, ry) = halves(h);
        let (ux, uy) = halves(combine(h, self.index));
        Vec2::new(
            self.component(dimension, rx, ux),
            self.component(dimension.wrapping_add(1), ry, uy),
        )
    }
}
