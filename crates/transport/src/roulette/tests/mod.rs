//! Every rule on transport that can be solved: finite states, and a slab.

mod finite_states;
mod slab;

/// Numbers in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        (kaustika_math::mix_bits(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Mean, variance of one estimate, and standard error of the mean.
#[derive(Clone, Copy, Debug)]
struct Statistics {
    mean: f64,
    variance: f64,
    error: f64,
}

impl Statistics {
    fn of(estimates: &[f64]) -> Statistics {
        let n = estimates.len() as f64;
        let mean = estimates.iter().sum::<f64>() / n;
        let variance = estimates.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Statistics { mean, variance, error: (variance / n).sqrt() }
    }
}
