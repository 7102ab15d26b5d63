//! Filling the image of a pass, and joining passes.
//!
//! `cargo bench -p kaustika-film`. The rate is pixels a second.

use divan::Bencher;
use divan::counter::ItemsCount;
use kaustika_film::accumulate::{Feature, Layers, PassImage, PassTree, PixelRecord};

fn main() {
    divan::main();
}

const SIDE: u32 = 128;
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Passes that are joined; a power of two, so that a single sum is left.
const PASSES: usize = 16;

/// A pass with a value in each pixel.
fn pass(layers: &Layers, value: f32) -> PassImage {
    let mut image = PassImage::new(SIDE, SIDE, layers.clone());
    fill(&mut image, value);
    image
}

fn fill(image: &mut PassImage, value: f32) {
    for mut band in image.bands(4) {
        for y in 0..band.height() {
            for x in 0..SIDE {
                let rgb = [value, value + x as f32, value + y as f32];
                band.add(x, y, &PixelRecord { rgb, weight: 1.0, ..PixelRecord::default() });
            }
        }
    }
}

fn layers(features: bool) -> Layers {
    Layers::new(if features { &Feature::FIRST_SURFACE } else { &[] })
}

#[divan::bench(args = [false, true], min_time = 0.2, max_time = 1)]
fn add_samples_with_features(bencher: Bencher, features: bool) {
    let mut image = PassImage::new(SIDE, SIDE, layers(features));
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| fill(&mut image, 1.0));
}

#[divan::bench(args = [false, true], min_time = 0.2, max_time = 1, sample_count = 20)]
fn join_passes_with_features(bencher: Bencher, features: bool) {
    let layers = layers(features);
    bencher
        .counter(ItemsCount::new(PASSES * PIXELS))
        .with_inputs(|| (0..PASSES).map(|i| pass(&layers, i as f32)).collect::<Vec<_>>())
        .bench_local_values(|images| {
            let mut tree = PassTree::new(SIDE, SIDE, layers.clone());
            for (i, image) in images.into_iter().enumerate() {
                tree.push(i as u64, image).expect("each pass comes once, with the tree's layers");
            }
            tree
        });
}
