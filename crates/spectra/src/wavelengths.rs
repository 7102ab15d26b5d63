//! The colour mode, and the wavelengths that travel with a path.

use crate::cie::{LAMBDA_MAX, LAMBDA_MIN};

/// What the lanes of a [`Spectrum`](crate::Spectrum) mean during one render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorMode {
    /// Lanes are linear sRGB r, g, b and 0.
    #[default]
    Rgb,
    /// Lanes are values at four wavelengths.
    Spectral,
}

/// The four wavelengths of a path (hero wavelength sampling, Wilkie et al. 2014) in spectral
/// mode, or a token that says "RGB".
///
/// Sampling follows p(λ) ∝ 1 / cosh²(0.0072 (λ - 538 nm)) on 360..830 nm, close to the eye's
/// sensitivity (Radziszewski et al. 2009, "An Improved Technique for Full Spectral Rendering").
/// In RGB mode `lambda` and `pdf` are zero and must not be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelengths {
    /// Wavelengths in nm; lane 0 is the hero.
    pub lambda: [f32; 4],
    /// Density of each wavelength, per nm; zero for terminated lanes.
    pub pdf: [f32; 4],
    /// Whose lanes these are.
    pub mode: ColorMode,
}

/// Steepness of the density, 1/nm, and its centre, nm.
const B: f32 = 0.0072;
const CENTRE: f32 = 538.0;
/// tanh(B (λ - CENTRE)) at both ends of the range.
const TANH_MIN: f32 = -0.856_910_63;
const TANH_MAX: f32 = 0.970_591_35;

impl Wavelengths {
    /// The token of RGB mode.
    #[inline]
    pub const fn rgb() -> Wavelengths {
        Wavelengths { lambda: [0.0; 4], pdf: [0.0; 4], mode: ColorMode::Rgb }
    }

    /// Four wavelengths from one `u` in [0, 1): the inverse of the distribution function at
    /// u, u + 1/4, u + 1/2 and u + 3/4 (modulo 1), so they are stratified.
    #[inline]
    pub fn sample(u: f32) -> Wavelengths {
        let tanh: [f32; 4] = std::array::from_fn(|i| {
            let v = u + 0.25 * i as f32;
            let v = if v >= 1.0 { v - 1.0 } else { v };
            TANH_MIN + v * (TANH_MAX - TANH_MIN)
        });
        Wavelengths {
            // atanh t = ½ ln((1 + t) / (1 - t)).
            lambda: tanh.map(|t| {
                let lambda = CENTRE + (0.5 / B) * ((1.0 + t) / (1.0 - t)).ln();
                lambda.clamp(LAMBDA_MIN, LAMBDA_MAX)
            }),
            // 1 / cosh² = 1 - tanh².
            pdf: tanh.map(|t| (1.0 - t * t) * (B / (TANH_MAX - TANH_MIN))),
            mode: ColorMode::Spectral,
        }
    }

    /// `sample(u)` in spectral mode, the token in RGB mode.
    #[inline]
    pub fn sample_for(mode: ColorMode, u: f32) -> Wavelengths {
        match mode {
            ColorMode::Rgb => Wavelengths::rgb(),
            ColorMode::Spectral => Wavelengths::sample(u),
        }
    }

    /// The density that `sample` follows, per nm; zero outside 360..=830 nm.
    #[inline]
    pub fn visible_pdf(lambda: f32) -> f32 {
        if !(LAMBDA_MIN..=LAMBDA_MAX).contains(&lambda) {
            return 0.0;
        }
        let c = (B * (lambda - CENTRE)).cosh();
        B / ((TANH_MAX - TANH_MIN) * c * c)
    }

    /// Keeps the hero wavelength only, for events that send wavelengths different ways
    /// (dispersion). The hero's density is divided by 4, so that estimators that average four
    /// lanes and skip lanes of zero density stay unbiased. Does nothing the second time, and in
    /// RGB mode.
    #[inline]
    pub fn terminate_secondary(&mut self) {
        if self.mode == ColorMode::Spectral && !self.secondary_terminated() {
            self.pdf = [0.25 * self.pdf[0], 0.0, 0.0, 0.0];
        }
    }

    /// True once `terminate_secondary` has been called; never in RGB mode.
    #[inline]
    pub fn secondary_terminated(&self) -> bool {
        self.mode == ColorMode::Spectral && self.pdf[1..] == [0.0; 3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cdf(lambda: f64) -> f64 {
        let t = |l: f64| (0.0072 * (l - 538.0)).tanh();
        (t(lambda) - t(360.0)) / (t(830.0) - t(360.0))
    }

    #[test]
    fn samples_invert_the_distribution_function() {
        for i in 0..1000 {
            let u = (i as f32 + 0.5) / 1000.0;
            let w = Wavelengths::sample(u);
            for (lane, &lambda) in w.lambda.iter().enumerate() {
                let want = (u as f64 + 0.25 * lane as f64).fract();
                assert!((cdf(lambda as f64) - want).abs() < 2e-6, "{u} {lane} {lambda}");
                let pdf = Wavelengths::visible_pdf(lambda);
                assert!((w.pdf[lane] / pdf - 1.0).abs() < 1e-4, "{lambda} {pdf}");
            }
        }
    }

    #[test]
    fn density_is_the_derivative_and_integrates_to_one() {
        let mut sum = 0.0;
        for i in 0..4700 {
            let lambda = 360.0 + (i as f64 + 0.5) * 0.1;
            let p = Wavelengths::visible_pdf(lambda as f32) as f64;
            let slope = (cdf(lambda + 0.05) - cdf(lambda - 0.05)) / 0.1;
            assert!((p / slope - 1.0).abs() < 1e-4, "{lambda}: {p} {slope}");
            sum += p * 0.1;
        }
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        assert_eq!(Wavelengths::visible_pdf(359.0), 0.0);
        assert_eq!(Wavelengths::visible_pdf(831.0), 0.0);
    }

    #[test]
    fn termination_keeps_the_hero_once() {
        let fresh = Wavelengths::sample(0.3);
        let mut w = fresh;
        assert!(!w.secondary_terminated());
        w.terminate_secondary();
        w.terminate_secondary();
        assert!(w.secondary_terminated());
        assert_eq!(w.pdf, [0.25 * fresh.pdf[0], 0.0, 0.0, 0.0]);
        let mut rgb = Wavelengths::rgb();
        rgb.terminate_secondary();
        assert_eq!(rgb, Wavelengths::rgb());
        assert!(!rgb.secondary_terminated());
    }

    #[test]
    fn ends_of_the_unit_interval_stay_visible() {
        for u in [0.0, 0.25, 0.5, 0.75, 1.0f32.next_down()] {
            for l in Wavelengths::sample(u).lambda {
                assert!((LAMBDA_MIN..=LAMBDA_MAX).contains(&l), "{u} {l}");
            }
        }
    }
}
