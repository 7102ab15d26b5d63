//! Closed furnaces: every surface emits Lₑ and reflects ρ, so L = Lₑ / (1 - ρ) everywhere, and
//! bounce k alone gives ρᵏ Lₑ (instrument FURN).

use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_scene::description::*;
use serde_json::json;

const RHO: f32 = 0.6;

/// The inside of a sphere or a cube, emitting 1 and reflecting ρ.
fn furnace(cube: bool, rho: f32) -> Stage {
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(rho), stage.emission(1.0));
    let form = if cube { GeometryDesc::Cube } else { sphere(1.0) };
    let s = stage.shape(form, HERE, m);
    (s.flip_normals, s.emission) = (true, Some(e));
    stage.camera(CameraKind::Spherical { equal_area: true }, at(0.2, -0.3, 0.1), [4, 4]);
    stage
}

#[test]
fn radiance_is_that_of_the_neumann_series_s_sum() {
    for cube in [false, true] {
        for mis in ["power", "bsdf", "light"] {
            let picture = furnace(cube, RHO).render(json!({"mis": mis}), 600, 1);
            agrees(&format!("cube {cube} {mis}"), &picture.mean(), 1.0 / (1.0 - RHO as f64));
        }
    }
}

#[test]
fn each_bounce_alone_is_a_power_of_the_albedo() {
    for cube in [false, true] {
        let stage = furnace(cube, RHO);
        let mut sum = 0.0;
        for k in 0..6 {
            let truth = (RHO as f64).powi(k);
            let term = |mis: &str| json!({"only_depth": k, "roulette": "none", "mis": mis});
            // BSDF samples alone carry ρᵏ without noise.
            let exact = stage.render(term("bsdf"), 4, 2);
            for p in &exact.pixels {
                close(&format!("cube {cube} bounce {k}"), p.mean(), truth, 1e-5);
            }
            agrees(
                &format!("cube {cube} bounce {k}"),
                &stage.render(term("power"), 100, 3).mean(),
                truth,
            );
            sum += exact.mean().mean();
        }
        let p = json!({"max_depth": 5, "roulette": "none", "mis": "bsdf"});
        close("sum of bounces", stage.render(p, 2, 4).mean().mean(), sum, 1e-5);
    }
}

#[test]
fn path_length_under_albedo_roulette() {
    // Rays traced a path follow a geometric law: mean 1/(1-ρ), variance ρ/(1-ρ)².
    let p = json!({"roulette": "albedo", "rr_depth": 0});
    let picture = furnace(false, RHO).render(p, 2000, 5);
    let paths = 16.0 * 2000.0;
    let (mean, rho) = (picture.rays as f64 / paths, RHO as f64);
    let error = rho.sqrt() / (1.0 - rho) / f64::sqrt(paths);
    agrees("mean path length", &with_error(mean, error), 1.0 / (1.0 - rho));
    agrees("radiance", &picture.mean(), 1.0 / (1.0 - rho));
}

#[test]
fn a_point_source_in_an_integrating_sphere() {
    // SPHERE: Φ at the centre; E = Φ/(4πr²) direct, over 1-ρ in all; B = ρE.
    let (phi, r) = (50.0f64, 2.5f64);
    let pi = std::f64::consts::PI;
    let mut stage = Stage::new();
    let m = stage.diffuse(RHO);
    stage.shape(sphere(r as f32), HERE, m).flip_normals = true;
    stage.point_light(v(0.0, 0.0, 0.0), (phi / (4.0 * pi)) as f32);
    stage.camera(CameraKind::Spherical { equal_area: false }, at(0.7, 0.3, -1.1), [4, 2]);
    let direct = RHO as f64 / pi * phi / (4.0 * pi * r * r);
    for k in 1..5 {
        let p = json!({"only_depth": k, "roulette": "none"});
        for pixel in &stage.render(p, 2, 6).pixels {
            close(&format!("bounce {k}"), pixel.mean(), direct * (RHO as f64).powi(k - 1), 2e-4);
        }
    }
    let all = stage.render(json!({"roulette": "albedo"}), 2000, 7).mean();
    close("total", all.mean(), direct / (1.0 - RHO as f64), 2e-2);
    agrees("total", &scaled(&all, 1.0), direct / (1.0 - RHO as f64));
}

#[test]
fn glass_inside_changes_nothing() {
    let mut stage = furnace(false, RHO);
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.3), at(0.2, 0.4, 0.1), glass);
    stage.shape(GeometryDesc::Cube, at(-0.4, -0.3, -0.2) * scale(0.15, 0.2, 0.1), glass);
    let picture = stage.render(json!({"rr_depth": 20}), 1500, 8);
    agrees("glass", &picture.mean(), 1.0 / (1.0 - RHO as f64));
}

#[test]
fn rough_glass_and_metal_lose_little_and_gain_nothing() {
    // One bounce off the facets is modelled; light that would bounce twice is lost: of a GGX
    // metal 3 % (α = 0.15) and 31 % (α = 0.5) at normal incidence.
    for (what, alpha, least) in [("glass", 0.15, 0.9), ("metal", 0.15, 0.9), ("metal", 0.5, 0.65)] {
        let mut stage = furnace(false, 0.0);
        let m = if what == "glass" { stage.glass(1.5, alpha) } else { stage.metal(alpha) };
        stage.shape(sphere(0.4), at(0.1, 0.0, 0.4), m);
        stage.camera(pinhole(50.0), look(v(0.1, 0.0, -0.5), v(0.1, 0.0, 0.4)), [4, 4]);
        let mean = stage.render(json!({"rr_depth": 50}), 1000, 9).mean();
        let room = 5.0 * mean.standard_error() + 1e-4;
        assert!(mean.mean() < 1.0 + room, "{what} {alpha}: gains, {}", mean.mean());
        assert!(mean.mean() > least - room, "{what} {alpha}: loses much, {}", mean.mean());
    }
}

#[test]
fn a_smooth_mirror_in_a_furnace_is_invisible() {
    let mut stage = furnace(false, 0.0);
    let m = stage.metal(0.0);
    stage.shape(sphere(0.3), at(0.2, -0.3, 0.5), m);
    for p in &stage.render(json!({"rr_depth": 50}), 8, 10).pixels {
        close("mirror", p.mean(), 1.0, 1e-5);
    }
}

#[test]
fn a_textured_furnace_gives_the_mean_albedo_s_result() {
    // In a sphere every point sees every other alike: irradiance is uniform whatever the
    // pattern, so mean radiance follows the mean albedo.
    let mut stage = furnace(false, 0.0);
    let (a, b) = (stage.d.float(0.2), stage.d.float(0.8));
    let mapping = TextureMapping::Uv(kaustika_math::Affine2::scale_shift(4.0, 0.0, 0.0, 0.25));
    let reflectance = stage.d.add_texture(TextureNode::Checkerboard { a, b, mapping }, None);
    let m = stage.material(MaterialModel::Diffuse { reflectance });
    stage.d.shapes[0].material = m;
    stage.camera(CameraKind::Spherical { equal_area: true }, HERE, [4, 4]);
    let mean = stage.render(json!({}), 1500, 11).mean();
    agrees("textured furnace", &mean, 1.0 / (1.0 - 0.5));
}
