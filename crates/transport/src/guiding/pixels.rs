//! What the pixels are worth: the measurement I of each, and the picture's variance.
//!
//! ```text
//! V̄ = mean over pixels and passes of ½ (xᵢ - xᵢ₋₁)² / (I² + ε²)                           (1)
//! V̄ = mean over pixels of (P - x̄²) / (I² + ε²)      of plain paths, at least               (2)
//! ```
//!
//! Both are guesses from passes that went before; they steer and are never seen. I is smoothed, and
//! wrong where the picture has edges: differences between passes do not see that. P is what trees say of
//! the second moment of plain paths ([`crate::trees`]), x̄ the mean so far.

use crate::saved::saved;

/// Half the width of the window that smooths.
const RADIUS: usize = 3;
/// ε over the picture's mean value.
const DIM: f32 = 0.1;
/// Part of the pixels of largest error that (1) and (2) leave out, of their means over the passes: of
/// each pass alone they would leave out all that is rare and bright, and with it, where light is
/// caught by chance, most of the variance, but not that of the cells that cause it.
const OUTLIERS: f64 = 0.001;

/// Grey values of the picture, as far as it is known.
#[derive(Clone, Debug)]
pub struct Pixels {
    width: u64,
    sums: Vec<f32>,
    /// Σ P.
    plain: Vec<f32>,
    passes: u32,
    /// The first pass, of plain paths.
    first: Vec<f32>,
    /// The pass before in this iteration.
    before: Vec<f32>,
    /// Σ of (1) over the pairs of passes of this iteration, of each pixel, and how many they are.
    errors: Vec<f32>,
    pairs: u32,
    /// I, never 0; empty while nothing is known.
    measurements: Vec<f32>,
}

saved!(Pixels { width, sums, plain, passes, first, before, errors, pairs, measurements });

impl Pixels {
    /// Of a picture of this size, nothing known.
    pub fn new(width: usize, height: usize) -> Pixels {
        Pixels {
            width: width as u64,
            sums: vec![0.0; width * height],
            plain: vec![0.0; width * height],
            passes: 0,
            first: Vec::new(),
            before: Vec::new(),
            errors: vec![0.0; width * height],
            pairs: 0,
            measurements: Vec::new(),
        }
    }

    /// I of every pixel, row by row; empty while nothing is known.
    pub fn measurements(&self) -> &[f32] {
        &self.measurements
    }

    /// Mean of the picture's values over I: below 1 where much of it is dark. 1 while nothing is
    /// known.
    pub fn lit(&self) -> f32 {
        let scale = 1.0 / f64::from(self.passes.max(1));
        let part = |(sum, i): (&f32, &f32)| f64::from(sum / i) * scale;
        let whole: f64 = self.sums.iter().zip(&self.measurements).map(part).sum();
        match self.measurements.len() {
            0 => 1.0,
            n => (whole / n as f64) as f32,
        }
    }

    /// Takes in what a pass says of plain paths.
    pub fn learn_plain(&mut self, plain: &[f32]) {
        self.plain.iter_mut().zip(plain).for_each(|(sum, p)| *sum += p);
    }

