//! Every sampler has the same mean.

use crate::scenes::*;
use crate::stats::same;
use kaustika_math::Vec3;
use kaustika_sampling::SamplerKind;
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::description::*;
use serde_json::json;

#[test]
fn means_agree() {
    // Runs of few samples a pixel with different seeds are independent, whatever correlation
    // there is within one.
    let mut stage = Stage::new();
    floor(&mut stage);
    let metal = stage.metal(0.2);
    stage.shape(sphere(0.4), at(0.3, 0.0, 0.4), metal);
    let grey = stage.diffuse(0.7);
    stage.shape(GeometryDesc::Cube, at(-0.6, 0.3, 0.3) * scale(0.3, 0.3, 0.3), grey);
    stage.lamp(disk(0.5), at(0.0, 0.0, 2.0) * down(), 3.0);
    stage.lamp(sphere(0.1), at(-1.0, -0.5, 0.8), 20.0);
    stage.sky(0.2);
    stage.camera(thin_lens(50.0, 0.1, 3.0), look(v(0.0, -3.0, 1.5), Vec3::ZERO), [6, 6]);
    let scene = stage.build();
    let mean = |kind| {
        let runs = (0..40u64).map(|seed| {
            render(&scene, [6, 6], json!({"max_depth": 6}), 4, 900 + seed, kind).mean().mean()
        });
        runs.collect::<RunningMean>()
    };
    let reference = mean(SamplerKind::Independent);
    for kind in SamplerKind::ALL {
        if kind != SamplerKind::Independent {
            let other = mean(kind);
            same(kind.name(), &other, &reference);
            // Stratified numbers are not worse than independent ones by more than chance.
            assert!(other.standard_error() < 1.7 * reference.standard_error(), "{kind}");
        }
    }
}
