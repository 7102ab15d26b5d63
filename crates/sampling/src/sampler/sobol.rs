//! Owen-scrambled Sobol points, padded in groups of four dimensions (Burley, "Practical
//! Hash-based Owen Scrambling", JCGT 9(4), 2020).
//!
//! Two consecutive 2D draws are four dimensions of one Sobol sequence (Joe & Kuo's direction
//! numbers), scrambled in each; the next two take the same sequence in an order shuffled
//! anew; so are the first four numbers of a vertex. The first pair of a group is a (0,2)-sequence, the second has t ≤ 2. A 1D draw is
//! shuffled and scrambled by itself. All keys depend on the pixel and on the upper half of the
//! index: beyond 2³² samples a fresh scramble begins.

use super::VERTEX_NUMBERS;
use super::sobol_matrix::{PAIR_COLUMNS, pair_reversed, pascal_reversed};
use crate::hash::{combine, halves, mix_bits_32, nth, owen_reversed, third, unit};
use kaustika_math::Vec2;
use kaustika_math::lanes::{LANES, Row};

#[derive(Clone, Copy, Debug)]
pub(super) struct Sobol {
    key: u64,
    /// The lower half of the index, bits reversed.
    index_reversed: u32,
    /// The shuffled index of the group whose first pair was the last 2D draw, if it was.
    half_group: Option<u32>,
}

/// A scrambled number from its reversed digits.
#[inline]
pub(super) fn scrambled(reversed: u32, seed: u32) -> f32 {
    unit(owen_reversed(reversed, seed).reverse_bits())
}

/// Two scrambled numbers from their reversed digits, which are put in order together.
#[inline]
pub(super) fn scrambled_2d(x: u32, y: u32, seeds: u64) -> Vec2 {
    let (sx, sy) = halves(seeds);
    let both = u64::from(owen_reversed(x, sx)) | u64::from(owen_reversed(y, sy)) << 32;
    let (x, y) = halves(both.reverse_bits());
    Vec2::new(unit(x), unit(y))
}

/// [`Sobol::get_vertex`] of sixteen paths from their [`Sobol::vertex_seeds`]: the same
/// operations, here with a path a lane.
#[inline(never)]
pub(super) fn vertices_from_seeds(
    [high, low, index_reversed]: &[[u32; LANES]; 3],
    out: &mut [Row; VERTEX_NUMBERS],
) {
    let shuffled = |group: u32| -> [u32; LANES] {
        std::array::from_fn(|i| {
            let seed = mix_bits_32(high[i] ^ group << 28);
            owen_reversed(index_reversed[i], seed).reverse_bits()
        })
    };
    let mut write = |k: usize, x: &[u32; LANES]| {
        for i in 0..LANES {
            out[k][i] = scrambled(x[i], mix_bits_32(low[i] ^ (k as u32) << 28));
        }
    };
    let x = shuffled(0);
    write(0, &x);
    write(1, &x.map(pascal_reversed));
    let (mut y, mut z) = ([0; LANES], [0; LANES]);
    for (bit, (third, fourth)) in PAIR_COLUMNS.iter().enumerate() {
        for i in 0..LANES {
            let set = 0u32.wrapping_sub(x[i] >> bit & 1);
            y[i] ^= third & set;
            z[i] ^= fourth & set;
        }
    }
    write(2, &y);
    write(3, &z);
    for k in 4..VERTEX_NUMBERS {
        write(k, &shuffled(k as u32 - 3));
    }
}

impl Sobol {
    #[inline]
    pub(super) fn new(pixel_key: u64, index: u64) -> Self {
        Sobol {
            key: combine(pixel_key, index >> 32),
            index_reversed: (index as u32).reverse_bits(),
            half_group: None,
        }
    }

    #[inline]
    pub(super) fn fork(&self, salt: u64) -> Self {
        Sobol { key: combine(self.key, salt), half_group: None, ..*self }
    }

    #[inline]
    pub(super) fn seek(&mut self) {
        self.half_group = None;
    }

    /// Four dimensions of one shuffled sequence, then the first dimension of four others. Keys,
    /// shuffles and scrambles are the same operations on eight lanes, which the compiler makes
    /// vector instructions of.
    #[inline]
    pub(super) fn get_vertex(&mut self, dimension: u32) -> [f32; VERTEX_NUMBERS] {
        self.half_group = None;
        let (high, low) = halves(nth(self.key, dimension));
        // Lane 0's shuffle serves the first four.
        let shuffles: [u32; VERTEX_NUMBERS] =
            std::array::from_fn(|lane| mix_bits_32(high ^ (lane.saturating_sub(3) as u32) << 28));
        let scrambles: [u32; VERTEX_NUMBERS] =
            std::array::from_fn(|lane| mix_bits_32(low ^ (lane as u32) << 28));
        let mut x = shuffles.map(|seed| owen_reversed(self.index_reversed, seed).reverse_bits());
        let i = x[0];
        x[1] = pascal_reversed(i);
        (x[2], x[3]) = pair_reversed(i);
        std::array::from_fn(|lane| scrambled(x[lane], scrambles[lane]))
    }

    /// What this path's numbers at a vertex are made of.
    #[inline(always)]
    pub(super) fn vertex_seeds(&mut self, dimension: u32) -> [u32; 3] {
        self.half_group = None;
        let (high, low) = halves(nth(self.key, dimension));
        [high, low, self.index_reversed]
    }

    #[inline(never)]
    pub(super) fn get_1d(&self, dimension: u32) -> f32 {
        let (shuffle, scramble) = halves(nth(self.key, dimension));
        scrambled(owen_reversed(self.index_reversed, shuffle).reverse_bits(), scramble)
    }

    #[inline(never)]
    pub(super) fn get_2d(&mut self, dimension: u32) -> Vec2 {
        let h = nth(self.key, dimension);
        let (x, y) = match self.half_group.take() {
            None => {
                let i = owen_reversed(self.index_reversed, third(h)).reverse_bits();
                self.half_group = Some(i);
                (i, pascal_reversed(i))
            }
            Some(i) => pair_reversed(i),
        };
        scrambled_2d(x, y, h)
    }
}
