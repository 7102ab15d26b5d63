//! From light at the film to tristimulus values.

use crate::{ColorMode, ColorSpace, Matrix3, Spectrum, Wavelengths};

/// An ideal colourimetric sensor: the CIE 1931 observer, an exposure and a white balance.
///
/// Converts a spectrum to linear RGB of an output colour space. Other sensors a scene file may
/// name (pbrt's measured cameras) are approximated by this one with a white balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    output: ColorSpace,
    rgb_from_xyz: Matrix3,
    /// `None`: the lanes of RGB mode are the output as they are.
    rgb_from_srgb: Option<Matrix3>,
    xyz_from_xyz: Option<Matrix3>,
    imaging_ratio: f32,
}

impl Default for Sensor {
    /// Linear sRGB, unit exposure, no white balance.
    fn default() -> Sensor {
        Sensor::new(ColorSpace::Srgb, 1.0, None)
    }
}

impl Sensor {
    /// A sensor for `output`. `imaging_ratio` scales everything; pbrt's is exposure time · ISO /
    /// 100. `white` is the chromaticity (x, y) that shall come out white (such as
    /// [`daylight_chromaticity`](crate::daylight_chromaticity) of pbrt's `whitebalance`).
    pub fn new(output: ColorSpace, imaging_ratio: f32, white: Option<[f32; 2]>) -> Sensor {
        let adaptation = white.map(|w| bradford_adaptation(w, output.white()));
        let rgb_from_xyz = *output.from_xyz() * adaptation.unwrap_or(Matrix3::IDENTITY);
        let pass = output == ColorSpace::Srgb && adaptation.is_none();
        Sensor {
            output,
            rgb_from_xyz,
            rgb_from_srgb: (!pass).then(|| rgb_from_xyz * *ColorSpace::Srgb.to_xyz()),
            xyz_from_xyz: adaptation,
            imaging_ratio,
        }
    }

    /// The colour space of `rgb`.
    pub fn output(&self) -> ColorSpace {
        self.output
    }

    /// Linear RGB of the output space, exposed and white-balanced; unclamped, and in spectral mode
    /// an estimate that is often negative. RGB mode passes linear sRGB through.
    #[inline]
    pub fn rgb(&self, radiance: Spectrum, w: &Wavelengths) -> [f32; 3] {
        let rgb = match w.mode {
            ColorMode::Rgb => match &self.rgb_from_srgb {
                None => radiance.rgb(),
                Some(m) => m.apply(radiance.rgb()),
            },
            ColorMode::Spectral => self.rgb_from_xyz.apply(radiance.xyz(w)),
        };
        rgb.map(|v| v * self.imaging_ratio)
    }

    /// XYZ, exposed and white-balanced.
    #[inline]
    pub fn xyz(&self, radiance: Spectrum, w: &Wavelengths) -> [f32; 3] {
        let xyz = radiance.xyz(w);
        let xyz = self.xyz_from_xyz.as_ref().map_or(xyz, |m| m.apply(xyz));
        xyz.map(|v| v * self.imaging_ratio)
    }
}

/// The matrix that adapts XYZ colours seen under the white `from` (x, y) to those under the white
/// `to`: von Kries scaling in the Bradford cone space (Lam 1985; Lindbloom's coefficients).
pub fn bradford_adaptation(from: [f32; 2], to: [f32; 2]) -> Matrix3 {
    const CONES: Matrix3 =
        Matrix3([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]);
    let cones = |[x, y]: [f32; 2]| CONES.apply([x / y, 1.0, (1.0 - x - y) / y]);
    let (a, b) = (cones(from), cones(to));
    let scale = Matrix3::diagonal(std::array::from_fn(|k| b[k] / a[k]));
    let back = CONES.inverse().expect("the Bradford matrix is regular");
    back * scale * CONES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        CompiledSpectrum, SpectrumDesc, SpectrumRole, daylight, daylight_chromaticity, luminance_of,
    };

    /// The sensor's mean over stratified wavelengths.
    fn seen(sensor: &Sensor, s: &CompiledSpectrum) -> [f32; 3] {
        let n = 1 << 14;
        let mut sum = [0.0f64; 3];
        for i in 0..n {
            let w = Wavelengths::sample((i as f32 + 0.5) / n as f32);
            let rgb = sensor.rgb(s.eval(&w), &w);
            for k in 0..3 {
                sum[k] += rgb[k] as f64 / n as f64;
            }
        }
        sum.map(|v| v as f32)
    }

    fn close(a: [f32; 3], b: [f32; 3], tolerance: f32) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn rgb_light_comes_back() {
        for space in ColorSpace::ALL {
            let sensor = Sensor::new(space, 1.0, None);
            for rgb in [[1.0; 3], [4.0, 3.0, 2.0], [0.5, 0.7, 0.6]] {
                let desc = SpectrumDesc::Rgb { rgb, space };
                let light =
                    CompiledSpectrum::new(&desc, SpectrumRole::Illuminant, ColorMode::Spectral);
                close(seen(&sensor, &light), rgb, 4e-3);
            }
        }
    }

    #[test]
    fn rgb_mode_passes_through_and_exposes() {
        let w = Wavelengths::rgb();
        let s = Spectrum::from_rgb([0.1, 0.2, 0.3]);
        assert_eq!(Sensor::default().rgb(s, &w), [0.1, 0.2, 0.3]);
        close(Sensor::new(ColorSpace::Srgb, 2.0, None).rgb(s, &w), [0.2, 0.4, 0.6], 1e-6);
        close(Sensor::default().xyz(Spectrum::from_rgb([1.0; 3]), &w), [0.9504, 1.0, 1.0888], 5e-4);
        let wide = Sensor::new(ColorSpace::Rec2020, 1.0, None);
        close(wide.rgb(Spectrum::from_rgb([1.0; 3]), &w), [1.0; 3], 1e-5);
    }

    #[test]
    fn white_balance_makes_the_light_white() {
        let desc = daylight(5000.0);
        let scale = 1.0 / luminance_of(&desc, SpectrumRole::Illuminant);
        let white = daylight_chromaticity(5000.0 * (1.4388 / 1.438));
        let sensor = Sensor::new(ColorSpace::Srgb, 1.0, Some(white));
        for mode in [ColorMode::Rgb, ColorMode::Spectral] {
            let light = CompiledSpectrum::new(&desc, SpectrumRole::Illuminant, mode).scaled(scale);
            let rgb = match mode {
                ColorMode::Rgb => {
                    let w = Wavelengths::rgb();
                    sensor.rgb(light.eval(&w), &w)
                }
                ColorMode::Spectral => seen(&sensor, &light),
            };
            close(rgb, [1.0; 3], 2e-3);
        }
    }

    #[test]
    fn adaptation_of_the_white_and_of_printed_values() {
        let (a, d65) = ([0.447_57, 0.407_45], [0.312_71, 0.329_02]);
        let m = bradford_adaptation(a, d65);
        let xyz = |[x, y]: [f32; 2]| [x / y, 1.0, (1.0 - x - y) / y];
        close(m.apply(xyz(a)), xyz(d65), 1e-5);
        // Lindbloom's table, A to D65.
        close(m.0[0], [0.8446965, -0.1179225, 0.3948108], 1e-3);
        close(m.0[1], [-0.1366303, 1.1041226, 0.1291718], 1e-3);
        close(m.0[2], [0.0798489, -0.1348999, 3.1924009], 2e-3);
    }
}
