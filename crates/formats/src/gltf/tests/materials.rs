//! Materials and textures.

use super::*;

/// A TGA of 2 x 1 pixels, opaque red and half transparent green, as images and textures.
fn image() -> String {
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 32, 0x28];
    bytes.extend([0, 0, 255, 255, 0, 255, 0, 128]);
    bytes.extend([0; 8]);
    bytes.extend(b"TRUEVISION-XFILE.\0");
    format!(
        r#","images":[{{"uri":"{}"}}],"samplers":[{{"wrapS":33071,"wrapT":33648,"magFilter":9728}}],
        "textures":[{{"source":0}},{{"source":0,"sampler":0}}]"#,
        uri(&bytes)
    )
}

fn bitmap(d: &SceneDescription, id: TextureId) -> &BitmapTexture {
    match node(d, id) {
        TextureNode::Bitmap(b) => b,
        TextureNode::Scale { scale, .. } => bitmap(d, *scale),
        TextureNode::WithUv { texture, .. } => bitmap(d, *texture),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_default_is_white_rough_metal_seen_from_both_sides() {
    let d = with_material("{}", "");
    let m = metallic_roughness(&d);
    assert_eq!((float(&d, m.metallic), float(&d, m.roughness)), (1.0, 1.0));
    assert_eq!(rgb(&d, m.base_color), [1.0; 3]);
    assert_eq!(m.ior, IorDesc::Constant(1.5));
    assert!(m.transmission.is_none() && m.clearcoat.is_none() && m.sheen.is_none());
    assert!(matches!(model(&d, d.shapes[0].material), MaterialModel::TwoSided { .. }));
    assert!(d.shapes[0].alpha.is_none() && d.shapes[0].emission.is_none());
}

#[test]
fn textures_have_their_curve_channel_and_sampler() {
    let d = with_material(
        r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"roughnessFactor":0.5,
            "metallicRoughnessTexture":{"index":1}},"normalTexture":{"index":0,"scale":0.5}}"#,
        &image(),
    );
    let m = metallic_roughness(&d);
    let base = bitmap(&d, m.base_color);
    assert_eq!(base.bitmap.encoding, Encoding::Srgb);
    assert_eq!((base.filter, base.wrap), (BitmapFilter::Trilinear, [Wrap::Repeat; 2]));
    let rough = bitmap(&d, m.roughness);
    assert_eq!(
        (rough.channels, rough.bitmap.encoding),
        (BitmapChannels::Channel(1), Encoding::Linear)
    );
    assert_eq!((rough.filter, rough.wrap), (BitmapFilter::Nearest, [Wrap::Clamp, Wrap::Mirror]));
    assert_eq!(bitmap(&d, m.metallic).channels, BitmapChannels::Channel(2));
    let MaterialModel::TwoSided { front, .. } = model(&d, d.shapes[0].material) else { panic!() };
    let MaterialModel::NormalMap { normals, space, .. } = model(&d, *front) else { panic!() };
    assert!(bitmap(&d, *normals).raw);
    assert_eq!(*space, TangentSpace { scale: 0.5, follows_v: true });
}

/// The example of KHR_texture_transform: the lower left quarter, turned by 90°.
#[test]
fn texture_transforms_turn_as_the_example_does() {
    let d = with_material(
        r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{
            "KHR_texture_transform":{"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]}}}}}"#,
        &image(),
    );
    let TextureMapping::Uv(m) = bitmap(&d, metallic_roughness(&d).base_color).mapping else {
        panic!()
    };
    // glTF's (0,0), upper left, shows the lower left corner; its (1,0) the middle of the left.
    let near = |a: Vec2, b: Vec2| assert!((a - b).length() < 1e-6, "{a:?} {b:?}");
    near(m.point(Vec2::new(0.0, 1.0)), Vec2::new(0.0, 0.0));
    near(m.point(Vec2::new(1.0, 1.0)), Vec2::new(0.0, 0.5));
    near(m.point(Vec2::new(0.0, 0.0)), Vec2::new(0.5, 0.0));
}

/// The normal map's coordinates are the mesh's own; others are attributes.
#[test]
fn two_sets_of_texture_coordinates() {
    let mut file = triangle();
    file.add(&floats(&[0.5; 6]), 5126, "VEC2", 3, "");
    let d = sound(file.read(&format!(
        r#""materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}},
                          "normalTexture":{{"index":0,"texCoord":1}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2}},"material":0}}]}}],
        "nodes":[{{"mesh":0}}]{}"#,
        image()
    )));
    assert_eq!(mesh(&d, 0).uvs, [Vec2::splat(0.5); 3]);
    assert_eq!(mesh(&d, 0).attributes[0].name, "uv0");
    assert_eq!(mesh(&d, 0).attributes[0].values[..3], [0.0, 0.75, 0.0]);
    let TextureNode::WithUv { attribute, .. } = node(&d, bitmap_parent(&d)) else { panic!() };
    assert_eq!(attribute, "uv0");
}

fn bitmap_parent(d: &SceneDescription) -> TextureId {
    let TextureNode::Scale { scale, .. } = node(d, metallic_roughness(d).base_color) else {
        panic!()
    };
    *scale
}

