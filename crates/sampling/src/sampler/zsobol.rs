//! Owen-scrambled Sobol points dealt out along a shuffled Z-order curve (Ahmed & Wonka,
//! "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering
//! of Pixels", ACM Trans. Graph. 39(6), 2020; pbrt-v4 uses it as its default).
//!
//! The planned samples of a pixel, rounded up to 4ᵏ, are an aligned block of one (0,2)-sequence
//! that spans the image; neighbouring pixels hold neighbouring blocks, so that their errors
//! cancel and the image's error has little low-frequency content. Each draw permutes the
//! base-4 digits of the global index (Z-order code of the pixel, then the sample) by a nested
//! random permutation of its own, so draws are independent.
//!
//! Samples past 4ᵏ continue with a fresh curve and fresh scrambles, keyed by the number of the
//! block: each block is as good as the first, the mean of several is the mean of independent
//! estimates.

use super::sobol::{scrambled, scrambled_2d};
use super::sobol_matrix::pascal_reversed_64;
use crate::hash::{combine, nth, owen4_reversed, third};
use kaustika_math::{Vec2, mix_bits};

/// Upper limit of k: 4¹⁴ samples and 2¹⁸ × 2¹⁸ pixels fill 64 bits.
const MAX_SAMPLE_DIGITS: u32 = 14;

/// How the global index is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    /// k, base-4 digits of the sample number.
    sample_digits: u32,
    /// Pixels beyond this square, which only happen outside the image, repeat it.
    pixel_mask: u32,
}

impl Curve {
    pub(super) fn new(resolution: [u32; 2], spp: u64) -> Self {
        let side = resolution[0].max(resolution[1]).clamp(1, 1 << 18).next_power_of_two();
        let sample_bits = 64 - (spp - 1).leading_zeros();
        Curve {
            sample_digits: sample_bits.div_ceil(2).min(MAX_SAMPLE_DIGITS),
            pixel_mask: side - 1,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct ZSobol {
    /// Of the seed and the block, the same for all pixels.
    key: u64,
    /// The global index, bits reversed.
    index_reversed: u64,
}

/// The bits of `v` moved to the even positions.
#[inline]
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    v = (v ^ (v << 16)) & 0x0000_ffff_0000_ffff;
    v = (v ^ (v << 8)) & 0x00ff_00ff_00ff_00ff;
    v = (v ^ (v << 4)) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v ^ (v << 2)) & 0x3333_3333_3333_3333;
    (v ^ (v << 1)) & 0x5555_5555_5555_5555
}

impl ZSobol {
    #[inline]
    pub(super) fn new(curve: &Curve, key: u64, pixel: [u32; 2], index: u64) -> Self {
        let bits = 2 * curve.sample_digits;
        let block = index >> bits;
        let [x, y] = pixel.map(|c| c & curve.pixel_mask);
        let morton = spread(x) | spread(y) << 1;
        let global = morton << bits | (index & ((1 << bits) - 1));
        ZSobol { key: combine(key, block), index_reversed: global.reverse_bits() }
    }

    #[inline]
    pub(super) fn fork(&self, salt: u64) -> Self {
        ZSobol { key: combine(self.key, salt), ..*self }
    }

    #[inline(never)]
    pub(super) fn get_1d(&self, dimension: u32) -> f32 {
        let h = nth(self.key, dimension);
        let i = owen4_reversed(self.index_reversed, h).reverse_bits();
        scrambled(i as u32, third(h))
    }

    #[inline(never)]
    pub(super) fn get_2d(&self, dimension: u32) -> Vec2 {
        let h = nth(self.key, dimension);
        let i = owen4_reversed(self.index_reversed, h).reverse_bits();
        // All of h went into the permutation.
        scrambled_2d(i as u32, pascal_reversed_64(i), mix_bits(!h))
    }
}
