//! Good scenes, and words that don't fit them or make no sense.

use super::case::Case;
use crate::kit::{Place, SCENE};

/// What stands in place of a checkpoint.
fn damage(place: &Place, change: impl Fn(Vec<u8>) -> Vec<u8>) {
    place.ok("render ball.pbrt -q --spp 4 --passes 0..2 -o a.exr");
    std::fs::remove_file(place.path("a.exr")).unwrap();
    let bytes = std::fs::read(place.path("a.ckpt")).unwrap();
    std::fs::write(place.path("a.ckpt"), change(bytes)).unwrap();
}

/// Two shares that begin alike.
fn shares(place: &Place, first: &str, second: &str) {
    place.ok(&format!("render ball.pbrt -q {first} -o x.exr"));
    place.ok(&format!("render ball.pbrt -q {second} -o y.exr"));
}

pub fn cases() -> Vec<Case> {
    [usage(), choices(), outputs(), checkpoints(), parts(), pictures()]
        .into_iter()
        .flatten()
        .collect()
}

/// What the words themselves are.
fn usage() -> Vec<Case> {
    let wrong = |name, args: &str| {
        Case::new(name, &format!("render ball.pbrt {args} -o a.exr")).wrong_usage()
    };
    vec![
        Case::new("usage-unknown-command", "rendr ball.pbrt").wrong_usage(),
        wrong("usage-unknown-option", "--sp 4"),
        wrong("usage-spp-of-letters", "--spp many"),
        wrong("usage-spp-of-zero", "--spp 0"),
        wrong("usage-spp-negative", "--spp -4"),
        wrong("usage-resolution-of-zero", "--resolution 0x0"),
        wrong("usage-resolution-absurd", "--resolution 1000000x1000000"),
        wrong("usage-resolution-negative", "--resolution -8x6"),
        wrong("usage-crop-outside", "--crop 100,100,110,110"),
        wrong("usage-crop-reversed", "--crop 8,0,4,6"),
        wrong("usage-crop-negative", "--crop -4,0,4,6"),
        wrong("usage-cropwindow-nan", "--cropwindow nan,1,0,1"),
        wrong("usage-exposure-nan", "--exposure nan"),
        wrong("usage-seed-of-letters", "--seed lucky"),
        wrong("usage-noise-negative", "--noise -1"),
        wrong("usage-time-negative", "--time -5"),
        wrong("usage-unknown-sampler", "--sampler sobl"),
        wrong("usage-unknown-filter", "--filter gausian"),
        wrong("usage-filter-of-no-width", "--filter box:0"),
        wrong("usage-unknown-tonemap", "--tonemap acess"),
        wrong("usage-unknown-layer", "--aov albdo"),
        wrong("usage-unknown-light-sampler", "--light-sampler powr"),
        wrong("usage-bad-time", "--time soon"),
        wrong("usage-bad-passes", "--passes 4-8"),
        wrong("usage-no-value-of-a-parameter", "-p max_depth"),
        wrong("usage-threads-absurd", "--threads 100000"),
        Case::new("merge-nothing", "merge -o a.exr").wrong_usage(),
        Case::new("compare-one", "compare x.exr").wrong_usage(),
    ]
}

/// What can't be known before the scene is.
fn choices() -> Vec<Case> {
    let wrong = |name, args: &str| {
        Case::new(name, &format!("render ball.pbrt {args} -o a.exr")).wrong_usage()
    };
    vec![
        Case::new("scene-of-unknown-kind", "render ball.blend -o a.exr").file("ball.blend", "BLENDER"),
        Case::new("scene-without-extension", "render ball -o a.exr").file("ball", SCENE),
        wrong("choice-unknown-method", "-m pth"),
        wrong("choice-unknown-parameter", "-p max_dept=4"),
        wrong("choice-parameter-of-letters", "-p max_depth=deep"),
        wrong("choice-parameter-negative", "-p rr_depth=-7"),
        wrong("choice-depth-negative", "-p max_depth=-5"),
        wrong("choice-depth-absurd", "-p only_depth=99999999999"),
        wrong("choice-parameter-not-a-truth", "-p hide_emitters=perhaps"),
        wrong("choice-layer-of-polarized-light", "--aov depth,stokes"),
        wrong("choice-parameter-fractional", "-p max_depth=2.5"),
        wrong("choice-unknown-camera", "--camera front"),
        wrong("choice-passes-beyond-spp", "--spp 4 --passes 2..6"),
        Case::new("choice-unused-define", "render s.xml -D depht=3 --spp 1 -o a.exr")
            .file("s.xml", "<scene version=\"3.0.0\">\n<default name=\"depth\" value=\"3\"/>\n<sensor type=\"perspective\"/>\n<emitter type=\"constant\"/></scene>")
            .args("render s.xml -D depht=3 --spp 1 --resolution 4x4 -o a.exr")
            .accepted(),
        Case::new("info-missing-scene", "info gone.pbrt"),
        Case::new("info-of-a-picture", "info a.png").file("a.png", "no scene"),
        Case::new("methods-unknown", "methods pth").wrong_usage(),
        Case::new("rays-missing", "rays gone.ply gone.f32"),
    ]
}

