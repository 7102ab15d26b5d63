//! Do chains agree? Split R̂ (Gelman & Rubin 1992; split: Gelman et al., *Bayesian Data Analysis*, 2013).
//!
//! ```text
//! R̂² = (n - 1)/n + B/W                                                               (1)
//! ```
//!
//! Of the light that each group of chains leaves in a part of the picture, pass by pass: sequences are the two
//! halves of each group's n passes; B is the variance of their means, W the mean of their
//! variances. Near 1, a sequence tells what all tell; where it is above, groups still keep to what they
//! began with. Passes are kept in at most eight stretches of one length, which doubles.

use crate::saved::saved;

/// Stretches before they are joined.
const STRETCHES: usize = 8;
/// Fewest passes of a sequence.
const FEWEST: u64 = 4;

/// What sequences have shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Numbers of a pass.
    width: u64,
    /// Passes of a stretch.
    length: u64,
    /// Passes of the last one, which may not be full.
    filled: u64,
    /// Sum and sum of squares of each number, stretch by stretch.
    stretches: Vec<Vec<[f64; 2]>>,
}
saved!(Series { width, length, filled, stretches });

impl Series {
    /// Of `width` numbers in each pass.
    pub fn new(width: usize) -> Series {
        Series { width: width as u64, length: 1, filled: 1, stretches: Vec::new() }
    }

    /// A pass.
    pub fn push(&mut self, numbers: &[f64]) {
        if self.filled == self.length {
            if self.stretches.len() == STRETCHES {
                let pairs = self.stretches.chunks(2);
                let join = |pair: &[Vec<[f64; 2]>]| {
                    let sum = |(a, b): (&[f64; 2], &[f64; 2])| [a[0] + b[0], a[1] + b[1]];
                    pair[0].iter().zip(&pair[1]).map(sum).collect()
                };
                self.stretches = pairs.map(join).collect();
                self.length *= 2;
            }
            self.stretches.push(vec![[0.0; 2]; self.width as usize]);
            self.filled = 0;
        }
        self.filled += 1;
        if let Some(last) = self.stretches.last_mut() {
            for (sums, x) in last.iter_mut().zip(numbers) {
                *sums = [sums[0] + x, sums[1] + x * x];
            }
        }
    }

    /// (1) of the numbers at these places of a pass, over as many full stretches as make two halves; 1
    /// where all are 0, `None` of too few passes.
    pub fn r_hat(&self, places: impl Iterator<Item = usize> + Clone) -> Option<f64> {
        let full = self.stretches.len() - usize::from(self.filled < self.length);
        let half = full / 2;
        let n = half as u64 * self.length;
        if n < FEWEST {
            return None;
        }
        let n = n as f64;
        let (mut within, mut means) = (0.0, Vec::new());
        for h in 0..2 {
            for place in places.clone() {
                let of = self.stretches[h * half..(h + 1) * half].iter().map(|s| s[place]);
                let [sum, squares] = of.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
                means.push(sum / n);
                within += (squares - sum * sum / n).max(0.0) / (n - 1.0);
            }
        }
        let m = means.len() as f64;
        let mean = means.iter().sum::<f64>() / m;
        let between = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (m - 1.0).max(1.0);
        let within = within / m;
        if within == 0.0 {
            return Some(if between == 0.0 { 1.0 } else { f64::INFINITY });
        }
        Some(((n - 1.0) / n + between / within).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metropolis::Draws;

    #[test]
    fn it_is_one_where_sequences_agree_and_more_where_they_do_not() {
        let mut draws = Draws::new(3, 5);
        let mut series = Series::new(8);
        let passes = 203;
        for pass in 0..passes {
            // Four sequences that agree; one of four that is off; and later all that drift.
            let mut x: Vec<f64> = (0..8).map(|_| draws.f64()).collect();
            x[4] += 1.0;
            if pass == 100 {
                let r = |s: &Series, k: usize| s.r_hat(4 * k..4 * k + 4).unwrap();
                assert!((r(&series, 0) - 1.0).abs() < 0.05, "{}", r(&series, 0));
                // Of eight means two are off by one: B = 1.5/7, W = 1/12.
                assert!((r(&series, 1) - 1.89).abs() < 0.1, "{}", r(&series, 1));
            }
            if pass >= 100 {
                x.iter_mut().take(4).for_each(|x| *x += 1.0);
            }
            series.push(&x);
        }
        // The halves of each differ though the sequences do not: B about 0.28, W about 1/12.
        assert!(series.r_hat(0..4).unwrap() > 1.5);
        assert_eq!(Series::new(1).r_hat(0..1), None);
    }
}
