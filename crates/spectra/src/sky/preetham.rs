//! The sun through a clear atmosphere (Preetham, Shirley and Smits, "A Practical Analytic Model
//! for Daylight", 1999, appendix A.1; tables of Iqbal, "An Introduction to Solar Radiation", 1983).
//!
//! ```text
//! L(λ) = L₀(λ) τ_r τ_a τ_o τ_g τ_w
//! m    = 1 / (cos θ + 0.15 (93.885 - θ°)^-1.253)          relative optical mass            (1)
//! τ_r  = exp(-0.008735 m λ^-4.08)                          Rayleigh, λ in µm               (2)
//! τ_a  = exp(-β m λ^-1.3),   β = 0.04608 T - 0.04586       aerosols of turbidity T         (3)
//! τ_o  = exp(-0.35 k_o m)                                  ozone, 0.35 cm                  (4)
//! τ_g  = exp(-1.41 k_g m / (1 + 118.93 k_g m)^0.45)        mixed gases                     (5)
//! τ_w  = exp(-0.2385 k_w 2 m / (1 + 20.07 k_w 2 m)^0.45)   water vapour, 2 cm              (6)
//! ```

use crate::SpectrumDesc;

/// Extraterrestrial radiance of the sun, W/(m² sr nm), from 380 nm in steps of 10 nm.
#[rustfmt::skip]
const SUN: [f64; 38] = [
    16559.0, 16233.7, 21127.5, 25888.2, 25829.1, 24232.3, 26760.5, 29658.3, 30545.4, 30057.5,
    30663.7, 28830.4, 28712.1, 27825.0, 27100.6, 27233.6, 26361.3, 25503.8, 25060.2, 25311.6,
    25355.9, 25134.2, 24631.5, 24173.2, 23685.3, 23212.1, 22827.7, 22339.8, 21970.2, 21526.7,
    21097.9, 20728.3, 20240.4, 19870.8, 19427.2, 19072.4, 18628.9, 18259.2,
];

/// Absorption by ozone, 1/cm, from 445 nm in steps of 5 nm.
#[rustfmt::skip]
const OZONE_FINE: [f64; 34] = [
    0.003, 0.003, 0.004, 0.006, 0.008, 0.009, 0.012, 0.014, 0.017, 0.021, 0.025, 0.03, 0.035,
    0.04, 0.045, 0.048, 0.057, 0.063, 0.07, 0.075, 0.08, 0.085, 0.095, 0.103, 0.11, 0.12, 0.122,
    0.12, 0.118, 0.115, 0.12, 0.125, 0.13, 0.12,
];

/// The same from 610 nm in steps of 10 nm.
#[rustfmt::skip]
const OZONE_COARSE: [f64; 19] = [
    0.12, 0.105, 0.09, 0.079, 0.067, 0.057, 0.048, 0.036, 0.028, 0.023, 0.018, 0.014, 0.011,
    0.01, 0.009, 0.007, 0.004, 0.0, 0.0,
];

/// Absorption by mixed gases about the oxygen band, nm and 1/km.
const GASES: [[f64; 2]; 4] = [[759.0, 0.0], [760.0, 3.0], [770.0, 0.21], [771.0, 0.0]];

/// Absorption by water vapour, nm and 1/cm.
#[rustfmt::skip]
const WATER: [[f64; 2]; 13] = [
    [689.0, 0.0], [690.0, 0.016], [700.0, 0.024], [710.0, 0.0125], [720.0, 1.0], [730.0, 0.87],
    [740.0, 0.061], [750.0, 0.001], [760.0, 1e-5], [770.0, 1e-5], [780.0, 6e-4], [790.0, 0.0175],
    [800.0, 0.036],
];

/// Piecewise linear through (wavelength, value), zero outside.
fn through(points: &[[f64; 2]], x: f64) -> f64 {
    let segment = points.windows(2).find(|s| (s[0][0]..=s[1][0]).contains(&x));
    segment.map_or(0.0, |s| {
        let t = (x - s[0][0]) / (s[1][0] - s[0][0]);
        s[0][1] + t * (s[1][1] - s[0][1])
    })
}

/// Piecewise linear through values from `first` nm in steps of `step` nm, zero outside.
fn sampled(values: &[f64], first: f64, step: f64, x: f64) -> f64 {
    let at = (x - first) / step;
    let i = at.floor();
    if !(0.0..values.len() as f64).contains(&at) {
        return 0.0;
    }
    let value = |i: f64| values.get(i as usize).copied().unwrap_or(0.0);
    value(i) + (at - i) * (value(i + 1.0) - value(i))
}

