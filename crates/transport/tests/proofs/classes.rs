//! Layers by path: methods agree layer by layer, and layers that part the paths add up.

use crate::bidirectional::{SIZE, room};
use crate::media::{Form, filled, hg, medium};
use crate::scenes::*;
use crate::stats::{close, same};
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_film::path_expression::{PathClasses, PathLayer};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::{Frame, Session, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

/// The mean of the picture and of each layer by a method; passes count as independent.
pub(crate) fn layers(
    scene: &Scene,
    method: &str,
    p: Value,
    expressions: &[&str],
    passes: u64,
    seed: u64,
) -> Vec<RunningMean> {
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed, spp: passes, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let parse = |(i, e): (usize, &&str)| PathLayer::parse(&format!("l{i}={e}")).expect(e);
    let parsed = expressions.iter().enumerate().map(parse).collect();
    frame.keep_paths(PathClasses::new(parsed).expect("layers"));
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let Value::Object(p) = p else { panic!("an object") };
    let mut method = (registry::find(method).expect("known").make)(&p).expect("parameters");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut means = vec![RunningMean::new(); expressions.len() + 1];
    for index in 0..passes {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
        for (k, mean) in means.iter_mut().enumerate() {
            let at = k.checked_sub(1).map_or(0, |k| image.layers().path_offset(k));
            let pixels = image.data().chunks(image.layers().stride());
            let grey = pixels.map(|p| f64::from(p[at] + p[at + 1] + p[at + 2]) / 3.0);
            mean.push(grey.sum());
        }
    }
    means
}

/// Every kind of scattering there is, under every kind of light.
pub(crate) fn all_kinds() -> Stage {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.22), at(0.5, -0.3, 0.23), glass);
    let frosted = stage.glass(1.4, 0.3);
    stage.shape(sphere(0.2), at(0.05, 0.35, 0.21), frosted);
    let (white, half) = (stage.diffuse(0.6), stage.d.float(0.5));
    let two_sided = stage.two_sided(white);
    let mask = stage.material(MaterialModel::Mask { material: two_sided, opacity: half });
    stage.shape(GeometryDesc::Rectangle, at(-0.4, -0.4, 0.7) * scale(0.3, 0.3, 1.0), mask);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    if let Some(lamp) = stage.d.shapes.last_mut() {
        lamp.name = "key".into();
    }
    stage.sky(0.2);
    stage
}

/// Classes that part all paths among them.
const PARTITION: [&str; 6] = ["C.", "C<RD>.", "C<RD>.{2,}", "C<R[GS]>.+", "C<T.>.*[LB]", "CV.+"];

#[test]
fn classes_that_part_the_paths_add_up_to_the_picture() {
    let scene = all_kinds().build();
    for method in ["path", "bdpt", "vcm", "vpl", "mlt", "erpt"] {
        let p = json!({"max_depth": 5});
        // Starts of short chains are few, and few of them lie in glass.
        let passes = if method == "erpt" { 60 } else { 6 };
        let l = layers(&scene, method, p, &PARTITION, passes, 3000);
        let sum: f64 = l[1..].iter().map(RunningMean::mean).sum();
        close(method, sum, l[0].mean(), 1e-4);
        let means: Vec<f64> = l[1..6].iter().map(RunningMean::mean).collect();
        assert!(means.iter().all(|m| *m > 0.0), "{method} {means:?}");
        assert_eq!(l[6].mean(), 0.0, "no media");
    }
}

