//! The clear sky and the sun of Hosek and Wilkie ("An Analytic Model for Full Spectral Sky-Dome
//! Radiance", 2012; "Adding a Solar Radiance Function to the Hosek Skylight Model", 2013).
//!
//! ```text
//! L(θ, γ) = L_m (1 + A exp(B / (cos θ + 0.01)))
//!           (C + D exp(E γ) + F cos² γ + G χ(H, γ) + I √cos θ)                             (1)
//! χ(H, γ) = (1 + cos² γ) / (1 + H² - 2 H cos γ)^(3/2)                                      (2)
//! coefficient = Σ b₅,ₖ(x) cₖ,   x = (elevation / (π/2))^(1/3)                              (3)
//! L_sun(ε, ψ) = Σ pₖ (ε - ε₀)ᵏ · Σ lⱼ cosʲ ψ,   cos² ψ = 1 - (sin γ / sin r)²             (4)
//! ```
//!
//! θ is the angle to the zenith, γ that to the sun's centre, ε the elevation above the horizon,
//! r the sun's angular radius, b₅,ₖ the Bernstein polynomials. Coefficients are linear in
//! turbidity and ground albedo between the tabulated ones.

use super::tables::{CHANNELS, COEFFICIENTS, POINTS, SEGMENTS, SkyTable, TABLES};
use crate::cie::{LAMBDA_MAX, LAMBDA_MIN, Y_INTEGRAL};
use crate::{ColorMode, CompiledSpectrum, Spectrum, SpectrumDesc, SpectrumRole, Wavelengths};
use std::f64::consts::{FRAC_PI_2, PI};

/// The first spectral channel and the step between them, nm.
const FIRST: f32 = 320.0;
const STEP: f32 = 40.0;

/// A clear sky.
#[derive(Clone, Debug)]
pub struct HosekSky {
    /// Three of RGB, or eleven from 320 to 720 nm.
    channels: Vec<Channel>,
}

#[derive(Clone, Copy, Debug)]
struct Channel {
    coefficients: [f32; COEFFICIENTS],
    /// L_m
    radiance: f32,
}

/// Index and share of the upper of two tabulated turbidities.
fn between(turbidity: f32) -> [(usize, f64); 2] {
    let t = f64::from(turbidity.clamp(1.0, 10.0)) - 1.0;
    let low = (t as usize).min(8);
    let share = t - low as f64;
    [(low, 1.0 - share), (low + 1, share)]
}

impl HosekSky {
    /// The sky for a turbidity in [1, 10], a ground albedo in [0, 1] and the sun's elevation,
    /// radians in [0, π/2]; values beyond are clamped.
    pub fn new(turbidity: f32, albedo: &SpectrumDesc, elevation: f32, mode: ColorMode) -> HosekSky {
        let table = match mode {
            ColorMode::Rgb => &TABLES.rgb,
            ColorMode::Spectral => &TABLES.spectral,
        };
        let ground = CompiledSpectrum::new(albedo, SpectrumRole::Albedo, mode);
        let albedo_of = |channel: usize| match mode {
            ColorMode::Rgb => ground.eval(&Wavelengths::rgb()).0[channel],
            ColorMode::Spectral => {
                let lambda = (FIRST + STEP * channel as f32).clamp(LAMBDA_MIN, LAMBDA_MAX);
                let at = Wavelengths { lambda: [lambda; 4], pdf: [1.0; 4], mode };
                ground.eval(&at).0[0]
            }
        };
        let channel = |c| Channel::new(table, c, turbidity, albedo_of(c), elevation);
        HosekSky { channels: (0..table.channels).map(channel).collect() }
    }

    /// (1): radiance from a direction above the horizon (cos θ ≥ 0), the cosine of whose angle to
    /// the sun is `cos_gamma`. Zero where the model is negative, and beyond 760 nm.
    pub fn radiance(&self, cos_theta: f32, cos_gamma: f32, lambda: &Wavelengths) -> Spectrum {
        let cos_theta = cos_theta.clamp(0.0, 1.0);
        let cos_gamma = cos_gamma.clamp(-1.0, 1.0);
        let view = View {
            inverse: 1.0 / (cos_theta + 0.01),
            zenith: cos_theta.sqrt(),
            cos_gamma,
            gamma: cos_gamma.acos(),
        };
        match lambda.mode {
            ColorMode::Rgb => {
                let rgb = [0, 1, 2].map(|c| self.channels[c].radiance(&view).max(0.0));
                Spectrum::from_rgb(rgb) / Y_INTEGRAL
            }
            ColorMode::Spectral => Spectrum(lambda.lambda.map(|l| {
                let x = (l - FIRST) / STEP;
                let (low, share) = (x as usize, x - x.floor());
                let at = |i: usize| self.channels.get(i).map_or(0.0, |c| c.radiance(&view));
                (at(low) * (1.0 - share) + at(low + 1) * share).max(0.0)
            })),
        }
    }
}

