//! Shares, weights, and what the sums say.

use super::*;
use crate::accumulate::{Feature, PixelRecord};

fn pass(i: u64) -> PassImage {
    let mut image = PassImage::new(5, 3, Layers::new(&[Feature::Depth, Feature::ShapeId]));
    for band in &mut image.bands(2) {
        for y in 0..band.height() {
            for x in 0..band.width() {
                let h = kaustika_math::mix_bits(i * 100 + (band.y + y) as u64 * 10 + x as u64);
                let v = (h % 1_000_003) as f32 / 7919.0;
                let r = PixelRecord {
                    rgb: [v, v * v, 1.0 / (v + 1.0)],
                    weight: 1.0,
                    depth: v,
                    shape: (h % 5) as u32,
                    ..PixelRecord::default()
                };
                band.add(x, y, &r);
            }
        }
    }
    image
}

fn tree(passes: impl IntoIterator<Item = u64>) -> PassTree {
    let mut t = PassTree::new(5, 3, Layers::new(&[Feature::Depth, Feature::ShapeId]));
    for p in passes {
        t.push(p, pass(p)).unwrap();
    }
    t
}

#[test]
fn shares_merge_to_the_single_run_bit_for_bit() {
    let whole = tree(0..13);
    for cuts in [[3u64, 8], [1, 2], [5, 12]] {
        let mut merged = tree(cuts[1]..13);
        merged.merge(tree(0..cuts[0])).unwrap();
        merged.merge(tree(cuts[0]..cuts[1])).unwrap();
        assert_eq!(merged, whole);
    }
    assert_eq!(whole.ranges(), vec![[0, 13]]);
    assert_eq!((whole.passes(), whole.next_missing(0)), (13, 13));
}

#[test]
fn chains_give_the_bits_of_one_join_after_another() {
    // Sums and M2 of 8 passes by definition: pairs of pairs of pairs, left before right.
    let layers = Layers::new(&[Feature::Depth, Feature::ShapeId]);
    let (stride, ids) = (layers.stride(), ids(&layers));
    let mut nodes: Vec<(Vec<f32>, Vec<f32>)> =
        (0..8).map(|i| (pass(i).data().to_vec(), vec![0.0; 45])).collect();
    for level in 0..3 {
        let pairs = nodes.chunks(2).map(|pair| {
            let [(mut sum, mut m2), (s, m)] = [pair[0].clone(), pair[1].clone()];
            let mut left = Part { sum: &mut sum, m2: &mut m2 };
            add(&mut left, (1 << level) as f32, (&s, &m), (1 << level) as f32, &ids);
            (sum, m2)
        });
        nodes = pairs.collect();
    }
    let whole = tree(0..8);
    assert_eq!(whole.nodes().len(), 1);
    assert_eq!((whole.nodes()[0].sum.len(), whole.nodes()[0].level), (15 * stride, 3));
    assert!(whole.nodes()[0].sum == nodes[0].0 && whole.nodes()[0].m2 == nodes[0].1);
}

#[test]
fn blank_images_are_black_whatever_their_memory_held() {
    let mut t = tree(0..6);
    for p in 6..9 {
        let image = t.blank();
        assert_eq!((image.width(), image.height()), (5, 3));
        assert!(image.data().len() == pass(0).data().len());
        assert!(image.data().iter().all(|v| *v == 0.0));
        t.push(p, pass(p)).unwrap();
    }
    assert_eq!(t, tree(0..9));
}

#[test]
fn order_of_arrival_does_not_matter() {
    assert_eq!(tree([4, 0, 2, 1, 3, 6, 5]), tree(0..7));
}

#[test]
fn overlaps_and_other_sizes_are_refused() {
    let mut t = tree(0..4);
    assert_eq!(t.merge(tree(3..5)), Err(MergeError::Overlap(3)));
    let other = PassTree::new(4, 3, Layers::new(&[]));
    assert_eq!(tree(0..2).merge(other), Err(MergeError::Layout));
}

#[test]
fn passes_count_by_their_weights() {
    // Weights 1 and 3 by turns: as if every second pass had come three times.
    let weight = |p: u64| if p.is_multiple_of(2) { 1.0 } else { 3.0 };
    let layers = Layers::new(&[Feature::Depth, Feature::ShapeId]);
    let mut t = PassTree::new(5, 3, layers);
    for p in 0..11 {
        t.push_weighted(p, pass(p), weight(p)).unwrap();
    }
    let total = t.total().unwrap();
    let stride = total.layers.stride();
    for pixel in 0..15 {
        let x = |p: u64| f64::from(pass(p).data()[pixel * stride]);
        let w = |p: u64| f64::from(weight(p));
        let all: f64 = (0..11).map(w).sum();
        let mean = (0..11).map(|p| w(p) * x(p)).sum::<f64>() / all;
        let m2 = (0..11).map(|p| w(p) * (x(p) - mean).powi(2)).sum::<f64>();
        assert!((f64::from(total.rgb(pixel)[0]) / mean - 1.0).abs() < 1e-5);
        let variance = m2 / 10.0 / (all / 11.0);
        assert!((f64::from(total.variance(pixel)[0]) / variance - 1.0).abs() < 1e-4);
        let depth = total.value(pixel, total.layers.offset(Feature::Depth).unwrap());
        assert!((f64::from(depth) / mean - 1.0).abs() < 1e-5);
        let shape = total.layers.offset(Feature::ShapeId).unwrap();
        assert_eq!(total.id(pixel, shape), pass(0).data()[pixel * stride + shape]);
    }
}

#[test]
fn mean_and_variance_are_those_of_the_samples() {
    let n = 37u64;
    let total = tree(0..n).total().unwrap();
    let stride = total.layers.stride();
    for pixel in 0..15 {
        let samples: Vec<f64> = (0..n).map(|p| pass(p).data()[pixel * stride] as f64).collect();
        let mean = samples.iter().sum::<f64>() / n as f64;
        let var = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
        assert!((total.rgb(pixel)[0] as f64 / mean - 1.0).abs() < 1e-5);
        assert!((total.variance(pixel)[0] as f64 / var - 1.0).abs() < 1e-4);
    }
}