#[test]
fn methods_agree_layer_by_layer() {
    let scene = all_kinds().build();
    let expressions = [
        "CL",
        "C<RD>L",
        "C<R[GS]>L",
        "C<RD>.+L",
        "LDE",
        "LDDE",
        "L(D|S)*DE",
        "LS+DE",
        "C<T.>.*L",
        "C.*<L.'key'>",
        "C.*<TG>.*L",
        "C.*B",
    ];
    let p = json!({"max_depth": 4});
    let path = layers(&scene, "path", p.clone(), &expressions, 1500, 3010);
    let bdpt = layers(&scene, "bdpt", p, &expressions, 500, 3011);
    let p = json!({"max_depth": 4, "radius": 0.004});
    // Passes of shrinking radius: the mean over independent renders.
    let mut vcm = vec![RunningMean::new(); expressions.len() + 1];
    for k in 0..10 {
        let one = layers(&scene, "vcm", p.clone(), &expressions, 20, 3020 + k);
        vcm.iter_mut().zip(one).for_each(|(all, one)| all.push(one.mean()));
    }
    let p = json!({"max_depth": 4, "chains": 96, "bootstrap": 20_000, "brightness_error": 1.0});
    let mut mlt = vec![RunningMean::new(); expressions.len() + 1];
    for k in 0..10 {
        let one = layers(&scene, "mlt", p.clone(), &expressions, 30, 3030 + k);
        mlt.iter_mut().zip(one).for_each(|(all, one)| all.push(one.mean()));
    }
    let p = json!({"max_depth": 4, "paths": 8});
    let vpl = layers(&scene, "vpl", p, &expressions, 800, 3012);
    for (i, path) in path.iter().enumerate() {
        let what = if i == 0 { "picture" } else { expressions[i - 1] };
        assert!(path.mean() > 0.0, "{what}");
        same(&format!("bdpt, {what}"), &bdpt[i], path);
        same(&format!("vpl, {what}"), &vpl[i], path);
        same(&format!("vcm, {what}"), &vcm[i], path);
        same(&format!("mlt, {what}"), &mlt[i], path);
    }
}

#[test]
fn light_tracing_is_a_layer_of_path_tracing() {
    let scene = all_kinds().build();
    // What the lens can be connected to.
    let seen = ["C[<.D><.G>].*L", "LDE", "L(D|S)+DE", "C<RD><RD>L", "C<.G>L"];
    let path = layers(&scene, "path", json!({"max_depth": 3}), &seen, 2500, 3030);
    let light = layers(&scene, "light", json!({"max_depth": 3}), &seen, 2500, 3031);
    same("all that light tracing sees", &light[0], &path[1]);
    for i in 1..=seen.len() {
        same(seen[i - 1], &light[i], &path[i]);
    }
}

#[test]
fn layers_of_bounces_are_those_of_the_depth() {
    let mut stage = room();
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    let plain = stage.build();
    let l = layers(&plain, "path", json!({"max_depth": 2}), &["CL", "C.L", "C..L"], 800, 3040);
    for depth in 0..3u64 {
        let p = json!({"only_depth": depth});
        let only = layers(&plain, "path", p, &[], 800, 3041 + depth);
        same(&format!("{depth} bounces"), &l[depth as usize + 1], &only[0]);
    }
}

#[test]
fn fog_has_its_layers() {
    let mut stage = all_kinds();
    filled(&mut stage, GeometryDesc::Cube, at(0.0, 0.0, 1.0) * scale(0.95, 0.95, 0.95), {
        medium(Form::Dense, 0.5, 0.8, hg(0.3))
    });
    let scene = stage.build();
    let expressions = ["C.*", "CVL", "CV.+L", "C<RD>L", "C<RD>V.*L", "C.*V.*L", "C[^V]*L"];
    let p = json!({"max_depth": 4});
    let path = layers(&scene, "path", p.clone(), &expressions, 1500, 3050);
    let bdpt = layers(&scene, "bdpt", p, &expressions, 600, 3051);
    close("all", path[1].mean(), path[0].mean(), 1e-4);
    close("with and without", path[6].mean() + path[7].mean(), path[0].mean(), 1e-4);
    for i in 0..path.len() {
        let what = if i == 0 { "picture" } else { expressions[i - 1] };
        assert!(path[i].mean() > 0.0, "{what}");
        same(what, &bdpt[i], &path[i]);
    }
}

#[test]
fn methods_that_know_no_classes_say_so() {
    let scene = all_kinds().build();
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let layer = PathLayer::parse("all=C.*").expect("sound");
    frame.keep_paths(PathClasses::new(vec![layer]).expect("one layer"));
    let workers = Workers::new(1, Arc::default()).expect("a thread");
    for entry in registry::ALL {
        let method = (entry.make)(&serde_json::Map::new()).expect("defaults");
        let prepared = Session::new(&scene, &frame, method).prepare(&workers);
        assert_eq!(prepared.is_ok(), entry.info.layers, "{}", entry.info.name);
    }
}
