//! How far an image is from a reference, and whether its differences are just noise.
//!
//! [`compare`] gives error figures, [`flip_map`] the perceived difference, and
//! [`variance_test`] the statistical tests for which the variance of the reference is known.
//! Everything is summed in `f64`.

mod compare;
mod flip;
#[cfg(test)]
mod synthetic;
mod variance_test;

pub use compare::{CompareOptions, Comparison, compare};
pub use flip::{FLIP_PIXELS_PER_DEGREE, flip_map};
pub use variance_test::{
    MeanTest, PixelTest, TileTest, VarianceReport, VarianceSpace, VarianceTestOptions,
    variance_test,
};

use crate::RgbView;

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// The images differ in size.
    #[error("the sizes differ: {} x {} and {} x {}", .0[0], .0[1], .1[0], .1[1])]
    SizesDiffer([usize; 2], [usize; 2]),
    /// There is nothing to compare.
    #[error("the images have no pixels")]
    Empty,
    /// No pixel of the reference is finite.
    #[error("the reference has no finite pixels")]
    NoReference,
    /// The image is smaller than one tile.
    #[error("the image of {} x {} pixels is smaller than a tile of {side} x {side}", size[0], size[1])]
    TileTooLarge {
        /// Columns and rows of the image.
        size: [usize; 2],
        /// Side of a tile.
        side: usize,
    },
    /// Numbers of samples must be positive.
    #[error("the number of samples per pixel must be positive")]
    NoSamples,
}

fn check_sizes(a: &RgbView, b: &RgbView) -> Result<(), MetricsError> {
    let size = |v: &RgbView| [v.width, v.height];
    if size(a) != size(b) {
        return Err(MetricsError::SizesDiffer(size(a), size(b)));
    }
    if a.is_empty() {
        return Err(MetricsError::Empty);
    }
    Ok(())
}

fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|v| v.is_finite())
}
