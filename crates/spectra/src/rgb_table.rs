//! Spectra of RGB colours by table, for textures.

use std::sync::OnceLock;
use std::thread;

use crate::rgb_fit::Fitter;
use crate::sigmoid::SigmoidPolynomial;
use crate::{ColorMode, ColorSpace, Spectrum, Wavelengths};

/// Nodes along each axis of the table.
const N: usize = 32;
/// Squared Lab distance up to which a colour counts as fitted.
const FITTED: f64 = 1.0;
/// Smallest value of the largest component in the table; darker colours are extrapolated.
const DARKEST: f64 = 1e-3;

/// Coefficients of every colour of one colour space, interpolated in a table of three 32³ grids.
///
/// The layout is that of Jakob and Hanika (2019, section 4): one grid for each choice of the
/// largest component; its axes are that component and the other two relative to it. All axes are
/// finer near 0 and 1, where the coefficients change fast.
pub struct RgbToSpectrum {
    space: ColorSpace,
    /// Nodes of the largest component z, as `dark_linear(z)`.
    z: Axis,
    /// Nodes of the other two, relative to the largest.
    ratio: Axis,
    /// `[largest][z][second][first]`, where first and second are the components after the largest.
    coefficients: Vec<[f32; 3]>,
}

/// -1/√z: the coefficients of dark colours of the same hue are proportional to it, since
/// S ≈ 1 / (4 x²) for large negative x, so interpolation and extrapolation in it are exact there.
#[inline]
fn dark_linear(z: f32) -> f32 {
    -1.0 / z.max(1e-12).sqrt()
}

/// Increasing node positions.
struct Axis([f32; N]);

impl Axis {
    /// The node at or below `v` that has another above it, and the fraction of the way to that
    /// one, negative for positions below all nodes. NaN gives NaN.
    #[inline]
    fn locate(&self, v: f32) -> (usize, f32) {
        let i = self.0.partition_point(|&node| node <= v).clamp(1, N - 1) - 1;
        let t = (v - self.0[i]) / (self.0[i + 1] - self.0[i]);
        (i, t)
    }
}

