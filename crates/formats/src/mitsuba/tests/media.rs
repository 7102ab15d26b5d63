//! Media, volumes and phase functions.

use super::*;
use kaustika_math::Vec3;
use kaustika_spectra::{ColorSpace, SpectrumDesc};

fn constant(v: f32) -> FieldDesc {
    FieldDesc::Constant(SpectrumDesc::Constant(v))
}

fn rgb(rgb: [f32; 3]) -> FieldDesc {
    FieldDesc::Constant(SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb })
}

#[test]
fn homogeneous_media() {
    let d = scene(
        r#"<medium type="homogeneous" id="fog">
  <rgb name="sigma_t" value="1 2 3"/><float name="albedo" value="0.5"/><float name="scale" value="4"/>
  <phase type="hg"><float name="g" value="0.3"/></phase>
</medium>
<medium type="homogeneous" id="plain"/>
<shape type="cube"><bsdf type="null"/><ref name="interior" id="fog"/><ref name="exterior" id="plain"/></shape>"#,
    );
    let m = &d.media[0];
    assert_eq!((m.name.as_str(), m.kind.as_str(), m.scale), ("fog", "homogeneous", 4.0));
    let coefficients = CoefficientsDesc::ExtinctionAlbedo(rgb([1.0, 2.0, 3.0]), constant(0.5));
    assert_eq!(m.coefficients, coefficients);
    assert_eq!(m.phase, PhaseDesc::HenyeyGreenstein { g: 0.3 });
    assert_eq!(m.extent, None);
    let defaults = CoefficientsDesc::ExtinctionAlbedo(constant(1.0), constant(0.75));
    assert_eq!((&d.media[1].coefficients, &d.media[1].phase), (&defaults, &PhaseDesc::Isotropic));
    let sides = (d.shapes[0].interior, d.shapes[0].exterior);
    assert_eq!(sides, (Some(MediumId(0)), Some(MediumId(1))));
    assert_eq!(*only_model(&d), MaterialModel::Null { counts: true });
}

