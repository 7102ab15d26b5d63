//! Choice of one of many in constant time.

use super::InvalidWeights;
use super::weights::check;
use kaustika_math::ONE_MINUS_EPSILON;

/// A distribution over 0..n as an alias table (Walker 1977, built by Vose, "A Linear Algorithm
/// for Generating Random Numbers with a Given Distribution", 1991).
///
/// One uniform number is enough: what the choice leaves of it is uniform again and returned.
/// Its bits are shared: with n entries about 24 - log₂ n of them are left, so take a fresh
/// number for a choice among more than some thousands. The table does not keep the order of
/// the entries: stratified numbers stay stratified only within an entry; use
/// [`PiecewiseConstant1D`](super::PiecewiseConstant1D) where order means nearness.
#[derive(Clone, Debug)]
pub struct Discrete {
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Probability that this bin, once chosen, stands for its own index.
    keep: f32,
    /// Otherwise for this one.
    alias: u32,
    pmf: f32,
}

/// A choice from a [`Discrete`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteSample {
    /// The index chosen.
    pub index: usize,
    /// Its probability.
    pub pmf: f32,
    /// A number in [0, 1), uniform given the choice.
    pub u: f32,
}

impl Discrete {
    /// With probabilities proportional to `weights`.
    ///
    /// # Errors
    /// If there are no weights, more than 2³²-1, an invalid one or no positive one.
    pub fn new(weights: &[f32]) -> Result<Self, InvalidWeights> {
        let n = weights.len();
        if n == 0 || n > u32::MAX as usize {
            return Err(InvalidWeights::Shape { expected: 1, found: n });
        }
        let sum = check(weights)?;
        // Each bin is filled to 1/n: the small ones as they are, their rest by a large one.
        let mut height: Vec<f64> = weights.iter().map(|&w| f64::from(w) / sum * n as f64).collect();
        let mut bins: Vec<Bin> = weights
            .iter()
            .enumerate()
            .map(|(i, &w)| Bin { keep: 1.0, alias: i as u32, pmf: (f64::from(w) / sum) as f32 })
            .collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&i| height[i] < 1.0);
        while let (Some(s), Some(&l)) = (small.last().copied(), large.last()) {
            small.pop();
            bins[s].keep = height[s] as f32;
            bins[s].alias = l as u32;
            height[l] -= 1.0 - height[s];
            if height[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // Rounding may leave bins of height 1 ± ε in `small`; an impossible entry never is, for
        // a large one's share is left as long as a small one is.
        for s in small {
            if weights[s] == 0.0 {
                bins[s].keep = 0.0;
                bins[s].alias = heaviest(weights) as u32;
            }
        }
        Ok(Discrete { bins })
    }

    /// Chooses an index; `u` in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> DiscreteSample {
        let n = self.bins.len();
        let scaled = f64::from(u) * n as f64;
        let i = (scaled as usize).min(n - 1);
        let bin = self.bins[i];
        let rest = ((scaled - i as f64) as f32).min(ONE_MINUS_EPSILON);
        let (index, u) = if rest < bin.keep {
            (i, rest / bin.keep)
        } else {
            (bin.alias as usize, (rest - bin.keep) / (1.0 - bin.keep))
        };
        DiscreteSample { index, pmf: self.bins[index].pmf, u: u.clamp(0.0, ONE_MINUS_EPSILON) }
    }

    /// The probability of `index`; 0 outside the table.
    #[inline]
    pub fn pmf(&self, index: usize) -> f32 {
        self.bins.get(index).map_or(0.0, |b| b.pmf)
    }

    /// The number of entries, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.bins.len()
    }
}

fn heaviest(weights: &[f32]) -> usize {
    (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0)
}
