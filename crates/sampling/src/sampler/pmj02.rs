//! Tables of progressive multi-jittered (0,2) points (Christensen, Kensler & Kilpatrick,
//! "Progressive Multi-Jittered Sample Sequences", 2018).
//!
//! A pmj02 sequence is a randomised (0,2)-sequence in base 2: every aligned block of 2ᵏ
//! points has one in each elementary interval of area 2⁻ᵏ. Owen scrambling of any digital
//! (0,2)-sequence draws from just that family (Helmer, Christensen & Kensler, "Stochastic
//! Generation of (t,s) Sample Sequences", 2021), so the tables are made by it, without the
//! search for blue noise among the candidates of the 2018 paper.
//!
//! The sequence scrambled is four-dimensional: Pascal matrices over the field of four
//! elements, powers 0, 1, ω, ω² (Faure 1982, Niederreiter 1987), a (0,4)-sequence in base 4;
//! with the digit maps below, dimensions (0,1) and (2,3) are (0,2)-sequences in base 2 as
//! well (the observation of Ahmed et al., "SZ Sequences", 2025; here checked by tests). Two
//! consecutive 2D draws take the two pairs of one table entry.
//!
//! Each pixel and draw picks a table, shuffles its index within aligned blocks and shifts its
//! digits (XOR), all of which keep the stratification. Beyond the table a fresh period
//! begins, keyed by its number.

use crate::hash::{combine, halves, nth, owen_reversed, third, unit};
use kaustika_math::Vec2;

/// Entries of one table.
const SMALLEST: u64 = 1 << 8;
const LARGEST: u64 = 1 << 14;
/// Entries of all tables together, 16 bytes each.
const TOTAL: usize = 1 << 15;
const MOST_SETS: usize = 32;

#[derive(Clone, Debug)]
pub(super) struct Pmj02Tables {
    /// All tables, one after the other.
    points: Vec<[u32; 4]>,
    length: u32,
    sets: u32,
}

impl Pmj02Tables {
    pub(super) fn new(spp: u64, key: u64) -> Self {
        let length = spp.clamp(SMALLEST, LARGEST).next_power_of_two() as usize;
        let sets = (TOTAL / length).min(MOST_SETS);
        let columns = columns_reversed();
        let points = (0..sets * length)
            .map(|k| {
                let set_key = combine(key, (k / length) as u64);
                let i = k % length;
                std::array::from_fn(|d| {
                    let reversed = (0..32)
                        .filter(|bit| i >> bit & 1 == 1)
                        .fold(0, |x, bit| x ^ columns[d][bit]);
                    let (seed, _) = halves(nth(set_key, d as u32));
                    owen_reversed(reversed, seed).reverse_bits()
                })
            })
            .collect();
        Pmj02Tables { points, length: length as u32, sets: sets as u32 }
    }
}

/// Two bits as an element b₁ω + b₀ of the field of four elements, times ω (ω² = ω + 1).
const fn times_omega(e: u32) -> u32 {
    let (b1, b0) = (e >> 1 & 1, e & 1);
    (b1 ^ b0) << 1 | b1
}

/// The columns of the four generator matrices, bits reversed.
///
/// Digit j of the index adds C(j, i) αʲ⁻ⁱ times itself to digit i of the number, where α is 0,
/// 1, ω, ω² in the four dimensions; the two bits of the sum leave through an invertible map.
fn columns_reversed() -> [[u32; 32]; 4] {
    let mut columns = [[0; 32]; 4];
    for (d, columns) in columns.iter_mut().enumerate() {
        for (bit, column) in columns.iter_mut().enumerate() {
            let j = bit as u32 / 2;
            for i in 0..=j {
                let odd_binomial = i & !j == 0;
                if !odd_binomial || (d == 0 && i != j) {
                    continue;
                }
                let mut e = 1 << (bit % 2);
                for _ in 0..d.saturating_sub(1) as u32 * (j - i) {
                    e = times_omega(e);
                }
                let (b1, b0) = (e >> 1, e & 1);
                // Of the 36 pairs of maps, 8 make the two dimensions of a pair a (0,2)-sequence.
                let (first, second) = if d % 2 == 0 { (b0, b1) } else { (b1 ^ b0, b0) };
                *column |= (first | second << 1) << (2 * i);
            }
        }
    }
    columns
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Pmj02<'a> {
    tables: &'a Pmj02Tables,
    /// Of the pixel and the period.
    key: u64,
    /// Position in the table, bits of a 32-bit number reversed.
    slot_reversed: u32,
    /// The entry whose first pair was the last 2D draw, if it was.
    half_entry: Option<u32>,
}

impl<'a> Pmj02<'a> {
    #[inline]
    pub(super) fn new(tables: &'a Pmj02Tables, pixel_key: u64, index: u64) -> Self {
        let length = u64::from(tables.length);
        Pmj02 {
            tables,
            key: combine(pixel_key, index >> length.trailing_zeros()),
            slot_reversed: ((index & (length - 1)) as u32).reverse_bits(),
            half_entry: None,
        }
    }

    #[inline]
    pub(super) fn fork(&self, salt: u64) -> Self {
        Pmj02 { key: combine(self.key, salt), half_entry: None, ..*self }
    }

    #[inline]
    pub(super) fn seek(&mut self) {
        self.half_entry = None;
    }

    /// A table entry for a draw: nested shuffling by `h` (an XOR of the index would not do: the
    /// first digits of two draws would stay functions of each other).
    #[inline]
    fn entry(&self, h: u64) -> u32 {
        let t = self.tables;
        let seed = third(h);
        let slot = owen_reversed(self.slot_reversed, seed).reverse_bits();
        ((seed >> 16) & (t.sets - 1)) * t.length + (slot & (t.length - 1))
    }

    #[inline(never)]
    pub(super) fn get_1d(&self, dimension: u32) -> f32 {
        let h = nth(self.key, dimension);
        let (shift, _) = halves(h);
        unit(self.tables.points[self.entry(h) as usize][0] ^ shift)
    }

    #[inline(never)]
    pub(super) fn get_2d(&mut self, dimension: u32) -> Vec2 {
        let h = nth(self.key, dimension);
        let (sx, sy) = halves(h);
        let (entry, pair) = match self.half_entry.take() {
            None => {
                let entry = self.entry(h);
                self.half_entry = Some(entry);
                (entry, 0)
            }
            Some(entry) => (entry, 2),
        };
        let point = &self.tables.points[entry as usize];
        Vec2::new(unit(point[pair] ^ sx), unit(point[pair + 1] ^ sy))
    }
}
