//! One shader, the same light: materials that are composed of textures and lobes look alike to every method,
//! and that is what their BSDF says.

use crate::ray_trees::one;
use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_math::{Affine2, Ray, Vec3};
use kaustika_scene::Scene;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::*;
use kaustika_spectra::Wavelengths;
use serde_json::json;

/// Adds a material to a stage.
type Shader = fn(&mut Stage) -> MaterialId;

const LAMP: Vec3 = Vec3::new(0.7, -0.5, 1.6);
const INTENSITY: f32 = 3.0;
/// From where surfaces are seen.
const WO: Vec3 = Vec3::new(0.3, -0.5, 1.0);

/// Squares of two textures, an eighth of a rectangle wide.
fn squares(stage: &mut Stage, a: TextureId, b: TextureId) -> TextureId {
    let mapping = TextureMapping::Uv(Affine2::scale_shift(4.0, 4.0, 0.0, 0.0));
    stage.d.add_texture(TextureNode::Checkerboard { a, b, mapping }, None)
}

/// Turbulence, times a colour.
fn noise(stage: &mut Stage) -> TextureId {
    let texture = stage.d.add_texture(
        TextureNode::Noise {
            kind: NoiseKind::Wrinkled,
            octaves: 4,
            roughness: 0.5,
            scale: 1.0,
            variation: 0.0,
            to_texture: scale(2.0, 2.0, 2.0),
        },
        None,
    );
    let color = stage.d.rgb([0.8, 0.5, 0.3]);
    stage.d.add_texture(TextureNode::Scale { texture, scale: color }, None)
}

/// A matte procedure: noise in squares of another colour.
fn matte(stage: &mut Stage) -> MaterialId {
    let (noise, plain) = (noise(stage), stage.d.rgb([0.1, 0.4, 0.6]));
    let reflectance = squares(stage, noise, plain);
    stage.material(MaterialModel::Diffuse { reflectance })
}

/// Two matte procedures, blended as noise says.
fn blend(stage: &mut Stage) -> MaterialId {
    let (a, b, amount) = (matte(stage), stage.diffuse(0.7), noise(stage));
    stage.material(MaterialModel::Mix { a, b, amount })
}

/// Phong's lobe on a matte base.
fn phong(stage: &mut Stage) -> MaterialId {
    let [d, s, n] = [0.4, 0.3, 25.0].map(|x| stage.d.float(x));
    stage.material(MaterialModel::Phong {
        diffuse_reflectance: d,
        specular_reflectance: s,
        exponent: n,
    })
}

/// Phong's lobe on a matte procedure: a lacquer that the z-buffer has too.
fn lacquer(stage: &mut Stage) -> MaterialId {
    let (noise, plain) = (noise(stage), stage.d.rgb([0.1, 0.4, 0.6]));
    let diffuse_reflectance = squares(stage, noise, plain);
    let [specular_reflectance, exponent] = [0.2, 25.0].map(|x| stage.d.float(x));
    stage.material(MaterialModel::Phong { diffuse_reflectance, specular_reflectance, exponent })
}

/// Varnish over a procedure, blended with rough metal in squares.
fn varnish(stage: &mut Stage) -> MaterialId {
    let (base, one) = (noise(stage), stage.d.float(1.0));
    let a = stage.material(MaterialModel::Plastic {
        diffuse_reflectance: base,
        specular_reflectance: one,
        ior: 1.5,
        nonlinear: true,
        roughness: None,
    });
    let (b, much, little) = (stage.metal(0.3), stage.d.float(0.8), stage.d.float(0.2));
    let amount = squares(stage, much, little);
    stage.material(MaterialModel::Mix { a, b, amount })
}

/// What the BSDF itself sends on of the lamp's light.
fn by_hand(scene: &Scene) -> f64 {
    let ray = scene.camera.sample_we(v2(0.5, 0.5), v2(0.5, 0.5), 0.0).ray;
    let s = scene.intersect(&ray, f32::INFINITY).expect("the rectangle");
    let to_lamp = LAMP - s.p;
    let bsdf = scene.bsdf(&s, -ray.d, &mut Wavelengths::rgb()).expect("a material");
    let f = bsdf.eval(-ray.d, to_lamp.normalize(), Mode::Radiance, Lobes::ALL);
    f64::from(f[0] * INTENSITY / to_lamp.length_squared())
}