impl RgbToSpectrum {
    /// The table of a colour space; the first call computes it (a fraction of a second, on two
    /// to four threads).
    pub fn get(space: ColorSpace) -> &'static RgbToSpectrum {
        static TABLES: [OnceLock<RgbToSpectrum>; 4] = [const { OnceLock::new() }; 4];
        TABLES[space as usize].get_or_init(|| RgbToSpectrum::new(space))
    }

    fn new(space: ColorSpace) -> RgbToSpectrum {
        let fitter = Fitter::new(space, 5);
        let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
        let ratio: [f64; N] = std::array::from_fn(|i| smooth(i as f64 / (N - 1) as f64));
        let mut z = ratio;
        // Black itself has no finite coefficients.
        z[0] = DARKEST;
        let mut coefficients = vec![[0.0; 3]; 3 * N * N * N];
        let threads = thread::available_parallelism().map_or(1, |n| n.get()).min(4);
        // One job fills the rows of one largest component and one second one.
        let jobs: Vec<Vec<[f32; 3]>> = thread::scope(|scope| {
            let workers: Vec<_> = (0..threads)
                .map(|worker| {
                    let (fitter, z, ratio) = (&fitter, &z, &ratio);
                    scope.spawn(move || {
                        (worker..3 * N)
                            .step_by(threads)
                            .map(|job| row(fitter, z, ratio, job))
                            .collect()
                    })
                })
                .collect();
            let mut by_worker: Vec<std::vec::IntoIter<_>> = workers
                .into_iter()
                .map(|w| {
                    let rows: Vec<_> = w.join().expect("fitting colours does not panic");
                    rows.into_iter()
                })
                .collect();
            (0..3 * N)
                .map(|job| by_worker[job % threads].next().expect("each worker did its jobs"))
                .collect()
        });
        for (job, values) in jobs.iter().enumerate() {
            let (largest, second) = (job / N, job % N);
            for first in 0..N {
                for k in 0..N {
                    coefficients[index(largest, k, second, first)] = values[first * N + k];
                }
            }
        }
        let axis = |nodes: [f64; N]| Axis(nodes.map(|v| v as f32));
        let z = Axis(z.map(|v| dark_linear(v as f32)));
        RgbToSpectrum { space, z, ratio: axis(ratio), coefficients }
    }

    /// The smooth reflectance of this colour under the space's illuminant; components are clamped
    /// to [0, 1], greys are exact.
    #[inline]
    pub fn coefficients(&self, rgb: [f32; 3]) -> SigmoidPolynomial {
        let rgb = rgb.map(|v| v.clamp(0.0, 1.0));
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return SigmoidPolynomial::constant(rgb[0]);
        }
        let largest = if rgb[0] > rgb[1] {
            if rgb[0] > rgb[2] { 0 } else { 2 }
        } else if rgb[1] > rgb[2] {
            1
        } else {
            2
        };
        let z = rgb[largest];
        let (zi, tz) = self.z.locate(dark_linear(z));
        let (xi, tx) = self.ratio.locate(rgb[(largest + 1) % 3] / z);
        let (yi, ty) = self.ratio.locate(rgb[(largest + 2) % 3] / z);
        let mut c = [0.0; 3];
        for (k, wz) in [(zi, 1.0 - tz), (zi + 1, tz)] {
            for (j, wy) in [(yi, 1.0 - ty), (yi + 1, ty)] {
                for (i, wx) in [(xi, 1.0 - tx), (xi + 1, tx)] {
                    let node = &self.coefficients[index(largest, k, j, i)];
                    let w = wx * wy * wz;
                    for n in 0..3 {
                        c[n] += w * node[n];
                    }
                }
            }
        }
        SigmoidPolynomial { c }
    }

    /// Reflectance of this colour (clamped to [0, 1]); in RGB mode the colour in linear sRGB,
    /// clamped to [0, 1].
    #[inline]
    pub fn albedo(&self, rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
        match w.mode {
            ColorMode::Rgb => Spectrum::from_rgb(self.space.to_srgb(rgb)).clamp(0.0, 1.0),
            ColorMode::Spectral => self.coefficients(rgb).eval(w),
        }
    }

    /// A non-negative quantity of this colour that may exceed 1: the reflectance of the colour
    /// scaled to a largest component of 1/2, scaled back (pbrt-v4's RGBUnboundedSpectrum); in
    /// RGB mode the colour in linear sRGB, negative components taken as 0.
    #[inline]
    pub fn unbounded(&self, rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
        match w.mode {
            ColorMode::Rgb => Spectrum::from_rgb(self.space.to_srgb(rgb)).clamp_zero(),
            ColorMode::Spectral => {
                let m = 2.0 * rgb[0].max(rgb[1]).max(rgb[2]);
                if m > 0.0 {
                    self.coefficients(rgb.map(|v| v / m)).eval(w) * m
                } else {
                    Spectrum::ZERO
                }
            }
        }
    }

    /// Light of this colour: `unbounded` times the space's illuminant in spectral mode, so that
    /// (1, 1, 1) is the white with Y = 1; `unbounded` in RGB mode.
    #[inline]
    pub fn illuminant(&self, rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
        let s = self.unbounded(rgb, w);
        match w.mode {
            ColorMode::Rgb => s,
            ColorMode::Spectral => s * self.space.illuminant().eval(w),
        }
    }
}

/// The fits of one largest component `job / N` and one second component `job % N`, as
/// `[first][z]`.
fn row(fitter: &Fitter, z: &[f64; N], ratio: &[f64; N], job: usize) -> Vec<[f32; 3]> {
    let (largest, second) = (job / N, job % N);
    let mut out = vec![[0.0; 3]; N * N];
    // Fits one colour, starting from a neighbour's coefficients if that one could be fitted (and
    // is no dead end of a colour that does not exist), else from grey. Returns them if they can
    // serve the next neighbour.
    let mut fit = |first: usize, k: usize, neighbour: Option<[f64; 3]>| {
        let mut rgb = [0.0; 3];
        rgb[largest] = z[k];
        rgb[(largest + 1) % 3] = z[k] * ratio[first];
        rgb[(largest + 2) % 3] = z[k] * ratio[second];
        let grey = || SigmoidPolynomial::constant(0.5 * z[k] as f32).c.map(f64::from);
        let (c, distance) = fitter.fit_from(rgb, neighbour.unwrap_or_else(grey), 20);
        out[first * N + k] = c.map(|v| v as f32);
        (distance < FITTED).then_some(c)
    };
    let centre = N / 2;
    let mut middle = None;
    // From the middle outwards.
    for first in 0..N {
        middle = fit(first, centre, middle);
        (centre + 1..N).fold(middle, |c, k| fit(first, k, c));
        (0..centre).rev().fold(middle, |c, k| fit(first, k, c));
    }
    out
}

#[inline]
fn index(largest: usize, z: usize, second: usize, first: usize) -> usize {
    ((largest * N + z) * N + second) * N + first
}

/// Reflectance of a linear sRGB colour, by table; see [`RgbToSpectrum::albedo`].
#[inline]
pub fn eval_rgb_albedo(rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
    match w.mode {
        ColorMode::Rgb => Spectrum::from_rgb(rgb).clamp(0.0, 1.0),
        ColorMode::Spectral => RgbToSpectrum::get(ColorSpace::Srgb).albedo(rgb, w),
    }
}

