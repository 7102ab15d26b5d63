//! Materials and their defaults.

use super::{material, messages, model, number, read, rgb, spectrum_name, world};
use kaustika_scene::description::{
    CoatDesc, CoefficientsDesc, ConductorColor, FibreLayout, FieldDesc, HairAbsorption, IorDesc,
    MaterialModel, PhaseDesc, RoughnessDesc, SceneDescription, TextureNode,
};
use kaustika_spectra::SpectrumDesc;

fn roughness(s: &SceneDescription, r: &RoughnessDesc) -> (f32, f32, bool) {
    (number(s, r.alpha_u), number(s, r.alpha_v), r.remap)
}

fn assert_default_coat(s: &SceneDescription, c: &CoatDesc) {
    assert_eq!(c.ior, IorDesc::Constant(1.5));
    assert_eq!(roughness(s, &c.roughness), (0.0, 0.0, true));
    assert_eq!([c.thickness, c.albedo, c.g].map(|t| number(s, t)), [0.01, 0.0, 0.0]);
    assert_eq!((c.max_depth, c.samples), (10, 1));
}

#[test]
fn diffuse() {
    let (s, m) = material("");
    let MaterialModel::Diffuse { reflectance } = m else { panic!() };
    assert_eq!(number(&s, reflectance), 0.5);
    let (s, m) = material("Material \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]");
    let MaterialModel::Diffuse { reflectance } = m else { panic!() };
    assert_eq!(rgb(&s, reflectance), [0.1, 0.2, 0.3]);
}

#[test]
fn diffuse_transmission() {
    let (s, m) = material("Material \"diffusetransmission\" \"float scale\" 2");
    let MaterialModel::DiffuseTransmission { reflectance, transmittance, scale } = m else {
        panic!()
    };
    assert_eq!((number(&s, reflectance), number(&s, transmittance), scale), (0.25, 0.25, 2.0));
}

#[test]
fn conductors() {
    let (s, m) = material("Material \"conductor\"");
    let MaterialModel::Conductor { color, specular_reflectance, roughness: r } = m else {
        panic!()
    };
    assert_eq!(number(&s, specular_reflectance), 1.0);
    assert_eq!(roughness(&s, &r), (0.0, 0.0, true));
    let ConductorColor::EtaK { eta, k } = color else { panic!() };
    assert_eq!(spectrum_name(&s, eta), "metal-Cu-eta");
    assert_eq!(spectrum_name(&s, k), "metal-Cu-k");
    let text =
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"
        \"float roughness\" .3 \"float vroughness\" .1 \"bool remaproughness\" false";
    let (s, m) = material(text);
    let MaterialModel::Conductor { color, roughness: r, .. } = m else { panic!() };
    let ConductorColor::EtaK { eta, .. } = color else { panic!() };
    assert_eq!(spectrum_name(&s, eta), "metal-Au-eta");
    assert_eq!(roughness(&s, &r), (0.3, 0.1, false));
    let (s, m) = material("Material \"conductor\" \"rgb reflectance\" [ .9 .8 .7 ]");
    let MaterialModel::Conductor { color: ConductorColor::Reflectance(r), .. } = m else {
        panic!()
    };
    assert_eq!(rgb(&s, r), [0.9, 0.8, 0.7]);
}