#[test]
fn one_shader_looks_the_same_to_every_method() {
    // The z-buffer's models know matte materials and Phong's; rays ask all.
    let all = &["zbuffer", "whitted", "distributed", "path", "bdpt"][..];
    let shaders: [(&str, Shader, &[&str]); 5] = [
        ("matte", matte, all),
        ("blend", blend, all),
        ("phong", phong, all),
        ("lacquer", lacquer, all),
        ("varnish", varnish, &all[1..]),
    ];
    for (what, shader, methods) in shaders {
        let mut values = Vec::new();
        for i in 0..12 {
            // In the middles of squares and near them.
            let x = 0.25 + 0.5 * (i % 4) as f32 - 1.0 + 0.02 * i as f32;
            let p = v(x, 0.75 - 0.5 * (i / 4) as f32, 0.0);
            let mut stage = Stage::new();
            let m = shader(&mut stage);
            stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), m);
            stage.point_light(LAMP, INTENSITY);
            stage.camera(parallel(1e-6, 0.0, 1.0), look(p + WO, p), [1, 1]);
            let scene = stage.build();
            let truth = by_hand(&scene);
            for method in methods {
                let p = match *method {
                    "zbuffer" => json!({}),
                    _ => json!({"max_depth": 1}),
                };
                let found = one(&scene, method, p, 0).0;
                // Noise has creases of black.
                let off = (found - truth).abs();
                assert!(
                    off < 2e-3 * truth.max(0.1),
                    "{what}, place {i}, {method}: {found}, not {truth}"
                );
            }
            values.push(truth);
        }
        let [least, most] = [f64::min, f64::max].map(|f| values.iter().copied().fold(values[0], f));
        assert!(least > 0.0 && most > 1.3 * least, "{what} is about even: {values:?}");
    }
}

/// How much of the second of [`blend`] there is, as a colour.
fn amount(stage: &mut Stage) -> MaterialId {
    let reflectance = noise(stage);
    stage.material(MaterialModel::Diffuse { reflectance })
}

/// The albedo of a shader's BSDF at a place, seen from [`WO`].
fn albedo_at(shader: Shader, p: Vec3) -> [f64; 3] {
    let mut stage = Stage::new();
    let m = shader(&mut stage);
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), m);
    stage.sky(1.0);
    let scene = stage.build();
    let ray = Ray::new(p + WO, -WO.normalize());
    let s = scene.intersect(&ray, f32::INFINITY).expect("the rectangle");
    let bsdf = scene.bsdf(&s, -ray.d, &mut Wavelengths::rgb()).expect("a material");
    bsdf.albedo(-ray.d).rgb().map(f64::from)
}

/// In a white sky no composed shader gains light, and matte ones give back their albedo: of two that are blended, the
/// parts of each.
#[test]
fn composed_shaders_keep_the_furnace() {
    let shaders: [(&str, Shader); 5] = [
        ("matte", matte),
        ("blend", blend),
        ("phong", phong),
        ("lacquer", lacquer),
        ("varnish", varnish),
    ];
    for (what, shader) in shaders {
        let mut stage = Stage::new();
        let m = shader(&mut stage);
        stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), m);
        stage.sky(1.0);
        for i in 0..4 {
            let p = v(0.45 * i as f32 - 0.7, 0.2, 0.0);
            let l = stage.probe(p + WO, -WO, json!({"max_depth": 1}), 4000);
            assert!(l.mean() > 0.0 && l.mean() < 1.0 + 1e-3, "{what}: {}", l.mean());
            let a = albedo_at(matte, p)[0];
            let t = albedo_at(amount, p).iter().sum::<f64>() / 3.0;
            match what {
                "matte" => agrees(what, &l, a),
                "blend" => agrees(what, &l, (1.0 - t) * a + t * 0.7),
                _ => {}
            }
        }
    }
}

/// Brushed in circles, a disc has its highlight along one diameter: a bow-tie (Kajiya 1985), which turns with the
/// lamp, and each place's lobe with its tangents.
#[test]
fn a_brushed_disc_has_a_bow_tie() {
    let radiance = |place: f32, lamp: f32| {
        let mut stage = Stage::new();
        let [along, across, white] = [0.08, 0.4, 1.0].map(|x| stage.d.float(x));
        let roughness = RoughnessDesc {
            distribution: Distribution::Beckmann,
            alpha_u: along,
            alpha_v: across,
            remap: false,
        };
        let color = ConductorColor::Mirror;
        let brushed = MaterialModel::Conductor { color, specular_reflectance: white, roughness };
        let m = stage.material(brushed);
        stage.shape(disk(1.0), HERE, m);
        let from = rotate(lamp, Vec3::Z).vector(v(0.65, 0.0, 0.76));
        let kind = LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None };
        stage.light(kind, look(from, Vec3::ZERO));
        let p = rotate(place, Vec3::Z).vector(v(0.7, 0.0, 0.0));
        stage.camera(parallel(1e-4, 0.0, 1.0), look(p + Vec3::Z, p), [1, 1]);
        one(&stage.build(), "path", json!({"max_depth": 1}), 0).0
    };
    // Around the disc: tangents run along the circles, and the facets toward the lamp lie along its diameter.
    let values: Vec<f64> = (0..8).map(|k| radiance(45.0 * k as f32, 0.0)).collect();
    close("both wings", values[0], values[4], 1e-3);
    for aside in [1, 2, 3, 5, 6, 7] {
        assert!(values[aside] < 0.1 * values[0], "{values:?}");
    }
    for turn in [30.0, 77.0] {
        for place in [0.0, 20.0, 180.0] {
            let [here, turned] = [radiance(place, 0.0), radiance(place + turn, turn)];
            close(&format!("turned by {turn}"), turned, here, 2e-3);
        }
    }
}
