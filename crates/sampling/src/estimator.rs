//! Means with error bars: what Monte Carlo quadrature returns.

use kaustika_math::special::erfc;

/// The running mean and variance of a sequence of estimates (Welford 1962), in `f64`.
///
/// ```
/// use kaustika_sampling::estimator::RunningMean;
///
/// let estimate: RunningMean = [1.0, 2.0, 3.0, 4.0].into_iter().collect();
/// assert_eq!(estimate.mean(), 2.5);
/// assert!((estimate.variance() - 5.0 / 3.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningMean {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    m2: f64,
}

impl RunningMean {
    /// Of no values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let delta = value - self.mean;
        self.mean += delta / self.count as f64;
        self.m2 += delta * (value - self.mean);
    }

    /// Adds the values of another (Chan, Golub & LeVeque 1979). Rounding depends on the order
    /// of merging; a fixed tree gives fixed bits.
    pub fn merge(&mut self, other: &RunningMean) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let delta = other.mean - self.mean;
        self.count += other.count;
        self.mean += delta * (m / (n + m));
        self.m2 += other.m2 + delta * delta * (n * m / (n + m));
    }

    /// The number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean, 0 if there are no values.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased estimate of the variance of one value; infinite for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::INFINITY } else { self.m2 / (self.count - 1) as f64 }
    }

    /// The standard deviation of the mean, for independent values; infinite for fewer than two.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count.max(1) as f64).sqrt()
    }

    /// Standard error over |mean|; infinite if the mean is 0 and the error is not.
    pub fn relative_error(&self) -> f64 {
        let e = self.standard_error();
        if e == 0.0 { 0.0 } else { e / self.mean.abs() }
    }

    /// Bounds that hold the true mean with probability `confidence`, by the central limit
    /// theorem: good for some tens of values with finite variance, too narrow where a few rare
    /// values carry the mean and none has been seen yet.
    pub fn confidence_interval(&self, confidence: f64) -> (f64, f64) {
        let half = normal_quantile(confidence) * self.standard_error();
        (self.mean - half, self.mean + half)
    }
}

impl Extend<f64> for RunningMean {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|v| self.push(v));
    }
}

impl FromIterator<f64> for RunningMean {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut mean = RunningMean::new();
        mean.extend(values);
        mean
    }
}

/// The z for which a standard normal variable lies in [-z, z] with probability `p`, for `p` in
/// [0, 1); by bisection, which is exact enough and never in a hot loop.
pub fn normal_quantile(p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    while high - low > 1e-9 {
        let z = 0.5 * (low + high);
        if erfc(z / std::f64::consts::SQRT_2) > 1.0 - p { low = z } else { high = z }
    }
    0.5 * (low + high)
}
