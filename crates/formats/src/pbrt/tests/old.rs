//! pbrt-v3 scenes.

use super::{messages, model, number, read, rgb, spectrum_name};
use kaustika_scene::description::{
    CameraKind, ConductorColor, FilterChoice, GeometryDesc, IorDesc, LightKind, MaterialModel,
    SceneDescription, TextureNode,
};

/// Reads a scene that must have notes, but no warnings and errors.
fn noted(text: &str) -> SceneDescription {
    let s = read(text);
    let all = messages(&s);
    assert!(!all.is_empty() && all.lines().all(|l| l.starts_with("note")), "{all}");
    s
}

#[test]
fn options_of_v3() {
    let text = "Film \"image\" \"float scale\" 2 \"float maxsampleluminance\" 9
        Sampler \"lowdiscrepancy\" \"integer pixelsamples\" 8
        PixelFilter \"gaussian\" \"float xwidth\" 3 \"float alpha\" 2
        Integrator \"directlighting\" \"string strategy\" \"all\"
        Camera \"environment\"
        WorldBegin WorldEnd";
    let s = noted(text);
    let c = &s.cameras[0];
    assert_eq!((c.film.imaging_ratio, c.film.max_component), (2.0, Some(9.0)));
    assert_eq!(c.film.filter, FilterChoice::Gaussian { radius: [3.0, 1.5], sigma: 0.5 });
    assert_eq!((c.sampler.as_deref(), c.spp), (Some("sobol"), Some(8)));
    assert_eq!(c.kind, CameraKind::Spherical { equal_area: false });
    assert_eq!((s.integrator.name.as_str(), s.integrator.max_depth), ("path", Some(1)));
    assert_eq!(
        messages(&s),
        "note 1:6 <\"image\"> pbrt-v3 film `image` is read as `rgb`\n\
         note 1:30 <\"float maxsampleluminance\"> pbrt-v3 parameter `maxsampleluminance` is read as \
         `maxcomponentvalue`\n\
         note 1:14 <\"float scale\"> pbrt-v3 parameter `scale` of the film is read as `iso`\n\
         note 2:17 <\"lowdiscrepancy\"> pbrt-v3 sampler `lowdiscrepancy` is read as `paddedsobol`\n\
         note 3:32 <\"float xwidth\"> pbrt-v3 parameter `xwidth` is read as `xradius`\n\
         note 3:49 <\"float alpha\"> pbrt-v3 parameter `alpha` of the filter is read as `sigma`\n\
         note 4:20 <\"directlighting\"> pbrt-v3 integrator `directlighting` is read as `path`\n\
         note 5:16 <\"environment\"> pbrt-v3 camera `environment` is read as `spherical`\n\
         note 6:20 <WorldEnd> pbrt-v3 directive `WorldEnd` is ignored\n"
    );
}

#[test]
fn materials_of_v3() {
    let text = "WorldBegin
Material \"matte\" \"color Kd\" [ .1 .2 .3 ] \"float sigma\" 20 Shape \"sphere\"
Material \"glass\" \"float index\" 1.7 \"rgb Kr\" [ 1 1 1 ] Shape \"sphere\"
Material \"mirror\" \"rgb Kr\" [ 1 1 1 ] Shape \"sphere\"
Material \"metal\" \"float roughness\" .2 Shape \"sphere\"
Material \"plastic\" \"rgb Kd\" [ .5 .5 .5 ] \"rgb Ks\" [ 0 0 0 ] \"float roughness\" .1 Shape \"sphere\"
Material \"substrate\" \"rgb Kd\" [ .5 .5 .5 ] \"rgb Ks\" [ 1 1 1 ] \"bool remaproughness\" \"false\" Shape \"sphere\"
Material \"uber\" \"rgb Kd\" [ .5 .5 .5 ] \"rgb opacity\" [ .3 .3 .3 ] Shape \"sphere\"
Material \"translucent\" \"rgb Kd\" [ .4 .4 .4 ] Shape \"sphere\"";
    let s = noted(text);
    let m = |i: usize| model(&s, &s.shapes[i]);
    let MaterialModel::Diffuse { reflectance } = m(0) else { panic!() };
    assert_eq!(rgb(&s, *reflectance), [0.1, 0.2, 0.3]);
    let MaterialModel::Dielectric { ior, .. } = m(1) else { panic!() };
    assert_eq!(*ior, IorDesc::Constant(1.7));
    let MaterialModel::Conductor { color: ConductorColor::EtaK { eta, .. }, .. } = m(2) else {
        panic!()
    };
    assert_eq!(spectrum_name(&s, *eta), "metal-Ag-eta");
    let MaterialModel::Conductor { roughness, .. } = m(3) else { panic!() };
    assert_eq!(number(&s, roughness.alpha_u), 0.2);
    assert!(matches!(m(4), MaterialModel::Diffuse { .. }));
    let MaterialModel::CoatedDiffuse { coat, .. } = m(5) else { panic!() };
    assert!(!coat.roughness.remap);
    let MaterialModel::Mask { material, opacity } = m(6) else { panic!() };
    assert_eq!(rgb(&s, *opacity), [0.3; 3]);
    let inner = &s.materials[material.0 as usize].model;
    assert!(matches!(inner, MaterialModel::CoatedDiffuse { .. }));
    let MaterialModel::DiffuseTransmission { transmittance, .. } = m(7) else { panic!() };
    assert_eq!(rgb(&s, *transmittance), [0.4; 3]);
}

