//! Thermal radiation.

/// Planck's constant (J s), the speed of light (m/s), Boltzmann's constant (J/K): CODATA 2018.
const H: f64 = 6.626_070_15e-34;
const C: f64 = 299_792_458.0;
const K: f64 = 1.380_649e-23;

/// Spectral radiance of a black body in W/(m² sr nm) (Planck 1900):
///
/// ```text
/// L(λ, T) = 2 h c² / (λ⁵ (exp(h c / (λ k T)) - 1))
/// ```
///
/// Zero for temperatures or wavelengths that are not positive.
pub fn blackbody(lambda_nm: f32, kelvin: f32) -> f32 {
    if !(kelvin > 0.0 && lambda_nm > 0.0) {
        return 0.0;
    }
    let l = lambda_nm as f64 * 1e-9;
    let x = H * C / (l * K * kelvin as f64);
    // 1e-9 turns "per metre of wavelength" into "per nm".
    (1e-9 * 2.0 * H * C * C / (l.powi(5) * x.exp_m1())) as f32
}

/// The wavelength in nm at which a black body of this temperature is brightest (Wien 1893).
pub fn wien_peak(kelvin: f32) -> f32 {
    2.897_771_955e6 / kelvin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stefan_boltzmann() {
        // ∫ L dλ = σ T⁴ / π, here by the trapezoid rule in log λ.
        for kelvin in [500.0f32, 2856.0, 6500.0] {
            let n = 20_000;
            let (a, b) = ((10.0f64).ln(), (1e6f64).ln());
            let h = (b - a) / n as f64;
            let sum: f64 = (0..=n)
                .map(|i| {
                    let l = (a + i as f64 * h).exp();
                    blackbody(l as f32, kelvin) as f64 * l * h
                })
                .sum();
            let want = 5.670_374_419e-8 * (kelvin as f64).powi(4) / std::f64::consts::PI;
            assert!((sum / want - 1.0).abs() < 1e-3, "{kelvin}: {sum} {want}");
        }
    }

    #[test]
    fn brightest_where_wien_says() {
        for kelvin in [1500.0, 3000.0, 10_000.0] {
            let peak = wien_peak(kelvin);
            let top = blackbody(peak, kelvin);
            assert!(top > blackbody(peak * 1.01, kelvin) && top > blackbody(peak * 0.99, kelvin));
        }
        assert_eq!(blackbody(500.0, 0.0), 0.0);
        assert_eq!(blackbody(500.0, f32::NAN), 0.0);
        assert_eq!(blackbody(400.0, 1.0), 0.0);
    }
}
