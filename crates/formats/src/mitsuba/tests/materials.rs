//! Materials and textures.

use super::*;
use kaustika_math::{Affine2, Vec2};
use kaustika_spectra::SpectrumDesc;

fn model(bsdf: &str) -> (SceneDescription, MaterialModel) {
    let d = scene(&on_sphere(bsdf));
    let model = only_model(&d).clone();
    (d, model)
}

fn model06(bsdf: &str) -> (SceneDescription, MaterialModel) {
    let d = scene06(&on_sphere(bsdf));
    let model = only_model(&d).clone();
    (d, model)
}

fn float(d: &SceneDescription, id: TextureId) -> f32 {
    match node(d, id) {
        TextureNode::Float(v) => *v,
        other => panic!("{other:?}"),
    }
}

#[test]
fn dielectrics_and_their_defaults() {
    let (d, glass) = model(r#"<bsdf type="dielectric"/>"#);
    let MaterialModel::Dielectric { ior, roughness, .. } = glass else { panic!() };
    assert_eq!(ior, IorDesc::Constant(1.5046 / 1.000277));
    assert_eq!(float(&d, roughness.alpha_u), 0.0);
    let (d, rough) = model(
        r#"<bsdf type="roughdielectric"><string name="int_ior" value="Diamond"/>
        <integer name="ext_ior" value="1"/><float name="alpha" value="0"/></bsdf>"#,
    );
    let MaterialModel::Dielectric { ior, roughness, .. } = rough else { panic!() };
    assert_eq!(ior, IorDesc::Constant(2.419));
    assert_eq!(roughness.distribution, Distribution::Beckmann);
    assert_eq!((float(&d, roughness.alpha_u), roughness.remap), (1e-4, false));
    let (d, plastic) = model(
        r#"<bsdf type="roughplastic"><string name="distribution" value="ggx"/>
        <boolean name="nonlinear" value="true"/></bsdf>"#,
    );
    let MaterialModel::Plastic { ior, nonlinear, roughness: Some(r), diffuse_reflectance, .. } =
        plastic
    else {
        panic!()
    };
    assert_eq!((ior, nonlinear, r.distribution), (1.49 / 1.000277, true, Distribution::Ggx));
    assert_eq!((float(&d, r.alpha_v), float(&d, diffuse_reflectance)), (0.1, 0.5));
    let (_, thin) = model(r#"<bsdf type="thindielectric"/>"#);
    assert!(matches!(thin, MaterialModel::ThinDielectric { .. }));
}

#[test]
fn conductors() {
    let (d, m) = model(
        r#"<bsdf type="roughconductor"><string name="material" value="Au"/>
        <float name="alpha_u" value="0.25"/><float name="alpha_v" value="0.05"/></bsdf>"#,
    );
    let MaterialModel::Conductor { color: ConductorColor::EtaK { eta, k }, roughness, .. } = m
    else {
        panic!()
    };
    let (gold_eta, gold_k) = kaustika_spectra::conductor("Au").expect("gold is known");
    assert_eq!(*node(&d, eta), TextureNode::Spectrum(gold_eta));
    assert_eq!(*node(&d, k), TextureNode::Spectrum(gold_k));
    let alphas = [roughness.alpha_u, roughness.alpha_v].map(|a| float(&d, a));
    assert_eq!(alphas, [0.25, 0.05]);
    let (d, m) = model(
        r#"<bsdf type="conductor"><spectrum name="eta" value="0.789"/>
        <spectrum name="k" value="6.15"/></bsdf>"#,
    );
    let MaterialModel::Conductor { color: ConductorColor::EtaK { eta, .. }, .. } = m else {
        panic!()
    };
    let TextureNode::Spectrum(eta) = node(&d, eta) else { panic!() };
    assert_eq!(eta.value_at(550.0), Some(0.789));
    let (_, m) = model06(r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#);
    assert!(matches!(m, MaterialModel::Conductor { color: ConductorColor::Mirror, .. }));
}

#[test]
fn models_of_mitsuba_06() {
    let (d, m) = model06(
        r#"<bsdf type="phong"><float name="exponent" value="100"/>
        <rgb name="diffuseReflectance" value="0"/></bsdf>"#,
    );
    let MaterialModel::Phong { specular_reflectance, exponent, .. } = m else { panic!() };
    assert_eq!((float(&d, specular_reflectance), float(&d, exponent)), (0.2, 100.0));
    let (d, m) =
        model06(r#"<bsdf type="roughdiffuse"><boolean name="useFastApprox" value="true"/></bsdf>"#);
    let MaterialModel::OrenNayar { alpha, fast: true, .. } = m else { panic!() };
    assert_eq!(float(&d, alpha), 0.2);
    let (_, m) = model06(r#"<bsdf type="ward"><string name="variant" value="ward-duer"/></bsdf>"#);
    assert!(matches!(m, MaterialModel::Ward { variant: WardVariant::WardDuer, .. }));
    let (_, m) = model06(
        r#"<bsdf type="mixturebsdf"><string name="weights" value="0.6, 0.2"/>
        <bsdf type="diffuse"/><bsdf type="conductor"/></bsdf>"#,
    );
    let MaterialModel::Sum { parts } = m else { panic!() };
    assert_eq!(parts.iter().map(|p| p.0).collect::<Vec<_>>(), [0.6, 0.2]);
    let (_, m) = model06(r#"<bsdf type="difftrans"/>"#);
    assert!(matches!(m, MaterialModel::DiffuseTransmission { .. }));
}

#[test]
fn materials_around_materials() {
    let (d, m) = model(r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#);
    let MaterialModel::TwoSided { front, back } = m else { panic!() };
    assert_eq!(front, back);
    assert!(matches!(d.materials[front.0 as usize].model, MaterialModel::Diffuse { .. }));
    let (d, m) = model(
        r#"<bsdf type="twosided"><bsdf type="diffuse" id="f"/><bsdf type="plastic" id="b"/></bsdf>"#,
    );
    let MaterialModel::TwoSided { front, back } = m else { panic!() };
    let names = [front, back].map(|m| d.materials[m.0 as usize].name.clone());
    assert_eq!(names, ["f", "b"]);
    let (d, m) = model(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/>
        <bsdf type="diffuse"/><bsdf type="plastic"/></bsdf>"#,
    );
    let MaterialModel::Mix { b, amount, .. } = m else { panic!() };
    assert_eq!(float(&d, amount), 0.3);
    assert!(matches!(d.materials[b.0 as usize].model, MaterialModel::Plastic { .. }));
    let (d, m) = model(
        r#"<bsdf type="bumpmap"><float name="scale" value="0.02"/>
        <texture name="any" type="checkerboard"/><bsdf type="diffuse"/></bsdf>"#,
    );
    let MaterialModel::Bump { displacement, scale, .. } = m else { panic!() };
    assert_eq!(scale, 0.02);
    assert!(matches!(node(&d, displacement), TextureNode::Checkerboard { .. }));
    let (d, m) = model(
        r#"<bsdf type="normalmap"><texture name="normalmap" type="rawconstant">
        <vector name="value" value="0.5, 0.5, 1.0"/></texture><bsdf type="diffuse"/></bsdf>"#,
    );
    let MaterialModel::NormalMap { normals, .. } = m else { panic!() };
    let TextureNode::Spectrum(SpectrumDesc::Rgb { rgb, .. }) = node(&d, normals) else { panic!() };
    assert_eq!(*rgb, [0.5, 0.5, 1.0]);
    let (d, m) = model(r#"<bsdf type="mask"><bsdf type="diffuse"/></bsdf>"#);
    let MaterialModel::Mask { opacity, .. } = m else { panic!() };
    assert_eq!(float(&d, opacity), 0.5);
}

#[test]
fn principled_materials() {
    let (d, m) = model(
        r#"<bsdf type="principled"><rgb name="base_color" value="0.2,0.8,0.1 "/>
        <float name="specular" value="0.7"/><float name="roughness" value="0.15"/></bsdf>"#,
    );
    let MaterialModel::Principled(p) = m else { panic!() };
    assert!(!p.thin);
    // 2 / (1 - √(0.08 · 0.7)) - 1
    assert!((p.eta - 1.620007).abs() < 1e-5, "{}", p.eta);
    assert_eq!((float(&d, p.roughness), float(&d, p.metallic)), (0.15, 0.0));
    let (_, m) = model(r#"<bsdf type="principled"/>"#);
    let MaterialModel::Principled(p) = m else { panic!() };
    assert!((p.eta - 1.5).abs() < 1e-6);
    let (d, m) = model(
        r#"<bsdf type="principledthin"><float name="eta" value="1.33"/>
        <float name="diff_trans" value="1.4"/></bsdf>"#,
    );
    let MaterialModel::Principled(p) = m else { panic!() };
    assert_eq!((p.thin, p.eta, float(&d, p.diff_trans)), (true, 1.33, 1.4));
}

#[test]
fn reflectances_stay_in_range() {
    let bright = r#"<bsdf type="diffuse"><rgb name="reflectance" value="2, 1, -1"/></bsdf>"#;
    let albedo = |version: &str| {
        let (d, messages) = read(version, &on_sphere(bright));
        assert_eq!(messages.len(), 1);
        let MaterialModel::Diffuse { reflectance } = *only_model(&d) else { panic!() };
        let TextureNode::Spectrum(SpectrumDesc::Rgb { rgb, .. }) = node(&d, reflectance) else {
            panic!()
        };
        *rgb
    };
    assert_eq!(albedo("3.0.0"), [1.0, 1.0, 0.0]);
    assert_eq!(albedo("0.6.0"), [1.0, 0.5, 0.0]);
}

fn checkerboard_mapping(version: &str, inner: &str) -> Affine2 {
    let board = format!(
        r#"<bsdf type="diffuse"><texture name="reflectance" type="checkerboard">{inner}</texture></bsdf>"#
    );
    let d = silent(version, &on_sphere(&board));
    let MaterialModel::Diffuse { reflectance } = *only_model(&d) else { panic!() };
    match node(&d, reflectance) {
        TextureNode::Checkerboard { mapping: TextureMapping::Uv(m), a, b } => {
            assert_eq!((float(&d, *a), float(&d, *b)), (0.4, 0.2));
            *m
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn texture_coordinates() {
    let steps =
        r#"<transform name="to_uv"><scale x="5" y="4"/><translate x="1" y="2"/></transform>"#;
    let m = checkerboard_mapping("3.0.0", steps);
    assert_eq!(m.point(Vec2::new(0.5, 0.25)), Vec2::new(3.5, 3.0));
    let old = r#"<float name="uvscale" value="3"/><float name="vscale" value="2"/>
        <float name="uoffset" value="0.5"/>"#;
    let m = checkerboard_mapping("0.6.0", old);
    assert_eq!(m.point(Vec2::new(1.0, 1.0)), Vec2::new(3.5, 2.0));
}

/// A grey PFM of one column and two rows.
fn tall_pfm() -> Vec<u8> {
    b"Pf\n1 2\n-1.0\n"
        .iter()
        .copied()
        .chain([0.25f32, 0.75].iter().flat_map(|v| v.to_le_bytes()))
        .collect()
}

fn bitmap(version: &str, inner: &str, parameter: &str, bsdf: &str) -> BitmapTexture {
    let text = format!(
        r#"<scene version="{version}"><sensor type="perspective"/><shape type="sphere">
        <bsdf type="{bsdf}"><texture name="{parameter}" type="bitmap">
        <string name="filename" value="t.pfm"/>{inner}</texture><bsdf type="diffuse"/></bsdf>
        </shape></scene>"#
    )
    .replace(
        if bsdf == "diffuse" { "<bsdf type=\"diffuse\"/></bsdf>" } else { "\u{0}" },
        "</bsdf>",
    );
    let files = Files::new(&[("a.xml", &text)]);
    std::fs::write(files.folder.path().join("t.pfm"), tall_pfm()).expect("it can be written");
    let d = files.read("a.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    let found = d.textures.iter().find_map(|t| match &t.node {
        TextureNode::Bitmap(b) => Some(b.clone()),
        _ => None,
    });
    found.expect("a bitmap")
}

#[test]
fn images_hang_from_the_top() {
    let t = bitmap("3.0.0", "", "reflectance", "diffuse");
    let TextureMapping::Uv(m) = t.mapping else { panic!() };
    // Mitsuba's v = 0 is the top row, the description's the bottom row.
    assert_eq!(m.point(Vec2::new(0.25, 0.0)), Vec2::new(0.25, 1.0));
    assert_eq!((t.bitmap.width, t.bitmap.height), (1, 2));
    assert_eq!((t.filter, t.wrap), (BitmapFilter::Bilinear, [Wrap::Repeat; 2]));
    assert_eq!((t.channels, t.raw), (BitmapChannels::Color, false));
    let scaled = r#"<transform name="to_uv"><scale x="2" y="3"/></transform>
        <string name="wrap_mode" value="mirror"/><string name="filter_type" value="nearest"/>
        <boolean name="raw" value="true"/>"#;
    let t = bitmap("3.0.0", scaled, "reflectance", "diffuse");
    let TextureMapping::Uv(m) = t.mapping else { panic!() };
    assert_eq!(m.point(Vec2::new(0.5, 0.5)), Vec2::new(1.0, 1.0 - 1.5));
    assert_eq!((t.filter, t.wrap, t.raw), (BitmapFilter::Nearest, [Wrap::Mirror; 2], true));
    assert_eq!(t.bitmap.encoding, Encoding::Linear);
}

#[test]
fn images_in_mitsuba_06() {
    let t = bitmap("0.6.0", r#"<float name="gamma" value="-1"/>"#, "reflectance", "diffuse");
    assert_eq!((t.filter, t.bitmap.encoding), (BitmapFilter::Ewa, Encoding::Srgb));
    let t = bitmap("0.6.0", r#"<float name="gamma" value="2.2"/>"#, "reflectance", "diffuse");
    assert_eq!(t.bitmap.encoding, Encoding::Gamma(2.2));
    let channel = r#"<string name="channel" value="a"/><string name="wrapModeV" value="clamp"/>"#;
    let t = bitmap("0.6.0", channel, "opacity", "mask");
    assert_eq!((t.channels, t.wrap), (BitmapChannels::Alpha, [Wrap::Repeat, Wrap::Clamp]));
}

#[test]
fn numbers_of_images_are_luminances() {
    let t = bitmap("3.0.0", "", "opacity", "mask");
    assert_eq!((t.channels, t.raw), (BitmapChannels::Luminance, true));
}

#[test]
fn scale_textures_of_mitsuba_06() {
    let d = scene06(&on_sphere(
        r#"<bsdf type="diffuse"><texture type="scale" name="reflectance">
        <float name="scale" value="0.5"/><texture type="checkerboard"/></texture></bsdf>"#,
    ));
    let MaterialModel::Diffuse { reflectance } = *only_model(&d) else { panic!() };
    let TextureNode::Scale { texture, scale } = node(&d, reflectance) else { panic!() };
    assert!(matches!(node(&d, *texture), TextureNode::Checkerboard { .. }));
    assert_eq!(float(&d, *scale), 0.5);
}

#[test]
fn hair_and_its_faults() {
    let (d, m) = model(r#"<bsdf type="hair"/>"#);
    let MaterialModel::Hair(hair) = m else { panic!() };
    assert_eq!(hair.layout, FibreLayout::TubeAlongV);
    let figures = [hair.eta, hair.beta_m, hair.beta_n, hair.alpha].map(|t| float(&d, t));
    assert_eq!(figures, [1.55 / 1.000277, 0.3, 0.3, 2.0]);
    let HairAbsorption::Melanin { eumelanin, pheomelanin } = hair.absorption else { panic!() };
    assert_eq!((float(&d, eumelanin), float(&d, pheomelanin)), (1.3, 0.2));
    let (d, m) = model(
        r#"<bsdf type="hair"><rgb name="sigma_a" value="0.2, 0.25, 0.7"/>
        <float name="scale" value="200"/></bsdf>"#,
    );
    let MaterialModel::Hair(hair) = m else { panic!() };
    let HairAbsorption::Coefficient(t) = hair.absorption else { panic!() };
    let TextureNode::Scale { scale, .. } = node(&d, t) else { panic!() };
    assert_eq!(float(&d, *scale), 200.0);
    let bad = r#"<bsdf type="hair"><float name="eumelanin" value="1"/><rgb name="sigma_a"
        value="1"/><float name="azimuthal_roughness" value="1.5"/></bsdf>"#;
    let (_, messages) = read("3.0.0", &on_sphere(bad));
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert!(messages[0].contains("exclude each other"), "{messages:?}");
    assert!(messages[1].contains("`azimuthal_roughness` must lie in [0, 1]"), "{messages:?}");
}

#[test]
fn coats_of_mitsuba_06() {
    let (d, m) = model06(
        r#"<bsdf type="coating"><float name="intIOR" value="1.7"/><float name="extIOR" value="1"/>
        <float name="thickness" value="2"/><spectrum name="sigmaA" value="0.1 0.2 0.3"/>
        <bsdf type="roughconductor"/></bsdf>"#,
    );
    let MaterialModel::Coating { material, ior, sigma_a, thickness, roughness, .. } = m else {
        panic!("{m:?}")
    };
    assert_eq!((ior, thickness, roughness), (1.7, 2.0, None));
    assert!(matches!(d.materials[material.0 as usize].model, MaterialModel::Conductor { .. }));
    assert!(matches!(node(&d, sigma_a), TextureNode::Spectrum(_)));
    let (d, m) = model06(
        r#"<bsdf type="roughcoating"><float name="alpha" value="0.2"/>
        <string name="distribution" value="ggx"/><bsdf type="diffuse"/></bsdf>"#,
    );
    let MaterialModel::Coating { ior, roughness: Some(r), thickness, .. } = m else { panic!() };
    assert_eq!((ior, thickness), (1.5046 / 1.000277, 1.0));
    assert_eq!((r.distribution, float(&d, r.alpha_u)), (Distribution::Ggx, 0.2));
    let glass = r#"<bsdf type="coating"><float name="thickness" value="2"/>
        <bsdf type="dielectric"/></bsdf>"#;
    let (d, messages) = read("0.6.0", &on_sphere(glass));
    assert_eq!(
        messages,
        ["warning 2:34 `coating` over this kind of material is not supported | the material \
          inside is used without its coat"]
    );
    assert!(matches!(only_model(&d), MaterialModel::Dielectric { .. }));
}

#[test]
fn polarized_plastic() {
    let (d, m) = model(r#"<bsdf type="pplastic"><float name="alpha" value="0.06"/></bsdf>"#);
    let MaterialModel::PolarizedPlastic { ior, roughness, diffuse_reflectance, .. } = m else {
        panic!()
    };
    assert_eq!((ior, float(&d, roughness.alpha_u)), (1.49 / 1.000277, 0.06));
    assert_eq!(float(&d, diffuse_reflectance), 0.5);
}

#[test]
fn gratings_and_their_faults() {
    let (_, m) = model(
        r#"<bsdf type="grating"><float name="period" value="1600"/>
        <float name="depth" value="120"/></bsdf>"#,
    );
    let MaterialModel::Grating(g) = m else { panic!() };
    let ior = 1.5046 / 1.000277;
    let sinusoid = GratingProfileDesc::Sinusoidal { depth: 120.0, ior };
    assert_eq!((g.period, g.profile), (1600.0, sinusoid));
    let (_, m) =
        model(r#"<bsdf type="grating"><string name="efficiencies" value="0.4, 0.2"/></bsdf>"#);
    let MaterialModel::Grating(g) = m else { panic!() };
    assert_eq!(g.profile, GratingProfileDesc::Efficiencies(vec![0.4, 0.2]));
    let bad = r#"<bsdf type="grating"><string name="efficiencies" value="0.4, 0.4"/>
        <float name="period" value="0"/></bsdf>"#;
    let (_, messages) = read("3.0.0", &on_sphere(bad));
    assert_eq!(
        messages,
        [
            "error 3:37 `period` must be positive",
            "error 2:78 the efficiencies of all orders, ±m counted twice, exceed 1"
        ]
    );
}

#[test]
fn height_fields() {
    let (d, m) = model(
        r#"<bsdf type="heightfield"><texture name="heights" type="checkerboard"/>
        <float name="scale" value="0.02"/></bsdf>"#,
    );
    let MaterialModel::HeightField { heights, scale, reflectance } = m else { panic!("{m:?}") };
    assert!(matches!(node(&d, heights), TextureNode::Checkerboard { .. }));
    assert_eq!((scale, float(&d, reflectance)), (0.02, 1.0));
}

#[test]
fn polarizing_filters() {
    let (d, m) = model(r#"<bsdf type="polarizer"><spectrum name="theta" value="90"/></bsdf>"#);
    let MaterialModel::Filter { element: FilterModel::Linear { theta }, transmittance } = m else {
        panic!("{m:?}")
    };
    assert_eq!((float(&d, theta), float(&d, transmittance)), (90.0, 1.0));
    let (d, m) = model(
        r#"<bsdf type="retarder"><float name="theta" value="20"/>
        <float name="transmittance" value="0.25"/></bsdf>"#,
    );
    let MaterialModel::Filter { element: FilterModel::Retarder { theta, delta }, transmittance } =
        m
    else {
        panic!("{m:?}")
    };
    assert_eq!((float(&d, theta), float(&d, delta)), (20.0, 90.0));
    assert_eq!(float(&d, transmittance), 0.25);
    let element = |xml| match model(xml).1 {
        MaterialModel::Filter { element, .. } => element,
        other => panic!("{other:?}"),
    };
    let left = r#"<bsdf type="circular"><boolean name="left_handed" value="true"/></bsdf>"#;
    assert_eq!(element(left), FilterModel::Circular { left_handed: true });
    let grey = r#"<bsdf type="polarizer"><boolean name="polarizing" value="false"/></bsdf>"#;
    assert_eq!(element(grey), FilterModel::Grey);
}