#[test]
fn null_is_no_bounce_for_integrators_that_know_media() {
    let d = scene(r#"<shape type="cube"><bsdf type="null"/></shape><integrator type="volpath"/>"#);
    assert_eq!(*only_model(&d), MaterialModel::Null { counts: false });
}

#[test]
fn media_of_old() {
    let d = scene06(
        r#"<medium type="homogeneous"><string name="material" value="Marble"/></medium>
<medium type="homogeneous"><rgb name="sigmaS" value="1 1 2"/><rgb name="sigmaA" value="0 0 1"/></medium>
<medium type="homogeneous"><float name="sigmaT" value="2"/><float name="albedo" value="0.25"/></medium>"#,
    );
    let of = |a, s| CoefficientsDesc::AbsorptionScattering(rgb(a), rgb(s));
    assert_eq!(d.media[0].coefficients, of([0.0021, 0.0041, 0.0071], [2.19, 2.62, 3.0]));
    assert_eq!(d.media[1].coefficients, of([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]));
    let by_albedo = CoefficientsDesc::ExtinctionAlbedo(constant(2.0), constant(0.25));
    assert_eq!(d.media[2].coefficients, by_albedo);
}

/// A `.vol` file of floats in the box from 0 to (1, 2, 4).
fn vol(resolution: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for i in [1, resolution[0], resolution[1], resolution[2], channels] {
        bytes.extend(i.to_le_bytes());
    }
    for f in [0.0, 0.0, 0.0, 1.0, 2.0, 4.0] {
        bytes.extend(f32::to_le_bytes(f));
    }
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// Reads a scene beside the volume `a.vol` of two samples.
fn beside_volume(version: &str, inner: &str) -> (SceneDescription, Vec<String>) {
    let text = format!("<scene version=\"{version}\">{CAMERA}\n{inner}</scene>");
    let files = Files::new(&[("a.xml", &text)]);
    let bytes = vol([2, 1, 1], 1, &[0.5, 2.0]);
    std::fs::write(files.folder.path().join("a.vol"), bytes).expect("files can be written");
    let d = files.read("a.xml", &[]);
    let messages = files.messages(&d);
    (d, messages)
}

#[test]
fn grids_and_their_boxes() {
    for (by_file, corner) in [(false, [3.0, 3.0, 3.0]), (true, [3.0, 5.0, 9.0])] {
        let (d, messages) = beside_volume(
            "3.0.0",
            &format!(
                r#"<medium type="heterogeneous"><volume type="gridvolume" name="sigma_t">
<string name="filename" value="a.vol"/><boolean name="use_grid_bbox" value="{by_file}"/>
<transform name="to_world"><scale value="2"/><translate value="1"/></transform></volume>
<volume type="constvolume" name="albedo"><rgb name="value" value="0.1 0.2 0.3"/></volume></medium>"#
            ),
        );
        assert_eq!(messages, Vec::<String>::new());
        let CoefficientsDesc::ExtinctionAlbedo(FieldDesc::Grid(grid), albedo) =
            &d.media[0].coefficients
        else {
            panic!("{:?}", d.media[0].coefficients)
        };
        assert_eq!(*albedo, rgb([0.1, 0.2, 0.3]));
        assert_eq!((grid.resolution, grid.channels), ([2, 1, 1], 1));
        assert_eq!(
            (grid.values.as_slice(), grid.layout),
            (&[0.5, 2.0][..], GridLayout::CellsClamped)
        );
        let extent = d.media[0].extent.expect("a box");
        for box_ in [&extent, &grid.to_world] {
            let (low, high) = (box_.point(Vec3::ZERO), box_.point(Vec3::splat(1.0)));
            assert_eq!((low, high), (Vec3::splat(1.0), corner.into()), "{by_file}");
        }
    }
}

#[test]
fn densities_of_old() {
    let (d, messages) = beside_volume(
        "0.6.0",
        r#"<medium type="heterogeneous"><string name="method" value="woodcock"/>
<volume type="gridvolume" name="density"><string name="filename" value="a.vol"/></volume>
<volume type="constvolume" name="albedo"><float name="value" value="0.9"/></volume>
<float name="scale" value="10"/></medium>"#,
    );
    assert_eq!(messages, Vec::<String>::new());
    let m = &d.media[0];
    let CoefficientsDesc::ExtinctionAlbedo(FieldDesc::Grid(grid), _) = &m.coefficients else {
        panic!("{:?}", m.coefficients)
    };
    assert_eq!((grid.layout, m.scale), (GridLayout::Corners, 10.0));
    assert_eq!(m.extent.expect("a box").point(Vec3::splat(1.0)), Vec3::new(1.0, 2.0, 4.0));
}

#[test]
fn phase_functions() {
    let d = scene(
        r#"<medium type="homogeneous"><phase type="blendphase"><float name="weight" value="0.2"/>
<phase type="rayleigh"/><phase type="hg"/></phase></medium>
<medium type="homogeneous"><phase type="tabphase"><string name="values" value="1, 2 3.5"/></phase></medium>"#,
    );
    let (a, b) = (PhaseDesc::Rayleigh, PhaseDesc::HenyeyGreenstein { g: 0.8 });
    let blend = PhaseDesc::Blend { weight: 0.2, a: Box::new(a), b: Box::new(b) };
    assert_eq!(d.media[0].phase, blend);
    assert_eq!(d.media[1].phase, PhaseDesc::Tabulated { values: vec![1.0, 2.0, 3.5] });
    let d = scene(
        r#"<medium type="homogeneous"><phase type="sggx">
<volume name="S" type="constvolume"><string name="value" value="1, 0.5 0.3, 0.1, 0, -0.1"/></volume></phase></medium>
<medium type="homogeneous"><phase type="sggx"><string name="S" value="1 1 1 0 0 0"/></phase></medium>"#,
    );
    let s = PhaseDesc::Sggx(SggxDesc::Constant([1.0, 0.5, 0.3, 0.1, 0.0, -0.1]));
    assert_eq!(d.media[0].phase, s);
    assert_eq!(
        d.media[1].phase,
        PhaseDesc::Sggx(SggxDesc::Constant([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    );
    // 0.6: half of the first, a quarter each of the others.
    let (d, messages) = read(
        "0.6.0",
        r#"<medium type="homogeneous"><phase type="mixturephase"><string name="weights" value="0.5, 0.25, 0.25"/>
<phase type="rayleigh"/><phase type="hg"/><phase type="isotropic"/></phase></medium>"#,
    );
    assert_eq!(messages, Vec::<String>::new());
    let blend = |weight, a, b| PhaseDesc::Blend { weight, a: Box::new(a), b: Box::new(b) };
    let first = blend(1.0, PhaseDesc::Isotropic, PhaseDesc::Rayleigh);
    let two = blend(1.0 / 3.0, first, PhaseDesc::HenyeyGreenstein { g: 0.8 });
    assert_eq!(d.media[0].phase, blend(0.25, two, PhaseDesc::Isotropic));
}

#[test]
fn grids_of_microflakes() {
    for (channels, samples, expected) in [
        (6, [1.0f32, 1.0, 1.0, -0.5, 0.0, 0.0], None),
        (6, [1.0, 1.0, 1.0, 2.0, 0.0, 0.0], Some("sample 0 of `S` is not positive semidefinite")),
    ] {
        let text = format!(
            r#"<scene version="3.0.0">{CAMERA}
<medium type="homogeneous"><phase type="sggx"><volume name="S" type="gridvolume"><string name="filename" value="s.vol"/></volume></phase></medium></scene>"#
        );
        let files = Files::new(&[("a.xml", &text)]);
        let bytes = vol([1, 1, 1], channels, &samples);
        std::fs::write(files.folder.path().join("s.vol"), bytes).expect("files can be written");
        let d = files.read("a.xml", &[]);
        match expected {
            None => assert!(
                matches!(&d.media[0].phase, PhaseDesc::Sggx(SggxDesc::Grid(g)) if g.values == samples),
                "{:?}",
                files.messages(&d)
            ),
            Some(message) => assert!(files.messages(&d)[0].ends_with(message)),
        }
    }
}

#[test]
fn faults() {
    let (_, messages) = read(
        "3.0.0",
        r#"<medium type="homogenous"/>
<medium type="homogeneous"><phase type="hg"><float name="g" value="1"/></phase></medium>
<medium type="homogeneous"><phase type="tabphase"><string name="values" value="1"/></phase></medium>
<medium type="homogeneous"><phase type="blendphase"><phase type="hg"/></phase></medium>
<medium type="homogeneous"><phase type="sggx"/></medium>
<medium type="homogeneous"><float name="sigmat" value="1"/></medium>
<medium type="heterogeneous"><volume name="sigma_t" type="gridvolume"/></medium>"#,
    );
    assert_eq!(
        messages,
        [
            "error 2:15 unknown medium `homogenous` | did you mean `homogeneous`?",
            "error 3:68 `g` must lie between -1 and 1, found 1",
            "error 4:80 a phase function needs two values or more, none negative, not all 0",
            "error 5:28 phase `blendphase` needs 2 phases inside, found 1",
            "error 6:28 phase `sggx` needs `S`: a `gridvolume` of six channels, or the six numbers \
             xx, yy, zz, xy, xz, yz in a `<string>`",
            "warning 7:28 unknown parameter `sigmat` of medium `homogeneous` | did you mean \
             `sigma_t`?",
            "error 8:30 volume `gridvolume` needs `filename`",
        ]
    );
    let (_, messages) = beside_volume(
        "3.0.0",
        r#"<medium type="heterogeneous"><volume name="sigma_t" type="gridvolume">
<string name="filename" value="a.xml"/></volume></medium>"#,
    );
    assert_eq!(
        messages,
        ["error 3:32 can't read the volume `a.xml`: not a volume: it does not begin with `VOL`",]
    );
}

#[test]
fn volumes_as_textures() {
    let (d, messages) = beside_volume(
        "3.0.0",
        r#"<shape type="sphere"><bsdf type="diffuse"><texture type="volume" name="reflectance">
<volume type="gridvolume" name="volume"><string name="filename" value="a.vol"/>
<string name="wrap_mode" value="mirror"/><string name="filter_type" value="nearest"/>
<transform name="to_world"><translate value="1"/></transform></volume></texture></bsdf></shape>
<shape type="sphere"><bsdf type="diffuse"><texture type="volume" name="reflectance">
<volume type="constvolume" name="volume"><float name="value" value="0.25"/></volume></texture></bsdf></shape>"#,
    );
    assert_eq!(messages, Vec::<String>::new());
    let reflectance = |i: usize| match &d.materials[i].model {
        MaterialModel::Diffuse { reflectance } => node(&d, *reflectance),
        other => panic!("{other:?}"),
    };
    let TextureNode::Grid(grid) = reflectance(0) else { panic!("{:?}", reflectance(0)) };
    assert_eq!((grid.layout, grid.filter), (GridLayout::CellsMirrored, GridFilter::Nearest));
    assert_eq!(grid.to_world.point(Vec3::ZERO), Vec3::splat(1.0));
    assert_eq!(*reflectance(1), TextureNode::Spectrum(SpectrumDesc::Constant(0.25)));
}

/// Where a number is asked for, a colour counts as its luminance (seen in Mitsuba 3.9.1).
#[test]
fn coloured_volumes_as_numbers() {
    let bsdf = r#"<bsdf type="roughconductor"><texture type="volume" name="alpha">
<volume type="gridvolume" name="volume"><string name="filename" value="a.vol"/></volume></texture></bsdf>"#;
    let text = format!("<scene version=\"3.0.0\">{CAMERA}\n{}</scene>", on_sphere(bsdf));
    let files = Files::new(&[("a.xml", &text)]);
    let bytes = vol([1, 1, 1], 3, &[0.1, 0.2, 0.4]);
    std::fs::write(files.folder.path().join("a.vol"), bytes).expect("files can be written");
    let d = files.read("a.xml", &[]);
    let MaterialModel::Conductor { roughness, .. } = only_model(&d) else { panic!() };
    let TextureNode::Grid(grid) = node(&d, roughness.alpha_u) else { panic!() };
    let luminance = 0.2126 * 0.1 + 0.7152 * 0.2 + 0.0722 * 0.4;
    assert!((grid.values[0] - luminance).abs() < 1e-4, "{:?}", grid.values);
}

#[test]
fn volume_textures_without_a_volume() {
    let bsdf = r#"<bsdf type="diffuse"><texture type="volume" name="reflectance"/></bsdf>"#;
    let text = format!("<scene version=\"3.0.0\">{CAMERA}\n{}</scene>", on_sphere(bsdf));
    let files = Files::new(&[("a.xml", &text)]);
    let messages = files.messages(&files.read("a.xml", &[]));
    assert!(messages[0].ends_with("texture `volume` needs a volume inside"), "{messages:?}");
}
