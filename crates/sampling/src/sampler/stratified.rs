//! Multi-jittered sampling (Chiu, Shirley & Wang, "Multi-Jittered Sampling", Graphics Gems IV,
//! 1994) for any number of samples, computed by permutations instead of tables as in Kensler,
//! "Correlated Multi-Jittered Sampling" (2013). The correlation of the title is left out: with
//! the same sub-cells in all rows the error of ∫f(x)g(y) falls as N^(-3/4) only, with a
//! permutation for each row and column as N^(-1).
//!
//! A *period* of N samples is the planned number. In every 1D draw each of the N strata holds
//! one sample of the period; in every 2D draw each cell of an m × n grid (m ≈ √N, mn ≥ N)
//! holds at most one and each of the N rows holds one. The order is a fresh permutation
//! for each pixel, dimension and period, so that draws are independent of each other. Prefixes
//! of a period are random subsets: good at the planned number, ordinary before it.

use crate::hash::{combine, halves, nth, permute, unit};
use kaustika_math::{ONE_MINUS_EPSILON, Vec2};

/// Longest period: finer strata than 1/65536 would not survive `f32` arithmetic. Longer plans
/// are made of several periods.
const MAX_PERIOD: u64 = 1 << 16;

/// The shape of a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strata {
    period: u32,
    columns: u32,
    rows: u32,
    inv_period: f32,
    inv_columns: f32,
    inv_rows: f32,
}

impl Strata {
    pub(super) fn new(spp: u64) -> Self {
        let period = spp.clamp(1, MAX_PERIOD) as u32;
        // The divisor next to √N wastes no cell; where there is none near, cells stay empty.
        let root = (period as f32).sqrt().round() as u32;
        let divisor = (root / 2 + 1..=root).rev().find(|&m| period.is_multiple_of(m));
        let columns = divisor.unwrap_or(root);
        let rows = period.div_ceil(columns);
        Strata {
            period,
            columns,
            rows,
            inv_period: 1.0 / period as f32,
            inv_columns: 1.0 / columns as f32,
            inv_rows: 1.0 / rows as f32,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Stratified<'a> {
    strata: &'a Strata,
    /// Of the pixel and the period.
    key: u64,
    /// Position within the period.
    slot: u32,
}

impl<'a> Stratified<'a> {
    #[inline]
    pub(super) fn new(strata: &'a Strata, pixel_key: u64, index: u64) -> Self {
        let period = u64::from(strata.period);
        Stratified {
            strata,
            key: combine(pixel_key, index / period),
            slot: (index % period) as u32,
        }
    }

    #[inline]
    pub(super) fn fork(&self, salt: u64) -> Self {
        Stratified { key: combine(self.key, salt), ..*self }
    }

    #[inline(never)]
    pub(super) fn get_1d(&self, dimension: u32) -> f32 {
        let key = nth(self.key, dimension);
        let stratum = permute(self.slot, self.strata.period, key);
        let jitter = unit(halves(combine(key, u64::from(stratum))).0);
        ((stratum as f32 + jitter) * self.strata.inv_period).min(ONE_MINUS_EPSILON)
    }

    #[inline(never)]
    pub(super) fn get_2d(&self, dimension: u32) -> Vec2 {
        let t = self.strata;
        let key = nth(self.key, dimension);
        // Sample s lies in row s of N and so in grid row s / m; the m samples of a grid row take
        // its columns in random order, the samples of a column its sub-columns.
        let s = permute(self.slot, t.period, key);
        let (row, place) = (s / t.columns, s % t.columns);
        let column = permute(place, t.columns, combine(key, u64::from(row)));
        let sub = permute(row, t.rows, combine(!key, u64::from(column)));
        let (jx, jy) = halves(combine(key, u64::from(s) << 32));
        let x = (column as f32 + (sub as f32 + unit(jx)) * t.inv_rows) * t.inv_columns;
        let y = (s as f32 + unit(jy)) * t.inv_period;
        Vec2::new(x.min(ONE_MINUS_EPSILON), y.min(ONE_MINUS_EPSILON))
    }
}