#[test]
fn coverage_has_its_modes() {
    let alpha = |mode: &str, base: &str| {
        let m = format!(
            r#"{{"alphaMode":"{mode}","alphaCutoff":0.3,"pbrMetallicRoughness":{{{base}}}}}"#
        );
        let d = with_material(&m, &image());
        let id = d.shapes[0].alpha;
        (d, id)
    };
    let factor = r#""baseColorFactor":[1,1,1,0.25]"#;
    assert!(alpha("OPAQUE", factor).1.is_none());
    assert!(alpha("BLEND", "").1.is_none(), "all is opaque");
    let (d, id) = alpha("BLEND", factor);
    assert_eq!(float(&d, id.unwrap()), 0.25);
    let (d, id) = alpha("MASK", r#""baseColorTexture":{"index":0}"#);
    let TextureNode::Step { texture, threshold } = node(&d, id.unwrap()) else { panic!() };
    assert_eq!((*threshold, bitmap(&d, *texture).channels), (0.3, BitmapChannels::Alpha));
}

#[test]
fn emission_is_factor_times_strength() {
    let d = with_material(
        r#"{"emissiveFactor":[1,0.5,0.25],"doubleSided":true,
            "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}}"#,
        "",
    );
    let e = d.shapes[0].emission.as_ref().unwrap();
    assert_eq!((rgb(&d, e.radiance), e.scale, e.two_sided), ([1.0, 0.5, 0.25], 8.0, true));
    let d = with_material(
        r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,0.6,1]},"extensions":{"KHR_materials_unlit":{}}}"#,
        "",
    );
    let e = d.shapes[0].emission.as_ref().unwrap();
    assert_eq!((rgb(&d, e.radiance), e.two_sided), ([0.2, 0.4, 0.6], true));
    assert!(matches!(model(&d, d.shapes[0].material), MaterialModel::Diffuse { .. }));
    assert!(d.lights.is_empty(), "nothing there waits for light");
}

#[test]
fn extensions_add_their_layers() {
    let d = with_material(
        r#"{"extensions":{
            "KHR_materials_ior":{"ior":1.8},
            "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[2,1,0.5]},
            "KHR_materials_clearcoat":{"clearcoatFactor":0.75,"clearcoatRoughnessFactor":0.25},
            "KHR_materials_sheen":{"sheenColorFactor":[0.1,0.2,0.3],"sheenRoughnessFactor":0.5},
            "KHR_materials_anisotropy":{"anisotropyStrength":0.6,"anisotropyRotation":1.5},
            "KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceIor":1.4},
            "KHR_materials_transmission":{"transmissionFactor":0.5},
            "KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.25},
            "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0.5,1,1]}
        }}"#,
        "",
    );
    let m = metallic_roughness(&d);
    assert_eq!(m.ior, IorDesc::Constant(1.8));
    assert_eq!((float(&d, m.specular), rgb(&d, m.specular_color)), (0.5, [2.0, 1.0, 0.5]));
    let coat = m.clearcoat.as_ref().unwrap();
    assert_eq!((float(&d, coat.factor), float(&d, coat.roughness)), (0.75, 0.25));
    let sheen = m.sheen.as_ref().unwrap();
    assert_eq!((rgb(&d, sheen.color), float(&d, sheen.roughness)), ([0.1, 0.2, 0.3], 0.5));
    let a = m.anisotropy.as_ref().unwrap();
    assert_eq!((float(&d, a.strength), a.rotation), (0.6, 1.5));
    let film = m.iridescence.as_ref().unwrap();
    assert_eq!((film.ior, float(&d, film.thickness)), (1.4, 400.0));
    assert_eq!(float(&d, m.transmission.unwrap()), 0.5);
    assert_eq!(float(&d, m.diffuse_transmission.as_ref().unwrap().factor), 0.25);
    let volume = m.volume.as_ref().unwrap();
    assert_eq!(
        (volume.attenuation_distance, rgb(&d, volume.attenuation_color)),
        (2.0, [0.5, 1.0, 1.0])
    );
    // What light goes through is not made two-sided.
    assert!(matches!(model(&d, d.shapes[0].material), MaterialModel::MetallicRoughness(_)));
}

/// V = 20/dispersion: crown glass of Abbe number 60 between the lines F and C.
#[test]
fn dispersion_has_abbes_number() {
    let d =
        with_material(r#"{"extensions":{"KHR_materials_dispersion":{"dispersion":0.333333}}}"#, "");
    let IorDesc::Spectrum(id) = metallic_roughness(&d).ior else { panic!() };
    let TextureNode::Spectrum(n) = node(&d, id) else { panic!() };
    let at = |l| n.value_at(l).unwrap();
    assert!((at(587.6) - 1.5).abs() < 1e-4, "{}", at(587.6));
    let abbe = (at(587.6) - 1.0) / (at(486.1) - at(656.3));
    assert!((abbe - 60.0).abs() < 1.0, "{abbe}");
}

#[test]
fn specular_glossiness_becomes_a_reflectance() {
    let d = with_material(
        r#"{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.1,0.2,0.3,1],
            "specularFactor":[0.9,0.8,0.7],"glossinessFactor":0.75}}}"#,
        "",
    );
    let m = metallic_roughness(&d);
    assert_eq!(
        (rgb(&d, m.base_color), rgb(&d, m.specular_color)),
        ([0.1, 0.2, 0.3], [0.9, 0.8, 0.7])
    );
    assert_eq!((m.ior.clone(), float(&d, m.metallic)), (IorDesc::Constant(0.0), 0.0));
    let TextureNode::Mix { a, b, amount } = node(&d, m.roughness) else { panic!() };
    assert_eq!((float(&d, *a), float(&d, *b), float(&d, *amount)), (1.0, 0.0, 0.75));
}
