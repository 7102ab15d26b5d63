//! Small images for the tests, made of exactly rounded operations so that the independent
//! implementation (NumPy) could be given bit for bit the same.

use crate::Picture;

/// Reference, variance of one sample, and a tested image, 50 x 37 pixels.
pub(super) fn images() -> [Picture; 3] {
    const SIZE: [u32; 2] = [50, 37];
    let n = SIZE[0] * SIZE[1];
    // Sawtooth in [0, 1).
    let saw = |i: u32, c: u32, step: u32, period: u32| {
        ((i * step + c * 101 + i / 50 * 7) % period) as f32 / period as f32
    };
    let image = |f: &dyn Fn(u32, u32) -> f32| {
        let pixels: Vec<[f32; 3]> =
            (0..n).map(|i| std::array::from_fn(|c| f(i, c as u32))).collect();
        Picture::from_rgb(SIZE[0], SIZE[1], &pixels)
    };
    let reference = |i, c| saw(i, c, 3, 97) * 1.5;
    let variance = |i, c| saw(i, c, 5, 61) * 0.25;
    let test = |i, c| reference(i, c) * 1.015625 + (saw(i, c, 53, 31) - 0.5) * 0.0625;
    [image(&reference), image(&variance), image(&test)]
}

/// Fails unless `got` is within `tolerance` of `expected`, relative to it.
pub(super) fn assert_close(what: &str, got: f64, expected: f64, tolerance: f64) {
    let error = (got - expected).abs();
    assert!(error <= tolerance * expected.abs(), "{what}: {got:e} is not {expected:e}");
}
