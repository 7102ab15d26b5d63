//! Checkerboards, dots, bilinear interpolation.

use super::mapping::Mapped;
use super::noise;
use kaustika_math::{Vec2, Vec3};

/// Weight of the second colour of a checkerboard with squares of side 1/2: 0 or 1, or their
/// mean over the filter box by the integral of the square wave in each direction.
pub fn checkerboard(at: &Mapped) -> f32 {
    if at.width <= 0.0 {
        let parity = (2.0 * at.st.x).floor() + (2.0 * at.st.y).floor();
        return parity.rem_euclid(2.0);
    }
    // ±1 square waves multiply; each is averaged over its interval: w = (1 - c(s) c(t)) / 2.
    0.5 * (1.0 - square_wave_mean(at.st.x, at.width) * square_wave_mean(at.st.y, at.width))
}

/// Mean over [x - w/2, x + w/2] of the wave that is +1 on [0, 1/2) and -1 on [1/2, 1).
fn square_wave_mean(x: f32, w: f32) -> f32 {
    // The integral of the wave is the triangle wave |frac - …|.
    mean(x, w, |x| {
        let f = x.rem_euclid(1.0);
        if f < 0.5 { f } else { 1.0 - f }
    })
    .clamp(-1.0, 1.0)
}

/// Mean over [x - w/2, x + w/2] of what has this integral. In double precision: of narrow intervals it is a
/// small difference of large numbers.
fn mean(x: f32, w: f32, integral: impl Fn(f64) -> f64) -> f32 {
    let (x, w) = (f64::from(x), f64::from(w));
    ((integral(x + 0.5 * w) - integral(x - 0.5 * w)) / w) as f32
}

/// Share of the filter box that lies on the lines along the integers of either coordinate, of
/// `half_width` to each side.
pub fn lines(at: &Mapped, half_width: f32) -> f32 {
    let half = half_width.clamp(0.0, 0.5);
    // ∫₀ˣ of 1 on the lines of one direction.
    let integral = |x: f64| {
        let (f, half) = (x - x.floor(), f64::from(half));
        2.0 * half * x.floor() + f.min(half) + (f - (1.0 - half)).max(0.0)
    };
    let covered = |x: f32| {
        if at.width <= 0.0 {
            return f32::from((x - x.round()).abs() < half);
        }
        mean(x, at.width, integral).clamp(0.0, 1.0)
    };
    1.0 - (1.0 - covered(at.st.x)) * (1.0 - covered(at.st.y))
}

/// Weight of the second colour of a solid checkerboard with unit cells.
pub fn checkerboard_3d(p: Vec3) -> f32 {
    (p.x.floor() + p.y.floor() + p.z.floor()).rem_euclid(2.0)
}

/// 0 inside a dot, 1 outside: about every second unit cell holds a disc of radius at most 0.35
/// (pbrt's `dots`).
pub fn outside_dots(st: Vec2) -> f32 {
    let (s, t) = ((st.x + 0.5).floor(), (st.y + 0.5).floor());
    if noise::perlin(Vec3::new(s + 0.5, t + 0.5, 0.0)) <= 0.0 {
        return 1.0;
    }
    const RADIUS: f32 = 0.35;
    let reach = 0.5 - RADIUS;
    let center = Vec2::new(
        s + reach * noise::perlin(Vec3::new(s + 1.5, t + 2.8, 0.0)),
        t + reach * noise::perlin(Vec3::new(s + 4.5, t + 9.8, 0.0)),
    );
    if (st - center).length_squared() < RADIUS * RADIUS { 0.0 } else { 1.0 }
}

/// Weights of the corners v00, v01, v10, v11 (first index along s).
pub fn bilinear_weights(st: Vec2) -> [f32; 4] {
    let (s, t) = (st.x, st.y);
    [(1.0 - s) * (1.0 - t), (1.0 - s) * t, s * (1.0 - t), s * t]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filtered_checkerboard_is_the_mean_of_the_sharp_one() {
        for (x, y, w) in [(0.3f32, 0.7f32, 0.2f32), (0.5, 0.25, 0.9), (1.9, -0.4, 3.3)] {
            let n = 400;
            let mut mean = 0.0;
            for i in 0..n * n {
                let f = |k: usize| (k as f32 + 0.5) / n as f32 - 0.5;
                let st = Vec2::new(x + w * f(i % n), y + w * f(i / n));
                mean += checkerboard(&Mapped { st, width: 0.0 }) / (n * n) as f32;
            }
            let filtered = checkerboard(&Mapped { st: Vec2::new(x, y), width: w });
            assert!((mean - filtered).abs() < 5e-3, "{mean} {filtered}");
        }
    }

    #[test]
    fn filtered_lines_are_the_mean_of_sharp_ones() {
        for (x, y, w) in [(0.3f32, 0.7f32, 0.6f32), (0.02, -1.01, 0.1), (7.9, -0.4, 3.3)] {
            let n = 400;
            let mut mean = 0.0;
            for i in 0..n * n {
                let f = |k: usize| (k as f32 + 0.5) / n as f32 - 0.5;
                let st = Vec2::new(x + w * f(i % n), y + w * f(i / n));
                mean += lines(&Mapped { st, width: 0.0 }, 0.1) / (n * n) as f32;
            }
            let filtered = lines(&Mapped { st: Vec2::new(x, y), width: w }, 0.1);
            assert!((mean - filtered).abs() < 5e-3, "{mean} {filtered}");
        }
    }

    #[test]
    fn narrow_filters_are_sharp() {
        for (x, y) in [(1.25f32, 2.75f32), (-7.3, 0.2), (30.1, 30.8)] {
            for exponent in 3..8 {
                let st = Vec2::new(x, y);
                let [sharp, narrow] =
                    [0.0, 10f32.powi(-exponent)].map(|width| Mapped { st, width });
                assert!((checkerboard(&narrow) - checkerboard(&sharp)).abs() < 1e-6);
                assert!((lines(&narrow, 0.22) - lines(&sharp, 0.22)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn wide_filters_turn_grey() {
        let at = Mapped { st: Vec2::new(0.37, 0.81), width: 64.0 };
        assert!((checkerboard(&at) - 0.5).abs() < 0.01);
    }
}
