//! The caustic in a cup: parallel light in half a cylinder that mirrors, on the floor below, in closed form;
//! and the same whatever it is kept in.
//!
//! ```text
//! P(φ) = (cos φ, sin φ),   D(φ) = -(cos 2φ, sin 2φ),   Q = P + s D                         (1)
//! E(Q) = E_⊥ sin α Σ_φ cos φ / |cos φ - 2 s|                                              (2)
//! caustic: s = cos φ / 2,   x = (3 cos φ - cos 3φ)/4,   y = (3 sin φ - sin 3φ)/4              (3)
//! ```
//!
//! Light goes along +x and falls at α; what meets the wall at a height of s tan α lands at Q. (3) is Huygens' nephroid,
//! with its cusp half way between axis and wall.

use crate::hybrid::pictures;
use crate::scenes::*;
use crate::stats::close;
use kaustika_math::Vec3;
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use serde_json::{Value, json};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [32, 32];
/// E_⊥, tan α and the albedo of the floor.
const ACROSS: f32 = 2.0;
const SLOPE: f32 = 0.5;
const RHO: f32 = 0.6;

/// Half a cylinder of radius and height 1 on a floor, lit from its open side; the eye above.
fn cup() -> Scene {
    let mut stage = Stage::new();
    let (mirror, white) = (stage.metal(0.0), stage.diffuse(RHO));
    let wall = GeometryDesc::Cylinder { radius: 1.0, z_min: 0.0, z_max: 1.0, phi_max: 180.0 };
    stage.shape(wall, rotate(-90.0, Vec3::Z), mirror).flip_normals = true;
    stage.shape(GeometryDesc::Rectangle, scale(1.2, 1.2, 1.0), white);
    let kind = LightKind::Directional { irradiance: grey(ACROSS), scale: 1.0, illuminance: None };
    stage.light(kind, look(Vec3::ZERO, v(1.0, 0.0, -SLOPE)));
    stage.camera(parallel(0.5, 0.0, 1.0), look(v(0.3, 0.0, 3.0), v(0.3, 0.0, 0.0)), SIZE);
    stage.build()
}

/// From a place on the floor to a place in the picture.
struct Floor {
    origin: [f64; 2],
    /// Along x and y, per pixel.
    step: [f64; 2],
}

impl Floor {
    fn new(scene: &Scene) -> Floor {
        let at = |x, y| scene.camera.sample_we(v2(x, y), v2(0.5, 0.5), 0.0).ray.o;
        let (a, b) = (at(0.0, 0.0), at(1.0, 1.0));
        let each = |f: fn(Vec3) -> f32| (f64::from(f(a)), f64::from(f(b) - f(a)));
        let ((x, dx), (y, dy)) = (each(|p| p.x), each(|p| p.y));
        Floor { origin: [x, y], step: [dx, dy] }
    }

    fn film(&self, q: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (q[k] - self.origin[k]) / self.step[k])
    }
}

/// The mean of (2) over each pixel.
fn truth(floor: &Floor) -> Vec<f64> {
    let n = 4000;
    let alpha = f64::from(SLOPE).atan();
    let mut sums = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
    for i in 0..n {
        let phi = ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * PI;
        // As far as it flies from the rim, or to the circle again.
        let far = (1.0 / f64::from(SLOPE)).min(2.0 * phi.cos());
        for j in 0..n {
            let s = far * (f64::from(j) + 0.5) / f64::from(n);
            let q = [phi.cos() - s * (2.0 * phi).cos(), phi.sin() - s * (2.0 * phi).sin()]; // (1)
            let [x, y] = floor.film(q);
            if x >= 0.0 && y >= 0.0 && x < f64::from(SIZE[0]) && y < f64::from(SIZE[1]) {
                let power = alpha.sin() * phi.cos() * far * PI / f64::from(n * n);
                sums[y as usize * SIZE[0] as usize + x as usize] += power;
            }
        }
    }
    let area = (floor.step[0] * floor.step[1]).abs();
    sums.iter().map(|power| f64::from(ACROSS) * power / area).collect()
}

/// Irradiance of each pixel, from radiance.
fn irradiance(picture: &[RunningMean]) -> Vec<f64> {
    picture.iter().map(|m| m.mean() * PI / f64::from(RHO)).collect()
}

/// Where each row is brightest, and where the nephroid crosses it.
fn crests<'p>(floor: &'p Floor, picture: &'p [f64]) -> impl Iterator<Item = [f64; 2]> + 'p {
    let crossing = |y: f64| {
        let phi = y.cbrt().asin(); // (3): y = sin³φ
        (3.0 * phi.cos() - (3.0 * phi).cos()) / 4.0
    };
    (0..SIZE[1]).filter_map(move |row| {
        let y = floor.origin[1] + (f64::from(row) + 0.5) * floor.step[1];
        let pixels = &picture[(row * SIZE[0]) as usize..][..SIZE[0] as usize];
        let brightest =
            (0..SIZE[0]).max_by(|a, b| pixels[*a as usize].total_cmp(&pixels[*b as usize]))?;
        // At the cusp the curve runs along the row.
        (y.abs() > 0.06).then(|| [f64::from(brightest) + 0.5, floor.film([crossing(y), y])[0]])
    })
}

/// Texels, photons and patches: a nephroid in all of them, and the light that geometry says.
#[test]
fn a_cup_has_its_nephroid_in_texels_photons_and_patches() {
    let scene = cup();
    let floor = Floor::new(&scene);
    let truth = truth(&floor);
    let sum: f64 = truth.iter().sum();
    let of = |terms: &str| {
        json!({"of": "LS_MDE", "terms": terms, "photons": 100_000, "radius": 0.015, "alpha": 1.0,
            "patches": 12_000})
    };
    let kept: [(&str, &str, Value); 3] = [
        // With light that comes straight, which is even.
        ("texels", "backward", json!({"photons": 200_000, "texel": 0.01, "max_depth": 2})),
        ("photons", "hybrid", of("photons@1:LS_MDE")),
        ("patches", "hybrid", of("radiosity@1:LS_MDE")),
    ];
    for (k, (what, method, p)) in kept.into_iter().enumerate() {
        let picture = pictures(&scene, (method, p), &[], (SIZE, 4, 2, 40 + k as u64));
        let mut found = irradiance(&picture[0]);
        if what == "texels" {
            let straight = f64::from(ACROSS) * f64::from(SLOPE).atan().sin();
            found.iter_mut().for_each(|e| *e -= straight);
        }
        let flux = found.iter().sum();
        // What lies beyond the edges of the picture blurs into it.
        close(&format!("flux in {what}"), flux, sum, 0.015);
        for [brightest, nephroid] in crests(&floor, &found) {
            let off = (brightest - nephroid).abs();
            assert!(off < 1.5, "{what}: brightest {off} pixels beside the nephroid");
        }
    }
    // The formula has its crest there too.
    assert!(crests(&floor, &truth).all(|[brightest, nephroid]| (brightest - nephroid).abs() < 1.0));
}
