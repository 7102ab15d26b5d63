//! How far a small step goes: learned while nothing is recorded, then kept.
//!
//! ```text
//! ln σ ← ln σ + (a - a*) c / (1 + n/n₀)                 (Robbins & Monro 1951)        (1)
//! ```
//!
//! A step size that went on learning from the chain it moves would bend what that converges to.

/// A step size σ on its way to an acceptance a*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSize {
    ln_size: f64,
    ln_range: (f64, f64),
    target: f64,
    steps: f64,
}

impl StepSize {
    /// c of (1).
    const RATE: f64 = 0.5;
    /// n₀ of (1).
    const CALM: f64 = 16.0;

    /// From `size` on, within a range, toward an acceptance `target`.
    pub fn new(size: f64, range: (f64, f64), target: f64) -> StepSize {
        let ln_range = (range.0.ln(), range.1.ln());
        StepSize { ln_size: size.ln(), ln_range, target, steps: 0.0 }
    }

    /// The size.
    pub fn size(&self) -> f64 {
        self.ln_size.exp()
    }

    /// (1): learns from the mean acceptance of some steps.
    pub fn learn(&mut self, acceptance: f64) {
        let rate = Self::RATE / (1.0 + self.steps / Self::CALM);
        let (low, high) = self.ln_range;
        self.ln_size = (self.ln_size + rate * (acceptance - self.target)).clamp(low, high);
        self.steps += 1.0;
    }
}