fn outputs() -> Vec<Case> {
    vec![
        Case::new("output-of-unknown-kind", "render ball.pbrt -o a.gif").wrong_usage(),
        Case::new("output-without-extension", "render ball.pbrt -o picture").wrong_usage(),
        Case::new("output-in-no-folder", "render ball.pbrt -o nowhere/a.exr"),
        Case::new("output-in-a-file", "render ball.pbrt -o ball.pbrt/a.exr"),
        Case::new("output-is-a-folder", "render ball.pbrt -q --spp 1 -o b.exr")
            .prepared(|p| std::fs::create_dir(p.path("b.exr")).unwrap()),
        Case::new(
            "output-stats-in-no-folder",
            "render ball.pbrt -q --spp 1 -o a.exr --stats nowhere/s.json",
        ),
        Case::new("output-no-viewer", "render ball.pbrt --display 127.0.0.1:1 -o a.exr"),
    ]
}

fn checkpoints() -> Vec<Case> {
    let resume = |name, prepare: fn(&Place)| {
        Case::new(name, "render ball.pbrt -q --spp 4 --resume -o a.exr").prepared(prepare)
    };
    vec![
        resume("resume-garbage", |p| p.write("a.ckpt", "my checkpoint")),
        resume("resume-empty", |p| p.write("a.ckpt", "")),
        resume("resume-cut", |p| damage(p, |b| b[..b.len() / 2].to_vec())),
        resume("resume-one-bit", |p| {
            damage(p, |mut b| {
                let middle = b.len() / 2;
                b[middle] ^= 4;
                b
            })
        }),
        resume("resume-of-another-seed", |p| damage(p, |b| b))
            .args("render ball.pbrt -q --seed 9 --resume -o a.exr"),
        resume("resume-of-another-scene", |p| {
            damage(p, |b| b);
            p.write("ball.pbrt", &SCENE.replace("0.7 0.4 0.2", "0.7 0.4 0.3"));
        }),
        resume("resume-a-folder", |p| std::fs::create_dir(p.path("a.ckpt")).unwrap()),
    ]
}

fn parts() -> Vec<Case> {
    vec![
        Case::new("merge-missing", "merge x.exr -o a.exr"),
        Case::new("merge-missing-checkpoint", "merge x.ckpt -o a.exr"),
        Case::new("merge-garbage", "merge x.ckpt -o a.exr").file("x.ckpt", "no share"),
        Case::new("merge-overlapping", "merge x.exr y.exr -o a.exr").prepared(|p| {
            shares(p, "--spp 4 --passes 0..2", "--spp 4 --passes 1..3");
        }),
        Case::new("merge-of-two-seeds", "merge x.exr y.exr -o a.exr").prepared(|p| {
            shares(p, "--spp 4 --passes 0..2", "--spp 4 --seed 1 --passes 2..4");
        }),
        Case::new("merge-of-two-sizes", "merge x.exr y.exr -o a.exr").prepared(|p| {
            shares(p, "--spp 4 --passes 0..2", "--spp 4 --resolution 8x6 --passes 2..4");
        }),
    ]
}

fn pictures() -> Vec<Case> {
    vec![
        Case::new("compare-missing", "compare x.exr y.exr"),
        Case::new("compare-scenes", "compare ball.pbrt ball.pbrt"),
        Case::new("compare-sizes", "compare x.exr y.exr").prepared(|p| {
            shares(p, "--spp 1", "--spp 1 --resolution 8x6");
        }),
        Case::new("compare-unknown-space", "compare x.exr y.exr --space lab").wrong_usage(),
        Case::new("compare-no-spp", "compare x.pfm x.pfm --variance x.pfm").wrong_usage().prepared(
            |p| {
                p.ok("render ball.pbrt -q --spp 1 -o x.pfm");
            },
        ),
    ]
}