/// Unbounded quantity of a linear sRGB colour, by table; see [`RgbToSpectrum::unbounded`].
#[inline]
pub fn eval_rgb_unbounded(rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
    match w.mode {
        ColorMode::Rgb => Spectrum::from_rgb(rgb).clamp_zero(),
        ColorMode::Spectral => RgbToSpectrum::get(ColorSpace::Srgb).unbounded(rgb, w),
    }
}

/// Light of a linear sRGB colour, by table; see [`RgbToSpectrum::illuminant`].
#[inline]
pub fn eval_rgb_illuminant(rgb: [f32; 3], w: &Wavelengths) -> Spectrum {
    match w.mode {
        ColorMode::Rgb => Spectrum::from_rgb(rgb).clamp_zero(),
        ColorMode::Spectral => RgbToSpectrum::get(ColorSpace::Srgb).illuminant(rgb, w),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DenseSpectrum;
    use crate::testing::Pcg;

    #[test]
    fn srgb_round_trips_through_the_table() {
        let table = RgbToSpectrum::get(ColorSpace::Srgb);
        let light = ColorSpace::Srgb.illuminant();
        let mut rng = Pcg(11);
        let n = 20_000;
        // Absolute errors, and those relative to the largest component.
        let (mut absolute, mut relative): (Vec<f32>, Vec<f32>) = (0..n)
            .map(|i| {
                // Half of them dark and saturated.
                let rgb = if i % 2 == 0 { rng.rgb() } else { rng.rgb().map(|v| v * v * v) };
                let s = table.coefficients(rgb);
                let seen = DenseSpectrum::from_fn(|l| s.at(l) * light.at(l)).xyz();
                let back = ColorSpace::Srgb.from_xyz().apply(seen);
                let e = (0..3).map(|k| (back[k] - rgb[k]).abs()).fold(0.0, f32::max);
                (e, e / rgb[0].max(rgb[1]).max(rgb[2]))
            })
            .unzip();
        absolute.sort_by(f32::total_cmp);
        relative.sort_by(f32::total_cmp);
        let mean = absolute.iter().sum::<f32>() / n as f32;
        let (worst, usual) = (absolute[n - 1], relative[n * 99 / 100]);
        assert!(mean < 0.001 && worst < 0.004 && usual < 0.01, "{mean} {worst} {usual}");
    }

    #[test]
    fn wide_gamuts_through_the_table() {
        for space in ColorSpace::ALL {
            let table = RgbToSpectrum::get(space);
            let light = space.illuminant();
            let mut rng = Pcg(13);
            for _ in 0..300 {
                // Towards grey all spaces' colours exist.
                let rgb = rng.rgb().map(|v| 0.35 + 0.3 * v);
                let s = table.coefficients(rgb);
                let seen = DenseSpectrum::from_fn(|l| s.at(l) * light.at(l)).xyz();
                let back = space.from_xyz().apply(seen);
                let e = (0..3).map(|k| (back[k] - rgb[k]).abs()).fold(0.0, f32::max);
                assert!(e < 0.01, "{space:?} {rgb:?} {e}");
            }
        }
    }

    #[test]
    fn greys_are_flat_and_extremes_are_finite() {
        let table = RgbToSpectrum::get(ColorSpace::Srgb);
        let w = Wavelengths::sample(0.4);
        assert_eq!(table.albedo([0.0; 3], &w), Spectrum::ZERO);
        assert_eq!(table.albedo([1.0; 3], &w), Spectrum::ONE);
        for rgb in [[1.0, 0.0, 0.0], [1e-7, 0.0, 0.0], [0.0, 1e-30, 0.0], [9.0, -3.0, 1e9]] {
            assert!(table.albedo(rgb, &w).is_finite(), "{rgb:?}");
            assert!(table.illuminant(rgb, &w).is_finite(), "{rgb:?}");
        }
        let white = table.illuminant([2.0; 3], &w);
        let d65 = ColorSpace::Srgb.illuminant().eval(&w);
        assert!((white - d65 * 2.0).map(f32::abs).max_component() < 1e-5);
    }

    #[test]
    fn rgb_mode_passes_colours_on() {
        let w = Wavelengths::rgb();
        assert_eq!(eval_rgb_albedo([0.2, 0.5, 1.5], &w), Spectrum([0.2, 0.5, 1.0, 0.0]));
        assert_eq!(eval_rgb_unbounded([0.2, -0.5, 1.5], &w), Spectrum([0.2, 0.0, 1.5, 0.0]));
        assert_eq!(eval_rgb_illuminant([4.0, 0.5, 1.5], &w), Spectrum([4.0, 0.5, 1.5, 0.0]));
    }
}
