//! What moves while the shutter is open.

use crate::placing::stages;
use crate::scenes::*;
use crate::stats::{Random, agrees, same};
use kaustika_math::{Motion, Ray, Transform};
use kaustika_scene::description::*;
use serde_json::json;

/// Keys at the opening and the closing of the shutter.
fn keys(a: Transform, b: Transform) -> Vec<MotionKey> {
    vec![MotionKey { time: 0.0, transform: a }, MotionKey { time: 1.0, transform: b }]
}

/// A black disk of radius 0.5 before a white sky, seen in parallel projection.
fn black_disk(disk_motion: Vec<MotionKey>, camera_motion: Vec<MotionKey>) -> Stage {
    let mut stage = Stage::new();
    stage.sky(1.0);
    let black = stage.diffuse(0.0);
    stage
        .d
        .groups
        .push(GroupDesc { name: String::new(), shapes: vec![shape(disk(0.5), HERE, black)] });
    let (transform, span) = (at(-0.75, 0.0, 2.0), None);
    let instance = InstanceDesc { group: GroupId(0), transform, motion: disk_motion, span };
    stage.d.instances.push(instance);
    stage.camera(parallel(2.0, 0.0, 1.0), HERE, [16, 16]);
    stage.d.cameras[0].shutter = [0.0, 1.0];
    stage.d.cameras[0].motion = camera_motion;
    stage
}

/// Mean over a pixel of the share of time in which the disk, going from x = -0.75 to x = 0.75,
/// does not cover a point: |[x-h, x+h] ∩ [-0.75, 0.75]| / 1.5 is covered, h = √(0.25 - y²).
fn uncovered(px: u32, py: u32) -> f64 {
    const N: u32 = 200;
    let mut sum = 0.0;
    for i in 0..N * N {
        let sub = |p: u32, k: u32| (f64::from(p) + (f64::from(k) + 0.5) / f64::from(N)) / 4.0 - 2.0;
        let (x, y) = (sub(px, i % N), sub(py, i / N));
        let h = (0.25 - y * y).max(0.0).sqrt();
        sum += 1.0 - ((x + h).min(0.75) - (x - h).max(-0.75)).max(0.0) / 1.5;
    }
    sum / f64::from(N * N)
}

#[test]
fn a_moving_disk_covers_its_share_of_time() {
    let moving = keys(at(-0.75, 0.0, 2.0), at(0.75, 0.0, 2.0));
    let picture = black_disk(moving, Vec::new()).render(json!({"max_depth": 1}), 3000, 1);
    for y in 0..16 {
        for x in 0..16 {
            agrees(&format!("pixel {x} {y}"), picture.at(x, y), uncovered(x, y));
        }
    }
}

#[test]
fn a_camera_that_moves_sees_what_moves_the_other_way() {
    let still = keys(at(0.0, 0.0, 2.0), at(0.0, 0.0, 2.0));
    let moving = keys(at(0.75, 0.0, 0.0), at(-0.75, 0.0, 0.0));
    let picture = black_disk(still, moving).render(json!({"max_depth": 1}), 3000, 2);
    for y in 0..16 {
        for x in 0..16 {
            agrees(&format!("pixel {x} {y}"), picture.at(x, y), uncovered(x, y));
        }
    }
}

#[test]
fn a_shutter_open_for_no_time_sees_what_stands_there_then() {
    let moving = keys(at(-0.75, 0.0, 2.0), at(0.75, 0.0, 2.0));
    let mut stage = black_disk(moving, Vec::new());
    stage.d.cameras[0].shutter = [0.5, 0.5];
    let mut still = black_disk(Vec::new(), Vec::new());
    still.d.instances[0].transform = at(0.0, 0.0, 2.0);
    let [a, b] = [stage, still].map(|s| s.render(json!({"max_depth": 1}), 20, 3));
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        assert_eq!(a.mean(), b.mean());
    }
}

/// From turn to turn and from size to size.
fn moving_stage() -> (Stage, Vec<(Transform, Transform)>) {
    let (_, mut stage) = stages();
    let mut ends = Vec::new();
    for (i, instance) in stage.d.instances.iter_mut().enumerate() {
        let a = instance.transform;
        let turn = rotate(70.0 + 40.0 * i as f32, v(0.3, 1.0 - i as f32, 1.0));
        let b = at(0.2, 0.1 * i as f32, 0.15) * a * turn * scale(1.0, 0.7, 1.2);
        ends.push((a, b));
        instance.motion = keys(a, b);
    }
    stage.d.cameras[0].shutter = [0.0, 1.0];
    (stage, ends)
}

