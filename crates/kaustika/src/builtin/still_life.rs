//! What stands in the room of the built-in scene.

use super::knot::TorusKnot;
use super::lathe::lathe;
use super::pattern;
use super::room::NICHE;
use super::rounded_box::rounded_box;
use super::stage::Stage;
use kaustika_math::{Transform, Vec2, Vec3};
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, ConductorColor, IorDesc, MaterialId,
    MaterialModel, RoughnessDesc, TextureMapping, TextureNode, Wrap,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc, named};
use std::sync::Arc;

/// Adds the objects to the stage.
pub fn build(stage: &mut Stage) {
    knot_on_pedestal(stage);
    vase(stage);
    glass(stage);
    marbles(stage);
}

/// A brushed golden trefoil before the niche.
fn knot_on_pedestal(stage: &mut Stage) {
    let stone = stage.diffuse("limestone", [0.72, 0.68, 0.61]);
    let half = Vec3::new(0.27, 0.33, 0.27);
    let foot = Vec3::new(NICHE.center, half.y, -0.95);
    let place = Transform::translate(foot).then_after(&turned(Vec3::Y, 24.0));
    stage.mesh("pedestal", stone, rounded_box(half, 0.035, 8), place);

    let roughness = stage.roughness(0.13, 0.28);
    let gold = metal(stage, "gold", "Au", roughness);
    let knot = TorusKnot { p: 2, q: 3, major: 0.235, minor: 0.105, tube: 0.062 };
    // A trefoil on two of its three loops, turned a little from the viewer.
    let place = Transform::translate(foot + Vec3::Y * (half.y + 0.325))
        .then_after(&turned(Vec3::Y, -22.0))
        .then_after(&turned(Vec3::Z, 30.0));
    stage.mesh("knot", gold, knot.mesh(480, 32), place);
}

/// A glazed vase.
fn vase(stage: &mut Stage) {
    let texture = BitmapTexture {
        bitmap: Arc::new(pattern::glaze(1024, 512)),
        channels: BitmapChannels::Color,
        filter: BitmapFilter::Bilinear,
        wrap: [Wrap::Repeat, Wrap::Clamp],
        mapping: TextureMapping::default(),
        scale: 1.0,
        invert: false,
        raw: false,
        space: ColorSpace::Srgb,
    };
    let diffuse_reflectance = stage.scene.add_texture(TextureNode::Bitmap(texture), None);
    let model = MaterialModel::Plastic {
        diffuse_reflectance,
        specular_reflectance: stage.scene.float(1.0),
        ior: 1.5,
        nonlinear: true,
        roughness: None,
    };
    let glaze = stage.scene.add_material("glaze", model, None);
    // Foot, belly, shoulder, neck, lip, and a stretch of the inside.
    let profile = [
        (0.0, 0.0),
        (0.11, 0.0),
        (0.155, 0.03),
        (0.235, 0.17),
        (0.285, 0.33),
        (0.285, 0.48),
        (0.22, 0.62),
        (0.12, 0.72),
        (0.092, 0.82),
        (0.115, 0.92),
        (0.135, 0.945),
        (0.12, 0.945),
        (0.078, 0.83),
        (0.10, 0.70),
        (0.20, 0.58),
        (0.0, 0.40),
    ]
    .map(|(r, y)| Vec2::new(r, y) * 1.15);
    let place = Transform::translate(Vec3::new(-0.96, 0.0, -0.68));
    stage.mesh("vase", glaze, lathe(&profile, 96, 6), place);
}

/// A clear ball and an amber block, for the caustics.
fn glass(stage: &mut Stage) {
    let clear = dielectric(stage, "clear glass", [1.0; 3]);
    let radius = 0.37;
    let place = Transform::translate(Vec3::new(-0.12, radius, 0.36));
    stage.sphere("glass ball", clear, radius, place);

    let amber = dielectric(stage, "amber glass", [1.0, 0.76, 0.36]);
    let half = Vec3::splat(0.15);
    let place = Transform::translate(Vec3::new(0.78, half.y + 0.001, 0.35))
        .then_after(&turned(Vec3::Y, 33.0));
    stage.mesh("amber block", amber, rounded_box(half, 0.035, 10), place);
}

/// Small balls that lead the eye in.
fn marbles(stage: &mut Stage) {
    let smooth = stage.roughness(0.0, 0.0);
    let copper = metal(stage, "copper", "Cu", smooth);
    let radius = 0.11;
    let place = Transform::translate(Vec3::new(-0.72, radius, 0.85));
    stage.sphere("copper ball", copper, radius, place);
}

fn turned(axis: Vec3, degrees: f32) -> Transform {
    Transform::rotate(degrees, axis).expect("the axes of coordinates are not zero")
}

/// A metal by its name in the collection of spectra.
fn metal(stage: &mut Stage, name: &str, symbol: &str, roughness: RoughnessDesc) -> MaterialId {
    let mut part = |part: &str| {
        let spectrum: SpectrumDesc = named(&format!("metal-{symbol}-{part}"))
            .expect("gold and copper are in the collection");
        stage.scene.add_texture(TextureNode::Spectrum(spectrum), None)
    };
    let color = ConductorColor::EtaK { eta: part("eta"), k: part("k") };
    let specular_reflectance = stage.scene.float(1.0);
    let model = MaterialModel::Conductor { color, specular_reflectance, roughness };
    stage.scene.add_material(name, model, None)
}

/// Smooth glass whose surface lets `tint` through.
fn dielectric(stage: &mut Stage, name: &str, tint: [f32; 3]) -> MaterialId {
    let model = MaterialModel::Dielectric {
        ior: IorDesc::Constant(1.5),
        specular_reflectance: stage.scene.float(1.0),
        specular_transmittance: stage.scene.rgb(tint),
        roughness: stage.roughness(0.0, 0.0),
    };
    stage.scene.add_material(name, model, None)
}