/// What (1) needs of a direction, whatever the channel.
struct View {
    /// 1 / (cos θ + 0.01)
    inverse: f32,
    /// √cos θ
    zenith: f32,
    cos_gamma: f32,
    gamma: f32,
}

impl Channel {
    /// (3)
    fn new(table: &SkyTable, channel: usize, turbidity: f32, albedo: f32, elevation: f32) -> Self {
        let x = (f64::from(elevation) / FRAC_PI_2).clamp(0.0, 1.0).cbrt();
        let albedo = f64::from(albedo.clamp(0.0, 1.0));
        let (mut coefficients, mut radiance) = ([0.0; COEFFICIENTS], 0.0);
        for (t, of_turbidity) in between(turbidity) {
            for (a, of_albedo) in [(0, 1.0 - albedo), (1, albedo)] {
                for (k, binomial) in [1.0, 5.0, 10.0, 10.0, 5.0, 1.0].into_iter().enumerate() {
                    let degree = (POINTS - 1) as i32;
                    let bernstein = binomial * x.powi(k as i32) * (1.0 - x).powi(degree - k as i32);
                    let weight = of_turbidity * of_albedo * bernstein;
                    let (c, r) = table.at([t, a, k, channel]);
                    coefficients.iter_mut().zip(c).for_each(|(sum, c)| *sum += weight * c);
                    radiance += weight * r;
                }
            }
        }
        Channel { coefficients: coefficients.map(|c| c as f32), radiance: radiance as f32 }
    }

    /// (1), (2)
    fn radiance(&self, view: &View) -> f32 {
        let [a, b, c, d, e, f, g, i, h] = self.coefficients;
        let cos = view.cos_gamma;
        let root = (1.0 + h * h - 2.0 * h * cos).max(0.0).sqrt();
        let chi = (1.0 + cos * cos) / (root * root * root);
        let glow = c + d * (e * view.gamma).exp() + f * cos * cos + g * chi + i * view.zenith;
        self.radiance * (1.0 + a * (b * view.inverse).exp()) * glow
    }
}

/// Mean spectral radiance of the sun's disc of angular radius `radius`, as seen from the ground at
/// a turbidity in [1, 10], its centre at `elevation`; both in radians. (4), by the midpoint rule
/// over the disc.
pub fn hosek_sun(turbidity: f32, elevation: f32, radius: f32) -> SpectrumDesc {
    const N: usize = 24;
    let (elevation, radius) = (f64::from(elevation), f64::from(radius));
    let mut sum = [0.0f64; CHANNELS];
    for k in 0..N * N {
        let [u, v] = [k % N, k / N].map(|i| (i as f64 + 0.5) / N as f64);
        // Over the cone about the centre, by sin γ from 1 - cos γ. With u = √(1 - rest) the limb's
        // darkening, about a polynomial in it, has no steep end.
        let rest = (1.0 - u * u) * (1.0 - radius.cos());
        let sin_gamma = (rest * (2.0 - rest)).sqrt();
        let sin_e =
            (1.0 - rest) * elevation.sin() + sin_gamma * (2.0 * PI * v).cos() * elevation.cos();
        let cos_psi = (1.0 - (sin_gamma / radius.sin()).powi(2)).max(0.0).sqrt();
        let at = sin_e.clamp(0.0, 1.0).asin();
        for (c, sum) in sum.iter_mut().enumerate() {
            *sum += sun_radiance(turbidity, at, cos_psi, c) * 2.0 * u / (N * N) as f64;
        }
    }
    let lambda: Vec<f32> = (0..CHANNELS).map(|c| FIRST + STEP * c as f32).collect();
    SpectrumDesc::Sampled { lambda: lambda.into(), values: sum.map(|v| v.max(0.0) as f32).into() }
}

