//! Densities whose cumulative function has an inverse in closed form.

use kaustika_math::{ONE_MINUS_EPSILON, Vec2, lerp};

/// A point of [0, 1) with density proportional to (1-x)a + xb, for a, b ≥ 0; uniform if both
/// are zero. The root of the quadratic is taken in the form that does not cancel.
#[inline]
pub fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    // u = x(2a + x(b-a))/(a+b)  =>  x = u(a+b)/(a + √((1-u)a² + ub²)); a common scale of a and b
    // drops out, which keeps the squares in range.
    let scale = a.max(b);
    if scale == 0.0 {
        return u;
    }
    let (a, b) = (a / scale, b / scale);
    if u == 0.0 && a == 0.0 {
        return 0.0;
    }
    let x = u * (a + b) / (a + lerp(u, a * a, b * b).sqrt());
    x.min(ONE_MINUS_EPSILON)
}

/// The density of [`sample_linear`]: 2((1-x)a + xb)/(a+b), 0 outside [0, 1].
#[inline]
pub fn linear_pdf(x: f32, a: f32, b: f32) -> f32 {
    if !(0.0..=1.0).contains(&x) {
        return 0.0;
    }
    if a + b == 0.0 { 1.0 } else { 2.0 * lerp(x, a, b) / (a + b) }
}

/// The number that gives `x` in [`sample_linear`]: x(a(2-x) + bx)/(a+b).
#[inline]
pub fn linear_inverse(x: f32, a: f32, b: f32) -> f32 {
    if a + b == 0.0 { x } else { x * (a * (2.0 - x) + b * x) / (a + b) }
}

/// A point of [0, 1)² with density proportional to the bilinear interpolation of the corner
/// values `[f(0,0), f(1,0), f(0,1), f(1,1)]`, all ≥ 0.
#[inline]
pub fn sample_bilinear(u: Vec2, corners: [f32; 4]) -> Vec2 {
    let [f00, f10, f01, f11] = corners;
    let y = sample_linear(u.y, f00 + f10, f01 + f11);
    Vec2::new(sample_linear(u.x, lerp(y, f00, f01), lerp(y, f10, f11)), y)
}

/// The density of [`sample_bilinear`], 0 outside [0, 1]².
#[inline]
pub fn bilinear_pdf(p: Vec2, corners: [f32; 4]) -> f32 {
    let [f00, f10, f01, f11] = corners;
    if !(0.0..=1.0).contains(&p.x) || !(0.0..=1.0).contains(&p.y) {
        return 0.0;
    }
    let sum = f00 + f10 + f01 + f11;
    if sum == 0.0 {
        return 1.0;
    }
    4.0 * lerp(p.y, lerp(p.x, f00, f10), lerp(p.x, f01, f11)) / sum
}

/// The numbers that give `p` in [`sample_bilinear`].
#[inline]
pub fn bilinear_inverse(p: Vec2, corners: [f32; 4]) -> Vec2 {
    let [f00, f10, f01, f11] = corners;
    Vec2::new(
        linear_inverse(p.x, lerp(p.y, f00, f01), lerp(p.y, f10, f11)),
        linear_inverse(p.y, f00 + f10, f01 + f11),
    )
}

/// A distance in [0, ∞) with density a·e^(-ax), for a > 0 (free flight in a medium of
/// extinction a).
#[inline]
pub fn sample_exponential(u: f32, a: f32) -> f32 {
    -(-u).ln_1p() / a
}

/// The density of [`sample_exponential`], 0 for negative `x`.
#[inline]
pub fn exponential_pdf(x: f32, a: f32) -> f32 {
    if x < 0.0 { 0.0 } else { a * (-a * x).exp() }
}

/// The number that gives `x` in [`sample_exponential`].
#[inline]
pub fn exponential_inverse(x: f32, a: f32) -> f32 {
    -(-a * x).exp_m1()
}