#[test]
fn factors_that_v4_lacks_are_lost_with_a_warning() {
    let s = read("WorldBegin Material \"glass\" \"rgb Kr\" [ .5 .5 .5 ]");
    assert_eq!(
        messages(&s),
        "note 1:21 <\"glass\"> pbrt-v3 material `glass` is read as `dielectric`\n\
         warning 1:29 <\"rgb Kr\"> pbrt-v3 factor `Kr` of `dielectric` is lost\n"
    );
}

#[test]
fn mixtures_of_v3_have_the_other_order() {
    let text = "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"matte\"
        MakeNamedMaterial \"b\" \"string type\" \"glass\"
        Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"
        \"rgb amount\" [ .3 .3 .3 ] Shape \"sphere\"";
    let s = noted(text);
    let MaterialModel::Mix { a, b, amount } = model(&s, &s.shapes[0]) else { panic!() };
    assert_eq!(s.materials[a.0 as usize].name, "b");
    assert_eq!(s.materials[b.0 as usize].name, "a");
    assert_eq!(number(&s, *amount), 0.3);
}

#[test]
fn names_may_be_defined_again_in_v3() {
    let text =
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"matte\" \"color Kd\" [ .1 .1 .1 ]
        NamedMaterial \"a\" Shape \"sphere\"
        MakeNamedMaterial \"a\" \"string type\" \"matte\" \"color Kd\" [ .2 .2 .2 ]
        NamedMaterial \"a\" Shape \"sphere\"";
    let s = noted(text);
    let grey = |i: usize| match model(&s, &s.shapes[i]) {
        MaterialModel::Diffuse { reflectance } => rgb(&s, *reflectance)[0],
        _ => panic!(),
    };
    assert_eq!((grey(0), grey(1)), (0.1, 0.2));
}

#[test]
fn textures_and_meshes_of_v3() {
    let text = "WorldBegin
        Texture \"c\" \"color\" \"constant\" \"color value\" [ .1 .2 .3 ]
        Texture \"s\" \"color\" \"scale\" \"texture tex1\" \"c\" \"color tex2\" [ .5 .5 .5 ]
        Shape \"trianglemesh\" \"point P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ]
            \"float uv\" [ 0 0 1 0 0 1 ] \"bool discarddegenerateUVs\" \"true\"";
    let s = noted(text);
    let node = s.textures.iter().find_map(|t| match t.node {
        TextureNode::Scale { texture, scale } => Some((texture, scale)),
        _ => None,
    });
    let (texture, scale) = node.unwrap();
    assert_eq!((rgb(&s, texture), number(&s, scale)), ([0.1, 0.2, 0.3], 0.5));
    let GeometryDesc::Mesh(m) = &s.shapes[0].geometry else { panic!() };
    assert_eq!(m.uvs.len(), 3);
}

#[test]
fn lights_of_v3() {
    let text = "WorldBegin
        LightSource \"point\" \"blackbody I\" [ 5000 3 ] \"rgb scale\" [ 2 2 2 ]
        AttributeBegin AreaLightSource \"area\" \"color L\" [ 1 1 1 ] \"integer nsamples\" 4
        Shape \"sphere\" AttributeEnd
        LightSource \"distant\" \"color L\" [ 1 1 1 ] \"color scale\" [ 5 5 5 ]";
    let s = noted(text);
    let LightKind::Point { scale, .. } = &s.lights[0].kind else { panic!() };
    let black = super::world("LightSource \"point\" \"blackbody I\" 5000");
    let LightKind::Point { scale: one, .. } = &black.lights[0].kind else { panic!() };
    assert!((scale / one - 6.0).abs() < 1e-4);
    let LightKind::Directional { scale, .. } = s.lights[1].kind else { panic!() };
    assert_eq!(scale, 5.0);
    assert!(s.shapes[0].emission.is_some());
}
