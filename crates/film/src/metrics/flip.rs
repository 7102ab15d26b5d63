//! LDR-FLIP: the difference a viewer sees who flips between two images on a screen.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference
//! Evaluator for Alternating Images", HPG (DOI 10.1145/3406183). Section numbers are theirs;
//! constants not in the paper's text follow its published supplement and reference code.
//!
//! ```text
//! ΔE   = ΔE_c ^ (1 - ΔE_f)                                        (sec. 4.3)
//! ΔE_c = redistribute( HyAB(L*a*b*, Hunt-adjusted, of CSF-filtered images) ^ 0.7 )   (4.1)
//! ΔE_f = ( max(| |edge_r| - |edge_t| |, | |point_r| - |point_t| |) / √2 ) ^ 0.5      (4.2)
//! ```

use std::f64::consts::PI;

use rayon::prelude::*;

use super::{MetricsError, check_sizes, is_finite};
use crate::RgbView;

/// The authors' default viewer: 0.7 m before a screen 0.7 m and 3840 pixels wide.
pub const FLIP_PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// The FLIP error of each pixel in [0, 1], row after row.
///
/// Both images are linear; they are exposed by 2^`exposure` and clamped to [0, 1], as an sRGB
/// screen would show them. Pixels that are not finite in the reference are black in both, those
/// not finite in the test are black there.
pub fn flip_map(
    reference: &RgbView,
    test: &RgbView,
    exposure: f32,
    pixels_per_degree: f32,
) -> Result<Vec<f32>, MetricsError> {
    check_sizes(reference, test)?;
    let scale = exposure.exp2();
    let shown = |pixel: [f32; 3], valid: bool| {
        let valid = valid && is_finite(&pixel);
        if valid { pixel.map(|v| (v * scale).clamp(0.0, 1.0)) } else { [0.0; 3] }
    };
    let (width, height) = (reference.width, reference.height);
    let opponent = |pixels: Vec<[f32; 3]>| {
        let ycxcz: Vec<[f32; 3]> = pixels.into_par_iter().map(ycxcz_from_rgb).collect();
        Opponent {
            width,
            height,
            planes: std::array::from_fn(|c| ycxcz.iter().map(|p| p[c]).collect()),
        }
    };
    let r = opponent(reference.pixels().map(|r| shown(r, true)).collect());
    let pairs = reference.pixels().zip(test.pixels());
    let t = opponent(pairs.map(|(r, t)| shown(t, is_finite(&r))).collect());

    let ppd = pixels_per_degree as f64;
    let color = color_difference(&r, &t, ppd);
    let feature = feature_difference(&r, &t, ppd);
    let combine = |(c, f): (&f32, &f32)| c.powf(1.0 - f);
    Ok(color.par_iter().zip(&feature).map(combine).collect())
}

/// An image in the opponent space YCxCz.
struct Opponent {
    width: usize,
    height: usize,
    planes: [Vec<f32>; 3],
}

// --- Colour spaces -----------------------------------------------------------------------------

/// Linear sRGB to CIE XYZ, white D65.
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse of [`XYZ_FROM_RGB`].
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

fn apply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ relative to the white point, which is RGB (1, 1, 1).
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let white = XYZ_FROM_RGB.map(|row| row.iter().sum::<f64>());
    let xyz = apply(&XYZ_FROM_RGB, rgb);
    std::array::from_fn(|i| xyz[i] / white[i])
}

/// The linearised CIELAB of Flohr et al. 1993, in which contrast sensitivity is measured.
fn ycxcz_from_rgb(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb.map(f64::from));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| v as f32)
}

fn rgb_from_ycxcz([y, cx, cz]: [f32; 3]) -> [f64; 3] {
    let white = XYZ_FROM_RGB.map(|row| row.iter().sum::<f64>());
    let y = (y as f64 + 16.0) / 116.0;
    let xyz = [y + cx as f64 / 500.0, y, y - cz as f64 / 200.0];
    apply(&RGB_FROM_XYZ, std::array::from_fn(|i| xyz[i] * white[i]))
}

/// CIELAB with the Hunt effect (sec. 4.1.2): colourfulness grows with lightness.
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// The distance HyAB (Abasi et al. 2020): city block in lightness, Euclidean in chroma.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

// --- Colour difference (sec. 4.1) --------------------------------------------------------------

