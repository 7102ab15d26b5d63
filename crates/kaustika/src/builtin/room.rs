//! The room of the built-in scene: walls, floor, niche and lights.

use super::niche::Niche;
use super::pattern;
use super::stage::Stage;
use kaustika_math::{Affine2, Transform, Vec2, Vec3};
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, EmissionDesc, GeometryDesc, MaterialId,
    MaterialModel, TextureMapping, TextureNode, TriMesh, Wrap,
};
use kaustika_spectra::ColorSpace;
use std::sync::Arc;

/// Half the width of the room.
const HALF_WIDTH: f32 = 1.9;
/// From floor to ceiling.
const HEIGHT: f32 = 2.8;
/// z of the wall with the niche and of the one behind the camera.
const DEPTH: [f32; 2] = [-1.5, 5.6];
/// What the pedestal stands before.
pub const NICHE: Niche = Niche { center: 0.62, half_width: 0.68, spring: 1.25, depth: 0.45 };

/// Adds the room to the stage.
pub fn build(stage: &mut Stage) {
    let plaster = stage.diffuse("plaster", [0.76, 0.73, 0.68]);
    let terracotta = stage.diffuse("terracotta wall", [0.62, 0.17, 0.07]);
    let teal = stage.diffuse("teal wall", [0.045, 0.26, 0.31]);
    let floor = terrazzo(stage);

    let (w, [back, front]) = (HALF_WIDTH, DEPTH);
    let length = front - back;
    let (across, along, up) = (Vec3::X * (2.0 * w), Vec3::Z * length, Vec3::Y * HEIGHT);
    let near_left = Vec3::new(-w, 0.0, front);
    let far_right = Vec3::new(w, 0.0, back);
    let mut wall = |name: &str, material: MaterialId, corner: Vec3, u: Vec3, v: Vec3| {
        stage.mesh(name, material, quad(corner, u, v), Transform::IDENTITY);
    };
    wall("floor", floor, near_left, across, -along);
    wall("ceiling", plaster, near_left + up, -along, across);
    wall("left wall", terracotta, near_left, -along, up);
    wall("right wall", teal, far_right, along, up);
    wall("wall behind the camera", plaster, far_right + along, -across, up);
    let niche_back = Vec3::new(NICHE.center - NICHE.half_width, 0.0, back - NICHE.depth);
    let niche_width = Vec3::X * (2.0 * NICHE.half_width);
    let niche_up = Vec3::Y * (NICHE.spring + NICHE.half_width);
    wall("back of the niche", teal, niche_back, niche_width, niche_up);
    wall(
        "floor of the niche",
        floor,
        Vec3::new(niche_back.x, 0.0, back),
        niche_width,
        -Vec3::Z * NICHE.depth,
    );
    let place = Transform::translate(Vec3::new(0.0, 0.0, back));
    stage.mesh("niche wall", plaster, NICHE.wall([-w, w], HEIGHT), place);
    stage.mesh("niche reveal", teal, NICHE.reveal(), place);

    // The key light, high on the left and a little behind, so that glass throws its caustics to
    // the right and towards the viewer; a weak broad one behind the camera lifts the shadows.
    let target = Vec3::new(0.0, 0.2, 0.1);
    lamp(stage, "softbox", Vec3::new(-1.25, 2.62, -0.35), target, [1.1, 1.1], [10.5, 9.6, 8.3]);
    let target = Vec3::new(0.0, 0.6, 0.0);
    lamp(stage, "fill", Vec3::new(0.5, 2.4, 5.0), target, [2.6, 1.2], [0.75, 0.85, 1.0]);
}

/// The parallelogram at `corner`, front along u x v.
fn quad(corner: Vec3, u: Vec3, v: Vec3) -> TriMesh {
    let n = u.cross(v).normalize();
    TriMesh {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        normals: vec![n; 4],
        uvs: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec2::new(u, v)).into(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    }
}

/// A rectangle of `size` at `at` that shines towards `target`.
fn lamp(stage: &mut Stage, name: &str, at: Vec3, target: Vec3, size: [f32; 2], radiance: [f32; 3]) {
    let black = stage.diffuse(format!("{name} housing"), [0.0; 3]);
    let radiance = stage.scene.rgb(radiance);
    let turn = Transform::look_at(at, target, Vec3::Y).expect("lamps do not shine straight down");
    let size = Transform::scale(Vec3::new(0.5 * size[0], 0.5 * size[1], 1.0))
        .expect("the sizes of lamps are not zero");
    let shape = stage.shape(name, black, GeometryDesc::Rectangle, turn.then_after(&size));
    shape.emission =
        Some(EmissionDesc { radiance, scale: 1.0, power: None, two_sided: false, span: None });
}

/// Polished terrazzo in tiles of the picture, 1.6 units wide.
fn terrazzo(stage: &mut Stage) -> MaterialId {
    let repeat = (2.0 * HALF_WIDTH / 1.6, (DEPTH[1] - DEPTH[0]) / 1.6);
    let texture = BitmapTexture {
        bitmap: Arc::new(pattern::terrazzo(1024)),
        channels: BitmapChannels::Color,
        filter: BitmapFilter::Trilinear,
        wrap: [Wrap::Repeat; 2],
        mapping: TextureMapping::Uv(Affine2::scale_shift(repeat.0, repeat.1, 0.13, 0.0)),
        scale: 1.0,
        invert: false,
        raw: false,
        space: ColorSpace::Srgb,
    };
    let stones = stage.scene.add_texture(TextureNode::Bitmap(texture), None);
    let model = MaterialModel::Plastic {
        diffuse_reflectance: stones,
        specular_reflectance: stage.scene.float(1.0),
        ior: 1.5,
        nonlinear: false,
        roughness: Some(stage.roughness(0.12, 0.12)),
    };
    stage.scene.add_material("terrazzo", model, None)
}