#[test]
fn dielectrics() {
    let (s, m) = material("Material \"dielectric\"");
    let MaterialModel::Dielectric { ior, roughness: r, .. } = m else { panic!() };
    assert_eq!((ior, roughness(&s, &r)), (IorDesc::Constant(1.5), (0.0, 0.0, true)));
    let (s, m) = material("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    let MaterialModel::Dielectric { ior: IorDesc::Spectrum(id), .. } = m else { panic!() };
    assert_eq!(spectrum_name(&s, id), "glass-BK7");
    let (_, m) = material("Material \"thindielectric\" \"float eta\" 1.3");
    let MaterialModel::ThinDielectric { ior, .. } = m else { panic!() };
    assert_eq!(ior, IorDesc::Constant(1.3));
}

#[test]
fn coated() {
    let (s, m) = material("Material \"coateddiffuse\"");
    let MaterialModel::CoatedDiffuse { reflectance, coat } = m else { panic!() };
    assert_eq!(number(&s, reflectance), 0.5);
    assert_default_coat(&s, &coat);
    let (s, m) = material("Material \"coatedconductor\"");
    let MaterialModel::CoatedConductor { color, base_roughness, coat } = m else { panic!() };
    assert!(matches!(color, ConductorColor::EtaK { .. }));
    assert_eq!(roughness(&s, &base_roughness), (0.0, 0.0, true));
    assert_default_coat(&s, &coat);
    let text = "Material \"coatedconductor\" \"float interface.roughness\" .2
        \"float conductor.uroughness\" .4 \"float interface.eta\" 1.7 \"integer nsamples\" 4
        \"float thickness\" .5 \"float g\" .6 \"rgb albedo\" [ .1 .1 .1 ] \"integer maxdepth\" 20";
    let (s, m) = material(text);
    let MaterialModel::CoatedConductor { base_roughness, coat, .. } = m else { panic!() };
    assert_eq!(roughness(&s, &base_roughness), (0.4, 0.0, true));
    assert_eq!(roughness(&s, &coat.roughness), (0.2, 0.2, true));
    assert_eq!((coat.ior, coat.samples, coat.max_depth), (IorDesc::Constant(1.7), 4, 20));
    assert_eq!((number(&s, coat.thickness), number(&s, coat.g)), (0.5, 0.6));
    assert_eq!(rgb(&s, coat.albedo), [0.1; 3]);
}

#[test]
fn mixtures_name_their_parts() {
    let text =
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"b\" ]
            \"texture amount\" \"t\"
        MakeNamedMaterial \"a\" \"string type\" \"diffuse\"
        MakeNamedMaterial \"b\" \"string type\" \"dielectric\"
        Texture \"t\" \"float\" \"constant\" \"float value\" .25
        NamedMaterial \"m\" Shape \"sphere\"";
    let s = world(text);
    let MaterialModel::Mix { a, b, amount } = model(&s, &s.shapes[0]) else { panic!() };
    assert_eq!(s.materials[a.0 as usize].name, "a");
    assert_eq!(s.materials[b.0 as usize].name, "b");
    assert_eq!(number(&s, *amount), 0.25);
    assert_eq!(s.materials.len(), 3);
}

#[test]
fn interface_is_nothing_that_does_not_count() {
    let (_, m) = material("Material \"interface\"");
    assert_eq!(m, MaterialModel::Null { counts: false });
}

#[test]
fn displacement_is_a_bump_map() {
    let text =
        "Texture \"t\" \"float\" \"constant\" Material \"diffuse\" \"texture displacement\" \"t\"";
    let (s, m) = material(text);
    let MaterialModel::Bump { material, displacement, scale } = m else { panic!() };
    assert!(matches!(s.materials[material.0 as usize].model, MaterialModel::Diffuse { .. }));
    assert_eq!((number(&s, displacement), scale), (1.0, 1.0));
}

#[test]
fn hair_by_each_of_its_colours() {
    let hair = |text: &str| {
        let (s, m) = material(&format!("Material \"hair\" {text}"));
        let MaterialModel::Hair(desc) = m else { panic!() };
        (s, desc)
    };
    let (s, d) = hair("");
    assert_eq!(d.layout, FibreLayout::RibbonAlongU);
    let figures = [d.eta, d.beta_m, d.beta_n, d.alpha].map(|t| number(&s, t));
    assert_eq!(figures, [1.55, 0.3, 0.3, 2.0]);
    let HairAbsorption::Melanin { eumelanin, pheomelanin } = d.absorption else { panic!() };
    assert_eq!((number(&s, eumelanin), number(&s, pheomelanin)), (1.3, 0.0));
    let (s, d) = hair("\"float pheomelanin\" .4 \"float beta_m\" .2");
    let HairAbsorption::Melanin { eumelanin, pheomelanin } = d.absorption else { panic!() };
    assert_eq!((number(&s, eumelanin), number(&s, pheomelanin)), (0.0, 0.4));
    assert_eq!(number(&s, d.beta_m), 0.2);
    let (s, d) = hair("\"rgb reflectance\" [ .1 .2 .3 ]");
    let HairAbsorption::Color(t) = d.absorption else { panic!() };
    assert_eq!(rgb(&s, t), [0.1, 0.2, 0.3]);
    let (s, d) = hair("\"rgb sigma_a\" [ 1 2 3 ]");
    let HairAbsorption::Coefficient(t) = d.absorption else { panic!() };
    assert_eq!(rgb(&s, t), [1.0, 2.0, 3.0]);
    let s = read(
        "WorldBegin Material \"hair\" \"rgb reflectance\" [ 1 1 1 ] \"rgb sigma_a\" [ 1 2 3 ]",
    );
    assert_eq!(
        messages(&s),
        "warning 1:21 <\"hair\"> hair has more than one colour, `sigma_a` is used\n"
    );
}

#[test]
fn measured_materials_and_their_faults() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let main = folder.path().join("scene.pbrt");
    std::fs::write(folder.path().join("a.bsdf"), crate::measured::tests::file()).expect("written");
    std::fs::write(folder.path().join("b.bsdf"), b"tensor").expect("written");
    let text = "WorldBegin
Material \"measured\" \"string filename\" \"a.bsdf\"
Shape \"sphere\"
Material \"measured\" \"string filename\" \"b.bsdf\"
Material \"measured\"
Material \"measured\" \"string filename\" \"a.bsd\"
Material \"measured\" \"string filename\" \"a.bsdf\"
Shape \"sphere\"";
    let s = crate::pbrt::read_pbrt_str(text, &main);
    assert_eq!(
        messages(&s),
        "error 4:39 <\"b.bsdf\"> can't read measured material `b.bsdf`: not a tensor file: it does \
         not begin with `tensor_file`\n\
         error 5:10 <\"measured\"> material `measured` needs \"string filename\"\n\
         error 6:39 <\"a.bsd\"> no material file `a.bsd`; did you mean `a.bsdf`?\n"
    );
    let MaterialModel::Measured(first) = model(&s, &s.shapes[0]) else { panic!() };
    let MaterialModel::Measured(second) = model(&s, &s.shapes[1]) else { panic!() };
    assert!(std::sync::Arc::ptr_eq(first, second));
}

