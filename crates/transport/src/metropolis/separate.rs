//! What chains leave out: light of at most one bounce, which bidirectional path tracing does better,
//! and what pixels show first.

use crate::features::first_seen;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::path_space::splat_bands;
use crate::strategies::{Pairs, Settings};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_scene::{LightSelection, Scene};

/// Pixels of a chunk.
const CHUNK: u32 = 2048;

/// A sample of each pixel, of the paths of these settings; of none, what the pixels show and no
/// light.
///
/// # Errors
/// If cancelled.
pub fn pass(
    index: u64,
    (scene, frame): (&Scene, &Frame),
    settings: Option<Settings>,
    (lights, emission): (&LightSelection, &LightSelection),
    out: &mut PassImage,
    workers: &Workers,
) -> Result<PassStats, RenderError> {
    let rows = CHUNK.div_ceil(out.width().max(1)).max(1);
    let room =
        || settings.clone().map(|s| Pairs::new(scene, frame, s, lights, emission).on_both_sides());
    let bands = splat_bands(workers, frame, out, rows, room, |room, band, splats| {
        let mut stats = PassStats::default();
        let features = band.wants_features();
        for ([x, y], pixel) in frame.places(band) {
            let Some(pairs) = room else {
                let record = match features {
                    true => first_seen(scene, frame, pixel, index),
                    false => PixelRecord::default(),
                };
                band.add(x, y, &PixelRecord { weight: 1.0, ..record });
                continue;
            };
            let record = pairs.sample(pixel, index, features, splats, &mut stats);
            band.add(x, y, &record);
            let [by_path, _] = pairs.layers();
            band.add_paths(x, y, record.weight, 0, by_path);
        }
        stats
    })?;
    Ok(bands.into_iter().sum())
}
