//! Error figures of an image against a reference.

use super::{FLIP_PIXELS_PER_DEGREE, MetricsError, check_sizes, flip_map, is_finite};
use crate::RgbView;

/// What [`compare`] computes.
#[derive(Clone, Copy, Debug)]
pub struct CompareOptions {
    /// Stops of exposure before FLIP.
    pub exposure: f32,
    /// Whether to compute FLIP, the slowest of the figures.
    pub flip: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        CompareOptions { exposure: 0.0, flip: true }
    }
}

/// Error figures; x is the tested image, r the reference, both linear RGB.
///
/// Pixels in which the test is not finite count as black. Pixels in which the reference is not
/// finite are left out of everything (in FLIP both are black there).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of (x - r)² over pixels and channels.
    pub mse: f64,
    /// Mean of (x - r)² / (r² + 0.01).
    pub rel_mse: f64,
    /// The same without the 0.1 % of pixels (rounded up) of largest error: fireflies.
    pub rel_mse_trimmed: f64,
    /// Mean of |x - r| / (|r| + 0.01), as a fraction (0.1 is 10 %).
    pub mape: f64,
    /// mean(x) / mean(r) over all channels; 1 when unbiased.
    pub mean_ratio: f64,
    /// mean(x) / mean(r) of red, green and blue.
    pub mean_ratio_rgb: [f64; 3],
    /// Pixels of the test with a NaN or an infinity.
    pub non_finite: usize,
    /// Pixels of the reference with a NaN or an infinity.
    pub reference_non_finite: usize,
    /// Mean LDR-FLIP at 67 pixels a degree, in [0, 1]; see [`flip_map`].
    pub flip: Option<f64>,
}

/// Keeps relative errors finite where the reference is black.
const EPSILON: f64 = 1e-2;

/// Share of pixels that the trimmed mean leaves out.
const TRIM: f64 = 1e-3;

/// Compares `test` with `reference`.
pub fn compare(
    reference: &RgbView,
    test: &RgbView,
    options: &CompareOptions,
) -> Result<Comparison, MetricsError> {
    check_sizes(reference, test)?;
    let (mut squared, mut absolute) = (0.0, 0.0);
    let (mut sum_test, mut sum_reference) = ([0.0; 3], [0.0; 3]);
    let (mut non_finite, mut reference_non_finite) = (0, 0);
    let mut relative = Vec::with_capacity(reference.len());
    for (r, x) in reference.pixels().zip(test.pixels()) {
        non_finite += !is_finite(&x) as usize;
        let x = if is_finite(&x) { x } else { [0.0; 3] };
        if !is_finite(&r) {
            reference_non_finite += 1;
            continue;
        }
        let mut of_pixel = 0.0;
        for c in 0..3 {
            let (r, x) = (r[c] as f64, x[c] as f64);
            let square = (x - r) * (x - r);
            squared += square;
            of_pixel += square / (r * r + EPSILON);
            absolute += (x - r).abs() / (r.abs() + EPSILON);
            sum_test[c] += x;
            sum_reference[c] += r;
        }
        relative.push(of_pixel / 3.0);
    }
    if relative.is_empty() {
        return Err(MetricsError::NoReference);
    }
    let values = 3.0 * relative.len() as f64;
    let flip = options.flip.then(|| {
        let map = flip_map(reference, test, options.exposure, FLIP_PIXELS_PER_DEGREE);
        let map = map.expect("the sizes were checked above");
        map.iter().map(|&v| v as f64).sum::<f64>() / map.len() as f64
    });
    Ok(Comparison {
        mse: squared / values,
        rel_mse: mean(&relative),
        rel_mse_trimmed: trimmed_mean(&mut relative, TRIM),
        mape: absolute / values,
        mean_ratio: sum_test.iter().sum::<f64>() / sum_reference.iter().sum::<f64>(),
        mean_ratio_rgb: std::array::from_fn(|c| sum_test[c] / sum_reference[c]),
        non_finite,
        reference_non_finite,
        flip,
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean without the largest `share` of the values (rounded up, but one value stays).
fn trimmed_mean(values: &mut [f64], share: f64) -> f64 {
    let dropped = (share * values.len() as f64).ceil() as usize;
    let kept = (values.len() - dropped).max(1);
    values.sort_unstable_by(f64::total_cmp);
    mean(&values[..kept])
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{assert_close, images};
    use super::*;
    use crate::Picture;

    // Expected values: NumPy in f64 and NVIDIA's flip-evaluator 1.7 on the same images.
    const MSE: f64 = 0.0004830050480760295;
    const REL_MSE: f64 = 0.0036026735135052594;
    const REL_MSE_TRIMMED: f64 = 0.003565931180818844;
    const MAPE: f64 = 0.06495742757414484;
    const MEAN_RATIO: f64 = 1.0142799784441867;
    const MEAN_RATIO_RGB: [f64; 3] = [1.0144127766629911, 1.0142956467021174, 1.0141314383863305];
    const FLIP: f64 = 0.04271531477570534;

    #[test]
    fn figures_agree_with_the_independent_implementation() {
        let [reference, _, test] = images();
        let options = CompareOptions { exposure: -0.5, flip: true };
        let c = compare(&reference.rgb().unwrap(), &test.rgb().unwrap(), &options).unwrap();
        assert_close("mse", c.mse, MSE, 1e-9);
        assert_close("rel_mse", c.rel_mse, REL_MSE, 1e-9);
        assert_close("trimmed", c.rel_mse_trimmed, REL_MSE_TRIMMED, 1e-9);
        assert_close("mape", c.mape, MAPE, 1e-9);
        assert_close("mean_ratio", c.mean_ratio, MEAN_RATIO, 1e-9);
        for (got, expected) in c.mean_ratio_rgb.into_iter().zip(MEAN_RATIO_RGB) {
            assert_close("mean_ratio_rgb", got, expected, 1e-9);
        }
        assert_close("flip", c.flip.unwrap(), FLIP, 1e-4);
        assert_eq!((c.non_finite, c.reference_non_finite), (0, 0));
    }

    #[test]
    fn non_finite_pixels_are_counted_and_kept_out() {
        let reference = Picture::from_rgb(2, 1, &[[1.0; 3], [f32::INFINITY, 0.0, 0.0]]);
        let test = Picture::from_rgb(2, 1, &[[0.0, f32::NAN, 0.0], [5.0; 3]]);
        let options = CompareOptions::default();
        let c = compare(&reference.rgb().unwrap(), &test.rgb().unwrap(), &options).unwrap();
        assert_eq!((c.non_finite, c.reference_non_finite), (1, 1));
        assert_eq!((c.mse, c.mean_ratio), (1.0, 0.0));
        let c = compare(&test.rgb().unwrap(), &test.rgb().unwrap(), &options).unwrap();
        assert_eq!((c.mse, c.flip), (0.0, Some(0.0)));

        let other = Picture::from_rgb(1, 2, &[[0.0; 3]; 2]);
        let error = compare(&reference.rgb().unwrap(), &other.rgb().unwrap(), &options);
        assert_eq!(error.unwrap_err().to_string(), "the sizes differ: 2 x 1 and 1 x 2");
    }
}
