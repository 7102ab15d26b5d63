//! Fresnel's reflectance of a surface under a thin film.
//!
//! With η₂ the film's index, d its thickness, and light of wavelength λ:
//!
//! ```text
//! Δ    = 2 η₂ d cos θ₂                                                                   (1)
//! R_s  = T₁₂₁² R₂₃ / (1 - R₁₂ R₂₃),   T₁₂₁ = 1 - R₁₂                                      (2)
//! F    = R₁₂ + R_s + Σ_m 2 (R_s - T₁₂₁) (R₁₂ R₂₃)^{m/2} S(mΔ, mφ)                        (3)
//! S    = cos(2π Δ/λ + φ)              at a wavelength                                     (4)
//!      = ∫ (3) over a sensitivity     for RGB, by Gaussians in the frequency             (5)
//! ```
//!
//! R₁₂ and R₂₃ by Schlick's approximation from the indices, that of the base from its normal
//! reflectance, real; φ is π for each reflection at the denser medium. Two orders are kept, as in
//! KHR_materials_iridescence. Belcour & Barla 2017, "A practical extension to microfacet theory
//! for the modeling of varying iridescence"; the fit (5) from its supplement.

use super::schlick;
use kaustika_math::sqr;
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};
use std::f32::consts::PI;

/// The greatest normal reflectance that a real index stands for here.
const R0_MOST: f32 = 0.9999;

/// A film at a point.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Strength in [0,1].
    pub factor: f32,
    ior: f32,
    /// nm.
    thickness: f32,
    /// Wavelengths, nm; `None` for RGB.
    lambda: Option<[f32; 4]>,
}

impl Film {
    /// A film of this strength, index and thickness (nm).
    pub fn new(factor: f32, ior: f32, thickness: f32, lambda: &Wavelengths) -> Film {
        // A film that grows thin is not there in the end.
        let t = (thickness / 0.03).clamp(0.0, 1.0);
        let ior = 1.0 + (ior - 1.0) * sqr(t) * (3.0 - 2.0 * t);
        let lambda = (lambda.mode == ColorMode::Spectral).then_some(lambda.lambda);
        Film { factor, ior, thickness, lambda }
    }

    /// F at `cos` outside over a base of normal reflectance `r0`, mixed with its reflectance
    /// without the film, `plain`, by the film's strength.
    pub(super) fn reflectance(&self, cos: f32, r0: Spectrum, plain: Spectrum) -> Spectrum {
        plain.lerp(self.airy(cos, r0), self.factor)
    }

    /// The greatest component of [`Film::reflectance`].
    pub(super) fn reflectance_max(&self, cos: f32, r0: f32, plain: f32) -> f32 {
        let film = self.airy(cos, Spectrum::splat(r0)).max_component();
        plain + (film - plain) * self.factor
    }

    /// (3), in [0,1].
    fn airy(&self, cos: f32, r0: Spectrum) -> Spectrum {
        let cos2_sq = 1.0 - (1.0 - sqr(cos)) / sqr(self.ior);
        if cos2_sq < 0.0 {
            return Spectrum::ONE;
        }
        let cos2 = cos2_sq.sqrt();
        let r12 = schlick(sqr((self.ior - 1.0) / (self.ior + 1.0)), 1.0, cos);
        let t121 = 1.0 - r12;
        let path = 2.0 * self.ior * self.thickness * cos2; // (1)
        let phi12 = if self.ior < 1.0 { PI } else { 0.0 };
        let mut out = Spectrum::ZERO;
        // Orders' amplitudes and phases by channel; RGB's are mixed by (5) afterwards.
        let mut waves = [[(0.0, 0.0); 2]; 4];
        for i in 0..4 {
            let root = r0[i].clamp(0.0, R0_MOST).sqrt();
            let base = (1.0 + root) / (1.0 - root);
            let r23 = schlick(sqr((base - self.ior) / (base + self.ior)), 1.0, cos2);
            let phi = PI - phi12 + if base < self.ior { PI } else { 0.0 };
            let r123 = (r12 * r23).clamp(0.0, R0_MOST);
            let rs = sqr(t121) * r23 / (1.0 - r123); // (2)
            out.0[i] = r12 + rs;
            let c1 = (rs - t121) * r123.sqrt();
            waves[i] = [(2.0 * c1, phi), (2.0 * c1 * r123.sqrt(), 2.0 * phi)];
        }
        for (i, wave) in waves.iter().enumerate() {
            for (m, (amplitude, phase)) in wave.iter().enumerate() {
                let path = path * (m + 1) as f32;
                let s = match self.lambda {
                    Some(lambda) => (2.0 * PI * path / lambda[i].max(1.0) + phase).cos(), // (4)
                    None => sensitivity(path, *phase)[i],
                };
                out.0[i] += amplitude * s;
            }
        }
        out.clamp(0.0, 1.0)
    }
}

/// (5): the cosine of a path difference (nm) and a phase, seen by linear sRGB, and 0.
fn sensitivity(path: f32, phase: f32) -> [f32; 4] {
    // Height, position and variance of Gaussians over the frequency, for X (two), Y, Z.
    const GAUSSIANS: [(f32, f32, f32, usize); 4] = [
        (5.4856e-13, 1.6810e6, 4.3278e9, 0),
        (9.7470e-14, 2.2399e6, 4.5282e9, 0),
        (4.4201e-13, 1.7953e6, 9.3046e9, 1),
        (5.2481e-13, 2.2084e6, 6.6121e9, 2),
    ];
    let k = 2.0 * PI * path * 1e-9;
    let mut xyz = [0.0f32; 3];
    for (height, position, variance, channel) in GAUSSIANS {
        let wave = (position * k + phase).cos() * (-variance * k * k).exp();
        xyz[channel] += height * (2.0 * PI * variance).sqrt() * wave / 1.0685e-7;
    }
    let [x, y, z] = xyz;
    // XYZ to linear sRGB (IEC 61966-2-1).
    [
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
        0.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of the base's own index changes nothing at normal incidence; one of the outside's
    /// neither.
    #[test]
    fn films_that_are_no_films_change_nothing() {
        let r0 = Spectrum::splat(0.04);
        for lambda in [Wavelengths::rgb(), Wavelengths::sample(0.3)] {
            for ior in [1.5, 1.0] {
                let film = Film::new(1.0, ior, 400.0, &lambda);
                let f = film.airy(1.0, r0);
                assert!((f[0] - 0.04).abs() < 2e-3 && (f[1] - 0.04).abs() < 2e-3, "{ior}: {f:?}");
            }
        }
    }

    /// The quarter-wave coat: a film of index √n over n, λ/4 thick, reflects nothing, and one
    /// half a wave thick as if it were not there (Born & Wolf 1999, sec. 1.6.4).
    #[test]
    fn a_quarter_wave_extinguishes() {
        let lambda = Wavelengths::sample(0.4);
        let l = lambda.lambda[0];
        let n = 2.25f32;
        let r0 = Spectrum::splat(sqr((n - 1.0) / (n + 1.0)));
        let ior = n.sqrt();
        let quarter = Film::new(1.0, ior, l / (4.0 * ior), &lambda).airy(1.0, r0)[0];
        let half = Film::new(1.0, ior, l / (2.0 * ior), &lambda).airy(1.0, r0)[0];
        // Two of infinitely many orders: the rest is of the third power of 0.04.
        assert!(quarter < 1e-3, "{quarter}");
        assert!((half - r0[0]).abs() < 1e-3, "{half} {}", r0[0]);
    }
}