    /// Takes in the values of a pass.
    pub fn learn(&mut self, values: &[f32]) {
        self.sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += v);
        self.passes += 1;
        if self.first.is_empty() {
            self.first = values.to_vec();
            self.smooth();
        }
        if !self.before.is_empty() {
            let pairs = values.iter().zip(&self.before).zip(&self.measurements);
            for (error, ((a, b), i)) in self.errors.iter_mut().zip(pairs) {
                *error += 0.5 * ((a - b) / i).powi(2);
            }
            self.pairs += 1;
        }
        self.before = values.to_vec();
    }

    /// Mean over the pixels of (a - b)² / I², for a pair a, b of each.
    fn square(&self, pairs: impl Iterator<Item = (f32, f32)>) -> f64 {
        let error = |((a, b), i): ((f32, f32), &f32)| f64::from(((a - b) / i).powi(2));
        trimmed(pairs.zip(&self.measurements).map(error).collect())
    }

    /// Ends an iteration: V̄ of its samples, if it had two passes and they were not alike.
    pub fn end(&mut self) -> Option<f32> {
        let scale = 1.0 / f64::from(self.pairs.max(1));
        let errors = self.errors.iter().map(|&e| f64::from(e) * scale).collect();
        let variance = trimmed(errors) as f32;
        self.errors.fill(0.0);
        self.pairs = 0;
        self.before.clear();
        self.smooth();
        (variance > 0.0).then_some(variance)
    }

    /// V̄ of plain paths: as those of the first pass have it, which are compared with the mean of n others, whose
    /// own error is taken to be 1/n of theirs; or by (2), which sees what they have missed. 0 as long as
    /// there are no others.
    pub fn plain(&self) -> f32 {
        let n = self.passes.saturating_sub(1);
        if n == 0 {
            return 0.0;
        }
        let rest = |(sum, first): (&f32, &f32)| (*first, (sum - first) / n as f32);
        let square = self.square(self.sums.iter().zip(&self.first).map(rest));
        let of_first = (square * f64::from(n) / f64::from(n + 1)) as f32;
        let scale = 1.0 / self.passes as f32;
        let of_trees = |((sum, p), i): ((&f32, &f32), &f32)| {
            f64::from((p * scale - (sum * scale).powi(2)) / (i * i))
        };
        let of_trees = self.sums.iter().zip(&self.plain).zip(&self.measurements).map(of_trees);
        of_first.max(trimmed(of_trees.collect()) as f32)
    }

    /// I from the sums: means over a window, values far above their surroundings cut.
    fn smooth(&mut self) {
        let scale = 1.0 / self.passes.max(1) as f32;
        let mean = self.sums.iter().map(|&s| f64::from(s)).sum::<f64>() / self.sums.len() as f64;
        let dim = (DIM * scale * mean as f32).max(f32::MIN_POSITIVE);
        let width = (self.width as usize).max(1);
        let height = self.sums.len() / width;
        let mut out = Vec::with_capacity(self.sums.len());
        let mut window = Vec::new();
        for y in 0..height {
            for x in 0..width {
                window.clear();
                for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height) {
                    let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width);
                    let start = row * width;
                    window.extend(&self.sums[start + columns.start..start + columns.end]);
                }
                let middle = window.len() / 2;
                let median = *window.select_nth_unstable_by(middle, f32::total_cmp).1;
                let most = (4.0 * median).max(2.0 * mean as f32);
                let sum: f32 = window.iter().map(|v| v.min(most)).sum();
                let value = scale * sum / window.len() as f32;
                out.push((value * value + dim * dim).sqrt());
            }
        }
        self.measurements = out;
    }
}

/// Mean without the largest.
fn trimmed(mut errors: Vec<f64>) -> f64 {
    let kept = errors.len() - (errors.len() as f64 * OUTLIERS).ceil() as usize;
    if kept == 0 {
        return 0.0;
    }
    errors.select_nth_unstable_by(kept, f64::total_cmp);
    errors[..kept].iter().sum::<f64>() / kept as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;

    /// Samples are 1, and one in a thousand is 1001: the mean is 2, the relative variance 250. Each
    /// pass of 2000 pixels has two such, as many as would be left out of it alone.
    #[test]
    fn what_is_rare_in_every_pass_is_in_the_variance() {
        let (width, height) = (50, 40);
        let mut pixels = Pixels::new(width, height);
        let mut told = Vec::new();
        for pass in 0..255u64 {
            let value = |i: usize| {
                let number = mix_bits(pass * 4096 + i as u64) >> 40;
                if number.is_multiple_of(1000) { 1001.0 } else { 1.0 }
            };
            pixels.learn(&(0..width * height).map(value).collect::<Vec<f32>>());
            if (pass + 2).is_power_of_two() {
                told.push(pixels.end());
            }
        }
        let last = told.last().copied().flatten().expect("had many passes");
        assert!((125.0..500.0).contains(&last), "{told:?}");
    }
}