/// The same scene, standing still as it does at `time`.
fn frozen(stage: &Stage, ends: &[(Transform, Transform)], time: f32) -> Stage {
    let mut still = stage.clone();
    for (instance, (a, b)) in still.d.instances.iter_mut().zip(ends) {
        instance.motion = Vec::new();
        instance.transform = Motion::new(&[(0.0, *a), (1.0, *b)]).expect("a motion").at(time);
    }
    still
}

#[test]
fn at_each_time_surfaces_are_those_of_the_scene_standing_still() {
    let (stage, ends) = moving_stage();
    let moving = stage.build();
    let mut random = Random::new(11);
    let mut met = 0;
    for i in 0..12 {
        let time = i as f32 / 11.0;
        let still = frozen(&stage, &ends, time).build();
        for _ in 0..2000 {
            let o = v(0.0, 0.3, 0.5) + random.v3().normalize() * 3.0;
            let target = v(0.0, 0.3, 0.3) + random.v3();
            let ray = Ray { time, ..Ray::new(o, (target - o).normalize()) };
            let all = |s: &kaustika_scene::Scene| {
                let hit = s.geometry.intersect(&ray, f32::INFINITY, |_, _| true)?;
                let surface = s.geometry.surface(&hit, &ray);
                Some((surface, s.geometry.tangents(&surface)))
            };
            let occluded = |s: &kaustika_scene::Scene| s.geometry.occluded(&ray, 2.9, |_, _| true);
            match (all(&moving), all(&still)) {
                (None, None) => {}
                (Some((a, ta)), Some((b, tb))) if (a.t - b.t).abs() < 1e-4 => {
                    met += 1;
                    assert!(a.ng.dot(b.ng) > 0.9999 && (a.p - b.p).length() < 1e-4);
                    let pole = tb.0.length() < 0.02;
                    assert!(pole || (ta.0 - tb.0).length() < 1e-2 * tb.0.length());
                    if (a.t - 2.9).abs() > 1e-3 {
                        assert_eq!(occluded(&moving), occluded(&still));
                    }
                }
                // Rounding decides at edges.
                (a, b) => {
                    let both = [a, b];
                    let edge = both.iter().flatten().any(|(s, _)| {
                        let near = |c: f32| !(2e-3..=1.0 - 2e-3).contains(&c);
                        s.ng.abs_dot(ray.d) < 0.02 || near(s.uv.x) || near(s.uv.y)
                    });
                    assert!(edge, "{both:?}");
                }
            }
        }
    }
    assert!(met > 8000, "{met}");
}

#[test]
fn a_picture_is_the_mean_of_pictures_standing_still() {
    let (stage, ends) = moving_stage();
    let p = json!({"max_depth": 3});
    let moving = stage.render(p.clone(), 600, 1);
    // Many times, evenly: what remains between them is far below the noise.
    let times = 60;
    let still: Vec<Picture> = (0..times)
        .map(|i| {
            frozen(&stage, &ends, (i as f32 + 0.5) / times as f32).render(p.clone(), 10, 100 + i)
        })
        .collect();
    for i in 0..moving.pixels.len() {
        let n = f64::from(times as u32);
        let mean = still.iter().map(|s| s.pixels[i].mean()).sum::<f64>() / n;
        let variance: f64 = still.iter().map(|s| s.pixels[i].standard_error().powi(2)).sum();
        let together = with_error(mean, variance.sqrt() / n);
        same(&format!("pixel {i}"), &moving.pixels[i], &together);
    }
}

#[test]
fn what_moves_nowhere_is_what_stands_still() {
    let (_, still) = stages();
    let mut kept = still.clone();
    for instance in &mut kept.d.instances {
        instance.motion = keys(instance.transform, instance.transform);
    }
    let [a, b] = [still, kept].map(|s| s.render(json!({"max_depth": 4}), 8, 5));
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        assert_eq!(a.mean(), b.mean());
    }
}
