//! CIE standard illuminants.

use std::sync::{Arc, LazyLock};

use crate::{DenseSpectrum, SpectrumDesc};

/// CIE illuminant A, relative power 100 at 560 nm (CIE 15:2004, eq. 3.1): Planck's law at 2848 K
/// with the constant c₂ = 1.435e-2 m K of 1931, chromatically 2856 K today.
pub fn illuminant_a(lambda_nm: f32) -> f32 {
    let l = lambda_nm as f64;
    let planck = |l: f64| (1.435e7 / (2848.0 * l)).exp_m1();
    (100.0 * (560.0 / l).powi(5) * planck(560.0) / planck(l)) as f32
}

/// Chromaticity (x, y) of CIE daylight of this correlated colour temperature (Judd, MacAdam and
/// Wyszecki 1964; CIE 15:2004, eqs. 3.2 to 3.4), clamped to 4000..=25000 K where it is defined.
pub fn daylight_chromaticity(kelvin: f32) -> [f32; 2] {
    let t = 1000.0 / (kelvin as f64).clamp(4000.0, 25_000.0);
    let x = if kelvin <= 7000.0 {
        0.244_063 + t * (0.099_11 + t * (2.967_8 - t * 4.607_0))
    } else {
        0.237_040 + t * (0.247_48 + t * (1.901_8 - t * 2.006_4))
    };
    [x as f32, (-3.0 * x * x + 2.87 * x - 0.275) as f32]
}

/// CIE daylight of the D series, relative power 100 at 560 nm, in 5 nm steps over 300..=830 nm
/// (CIE 15:2004, eqs. 3.5 and 3.6):
///
/// ```text
/// S(λ) = S₀(λ) + M₁ S₁(λ) + M₂ S₂(λ),   M₁, M₂ rounded to three decimals as the standard says
/// ```
///
/// `kelvin` is the nominal temperature: 6500 gives D65, whose colour temperature is 6504 K
/// because c₂ has been changed from 1.438e-2 to 1.4388e-2 m K since it was named. D65 differs
/// from its published table by less than 0.001.
pub fn daylight(kelvin: f32) -> SpectrumDesc {
    let [x, y] = daylight_chromaticity(kelvin * (1.4388 / 1.438)).map(f64::from);
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let round = |v: f64| (v * 1000.0).round() / 1000.0;
    let m1 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
    let m2 = round((0.03 - 31.4424 * x + 30.0717 * y) / m);
    let basis = &*DAYLIGHT_BASIS;
    let values = basis.iter().map(|r| (r[1] + m1 * r[2] + m2 * r[3]) as f32).collect();
    SpectrumDesc::Sampled { lambda: basis.iter().map(|r| r[0] as f32).collect(), values }
}

/// D65 normalised to Y = 1.
pub(crate) fn d65() -> &'static DenseSpectrum {
    static D65: LazyLock<DenseSpectrum> = LazyLock::new(|| daylight(6500.0).dense().normalized());
    &D65
}

/// D60 as the ACES system uses it, normalised to Y = 1.
pub(crate) fn d60() -> &'static DenseSpectrum {
    static D60: LazyLock<DenseSpectrum> = LazyLock::new(|| daylight(6000.0).dense().normalized());
    &D60
}

/// CIE fluorescent illuminant F`n`, n in 1..=12, as wavelengths and relative powers.
pub(crate) fn fluorescent(n: usize) -> (Arc<[f32]>, Arc<[f32]>) {
    let rows: Vec<[f64; 13]> = table(include_str!("../data/f_series.txt"));
    let column = |k: usize| rows.iter().map(|r| r[k] as f32).collect();
    (column(0), column(n))
}

/// nm, S₀, S₁, S₂.
static DAYLIGHT_BASIS: LazyLock<Vec<[f64; 4]>> =
    LazyLock::new(|| table(include_str!("../data/d_series.txt")));

/// Rows of `N` numbers of one of our own data files.
pub(crate) fn table<const N: usize>(text: &str) -> Vec<[f64; N]> {
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| {
            let mut numbers = l.split_ascii_whitespace().map(|t| {
                t.parse().expect("the data files hold numbers only: the tests read all of them")
            });
            std::array::from_fn(|_| numbers.next().expect("the data files have full rows"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xy(d: &DenseSpectrum) -> [f32; 2] {
        let [x, y, z] = d.xyz();
        [x / (x + y + z), y / (x + y + z)]
    }

    fn near(a: [f32; 2], b: [f32; 2], tolerance: f32) {
        assert!((a[0] - b[0]).abs() < tolerance && (a[1] - b[1]).abs() < tolerance, "{a:?} {b:?}");
    }

    #[test]
    fn chromaticities_of_the_standard() {
        // CIE 15:2004, table T.3 (2° observer).
        near(xy(&DenseSpectrum::from_fn(illuminant_a)), [0.447_58, 0.407_45], 2e-5);
        near(xy(d65()), [0.312_72, 0.329_03], 2e-5);
        for (kelvin, want) in [
            (5000.0, [0.345_67, 0.358_51]),
            (5500.0, [0.332_43, 0.347_44]),
            (7500.0, [0.299_03, 0.314_88]),
        ] {
            near(xy(&daylight(kelvin).dense()), want, 5e-5);
        }
        for (n, want) in
            [(2, [0.372_08, 0.375_29]), (7, [0.312_92, 0.329_33]), (11, [0.380_52, 0.377_13])]
        {
            let (l, v) = fluorescent(n);
            near(xy(&DenseSpectrum::from_samples(&l, &v)), want, 1e-4);
        }
        near(xy(d60()), [0.321_68, 0.337_67], 2e-4);
    }

    #[test]
    fn d65_of_the_published_table() {
        let SpectrumDesc::Sampled { lambda, values } = daylight(6500.0) else { panic!() };
        for (l, want) in [(300.0, 0.0341), (400.0, 82.7549), (560.0, 100.0), (830.0, 60.3125)] {
            let i = lambda.iter().position(|&x| x == l).expect("5 nm steps");
            assert!((values[i] - want).abs() < 1e-3, "{l} {}", values[i]);
        }
    }

    #[test]
    fn illuminant_a_of_the_published_table() {
        for (l, want) in [(400.0, 14.708), (560.0, 100.0), (830.0, 261.602)] {
            assert!((illuminant_a(l) / want - 1.0).abs() < 1e-5, "{l}");
        }
    }
}