/// Exponent of the colour distance, q_c.
const COLOR_EXPONENT: f64 = 0.7;

fn color_difference(reference: &Opponent, test: &Opponent, ppd: f64) -> Vec<f32> {
    /// Distances up to this share of the largest (p_c) take up [0, p_t] of the result.
    const KNEE: f64 = 0.4;
    const KNEE_VALUE: f64 = 0.95;
    // The largest distance in the sRGB gamut: green against blue.
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(COLOR_EXPONENT);
    let knee = KNEE * largest;
    let redistribute = |d: f64| {
        if d < knee {
            d * KNEE_VALUE / knee
        } else {
            KNEE_VALUE + (d - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
        }
    };
    let filters = CsfFilters::new(ppd);
    let (r, t) = (filters.apply(reference), filters.apply(test));
    let seen = |planes: &[Vec<f32>; 3], i: usize| {
        let rgb = rgb_from_ycxcz(std::array::from_fn(|c| planes[c][i]));
        hunt_lab(rgb.map(|v| v.clamp(0.0, 1.0)))
    };
    let difference = |i| redistribute(hyab(seen(&r, i), seen(&t, i)).powf(COLOR_EXPONENT)) as f32;
    (0..r[0].len()).into_par_iter().map(difference).collect()
}

/// Contrast sensitivity as sums of Gaussians a √(π/b) exp(-π² d² / b), d in degrees (table 1).
struct CsfFilters {
    /// One separable kernel for Y and Cx each, two that are added for Cz.
    luminance: Vec<f32>,
    red_green: Vec<f32>,
    blue_yellow: [Vec<f32>; 2],
}

impl CsfFilters {
    fn new(ppd: f64) -> Self {
        /// The widest of the Gaussians decides the radius of all, at three deviations.
        const WIDEST: f64 = 0.04;
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
        // Half of the amplitude's exponent goes to each direction.
        let gaussian = |a: f64, b: f64| -> Vec<f64> {
            let amplitude = (a * (PI / b).sqrt()).sqrt();
            let at = |i: i32| amplitude * (-PI * PI * (i as f64 / ppd).powi(2) / b).exp();
            (-radius..=radius).map(at).collect()
        };
        // All kernels of a channel share one norm: their sums in two dimensions add up to 1.
        let normalized = |kernels: Vec<Vec<f64>>| -> Vec<Vec<f32>> {
            let volume: f64 = kernels.iter().map(|k| k.iter().sum::<f64>().powi(2)).sum();
            let scale = |k: Vec<f64>| k.iter().map(|v| (v / volume.sqrt()) as f32).collect();
            kernels.into_iter().map(scale).collect()
        };
        let single = |a, b| normalized(vec![gaussian(a, b)]).swap_remove(0);
        let mut pair = normalized(vec![gaussian(34.1, 0.04), gaussian(13.5, 0.025)]);
        let second = pair.pop().unwrap_or_default();
        let first = pair.pop().unwrap_or_default();
        CsfFilters {
            luminance: single(1.0, 0.0047),
            red_green: single(1.0, 0.0053),
            blue_yellow: [first, second],
        }
    }

    fn apply(&self, image: &Opponent) -> [Vec<f32>; 3] {
        let (w, h) = (image.width, image.height);
        let [y, cx, cz] = &image.planes;
        let filter = |plane: &[f32], k: &[f32]| convolve(plane, w, h, k, k);
        let mut blue_yellow = filter(cz, &self.blue_yellow[0]);
        let second = filter(cz, &self.blue_yellow[1]);
        blue_yellow.iter_mut().zip(second).for_each(|(a, b)| *a += b);
        [filter(y, &self.luminance), filter(cx, &self.red_green), blue_yellow]
    }
}

// --- Feature difference (sec. 4.2) -------------------------------------------------------------

fn feature_difference(reference: &Opponent, test: &Opponent, ppd: f64) -> Vec<f32> {
    let detectors = Detectors::new(ppd);
    let (r, t) = (detectors.apply(reference), detectors.apply(test));
    let difference = |(r, t): (&[f32; 2], &[f32; 2])| {
        let largest = (r[0] - t[0]).abs().max((r[1] - t[1]).abs());
        (largest * std::f32::consts::FRAC_1_SQRT_2).sqrt()
    };
    r.par_iter().zip(&t).map(difference).collect()
}

/// A Gaussian and its first two derivatives, the detectors of edges and points.
struct Detectors {
    gaussian: Vec<f32>,
    edge: Vec<f32>,
    point: Vec<f32>,
}

impl Detectors {
    fn new(ppd: f64) -> Self {
        /// Width of a feature in degrees, w.
        const WIDTH: f64 = 0.082;
        let sigma = 0.5 * WIDTH * ppd;
        let radius = (3.0 * sigma).ceil() as i32;
        let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f32> {
            let values: Vec<f64> = (-radius..=radius)
                .map(|i| f(i as f64) * (-0.5 * (i as f64 / sigma).powi(2)).exp())
                .collect();
            // Positive weights sum to 1, negative ones to -1.
            let sum = |sign: f64| values.iter().map(|v| (sign * v).max(0.0)).sum::<f64>();
            let (positive, negative) = (sum(1.0), sum(-1.0));
            let scale = |v: f64| if v > 0.0 { v / positive } else { v / negative.max(1e-300) };
            values.iter().map(|&v| scale(v) as f32).collect()
        };
        Detectors {
            gaussian: kernel(&|_| 1.0),
            edge: kernel(&|x| -x),
            point: kernel(&|x| (x / sigma).powi(2) - 1.0),
        }
    }

    /// Magnitudes of the edge and the point response of each pixel.
    fn apply(&self, image: &Opponent) -> Vec<[f32; 2]> {
        let (w, h) = (image.width, image.height);
        let achromatic: Vec<f32> = image.planes[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        let magnitude = |detector: &[f32]| -> Vec<f32> {
            let x = convolve(&achromatic, w, h, detector, &self.gaussian);
            let y = convolve(&achromatic, w, h, &self.gaussian, detector);
            x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
        };
        let (edges, points) = (magnitude(&self.edge), magnitude(&self.point));
        edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect()
    }
}

// --- Convolution -------------------------------------------------------------------------------

/// Correlation with the product of two kernels of odd length; the border pixels are repeated.
fn convolve(plane: &[f32], width: usize, height: usize, kx: &[f32], ky: &[f32]) -> Vec<f32> {
    let clamped =
        |i: usize, j: usize, radius: usize, n: usize| (i + j).saturating_sub(radius).min(n - 1);
    let mut rows = vec![0.0; plane.len()];
    let rx = kx.len() / 2;
    rows.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(out, row)| {
        let padded: Vec<f32> = (0..width + 2 * rx).map(|i| row[clamped(i, 0, rx, width)]).collect();
        for (j, &k) in kx.iter().enumerate() {
            out.iter_mut().zip(&padded[j..]).for_each(|(o, v)| *o += k * v);
        }
    });
    let mut result = vec![0.0; plane.len()];
    let ry = ky.len() / 2;
    result.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (j, &k) in ky.iter().enumerate() {
            let start = clamped(y, j, ry, height) * width;
            let row = &rows[start..start + width];
            out.iter_mut().zip(row).for_each(|(o, v)| *o += k * v);
        }
    });
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Picture;

    #[test]
    fn matrices_are_inverse_and_white_is_neutral() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.4, 0.9]] {
            let back = apply(&RGB_FROM_XYZ, apply(&XYZ_FROM_RGB, rgb));
            assert!(back.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-7), "{back:?}");
        }
        let [l, a, b] = hunt_lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-9 && a.abs() < 1e-9 && b.abs() < 1e-9);
    }

    #[test]
    fn extremes_of_the_scale() {
        let flat = |c: [f32; 3]| Picture::from_rgb(32, 32, &[c; 1024]);
        let flip = |a: [f32; 3], b: [f32; 3]| {
            let (a, b) = (flat(a), flat(b));
            let map = flip_map(&a.rgb().unwrap(), &b.rgb().unwrap(), 0.0, FLIP_PIXELS_PER_DEGREE);
            map.unwrap()[500]
        };
        assert_eq!(flip([0.3, 0.2, 0.1], [0.3, 0.2, 0.1]), 0.0);
        // The largest colour difference of flat images is that of green and blue.
        assert!((flip([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]) - 1.0).abs() < 1e-4);
        assert!(flip([0.0; 3], [1.0; 3]) > 0.9);
        // Beyond the screen's range nothing can be seen.
        assert_eq!(flip([1.5; 3], [7.0; 3]), 0.0);
    }
}
