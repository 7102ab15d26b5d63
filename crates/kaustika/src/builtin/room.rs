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
const HALF_WIDTH: f32 = 1.72;
/// From floor to ceiling.
const HEIGHT: f32 = 3.4;
/// z of the wall with the niche and of the one behind the camera.
const DEPTH: [f32; 2] = [-1.5, 5.6];
/// What the pedestal stands before.
pub const NICHE: Niche = Niche { center: 0.62, half_width: 0.64, spring: 1.13, depth: 0.45 };

/// Adds the room to the stage.
pub fn build(stage: &mut Stage) {
    let plaster = stage.diffuse("plaster", [0.76, 0.73, 0.68]);
    let terracotta = stage.diffuse("terracotta wall", [0.66, 0.17, 0.065]);
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

    // The key light, high on the left and behind: glass throws its caustics to the right and
    // towards the viewer. A broad panel in the ceiling, out of the picture, lifts the shadows.
    let key = Lamp {
        at: Vec3::new(-0.82, 2.68, -0.72),
        target: Vec3::new(0.1, 0.8, 1.6),
        up: Vec3::Y,
        size: [1.6, 1.5],
        radiance: [10.4, 9.0, 7.2],
    };
    key.hang(stage, "softbox");
    let panel = Lamp {
        at: Vec3::new(0.2, HEIGHT - 0.02, 1.9),
        target: Vec3::new(0.2, 0.0, 1.9),
        up: Vec3::Z,
        size: [2.8, 2.8],
        radiance: [2.7, 2.95, 3.3],
    };
    panel.hang(stage, "ceiling panel");
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

/// A rectangle that shines to one side.
struct Lamp {
    /// Its middle.
    at: Vec3,
    /// Where it shines to.
    target: Vec3,
    /// Across `target - at`; its second side is near this direction.
    up: Vec3,
    /// Its sides.
    size: [f32; 2],
    /// Radiance, linear sRGB.
    radiance: [f32; 3],
}

impl Lamp {
    fn hang(&self, stage: &mut Stage, name: &str) {
        let black = stage.diffuse(format!("{name} housing"), [0.0; 3]);
        let radiance = stage.scene.rgb(self.radiance);
        let turn = Transform::look_at(self.at, self.target, self.up)
            .expect("`up` is not along the light of a lamp");
        let [width, height] = self.size;
        let size = Transform::scale(Vec3::new(0.5 * width, 0.5 * height, 1.0))
            .expect("the sides of lamps are not zero");
        let place = turn.then_after(&size);
        let shape = stage.shape(name, black, GeometryDesc::Rectangle, place);
        shape.emission = Some(EmissionDesc {
            radiance,
            scale: 1.0,
            power: None,
            two_sided: false,
            along_normal: false,
            span: None,
        });
    }
}

/// Polished terrazzo in tiles of the picture, 1.15 units wide.
fn terrazzo(stage: &mut Stage) -> MaterialId {
    let repeat = (2.0 * HALF_WIDTH / 1.15, (DEPTH[1] - DEPTH[0]) / 1.15);
    let texture = BitmapTexture {
        bitmap: Arc::new(pattern::terrazzo(512)),
        channels: BitmapChannels::Color,
        filter: BitmapFilter::Bilinear,
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
