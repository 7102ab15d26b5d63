//! Directions drawn by the BSDF or by the guide, and how often by which.
//!
//! ```text
//! p = α p_bsdf + (1 - α) p_guide                                                         (1)
//! ∂/∂α KL(f L cos ‖ p) = -E[ f L cos/p · (p_bsdf - p_guide)/p ]                          (2)
//! ```
//!
//! α is learned in each cell by Adam (Kingma & Ba 2015) along (2): Müller 2019, "Practical Path
//! Guiding in Production", sec. 10.5. It stays between bounds, so that whatever the BSDF can draw
//! stays possible.

use super::{LightRecord, LocalDirections};
use crate::saved::saved;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3};
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};

/// α of a cell, and Adam's state.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice {
    /// α = σ(θ).
    theta: f32,
    mean: f32,
    square: f32,
    steps: f32,
}

saved!(Choice { theta, mean, square, steps });

/// Bounds of α.
const LEAST: f32 = 0.1;
const MOST: f32 = 0.9;
/// Adam's numbers: rate, decays, and a pull of θ toward 0.
const RATE: f32 = 0.01;
const DECAY_MEAN: f32 = 0.9;
const DECAY_SQUARE: f32 = 0.999;
const PULL: f32 = 0.01;

impl Choice {
    /// The share of directions that the BSDF draws.
    #[inline]
    pub fn alpha(&self) -> f32 {
        LEAST + (MOST - LEAST) * sigmoid(self.theta)
    }

    /// Takes a step down (2) for every record, in order.
    pub fn learn(&mut self, records: &[LightRecord]) {
        for r in records {
            let alpha = self.alpha();
            let guide = (r.pdf - alpha * r.pdf_bsdf) / (1.0 - alpha);
            // Records that were drawn before there was a guide say nothing, nor do black ones.
            if r.pdf == r.pdf_bsdf || r.product <= 0.0 {
                continue;
            }
            let slope = -(r.product / r.pdf) * (r.pdf_bsdf - guide) / r.pdf;
            let s = sigmoid(self.theta);
            let gradient = slope * (MOST - LEAST) * s * (1.0 - s);
            if gradient.is_finite() {
                self.step(gradient + PULL * self.theta);
            }
        }
    }

    fn step(&mut self, gradient: f32) {
        self.steps += 1.0;
        self.mean = DECAY_MEAN * self.mean + (1.0 - DECAY_MEAN) * gradient;
        self.square = DECAY_SQUARE * self.square + (1.0 - DECAY_SQUARE) * gradient * gradient;
        let mean = self.mean / (1.0 - DECAY_MEAN.powf(self.steps));
        let square = self.square / (1.0 - DECAY_SQUARE.powf(self.steps));
        self.theta = (self.theta - RATE * mean / (square.sqrt() + 1e-8)).clamp(-20.0, 20.0);
    }
}

fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}

/// What is known of incident radiance at a point, and how much to rely on it.
#[derive(Clone, Copy, Debug)]
pub struct Guide<L> {
    /// p_guide.
    pub directions: L,
    /// α.
    pub alpha: f32,
}

/// A direction drawn by (1).
#[derive(Clone, Copy, Debug)]
pub struct DirectionSample {
    /// The direction, its weight f |cos θ|/p, its density p (a probability for Dirac lobes).
    pub bsdf: BsdfSample,
    /// Density with which the BSDF alone draws it.
    pub pdf_bsdf: f32,
}

/// A BSDF, guided where something is known and it does not scatter by Dirac lobes alone.
#[derive(Debug)]
pub struct MixedBsdf<'b, 's, L> {
    bsdf: &'b Bsdf<'s>,
    lobes: Lobes,
    guide: Option<&'b Guide<L>>,
}

impl<'b, 's, L: LocalDirections> MixedBsdf<'b, 's, L> {
    /// Of these two.
    pub fn new(bsdf: &'b Bsdf<'s>, guide: Option<&'b Guide<L>>) -> Self {
        let guide = guide.filter(|_| bsdf.lobes().has(Lobes::SMOOTH));
        MixedBsdf { bsdf, lobes: Lobes::ALL, guide }
    }

    /// Only some of the lobes.
    #[must_use]
    pub fn of(self, lobes: Lobes) -> Self {
        let guide = self.guide.filter(|_| (self.bsdf.lobes() & lobes).has(Lobes::SMOOTH));
        MixedBsdf { lobes, guide, ..self }
    }

    /// (1), given p_bsdf.
    #[inline]
    pub fn pdf(&self, w: Vec3, pdf_bsdf: f32) -> f32 {
        match self.guide {
            None => pdf_bsdf,
            Some(g) => g.alpha * pdf_bsdf + (1.0 - g.alpha) * g.directions.pdf(w),
        }
    }

    /// Draws a direction with `uc` (choices) and `u2`, uniform in [0,1).
    pub fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode) -> Option<DirectionSample> {
        let Some(g) = self.guide else {
            let bsdf = self.bsdf.sample(wo, uc, u2, mode, self.lobes)?;
            return Some(DirectionSample { bsdf, pdf_bsdf: bsdf.pdf });
        };
        if uc < g.alpha {
            let uc = (uc / g.alpha).min(ONE_MINUS_EPSILON);
            let s = self.bsdf.sample(wo, uc, u2, mode, self.lobes)?;
            let pdf = match s.lobe.has(Lobes::DELTA) || s.lobe.has(Lobes::NULL) {
                // The guide never draws it.
                true => g.alpha * s.pdf,
                false => self.pdf(s.wi, s.pdf),
            };
            let bsdf = BsdfSample { weight: s.weight * (s.pdf / pdf), pdf, ..s };
            return Some(DirectionSample { bsdf, pdf_bsdf: s.pdf });
        }
        let (wi, pdf_guide) = g.directions.sample(u2);
        let (f, (pdf_bsdf, pdf_rev)) = self.bsdf.eval_pdf(wo, wi, mode, self.lobes);
        let pdf = g.alpha * pdf_bsdf + (1.0 - g.alpha) * pdf_guide;
        if f.is_black() || pdf <= 0.0 {
            return None;
        }
        let lobe = Lobes::SMOOTH;
        let bsdf = BsdfSample { wi, weight: f / pdf, pdf, pdf_rev, eta: 1.0, lobe };
        Some(DirectionSample { bsdf, pdf_bsdf })
    }
}

/// True where the cosine decides more than the BSDF: guides then draw by their product with it.
pub fn is_matte(bsdf: &Bsdf) -> bool {
    let lobes = bsdf.lobes();
    lobes.has(Lobes::DIFFUSE_REFLECTION) && !lobes.has(Lobes::TRANSMISSION)
}