#[test]
fn subsurface_is_a_boundary_around_matter() {
    let text = "WorldBegin
Texture \"t\" \"spectrum\" \"checkerboard\"
Material \"subsurface\" \"float eta\" 1.4 \"string name\" \"Skin1\" \"float scale\" 10
Shape \"sphere\"
Material \"subsurface\" \"rgb reflectance\" [ 1 .5 0 ] \"rgb mfp\" [ 1 2 4 ] \"float scale\" 2
Shape \"sphere\"
Material \"subsurface\" \"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 4 5 6 ] \"float g\" .5
Shape \"sphere\"
Material \"subsurface\"
Shape \"sphere\"
Material \"subsurface\" \"texture reflectance\" \"t\" \"float scale\" 2
Shape \"sphere\"
Material \"subsurface\" \"rgb sigma_a\" [ 1 2 3 ]";
    let s = read(text);
    assert_eq!(
        messages(&s),
        "error 13:10 <\"subsurface\"> `sigma_a` and `sigma_s` are needed together\n\
         warning 11:23 <\"texture reflectance\"> `reflectance` varies over a `subsurface`, a coated \
         diffuse is used\n"
    );
    let inside = |i: usize| {
        let m = &s.media[s.shapes[i].interior.expect("matter inside").0 as usize];
        let rgb = |f: &FieldDesc| match f {
            FieldDesc::Constant(SpectrumDesc::Rgb { rgb, .. }) => *rgb,
            other => panic!("{other:?}"),
        };
        let CoefficientsDesc::AbsorptionScattering(a, s) = &m.coefficients else { panic!() };
        (rgb(a).map(|v| v * m.scale), rgb(s).map(|v| v * m.scale), m.phase.clone())
    };
    let MaterialModel::Dielectric { ior, .. } = model(&s, &s.shapes[0]) else { panic!() };
    assert_eq!(*ior, IorDesc::Constant(1.4));
    let skin = ([0.32, 1.7, 4.8], [7.4, 8.8, 10.1]);
    let (a, scattering, phase) = inside(0);
    for k in 0..3 {
        assert!((a[k] - skin.0[k]).abs() < 1e-5 && (scattering[k] - skin.1[k]).abs() < 1e-5);
    }
    assert_eq!(phase, PhaseDesc::Isotropic);
    // Extinctions of 1 / (2 mfp); all, some and none of it scatters.
    let (a, scattering, _) = inside(1);
    for (k, sigma_t) in [0.5, 0.25, 0.125].into_iter().enumerate() {
        assert!((a[k] + scattering[k] - sigma_t).abs() < 1e-6);
    }
    assert!(a[0] == 0.0 && scattering[1] > 0.24 && scattering[2] < 1e-6);
    let given = ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], PhaseDesc::HenyeyGreenstein { g: 0.5 });
    assert_eq!(inside(2), given);
    let milk = ([0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77], PhaseDesc::Isotropic);
    assert_eq!(inside(3), milk);
    assert!(matches!(model(&s, &s.shapes[4]), MaterialModel::CoatedDiffuse { .. }));
    assert_eq!(s.shapes[4].interior, None);
}

#[test]
fn reflectances_above_one_are_cut() {
    let s = read("WorldBegin Material \"diffuse\" \"rgb reflectance\" [ 1.5 .5 0 ]");
    let TextureNode::Spectrum(SpectrumDesc::Rgb { rgb, .. }) = s.textures[0].node else { panic!() };
    assert_eq!(rgb, [1.0, 0.5, 0.0]);
    assert_eq!(
        messages(&s),
        "warning 1:31 <\"rgb reflectance\"> the reflectance `reflectance` has a component above 1, \
         cut at 1\n"
    );
    // The same of an index of refraction means nothing.
    world("Material \"conductor\" \"rgb eta\" [ 1.5 .5 2 ] \"rgb k\" [ 3 3 3 ]");
}