/// (4)
fn sun_radiance(turbidity: f32, elevation: f64, cos_psi: f64, channel: usize) -> f64 {
    let segment = ((elevation / FRAC_PI_2).cbrt() * SEGMENTS as f64) as usize;
    let segment = segment.min(SEGMENTS - 1);
    let x = elevation - FRAC_PI_2 * (segment as f64 / SEGMENTS as f64).powi(3);
    let polynomial = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let radiance: f64 = between(turbidity)
        .into_iter()
        .map(|(t, share)| share * polynomial(&TABLES.sun(t, segment, channel), x))
        .sum();
    radiance * polynomial(&TABLES.limb(channel), cos_psi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xyz_of;

    fn sky(turbidity: f32, elevation: f32, mode: ColorMode) -> HosekSky {
        HosekSky::new(turbidity, &SpectrumDesc::Constant(0.3), elevation, mode)
    }

    /// Mitsuba 3.9.1, `sunsky` with `sun_scale` 0, the sun straight along (0, 0.8, 0.6): radiance
    /// from the normalised directions; linear RGB, and at 440, 520, 600, 690 nm.
    #[test]
    fn radiances_of_another_renderer() {
        let lambda = Wavelengths {
            lambda: [440.0, 520.0, 600.0, 690.0],
            pdf: [1.0; 4],
            mode: ColorMode::Spectral,
        };
        let sun = [0.0, 0.8, 0.6f32];
        let elevation = 0.6f32.asin();
        // Its RGB mode divides by 106.750, where ∫ ȳ dλ is 106.857.
        let peer = 106.750_26 / Y_INTEGRAL;
        for (d, turbidity, rgb, spectral) in PEER {
            let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
            let d = d.map(|v| v / length);
            let cos_gamma = (0..3).map(|k| d[k] * sun[k]).sum();
            let found = sky(turbidity, elevation, ColorMode::Rgb).radiance(
                d[2],
                cos_gamma,
                &Wavelengths::rgb(),
            );
            for (found, rgb) in found.0.iter().zip(rgb) {
                assert!((found / (rgb * peer) - 1.0).abs() < 1e-4, "{d:?} {found} {rgb}");
            }
            let found =
                sky(turbidity, elevation, ColorMode::Spectral).radiance(d[2], cos_gamma, &lambda);
            for (found, wanted) in found.0.iter().zip(spectral) {
                assert!((found / wanted - 1.0).abs() < 1e-4, "{d:?} {found} {wanted}");
            }
        }
    }

    /// Direction, turbidity, RGB, and radiance at four wavelengths.
    type Row = ([f32; 3], f32, [f32; 3], [f32; 4]);

    #[rustfmt::skip]
    const PEER: [Row; 16] = [
        ([0.0, 0.0, 1.0], 1.0, [0.0141828, 0.0312768, 0.0700258], [0.0738329, 0.0407372, 0.0205717, 0.00937821]),
        ([1.0, 0.0, 0.02], 1.0, [0.123179, 0.171084, 0.187585], [0.191177, 0.188796, 0.13021, 0.0770949]),
        ([0.0, 0.85, 0.55], 1.0, [0.0514167, 0.0859646, 0.157235], [0.163754, 0.103693, 0.0589202, 0.0292498]),
        ([-0.5, -0.7, 0.4], 1.0, [0.03842, 0.0738469, 0.134922], [0.140434, 0.0915195, 0.0488479, 0.0240744]),
        ([0.0, 0.0, 1.0], 3.0, [0.0196622, 0.0359278, 0.0726145], [0.0764994, 0.044866, 0.0248047, 0.0130067]),
        ([1.0, 0.0, 0.02], 3.0, [0.124974, 0.160779, 0.172123], [0.17572, 0.176797, 0.131256, 0.0825352]),
        ([0.0, 0.85, 0.55], 3.0, [0.221644, 0.243862, 0.260825], [0.267861, 0.266711, 0.21757, 0.155174]),
        ([-0.5, -0.7, 0.4], 3.0, [0.0424897, 0.0763795, 0.13366], [0.13888, 0.0932089, 0.05299, 0.0272263]),
        ([0.0, 0.0, 1.0], 5.5, [0.0322152, 0.0480829, 0.080038], [0.0837996, 0.0578596, 0.0362192, 0.0220168]),
        ([1.0, 0.0, 0.02], 5.5, [0.132366, 0.142041, 0.147686], [0.144202, 0.152869, 0.128318, 0.093728]),
        ([0.0, 0.85, 0.55], 5.5, [0.615982, 0.592468, 0.491703], [0.507747, 0.6198, 0.562998, 0.445529]),
        ([-0.5, -0.7, 0.4], 5.5, [0.0500369, 0.0808077, 0.129652], [0.133495, 0.0962396, 0.0583442, 0.0327762]),
        ([0.0, 0.0, 1.0], 10.0, [0.0781449, 0.0859277, 0.106428], [0.110931, 0.095782, 0.0752677, 0.0575886]),
        ([1.0, 0.0, 0.02], 10.0, [0.136982, 0.125563, 0.10165], [0.103655, 0.13094, 0.122819, 0.103995]),
        ([0.0, 0.85, 0.55], 10.0, [1.60836, 1.42403, 1.09056], [1.1286, 1.46878, 1.42197, 1.22079]),
        ([-0.5, -0.7, 0.4], 10.0, [0.065637, 0.0799141, 0.105654], [0.111202, 0.0903509, 0.0674032, 0.0459901]),
    ];

    /// The spectral tables projected to RGB are the RGB tables, within what their fits leave.
    #[test]
    fn both_modes_give_one_colour() {
        for (cos_theta, cos_gamma) in [(1.0, 0.6), (0.3, 0.9), (0.5, -0.5)] {
            let rgb =
                sky(3.0, 0.6, ColorMode::Rgb).radiance(cos_theta, cos_gamma, &Wavelengths::rgb());
            let spectral = sky(3.0, 0.6, ColorMode::Spectral);
            let at = |l: f32| {
                let w = Wavelengths { lambda: [l; 4], pdf: [1.0; 4], mode: ColorMode::Spectral };
                spectral.radiance(cos_theta, cos_gamma, &w).0[0]
            };
            let lambda: Vec<f32> = (0..47).map(|i| 360.0 + 10.0 * i as f32).collect();
            let values: Vec<f32> = lambda.iter().map(|&l| at(l)).collect();
            let desc = SpectrumDesc::sampled(&lambda, &values).expect("valid");
            let [_, y, _] = xyz_of(&desc, SpectrumRole::Illuminant);
            let wanted = rgb.luminance(&Wavelengths::rgb());
            assert!((y / wanted - 1.0).abs() < 0.01, "{y} {wanted}");
        }
    }

    /// Mitsuba 3.9.1's `sunsky` with `sky_scale` 0 and turbidity 3. Its table of the mean is
    /// 0.35 % lower than (4) at every elevation, and its solid angle of the sun, 1 - cos in single
    /// precision, 0.22 % smaller than it should be: together 0.13 %.
    #[test]
    fn suns_of_another_renderer() {
        let radius = (0.5f32 * 0.5358).to_radians();
        for (elevation, wanted) in [
            (0.6f32.asin(), [11401.2f32, 16038.6, 16900.4, 15807.9]),
            (
                (0.995f32 / (0.01f32 + 0.995 * 0.995).sqrt()).asin(),
                [14298.8, 18185.8, 18263.5, 16655.2],
            ),
        ] {
            let sun = hosek_sun(3.0, elevation, radius);
            for (lambda, wanted) in [440.0, 520.0, 600.0, 680.0].into_iter().zip(wanted) {
                let found = sun.value_at(lambda).expect("has values");
                assert!((found / wanted - 1.0).abs() < 2.5e-3, "{lambda} {found} {wanted}");
            }
        }
    }

    #[test]
    fn whatever_is_asked_the_answer_is_finite() {
        for turbidity in [-1.0, 1.0, 9.99, 10.0, 30.0] {
            for elevation in [-1.0, 0.0, 0.001, 1.6, 3.0] {
                let sky = sky(turbidity, elevation, ColorMode::Rgb);
                for (theta, gamma) in [(0.0, 1.0), (1.0, 1.0), (0.0, -1.0), (-2.0, 2.0)] {
                    let l = sky.radiance(theta, gamma, &Wavelengths::rgb());
                    assert!(l.0.iter().all(|v| v.is_finite() && *v >= 0.0), "{l:?}");
                }
                let sun = hosek_sun(turbidity, elevation, 0.005);
                assert!(sun.value_at(520.0).is_some_and(|v| v.is_finite() && v >= 0.0));
            }
        }
    }
}
