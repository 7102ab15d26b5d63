//! Ideal filters: the matrices of Collett 2005, each divided by its m₀₀.

use super::Mueller;
use kaustika_spectra::Spectrum;

/// Passes linear polarization along x and absorbs that along y. m₀₀ is 1/2 in truth.
pub fn linear_polarizer() -> Mueller {
    diattenuating_retarder(Spectrum::ONE, Spectrum::ZERO, Spectrum::ZERO)
}

/// Retards polarization along y by the phase `delta` (radians) behind that along x, the fast axis.
/// m₀₀ is 1.
pub fn linear_retarder(delta: Spectrum) -> Mueller {
    diattenuating_retarder(Spectrum::ZERO, delta.map(f32::cos), delta.map(f32::sin))
}

/// Passes right circular polarization (or left) and absorbs the other, in any frame. m₀₀ is 1/2 in truth.
pub fn circular_polarizer(left_handed: bool) -> Mueller {
    let sign = Spectrum::splat(if left_handed { -1.0 } else { 1.0 });
    let mut m = Mueller::default();
    (m.0[0][0], m.0[3][3]) = (Spectrum::ONE, Spectrum::ONE);
    (m.0[0][3], m.0[3][0]) = (sign, sign);
    m
}

/// Weakens and retards the components along x and y without mixing them:
///
/// ```text
/// | 1 b  0 0 |
/// | b 1  0 0 |
/// | 0 0  c d |
/// | 0 0 -d c |
/// ```
///
/// b = (|a_x|² - |a_y|²)/(|a_x|² + |a_y|²) and c - i d = 2 aₓ a_y*/(|aₓ|² + |a_y|²) for amplitudes a.
#[inline]
pub(super) fn diattenuating_retarder(b: Spectrum, c: Spectrum, d: Spectrum) -> Mueller {
    let (o, i) = (Spectrum::ZERO, Spectrum::ONE);
    Mueller([[i, b, o, o], [b, i, o, o], [o, o, c, d], [o, o, -d, c]])
}

#[cfg(test)]
mod tests {
    use super::super::{Stokes, Turn};
    use super::*;
    use kaustika_math::Vec3;
    use std::f32::consts::FRAC_PI_2;

    fn at(degrees: f32, m: Mueller) -> Mueller {
        // From the filter's axis back to x.
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turn = Turn::between(Vec3::Z, Vec3::new(cos, sin, 0.0), Vec3::X);
        m.turned(turn, turn)
    }

    fn of(m: Mueller, s: [f32; 4]) -> [f32; 4] {
        (m * Stokes(s.map(Spectrum::splat))).0.map(|s| s[0])
    }

    fn near(a: [f32; 4], b: [f32; 4]) {
        (0..4).for_each(|i| assert!((a[i] - b[i]).abs() < 1e-6, "{a:?} {b:?}"));
    }

    /// Malus 1810: cos² of the angle; crossed filters are black, one between them at 45° passes
    /// a quarter of what the first lets through.
    #[test]
    fn malus() {
        let first = linear_polarizer() * Spectrum::splat(0.5);
        for degrees in [0.0f32, 20.0, 45.0, 70.0, 90.0, 130.0] {
            let cos = degrees.to_radians().cos();
            let both = (at(degrees, first) * first).m00()[0];
            assert!((both - 0.5 * cos * cos).abs() < 1e-6, "{degrees}: {both}");
        }
        let three = (at(90.0, first) * at(45.0, first) * first).m00()[0];
        assert!((three - 0.125).abs() < 1e-6, "{three}");
    }

    /// Light at +45° is made left circular by a quarter-wave plate whose fast axis is x, right
    /// circular by one turned to y, and -45° by a half-wave plate (Collett 2005).
    #[test]
    fn retarders() {
        let (quarter, half) = (Spectrum::splat(FRAC_PI_2), Spectrum::splat(2.0 * FRAC_PI_2));
        let diagonal = [1.0, 0.0, 1.0, 0.0];
        near(of(linear_retarder(quarter), diagonal), [1.0, 0.0, 0.0, -1.0]);
        near(of(at(90.0, linear_retarder(quarter)), diagonal), [1.0, 0.0, 0.0, 1.0]);
        near(of(linear_retarder(half), diagonal), [1.0, 0.0, -1.0, 0.0]);
        near(of(linear_retarder(half), [1.0, 0.0, 0.0, 1.0]), [1.0, 0.0, 0.0, -1.0]);
        let right = of(circular_polarizer(false), [1.0, 0.0, 0.0, 0.0]);
        near(right, [1.0, 0.0, 0.0, 1.0]);
        near(of(circular_polarizer(true), right), [0.0; 4]);
        // Right circular light becomes linear at 45° to the fast axis, here at 45° + 45°.
        near(of(at(45.0, linear_retarder(quarter)), right), [1.0, -1.0, 0.0, 0.0]);
    }
}
