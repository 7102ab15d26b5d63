//! Pictures without their noise, and what is said of them.

use crate::kit::Place;
use kaustika::film::{MetaValue, Picture};

const AOVS: &str = "--aov albedo,sh_normal,depth";

fn rgb(picture: &Picture, layer: &str) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|c| picture.channel(&format!("{layer}{c}")).unwrap().to_vec())
}

fn distance(a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

#[test]
fn the_noisy_picture_stays_beside_the_filtered_one() {
    let place = Place::new();
    place.ok("render ball.pbrt --spp 16 -q -o noisy.exr");
    place.ok("render ball.pbrt --spp 2048 --seed 5 -q -o good.exr");
    let out = place.run("render ball.pbrt --spp 16 --denoise -o clean.exr");
    let told = String::from_utf8(out.stderr).unwrap();
    assert!(told.contains("denoised in "), "{told}");
    assert!(
        told.contains("by Kaustika's filter (local linear fits; albedo, normal, depth, variance)")
    );

    let (noisy, clean, good) =
        (place.picture("noisy.exr"), place.picture("clean.exr"), place.picture("good.exr"));
    assert_eq!(rgb(&noisy, ""), rgb(&clean, "Noisy."));
    assert_eq!(rgb(&noisy, "Variance."), rgb(&clean, "Variance."));
    let truth = rgb(&good, "");
    let (before, after) = (distance(&rgb(&noisy, ""), &truth), distance(&rgb(&clean, ""), &truth));
    assert!(after < 0.7 * before, "{before} {after}");
    assert!(clean.channels.iter().all(|c| !c.name.starts_with("Albedo")));
    assert!(noisy.meta("kaustika.denoised").is_none());
    match clean.meta("kaustika.denoised") {
        Some(MetaValue::Text(text)) => assert!(text.starts_with("Kaustika's filter")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_file_with_the_layers_becomes_the_same_picture() {
    let place = Place::new();
    place.ok("render ball.pbrt --spp 4 -q --denoise --aov albedo -o at-once.exr");
    place.ok(&format!("render ball.pbrt --spp 4 -q {AOVS} -o layers.exr"));
    place.ok("denoise layers.exr -o later.exr");
    let (at_once, later) = (place.picture("at-once.exr"), place.picture("later.exr"));
    assert_eq!(rgb(&at_once, ""), rgb(&later, ""));
    assert_eq!(rgb(&at_once, "Albedo."), rgb(&later, "Albedo."));
    assert!(at_once.channel("Depth.Z").is_none() && later.channel("Depth.Z").is_some());
    let told = place.fails(1, "denoise later.exr -o twice.exr");
    assert_eq!(
        told,
        "error: later.exr: it has a layer Noisy: the noise was taken out of it before\n"
    );
}

#[test]
fn colour_alone_is_enough() {
    let place = Place::new();
    place.ok("render ball.pbrt --spp 4 -q -o a.pfm");
    let out = place.run("denoise a.pfm -o b.png");
    let told = String::from_utf8(out.stderr).unwrap();
    assert!(told.contains("(local linear fits; colour alone)"), "{told}");
    assert!(place.has("b.png"));
}

#[cfg(not(feature = "oidn"))]
#[test]
fn a_filter_that_was_not_built_says_how_to_build_it() {
    let place = Place::new();
    place.ok("render ball.pbrt --spp 1 -q -o a.exr");
    for args in ["render ball.pbrt --denoise=oidn -o b.exr", "denoise a.exr --filter oidn -o b.exr"]
    {
        let told = place.fails(2, args);
        assert!(told.contains("cargo build --release --features oidn"), "{told}");
    }
    let told = place.fails(2, "render ball.pbrt --denoise=nlm -o b.exr");
    assert!(told.contains("known: kaustika, oidn"), "{told}");
    assert!(!place.has("b.exr"));
}
