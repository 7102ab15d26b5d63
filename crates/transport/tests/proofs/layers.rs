//! The metallic-roughness model and what only glTF asks of textures, as parts of a scene.

use crate::scenes::*;
use crate::stats::close;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use serde_json::json;
use std::f64::consts::PI;
use std::sync::Arc;

/// A white dielectric without reflection: Lambert's.
fn matte(stage: &mut Stage) -> MetallicRoughnessDesc {
    let (zero, one) = (stage.d.float(0.0), stage.d.float(1.0));
    MetallicRoughnessDesc {
        base_color: one,
        metallic: zero,
        roughness: one,
        ior: IorDesc::Constant(1.5),
        specular: zero,
        specular_color: one,
        anisotropy: None,
        sheen: None,
        clearcoat: None,
        transmission: None,
        diffuse_transmission: None,
        volume: None,
        iridescence: None,
    }
}

fn add(stage: &mut Stage, desc: MetallicRoughnessDesc) -> MaterialId {
    stage.material(MaterialModel::MetallicRoughness(Box::new(desc)))
}

/// Beer's law through a box of index 1 under a sky of 1: color^(thickness/distance).
#[test]
fn solids_absorb_along_the_way() {
    for thickness in [0.5f32, 1.0, 3.0] {
        let mut stage = Stage::new();
        let plain = matte(&mut stage);
        let attenuation_color = stage.d.float(0.25);
        let desc = MetallicRoughnessDesc {
            ior: IorDesc::Constant(1.0),
            roughness: stage.d.float(0.0),
            transmission: Some(stage.d.float(1.0)),
            volume: Some(VolumeDesc { attenuation_color, attenuation_distance: 2.0 }),
            ..plain
        };
        let m = add(&mut stage, desc);
        stage.shape(GeometryDesc::Cube, scale(1.0, 1.0, 0.5 * thickness), m);
        stage.sky(1.0);
        // No luck but the facets': what is left is the same for nearly every path.
        let p = json!({"roulette": "none"});
        let seen = stage.probe(v(0.1, 0.2, -5.0), Vec3::Z, p, 2000).mean();
        let truth = 0.25f64.powf(f64::from(thickness) / 2.0);
        close(&format!("through {thickness}"), seen, truth, 2e-3);
    }
}

/// A square in z = 0 whose u runs along -x if `mirrored`, under light along the normal that its
/// map has.
fn tilted(mirrored: bool, space: TangentSpace) -> f64 {
    let (sin, cos) = 0.5f32.sin_cos();
    let mut stage = Stage::new();
    let desc = matte(&mut stage);
    let material = add(&mut stage, desc);
    // Half the tilt in the map and a scale of tan θ / tan θ/2 make the whole.
    let (sx, cx) = (0.5 * (sin / cos / space.scale).atan()).sin_cos();
    let (y, z) = (2.0 * sx * cx, cx * cx - sx * sx);
    let rgb = [0.5, 0.5 + 0.5 * y, 0.5 + 0.5 * z];
    let color = SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb };
    let normals = stage.d.add_texture(TextureNode::Spectrum(color), None);
    let m = stage.material(MaterialModel::NormalMap { material, normals, space });
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let uv = |(x, y): (f32, f32)| kaustika_math::Vec2::new(if mirrored { -x } else { x }, y);
    let square = TriMesh {
        positions: corners.map(|(x, y)| v(x, y, 0.0)).to_vec(),
        uvs: corners.map(uv).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    };
    stage.shape(GeometryDesc::Mesh(Arc::new(square)), HERE, m);
    let toward = v(0.0, sin, cos);
    let place = kaustika_math::Transform::look_at(toward, Vec3::ZERO, Vec3::X).expect("a frame");
    let (irradiance, scale) = (grey(1.0), PI as f32);
    stage.light(LightKind::Directional { irradiance, scale, illuminance: None }, place);
    stage.probe(v(0.1, 0.2, 5.0), -Vec3::Z, json!({"max_depth": 1}), 200).mean()
}

/// A normal map's y follows v where the space says so, whatever u does: light along the normal
/// has the full irradiance π, radiance 1; on the other side of the tilt it is cos 2θ.
#[test]
fn normal_maps_follow_v() {
    for scale in [1.0, 2.0] {
        for mirrored in [false, true] {
            let space = TangentSpace { scale, follows_v: true };
            close(&format!("{mirrored}, {scale}"), tilted(mirrored, space), 1.0, 1e-4);
        }
    }
    let right_handed = TangentSpace::default();
    close("right-handed", tilted(false, right_handed), 1.0, 1e-4);
    close("right-handed, mirrored", tilted(true, right_handed), 1f64.cos(), 1e-4);
}

/// A lamp that shows the right half of a picture by its second coordinates, and steps of it.
#[test]
fn second_coordinates_and_steps() {
    let seen = |step: Option<f32>| {
        let mut stage = Stage::new();
        let picture = TextureNode::Bitmap(BitmapTexture {
            bitmap: bitmap(2, 1, |x, _| [if x < 0.5 { 0.25 } else { 0.75 }; 3]),
            channels: BitmapChannels::Color,
            filter: BitmapFilter::Nearest,
            wrap: [Wrap::Clamp; 2],
            mapping: TextureMapping::default(),
            scale: 1.0,
            invert: false,
            raw: false,
            space: ColorSpace::Srgb,
        });
        let texture = stage.d.add_texture(picture, None);
        let attribute = "uv1".into();
        let mut shown = stage.d.add_texture(TextureNode::WithUv { texture, attribute }, None);
        if let Some(threshold) = step {
            shown = stage.d.add_texture(TextureNode::Step { texture: shown, threshold }, None);
        }
        let mesh = TriMesh {
            positions: vec![v(-9.0, -9.0, 2.0), v(9.0, -9.0, 2.0), v(0.0, 9.0, 2.0)],
            uvs: vec![kaustika_math::Vec2::new(0.25, 0.5); 3],
            indices: vec![[0, 2, 1]],
            attributes: vec![MeshAttribute {
                name: "uv1".into(),
                channels: 3,
                per_face: false,
                values: [0.7, 0.5, 0.0].repeat(3),
            }],
            ..TriMesh::default()
        };
        let lamp = stage.lamp(GeometryDesc::Mesh(Arc::new(mesh)), HERE, 1.0);
        lamp.emission.as_mut().expect("a lamp").radiance = shown;
        stage.probe(Vec3::ZERO, Vec3::Z, json!({}), 10).mean()
    };
    close("second coordinates", seen(None), 0.75, 1e-6);
    close("above the step", seen(Some(0.5)), 1.0, 1e-6);
    assert_eq!(seen(Some(0.8)), 0.0, "below the step");
}