/// Absorption by ozone, 1/cm; nearly none between the ultraviolet and 445 nm.
fn ozone(lambda: f64) -> f64 {
    match lambda {
        ..445.0 => through(&[[355.0, 0.0], [445.0, OZONE_FINE[0]]], lambda),
        445.0..610.0 => sampled(&OZONE_FINE, 445.0, 5.0, lambda),
        _ => sampled(&OZONE_COARSE, 610.0, 10.0, lambda),
    }
}

/// Spectral radiance of the sun's disc of 0.5358° seen from the ground, W/(m² sr nm), 380 to
/// 750 nm: at a turbidity in [1, 10], `zenith` radians from straight above.
pub fn preetham_sun(turbidity: f32, zenith: f32) -> SpectrumDesc {
    let turbidity = f64::from(turbidity.clamp(1.0, 10.0));
    let theta = f64::from(zenith).to_degrees().clamp(0.0, 90.0);
    let mass = 1.0 / (theta.to_radians().cos() + 0.15 * (93.885 - theta).powf(-1.253)); // (1)
    let beta = 0.04608365822050 * turbidity - 0.04586025928522;
    let radiance = |lambda: f64| {
        let um = lambda * 1e-3;
        let (gas, water) = (through(&GASES, lambda) * mass, through(&WATER, lambda) * 2.0 * mass);
        let depth = 0.008735 * mass * um.powf(-4.08)                                // (2)
            + beta * mass * um.powf(-1.3)                                           // (3)
            + 0.35 * ozone(lambda) * mass                                           // (4)
            + 1.41 * gas / (1.0 + 118.93 * gas).powf(0.45)                          // (5)
            + 0.2385 * water / (1.0 + 20.07 * water).powf(0.45); // (6)
        sampled(&SUN, 380.0, 10.0, lambda) * (-depth).exp()
    };
    let lambda: Vec<f32> = (0..75).map(|i| 380.0 + 5.0 * i as f32).collect();
    let values: Vec<f32> = lambda.iter().map(|&l| radiance(f64::from(l)) as f32).collect();
    SpectrumDesc::Sampled { lambda: lambda.into(), values: values.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SpectrumRole, hosek_sun, luminance_of};

    #[test]
    fn transmittances_by_hand() {
        // Straight above, no aerosols: m = 1/(1 + 0.15 · 93.885^-1.253) = 0.99949.
        let sun = preetham_sun(1.0, 0.0);
        let depth: f64 = 0.99949
            * (0.008735 * 0.55f64.powf(-4.08)
                + 0.00022339893528 * 0.55f64.powf(-1.3)
                + 0.35 * 0.085);
        let wanted = 25503.8 * (-depth).exp();
        let found = f64::from(sun.value_at(550.0).expect("has values"));
        assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
    }

    #[test]
    fn tables_lie_where_they_should() {
        for (lambda, k) in [
            (445.0, 0.003),
            (500.0, 0.03),
            (605.0, 0.13),
            (610.0, 0.12),
            (700.0, 0.023),
            (790.0, 0.0),
        ] {
            assert!((ozone(lambda) - k).abs() < 1e-9, "{lambda} {}", ozone(lambda));
        }
        assert!((ozone(400.0) - 0.0015).abs() < 1e-9);
        assert_eq!(sampled(&SUN, 380.0, 10.0, 750.0), 18259.2);
        assert_eq!(sampled(&SUN, 380.0, 10.0, 379.0), 0.0);
    }

    /// Two models of one thing, thirteen years apart.
    #[test]
    fn it_is_about_as_bright_as_that_of_hosek_and_wilkie() {
        for zenith in [0.0f32, 0.5, 1.0] {
            for turbidity in [1.5, 2.0, 3.0] {
                let elevation = std::f32::consts::FRAC_PI_2 - zenith;
                let y =
                    [preetham_sun(turbidity, zenith), hosek_sun(turbidity, elevation, 0.004676)]
                        .map(|sun| luminance_of(&sun, SpectrumRole::Illuminant));
                assert!((y[0] / y[1] - 1.0).abs() < 0.25, "{zenith} {turbidity} {y:?}");
            }
        }
    }
}
