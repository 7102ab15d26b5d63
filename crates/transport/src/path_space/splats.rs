//! Samples that choose their pixels.

use super::{Closing, Tracks};
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelBand};
use kaustika_math::Vec2;
use kaustika_spectra::{Spectrum, Wavelengths};

/// Light that reached the film.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Where, in pixels of the whole picture.
    pub film: Vec2,
    /// Number of a layer by path; `None`: the picture itself.
    pub layer: Option<usize>,
    /// How much, linear RGB.
    pub rgb: [f32; 3],
}

/// Leaves a value on the film, and on the layers by path that it belongs to. Bad numbers count as
/// black.
#[expect(clippy::too_many_arguments)]
pub fn splat(
    frame: &Frame,
    tracks: Option<&Tracks>,
    closing: &Closing,
    value: Spectrum,
    film: Vec2,
    lambda: &Wavelengths,
    splats: &mut Vec<Splat>,
    stats: &mut PassStats,
) {
    let sound = leave(frame, None, value, film, lambda, splats);
    stats.bad_samples += u64::from(!sound);
    if let Some(tracks) = tracks {
        tracks.each(closing, |layer, part| {
            leave(frame, Some(layer), value * part, film, lambda, splats);
        });
    }
}

/// Leaves a value on a layer, `None` being the picture; false, and nothing left, if it is no
/// number.
pub fn leave(
    frame: &Frame,
    layer: Option<usize>,
    value: Spectrum,
    film: Vec2,
    lambda: &Wavelengths,
    splats: &mut Vec<Splat>,
) -> bool {
    let rgb = frame.sensor.rgb(value, lambda);
    let sound = rgb.iter().all(|v| v.is_finite());
    if sound {
        splats.push(Splat { film, layer, rgb: frame.clamp(rgb) });
    }
    sound
}

/// Bands whose splats are kept at the same time: bounds the memory they take.
const WINDOW: usize = 32;

/// As [`Workers::bands`], where `f` also leaves splats; they are added to the picture in the
/// order of the bands, so that the number of threads changes nothing.
///
/// # Errors
/// As [`Workers::bands`].
pub fn splat_bands<S: Send, T: Send>(
    workers: &Workers,
    frame: &Frame,
    image: &mut PassImage,
    rows: u32,
    room: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, &mut PixelBand, &mut Vec<Splat>) -> T + Sync,
) -> Result<Vec<T>, RenderError> {
    let bands = image.height().div_ceil(rows) as usize;
    let mut results = Vec::with_capacity(bands);
    for first in (0..bands).step_by(WINDOW) {
        let window = first..bands.min(first + WINDOW);
        let filled = workers.some_bands(image, rows, window, &room, |room, band| {
            let mut splats = Vec::new();
            let result = f(room, band, &mut splats);
            (result, splats)
        })?;
        for (result, splats) in filled {
            splats.iter().for_each(|s| add_splat(frame, image, s));
            results.push(result);
        }
    }
    Ok(results)
}

/// Adds a splat to every pixel whose filter covers its place.
pub fn add_splat(frame: &Frame, image: &mut PassImage, s: &Splat) {
    each_covered(frame, s.film, |x, y, k| image.splat(x, y, s.layer, s.rgb.map(|v| k * v)));
}

/// Every pixel whose filter covers a place of the film, column and row in the region, with the
/// filter's value there.
pub fn each_covered(frame: &Frame, film: Vec2, mut f: impl FnMut(u32, u32, f32)) {
    let filter = &frame.filter_desc;
    let radius = filter.radius();
    let scale = 1.0 / filter.integral();
    // Pixel i has its centre at i + ½; a box of half a pixel covers just the pixel it is in.
    let span = |at: f32, radius: f32, from: u32, to: u32| {
        let first = ((at - 0.5 - radius).floor() + 1.0).max(from as f32) as u32;
        let last = (at - 0.5 + radius).floor().min(to as f32 - 1.0);
        first..(last + 1.0).max(first as f32) as u32
    };
    let [x0, y0, x1, y1] = frame.region;
    for y in span(film.y, radius.y, y0, y1) {
        for x in span(film.x, radius.x, x0, x1) {
            let offset = film - Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let k = filter.evaluate(offset) * scale;
            f(x - x0, y - y0, k);
        }
    }
}
