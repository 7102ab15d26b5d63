//! The methods agree on the project's own scenes, on the light that two of them can sample.
//!
//! A small part of `scripts/agreement.py`, whose table stands in `docs/agreement.md`.

use kaustika::film::FilterDesc;
use kaustika::film::accumulate::PassImage;
use kaustika::math::special::p_two_sided;
use kaustika::sampling::SamplerKind;
use kaustika::sampling::estimator::RunningMean;
use kaustika::spectra::ColorMode;
use kaustika::transport::Workers;
use kaustika::{RenderOptions, Setup, load};
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [16, 12];
/// Means of so many passes are taken as normal.
const GROUP: u64 = 10;

/// Everything.
const ALL: &str = "C.*L";
/// What light tracing can show the camera: the last thing that the light meets is no mirror.
const SHOWN: &str = "C[^S].*L";
/// What is seen on matte surfaces: light tracing meets the way from a smooth plate to the lens so seldom that the mean of
/// a thousand passes is not normal.
const MATTE: &str = "CD.*L";
/// What next event estimation from the eye finds, and lamps in mirrors: no caustics.
const ASKED: &str = "C(S*|.*[^S])L";

/// Scene, a method, another, the class of paths on which they are compared.
const COMPARISONS: [(&str, &str, &str, &str); 20] = [
    ("cornell-box/scene.pbrt", "path", "bdpt", ALL),
    ("cornell-box/scene.pbrt", "light", "bdpt", SHOWN),
    ("cornell-box/scene.pbrt", "vcm", "bdpt", ALL),
    ("plates/scene.pbrt", "path", "bdpt", ALL),
    ("plates/scene.pbrt", "light", "bdpt", MATTE),
    ("sky/scene.xml", "path", "bdpt", ASKED),
    ("sky/scene.xml", "light", "bdpt", SHOWN),
    ("lamp-room/scene.xml", "path", "bdpt", ASKED),
    ("lamp-room/scene.xml", "light", "bdpt", SHOWN),
    ("door/scene.xml", "path", "bdpt", ASKED),
    ("door/scene.xml", "light", "bdpt", SHOWN),
    ("glass-sphere/scene.xml", "path", "bdpt", ASKED),
    ("glass-sphere/scene.xml", "light", "bdpt", SHOWN),
    ("ring/scene.xml", "path", "bdpt", ASKED),
    ("ring/scene.xml", "light", "bdpt", SHOWN),
    ("pool/large.xml", "path", "bdpt", ALL),
    ("pool/large.xml", "light", "bdpt", SHOWN),
    ("pool/small.xml", "path", "bdpt", ASKED),
    ("fog/scene.pbrt", "path", "bdpt", ASKED),
    ("fog/scene.pbrt", "light", "bdpt", SHOWN),
];

/// The mean of one class over the picture and over its quarters, by groups of passes.
fn means(scene: &str, method: &str, class: &str, passes: u64, seed: u64) -> [RunningMean; 5] {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let description = load(&scenes.join(scene), &[]);
    let faults = &description.diagnostics.entries;
    assert!(faults.is_empty(), "{scene}: {faults:?}");
    let mut parameters = vec![("max_depth".into(), "6".into())];
    if method == "vcm" {
        parameters.extend([("radius".into(), "0.001".into()), ("alpha".into(), "1".into())]);
    }
    let options = RenderOptions {
        method: Some(method.into()),
        parameters,
        mode: Some(ColorMode::Rgb),
        resolution: Some(SIZE),
        sampler: Some(SamplerKind::Independent),
        filter: Some(FilterDesc::BOX),
        seed: Some(seed),
        path_layers: vec![format!("class={class}")],
        ..RenderOptions::default()
    };
    let Setup { scene, frame, mut method, .. } = Setup::new(&description, &options).unwrap();
    let workers = Workers::new(2, Arc::default()).unwrap();
    method.prepare(&scene, &frame, &workers).unwrap();
    let at = frame.layers.path_offset(0);
    let mut means = [RunningMean::new(); 5];
    for group in 0..passes / GROUP {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        for pass in group * GROUP..(group + 1) * GROUP {
            method.pass(pass, &scene, &frame, &mut image, &workers).unwrap();
        }
        let mut sums = [0.0; 5];
        for (i, pixel) in image.data().chunks(frame.layers.stride()).enumerate() {
            let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
            let quarter = 2 * usize::from(2 * y >= SIZE[1]) + usize::from(2 * x >= SIZE[0]);
            let grey = f64::from(pixel[at] + pixel[at + 1] + pixel[at + 2]);
            sums[quarter] += grey;
            sums[4] += grey;
        }
        means.iter_mut().zip(sums).for_each(|(mean, sum)| mean.push(sum));
    }
    means
}

/// The smallest p-value of the parts' differences, `a` having been made brighter by a factor.
fn smallest_p(a: &[RunningMean; 5], b: &[RunningMean; 5], factor: f64) -> f64 {
    let p = a.iter().zip(b).map(|(a, b)| {
        let error = (factor * a.standard_error()).hypot(b.standard_error());
        p_two_sided((factor * a.mean() - b.mean()).abs() / error.max(1e-300))
    });
    p.fold(1.0, f64::min)
}

/// The level of one of all tests, which together reject with probability 1 % if all is well (Šidák 1967).
fn level() -> f64 {
    -(0.99f64.ln() / (5 * COMPARISONS.len()) as f64).exp_m1()
}

#[test]
fn methods_agree_on_our_own_scenes() {
    let passes = |method: &str| if method == "path" || method == "light" { 800 } else { 200 };
    for (i, (scene, one, other, class)) in COMPARISONS.into_iter().enumerate() {
        let seed = 2 * i as u64;
        let a = means(scene, one, class, passes(one), seed + 1);
        let b = means(scene, other, class, passes(other), seed + 2);
        let p = smallest_p(&a, &b, 1.0);
        let (x, y) = (a[4].mean(), b[4].mean());
        assert!(x > 0.0 && p > level(), "{scene}: {one} {x:.4}, {other} {y:.4}, p = {p:.2e}");
    }
}

/// The test above would find a fault of a few per cent.
#[test]
fn a_picture_that_is_too_bright_does_not_agree() {
    let (scene, one, other, class) = COMPARISONS[1];
    let (a, b) = (means(scene, one, class, 800, 1), means(scene, other, class, 200, 2));
    assert!(smallest_p(&a, &b, 1.03) < level());
}
