//! Where to search a row of running integrals.

/// Cutpoints (Chen & Asau 1974, "On Generating Random Variates from an Empirical Distribution")
/// for the interpolation between neighbouring rows of running integrals: for k/G of a row's own
/// total the columns between which it is reached.
///
/// For u in [k/G, (k + 1)/G) the column sought between two rows lies between the lesser of the
/// columns where they reach k/G and the greater of those where they reach (k + 1)/G: where both
/// rows have at most u times their totals, so has their interpolation, and where both have
/// more, it has. This holds up to rounding, so the bracket is to be checked.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    /// G.
    parts: usize,
    /// Low and high column over 2^shift, rounded down and up; G pairs between two rows.
    brackets: Vec<[u16; 2]>,
    /// 0 unless columns are too many for 16 bits.
    shift: u32,
}

/// Columns a cutpoint, on average: a table eight times smaller than the integrals' and
/// densities', to stay in a cache that they leave.
const COLUMNS: usize = 8;

impl Guide {
    /// For rows of `width` ≥ 2 integrals that start at 0 and do not decrease; at least two rows.
    pub fn new(integrals: &[f32], width: usize) -> Guide {
        let parts = (width - 1).div_ceil(COLUMNS);
        let cuts: Vec<Vec<[u32; 2]>> =
            integrals.chunks_exact(width).map(|row| cutpoints(row, parts)).collect();
        let shift = (width.ilog2() + 1).saturating_sub(16);
        let last = (width - 2) as u32;
        let between = cuts.windows(2).flat_map(|rows| {
            rows[0].iter().zip(&rows[1]).map(|(a, b)| {
                let low = a[0].min(b[0]).min(last);
                let high = a[1].max(b[1]).max(low + 1);
                [(low >> shift) as u16, high.div_ceil(1 << shift) as u16]
            })
        });
        Guide { parts, brackets: between.collect(), shift }
    }

    /// Columns low < high within the row, between rows `row` and `row` + 1, such that the
    /// integral at low is at most `u` of the total, or low is 0, and the integral at high is
    /// more, or high is the last column (or beyond it, by the rounding to 2^shift); both up to
    /// rounding. `u` in [0, 1].
    #[inline]
    pub fn bracket(&self, row: usize, u: f32) -> (usize, usize) {
        let k = ((u * self.parts as f32) as usize).min(self.parts - 1);
        let [low, high] = self.brackets[row * self.parts + k];
        ((low as usize) << self.shift, (high as usize) << self.shift)
    }
}

/// The bracket of each of the parts in one row. An empty row has no say: its brackets are the
/// neutral elements of the union.
fn cutpoints(row: &[f32], parts: usize) -> Vec<[u32; 2]> {
    let last = row.len() - 1;
    let total = f64::from(row[last]);
    if total <= 0.0 {
        return vec![[u32::MAX, 0]; parts];
    }
    let (mut low, mut high) = (0, 0);
    let bracket = |k: usize| {
        let share = |k: usize| total * k as f64 / parts as f64;
        while low + 1 < last && f64::from(row[low + 1]) <= share(k) {
            low += 1;
        }
        while high < last && f64::from(row[high]) < share(k + 1) {
            high += 1;
        }
        [low as u32, high as u32]
    };
    (0..parts).map(bracket).collect()
}
