//! Textures, their defaults and mappings.

use super::{number, rgb, world};
use kaustika_math::{Affine2, Vec2};
use kaustika_scene::description::{NoiseKind, SceneDescription, TextureMapping, TextureNode};

/// The last texture node of a scene with these directives.
fn texture(text: &str) -> (SceneDescription, TextureNode) {
    let scene = world(text);
    let node = scene.textures.last().unwrap().node.clone();
    (scene, node)
}

#[test]
fn constants() {
    assert_eq!(texture("Texture \"t\" \"float\" \"constant\"").1, TextureNode::Float(1.0));
    let text = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [ 1 2 3 ]";
    let s = world(text);
    assert_eq!(rgb(&s, kaustika_scene::description::TextureId(0)), [1.0, 2.0, 3.0]);
}

#[test]
fn each_type_has_its_own_names() {
    let text = "Texture \"t\" \"float\" \"constant\" \"float value\" .3
        Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [ .1 .2 .3 ]
        Texture \"f\" \"float\" \"scale\" \"texture tex\" \"t\"
        Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"texture scale\" \"t\"";
    let (s, node) = texture(text);
    let TextureNode::Scale { texture, scale } = node else { panic!() };
    assert_eq!((rgb(&s, texture), number(&s, scale)), ([0.1, 0.2, 0.3], 0.3));
}

#[test]
fn mixtures() {
    let (s, node) = texture("Texture \"t\" \"float\" \"mix\"");
    let TextureNode::Mix { a, b, amount } = node else { panic!() };
    assert_eq!([a, b, amount].map(|t| number(&s, t)), [0.0, 1.0, 0.5]);
    let text =
        "Rotate 90 0 0 1 Texture \"t\" \"spectrum\" \"directionmix\" \"vector3 dir\" [ 2 0 0 ]";
    let (s, node) = texture(text);
    let TextureNode::DirectionMix { a, b, dir } = node else { panic!() };
    assert_eq!((number(&s, a), number(&s, b)), (0.0, 1.0));
    assert!(dir[0].abs() < 1e-6 && (dir[1] - 1.0).abs() < 1e-6, "{dir:?}");
    let (s, node) = texture("Texture \"t\" \"float\" \"bilerp\" \"float v10\" .7");
    let TextureNode::Bilerp { corners, .. } = node else { panic!() };
    assert_eq!(corners.map(|t| number(&s, t)), [0.0, 1.0, 0.7, 1.0]);
    let (s, node) = texture("Texture \"t\" \"float\" \"dots\" \"float inside\" .7");
    let TextureNode::Dots { inside, outside, .. } = node else { panic!() };
    assert_eq!((number(&s, inside), number(&s, outside)), (0.7, 0.0));
}

#[test]
fn checkers_are_as_large_as_in_pbrt() {
    let text = "Texture \"t\" \"float\" \"checkerboard\" \"float uscale\" 8 \"float vscale\" 4
        \"float udelta\" .5";
    let (s, node) = texture(text);
    let TextureNode::Checkerboard { a, b, mapping: TextureMapping::Uv(m) } = node else { panic!() };
    assert_eq!((number(&s, a), number(&s, b)), (1.0, 0.0));
    // Ours is `a` where floor(2u) + floor(2v) is even, pbrt's tex1 where floor(s) + floor(t) is.
    for (u, v) in [(0.01f32, 0.02f32), (0.1, 0.3), (0.77, 0.9), (-0.3, 0.2)] {
        let p = m.point(Vec2::new(u, v));
        let ours = (2.0 * p.x).floor() + (2.0 * p.y).floor();
        let pbrt = (8.0 * u + 0.5f32).floor() + (4.0 * v).floor();
        assert_eq!(ours, pbrt);
    }
    let text = "Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 3";
    assert!(matches!(texture(text).1, TextureNode::Checkerboard3d { .. }));
}

#[test]
fn mappings_are_in_the_space_of_the_texture() {
    let mapping = |text: &str| match texture(&format!(
        "Translate 1 0 0 Texture \"t\" \"float\" \"dots\" {text}"
    ))
    .1
    {
        TextureNode::Dots { mapping, .. } => mapping,
        _ => panic!(),
    };
    assert_eq!(mapping(""), TextureMapping::Uv(Affine2::IDENTITY));
    let TextureMapping::Spherical(t) = mapping("\"string mapping\" \"spherical\"") else {
        panic!()
    };
    super::assert_maps(&t, [1.0, 0.0, 0.0], [0.0; 3]);
    let text = "\"string mapping\" \"planar\" \"vector3 v1\" [ 0 0 2 ] \"float vdelta\" 3";
    let TextureMapping::Planar { to_texture, vs, vt, ds, dt } = mapping(text) else { panic!() };
    super::assert_maps(&to_texture, [1.0, 0.0, 0.0], [0.0; 3]);
    assert_eq!((vs, vt, ds, dt), ([0.0, 0.0, 2.0], [0.0, 1.0, 0.0], 0.0, 3.0));
    assert!(matches!(
        mapping("\"string mapping\" \"cylindrical\""),
        TextureMapping::Cylindrical(_)
    ));
}

#[test]
fn noises() {
    let noise = |text: &str| match texture(&format!("Texture \"t\" {text}")).1 {
        TextureNode::Noise { kind, octaves, roughness, scale, variation, .. } => {
            (kind, octaves, roughness, scale, variation)
        }
        _ => panic!(),
    };
    assert_eq!(noise("\"float\" \"fbm\""), (NoiseKind::Fbm, 8, 0.5, 1.0, 0.2));
    let text = "\"float\" \"wrinkled\" \"integer octaves\" 3 \"float roughness\" .7";
    assert_eq!(noise(text), (NoiseKind::Wrinkled, 3, 0.7, 1.0, 0.2));
    assert_eq!(noise("\"float\" \"windy\"").0, NoiseKind::Windy);
    let text = "\"spectrum\" \"marble\" \"float scale\" 4 \"float variation\" .1";
    assert_eq!(noise(text), (NoiseKind::Marble, 8, 0.5, 4.0, 0.1));
}
