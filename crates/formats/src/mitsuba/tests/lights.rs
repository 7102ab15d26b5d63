//! Lights and what spectra mean as light.

use super::*;
use kaustika_math::Vec3;
use kaustika_spectra::{ColorMode, ColorSpace, CompiledSpectrum, SpectrumDesc, SpectrumRole};

fn rgb(rgb: [f32; 3]) -> SpectrumDesc {
    SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb }
}

fn intensity(version: &str, value: &str) -> (SpectrumDesc, f32) {
    let d = silent(version, &format!("<emitter type=\"point\">{value}</emitter>"));
    match &d.lights[0].kind {
        LightKind::Point { intensity, scale, .. } => (intensity.clone(), *scale),
        other => panic!("{other:?}"),
    }
}

#[test]
fn spectra_as_light() {
    let d65 = |scale: f32| (SpectrumDesc::D65 { scale }, 1.0);
    for (version, xml, expected) in [
        ("3.0.0", "", d65(1.0)),
        ("3.0.0", r#"<float name="intensity" value="3"/>"#, d65(3.0)),
        ("3.0.0", r#"<rgb name="intensity" value="300"/>"#, (rgb([300.0; 3]), 1.0)),
        (
            "3.0.0",
            r#"<spectrum name="intensity" value="3"/>"#,
            (SpectrumDesc::EqualEnergy(3.0), 1.0),
        ),
        ("0.6.0", r#"<spectrum name="intensity" value="3"/>"#, d65(3.0)),
        ("0.6.0", r#"<spectrum name="intensity" value="1, 2, 3"/>"#, (rgb([1.0, 2.0, 3.0]), 1.0)),
        ("0.6.0", r##"<srgb name="intensity" value="#00ff00"/>"##, (rgb([0.0, 1.0, 0.0]), 1.0)),
        (
            "0.6.0",
            r#"<blackbody name="intensity" temperature="5000K" scale="2"/>"#,
            (SpectrumDesc::Blackbody { kelvin: 5000.0, normalized: false }, 2.0),
        ),
        (
            "3.0.0",
            r#"<spectrum name="intensity" type="d65"><float name="scale" value="4"/></spectrum>"#,
            d65(4.0),
        ),
        (
            "3.0.0",
            r#"<spectrum name="intensity" type="blackbody">
                <float name="temperature" value="4000"/></spectrum>"#,
            (SpectrumDesc::Blackbody { kelvin: 4000.0, normalized: false }, 1.0),
        ),
        (
            "3.0.0",
            r#"<spectrum name="intensity" type="irregular">
                <string name="wavelengths" value="400, 700"/><string name="values" value="1 2"/>
                </spectrum>"#,
            (SpectrumDesc::sampled(&[400.0, 700.0], &[1.0, 2.0]).expect("valid"), 1.0),
        ),
        (
            "3.0.0",
            r#"<spectrum name="intensity" type="regular"><float name="wavelength_min" value="400"/>
                <float name="wavelength_max" value="600"/><string name="values" value="1 2 3"/>
                </spectrum>"#,
            (SpectrumDesc::sampled(&[400.0, 500.0, 600.0], &[1.0, 2.0, 3.0]).expect("valid"), 1.0),
        ),
    ] {
        assert_eq!(intensity(version, xml), expected, "{xml}");
    }
}

/// The light of the Cornell box: Mitsuba 3's RGB variants integrate the spectrum against the CIE
/// curves, over the integral of ȳ, in linear sRGB. The expected values come from a quadrature of
/// its own, 1000 points as in Mitsuba's `spectrum_list_to_srgb`, which is good to 0.03 %.
#[test]
fn measured_emission_in_rgb() {
    let d = scene(
        r#"<shape type="rectangle"><emitter type="area">
            <spectrum name="radiance" value="400:0, 500:8, 600:15.6, 700:18.4"/></emitter></shape>"#,
    );
    let e = d.shapes[0].emission.as_ref().expect("it shines");
    let TextureNode::Spectrum(desc) = node(&d, e.radiance) else { panic!() };
    let compiled = CompiledSpectrum::new(desc, SpectrumRole::Illuminant, ColorMode::Rgb);
    let wavelengths = kaustika_spectra::Wavelengths::rgb();
    let lanes = compiled.eval(&wavelengths);
    for (lane, expected) in lanes.0.iter().zip([20.71084, 10.85463, 2.771152]) {
        assert!((lane / expected - 1.0).abs() < 3e-4, "{lanes:?}");
    }
}

#[test]
fn places_and_directions() {
    let d = scene(
        r#"<emitter type="point"><point name="position" value="1,2,3"/></emitter>
        <emitter type="directional"><vector name="direction" value="0,-2,0"/></emitter>
        <emitter type="spot"><float name="cutoff_angle" value="40"/></emitter>
        <emitter type="constant"><rgb name="radiance" value="0.1"/></emitter>"#,
    );
    assert_eq!(d.lights[0].transform.point(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    assert!((d.lights[1].transform.vector(Vec3::Z) + Vec3::Y).length() < 1e-6);
    let LightKind::Spot { cutoff, beam_width, falloff, .. } = &d.lights[2].kind else { panic!() };
    assert_eq!((*cutoff, *beam_width), (40.0, 30.0));
    assert_eq!(*falloff, SpotFalloff::LinearAngle);
    let LightKind::Constant { radiance, .. } = &d.lights[3].kind else { panic!() };
    assert_eq!(*radiance, rgb([0.1; 3]));
}

#[test]
fn environment_maps_are_loaded() {
    let pfm: Vec<u8> = b"PF\n2 1\n-1.0\n"
        .iter()
        .copied()
        .chain([1.0f32; 6].iter().flat_map(|v| v.to_le_bytes()))
        .collect();
    let files = Files::new(&[(
        "a.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="envmap">
            <string name="filename" value="sky.pfm"/><float name="scale" value="2"/>
            </emitter></scene>"#,
    )]);
    std::fs::write(files.folder.path().join("sky.pfm"), pfm).expect("it can be written");
    let d = files.read("a.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    let LightKind::Image { bitmap, layout, scale, .. } = &d.lights[0].kind else { panic!() };
    assert_eq!((bitmap.width, bitmap.height, *scale), (2, 1, 2.0));
    assert_eq!(*layout, EnvironmentLayout::LatLong);
}

#[test]
fn area_lights_may_be_shared_from_the_scene() {
    let d = scene(
        r#"<emitter type="area" id="e"><float name="radiance" value="2"/></emitter>
        <shape type="disk"><ref id="e"/></shape><shape type="cube"><ref id="e"/></shape>"#,
    );
    assert!(d.lights.is_empty());
    for shape in &d.shapes {
        let e = shape.emission.as_ref().expect("it shines");
        let expected = TextureNode::Spectrum(SpectrumDesc::D65 { scale: 2.0 });
        assert_eq!(*node(&d, e.radiance), expected);
        assert!(!e.two_sided);
    }
}

#[test]
fn projectors() {
    let d = silent(
        "3.0.0",
        r#"<emitter type="projector"><rgb name="irradiance" value="0.5"/><float name="fov" value="60"/>
<string name="fov_axis" value="y"/><float name="scale" value="3"/></emitter>"#,
    );
    let LightKind::Projector { texture, scale, fov, fov_axis } = d.lights[0].kind else {
        panic!("{:?}", d.lights)
    };
    assert_eq!((scale, fov, fov_axis), (3.0, 60.0, FovAxis::Y));
    assert_eq!(d.textures[texture.0 as usize].node, TextureNode::Spectrum(rgb([0.5; 3])));
}

#[test]
fn lights_of_one_direction() {
    let (d, messages) = read(
        "0.6.0",
        r#"<emitter type="collimated"><spectrum name="power" value="1, 2, 3"/></emitter>
<shape type="sphere"><emitter type="area"/></shape>"#,
    );
    assert_eq!(d.lights[0].kind, LightKind::Beam { power: rgb([1.0, 2.0, 3.0]), scale: 1.0 });
    let hint = "render with `-m light`, `bdpt`, `vcm` or `sppm`; `path` leaves it out";
    let found =
        |name| format!("the light of `{name}` can't be found from the camera's side | {hint}");
    assert_eq!(messages, [format!("note 2:16 {}", found("collimated"))]);
    let (d, messages) =
        read("3.0.0", r#"<shape type="disk"><emitter type="directionalarea"/></shape>"#);
    assert!(d.shapes[0].emission.as_ref().is_some_and(|e| e.along_normal));
    assert_eq!(messages, [format!("note 2:35 {}", found("directionalarea"))]);
}
