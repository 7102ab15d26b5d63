//! One-dimensional kernels, in `f64`: tables and integrals are built from them.

use std::f64::consts::PI;

use kaustika_math::special::erf;

use super::FilterDesc;

/// An even function that is zero beyond `radius`.
#[derive(Clone, Copy)]
pub(super) struct Kernel {
    radius: f64,
    shape: Shape,
}

#[derive(Clone, Copy)]
enum Shape {
    Box,
    Tent,
    /// σ and the value at the border, which is taken off.
    Gaussian {
        sigma: f64,
        border: f64,
    },
    Mitchell {
        b: f64,
        c: f64,
    },
    Lanczos {
        tau: f64,
    },
}

impl Kernel {
    /// The kernel of a filter along an axis with this radius.
    pub fn new(desc: &FilterDesc, radius: f32) -> Self {
        let radius = radius as f64;
        let shape = match *desc {
            FilterDesc::Box { .. } => Shape::Box,
            FilterDesc::Tent { .. } => Shape::Tent,
            FilterDesc::Gaussian { sigma, .. } => {
                Shape::Gaussian { sigma: sigma as f64, border: gaussian(radius, sigma as f64) }
            }
            FilterDesc::Mitchell { b, c, .. } => Shape::Mitchell { b: b as f64, c: c as f64 },
            FilterDesc::Lanczos { tau, .. } => Shape::Lanczos { tau: tau as f64 },
        };
        Kernel { radius, shape }
    }

    /// k(x).
    pub fn evaluate(&self, x: f64) -> f64 {
        let x = x.abs();
        if x > self.radius {
            return 0.0;
        }
        match self.shape {
            Shape::Box => 1.0,
            Shape::Tent => 1.0 - x / self.radius,
            Shape::Gaussian { sigma, border } => gaussian(x, sigma) - border,
            Shape::Mitchell { b, c } => mitchell(2.0 * x / self.radius, b, c),
            Shape::Lanczos { tau } => sinc(x) * sinc(x / tau),
        }
    }

    /// ∫ k(x) dx from -radius to radius.
    pub fn integral(&self) -> f64 {
        let r = self.radius;
        match self.shape {
            Shape::Box => 2.0 * r,
            Shape::Tent => r,
            Shape::Gaussian { sigma, border } => {
                sigma * (2.0 * PI).sqrt() * erf(r / (sigma * 2f64.sqrt())) - 2.0 * r * border
            }
            // The cubics sum to 1 over the integers, so that over [-2, 2] they integrate to 1.
            Shape::Mitchell { .. } => 0.5 * r,
            Shape::Lanczos { .. } => 2.0 * simpson(|x| self.evaluate(x), r),
        }
    }

    /// Nodes (x, k(x)) from 0 to the radius between which k is taken as linear: as few as are
    /// exact for box and tent, `2^10` for the others. Sign changes are nodes.
    pub fn nodes(&self) -> Vec<(f64, f64)> {
        const SEGMENTS: usize = 1024;
        let segments = match self.shape {
            Shape::Box | Shape::Tent => 1,
            _ => SEGMENTS,
        };
        let node = |i: usize| {
            let x = self.radius * i as f64 / segments as f64;
            (x, self.evaluate(x))
        };
        let mut nodes = vec![node(0)];
        for i in 1..=segments {
            let (previous, next) = (node(i - 1), node(i));
            if previous.1 * next.1 < 0.0 {
                // Where the chord crosses zero: the table then is the chord exactly.
                let t = previous.1 / (previous.1 - next.1);
                nodes.push((previous.0 + t * (next.0 - previous.0), 0.0));
            }
            nodes.push(next);
        }
        nodes
    }
}

fn gaussian(x: f64, sigma: f64) -> f64 {
    (-x * x / (2.0 * sigma * sigma)).exp()
}

fn sinc(x: f64) -> f64 {
    let t = PI * x;
    // The series to second order is exact to f64 here.
    if t.abs() < 1e-4 { 1.0 - t * t / 6.0 } else { t.sin() / t }
}

/// Mitchell and Netravali 1988, eq. 8, for x ≥ 0.
fn mitchell(x: f64, b: f64, c: f64) -> f64 {
    let sixth = if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x + (6.0 - 2.0 * b)
    } else if x < 2.0 {
        (((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c)) * x
            + (8.0 * b + 24.0 * c)
    } else {
        0.0
    };
    sixth / 6.0
}

/// Simpson's rule on [0, r]; the kernels are smooth there.
fn simpson(f: impl Fn(f64) -> f64, r: f64) -> f64 {
    const HALF_STEPS: usize = 2000;
    let h = r / HALF_STEPS as f64;
    let weight = |i: usize| match i {
        0 | HALF_STEPS => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=HALF_STEPS).map(|i| weight(i) * f(i as f64 * h)).sum();
    sum * h / 3.0
}
