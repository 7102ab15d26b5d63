//! Variables, includes, paths, references, transforms, dialects.

use super::*;
use crate::mitsuba::{matrix, upgrade, values, variables};
use kaustika_math::Vec3;

#[test]
fn the_version_decides_the_dialect() {
    let conductor = on_sphere(r#"<bsdf type="conductor"/>"#);
    let new = scene(&conductor);
    assert_eq!(new.format, SourceFormat::Mitsuba3);
    let MaterialModel::Conductor { color, .. } = only_model(&new) else { panic!() };
    assert_eq!(*color, ConductorColor::Mirror);
    let old = scene06(&conductor);
    assert_eq!(old.format, SourceFormat::Mitsuba06);
    // 0.6 assumes copper, seen from air: a table over 1.000277.
    let MaterialModel::Conductor { color: ConductorColor::EtaK { eta, .. }, .. } = only_model(&old)
    else {
        panic!()
    };
    let TextureNode::Scale { scale, .. } = node(&old, *eta) else { panic!() };
    assert_eq!(*node(&old, *scale), TextureNode::Float(1.0 / 1.000277));
    for (version, format) in [
        ("2.0.0", SourceFormat::Mitsuba3),
        ("2.1", SourceFormat::Mitsuba3),
        ("0.4.0", SourceFormat::Mitsuba06),
        ("0.5.0", SourceFormat::Mitsuba06),
    ] {
        assert_eq!(silent(version, "").format, format, "{version}");
    }
}

#[test]
fn camel_case_is_upgraded() {
    for (old, new) in [
        ("toWorld", "to_world"),
        ("intIOR", "int_ior"),
        ("diffuseReflectance", "diffuse_reflectance"),
        ("alphaU", "alpha_u"),
        ("uscale", "uscale"),
        ("B", "B"),
        ("hideEmitters", "hide_emitters"),
    ] {
        assert_eq!(upgrade::snake_case(old), new);
        assert_eq!(upgrade::camel_case(new), old);
    }
}

#[test]
fn variables_are_replaced_longest_first() {
    let mut v = variables::Variables::new(&[("a".into(), "1".into()), ("ab".into(), "2".into())]);
    v.set_default("a", "9");
    v.set_default("c", "3");
    assert_eq!(v.substitute("$a$ab $c"), Ok("12 3".to_string()));
    assert_eq!(v.substitute(r"\$a"), Ok("$a".to_string()));
    assert_eq!(v.substitute("x$nope_1-"), Err("nope_1".to_string()));
    assert_eq!(v.unused().count(), 0);
}

#[test]
fn defines_override_defaults() {
    let text = r#"<scene version="3.0.0">
        <default name="spp" value="16"/>
        <sensor type="perspective"><sampler type="halton">
            <integer name="sample_count" value="$spp"/>
        </sampler></sensor></scene>"#;
    let files = Files::new(&[("a.xml", text)]);
    assert_eq!(files.read("a.xml", &[]).cameras[0].spp, Some(16));
    let d = files.read("a.xml", &[("spp", "0x20")]);
    assert_eq!(d.cameras[0].spp, Some(32));
    assert_eq!(d.cameras[0].sampler.as_deref(), Some("halton"));
    assert!(d.diagnostics.entries.is_empty());
}

#[test]
fn includes_paths_and_aliases() {
    let main = r#"<scene version="3.0.0">
        <path value="data"/>
        <default name="radius" value="2"/>
        <include filename="parts/camera.xml"/>
        <include filename="parts/glass.xml"/>
        <alias id="glass" as="window"/>
        <shape type="sphere"><float name="radius" value="$radius"/><ref id="window"/></shape>
        <shape type="sphere"><ref id="later"/></shape>
        <bsdf type="diffuse" id="later">
            <spectrum name="reflectance" filename="grey.spd"/>
        </bsdf>
    </scene>"#;
    let files = Files::new(&[
        ("a.xml", main),
        // In the folder of the file that includes it; the scene element is left out.
        ("parts/camera.xml", r#"<scene version="3.0.0"><include filename="lens.xml"/></scene>"#),
        ("parts/lens.xml", r#"<sensor type="perspective" version="3.0.0" id="eye"/>"#),
        (
            "parts/glass.xml",
            r#"<bsdf type="dielectric" version="0.6.0" id="glass">
            <float name="intIOR" value="1.5"/><float name="extIOR" value="1"/></bsdf>"#,
        ),
        ("data/grey.spd", "# wavelength value\n400 0.5\n700 0.5\n"),
    ]);
    let d = files.read("a.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    assert_eq!((d.cameras.len(), d.shapes.len(), d.sources.files.len()), (1, 2, 4));
    assert_eq!(d.cameras[0].name, "eye");
    assert!(matches!(d.shapes[0].geometry, GeometryDesc::Sphere { radius: 2.0, .. }));
    let glass = &d.materials[d.shapes[0].material.0 as usize];
    assert_eq!(glass.name, "glass");
    let MaterialModel::Dielectric { ior: IorDesc::Constant(1.5), .. } = glass.model else {
        panic!("{glass:?}")
    };
    let grey = &d.materials[d.shapes[1].material.0 as usize];
    let MaterialModel::Diffuse { reflectance } = grey.model else { panic!() };
    let TextureNode::Spectrum(spectrum) = node(&d, reflectance) else { panic!() };
    assert_eq!(spectrum.value_at(550.0), Some(0.5));
}

#[test]
fn objects_that_are_shared_are_made_once() {
    let d = scene(
        r#"<texture type="checkerboard" id="t"/>
        <bsdf type="diffuse" id="m"><ref name="reflectance" id="t"/></bsdf>
        <bsdf type="plastic" id="p"><ref name="diffuse_reflectance" id="t"/></bsdf>
        <shape type="sphere"><ref id="m"/></shape><shape type="cube"><ref id="m"/></shape>
        <shape type="disk"><ref id="p"/></shape>"#,
    );
    assert_eq!(d.shapes[0].material, d.shapes[1].material);
    assert_eq!(d.materials.len(), 2);
    let boards = d.textures.iter().filter(|t| matches!(t.node, TextureNode::Checkerboard { .. }));
    assert_eq!(boards.count(), 1);
}

#[test]
fn later_steps_apply_after() {
    let d = scene(
        r#"<shape type="cube"><transform name="to_world">
            <scale x="2" y="3"/>
            <rotate z="1" angle="90"/>
            <translate value="10, 20, 30"/>
        </transform></shape>"#,
    );
    let p = d.shapes[0].transform.point(Vec3::new(1.0, 1.0, 1.0));
    assert!((p - Vec3::new(10.0 - 3.0, 20.0 + 2.0, 31.0)).length() < 1e-5, "{p:?}");
}

#[test]
fn every_step_is_read() {
    let point = |steps: &str| {
        let d = scene(&format!(
            r#"<shape type="cube"><transform name="to_world">{steps}</transform></shape>"#
        ));
        d.shapes[0].transform.point(Vec3::new(1.0, 2.0, 3.0))
    };
    for (steps, expected) in [
        (r#"<scale value="2"/>"#, [2.0, 4.0, 6.0]),
        (r#"<scale value="1 2,3"/>"#, [1.0, 4.0, 9.0]),
        (r#"<translate z="-1"/>"#, [1.0, 2.0, 2.0]),
        (r#"<matrix value="0 1 0  1 0 0  0 0 1"/>"#, [2.0, 1.0, 3.0]),
        (r#"<matrix value="0 1 0 5 1 0 0 6 0 0 1 7 0 0 0 1"/>"#, [7.0, 7.0, 10.0]),
        (r#"<rotate value="1, 0, 0" angle="90"/>"#, [1.0, -3.0, 2.0]),
        // +z to the target, +x = up x z: left.
        (r#"<lookat origin="0,0,5" target="0,0,4" up="0,1,0"/>"#, [-1.0, 2.0, 2.0]),
    ] {
        let expected = Vec3::from(expected.map(|v: f32| v));
        assert!((point(steps) - expected).length() < 1e-5, "{steps}: {:?}", point(steps));
    }
    // Without an up vector any frame will do.
    let free = matrix::look_at([0.0; 3], [0.0, 0.0, -2.0], [0.0; 3]).expect("a frame");
    assert_eq!([free[0][2], free[1][2], free[2][2]], [0.0, 0.0, -1.0]);
}

#[test]
fn shapes_and_cameras_move_and_lights_do_not() {
    let moving = r#"<animation name="toWorld">
<transform time="1"><translate x="2"/></transform>
<transform time="0"><translate x="1"/></transform>
</animation>"#;
    let (d, messages) = read(
        "0.6.0",
        &format!(
            r#"<shape type="cube">{moving}</shape><sensor type="perspective">{moving}</sensor>
<shape type="cube">{moving}<emitter type="area"/></shape>"#
        ),
    );
    assert_eq!(
        messages,
        ["warning 9:20 a shape does not move here | the first key stands for all"]
    );
    assert_eq!((d.shapes.len(), d.groups[0].shapes.len()), (1, 1));
    assert!(d.groups[0].shapes[0].transform.is_identity());
    for motion in [&d.instances[0].motion, &d.cameras.last().unwrap().motion] {
        assert_eq!(motion.iter().map(|k| k.time).collect::<Vec<_>>(), [0.0, 1.0]);
        assert_eq!(motion[1].transform.point(Vec3::ZERO), Vec3::X * 2.0);
    }
    assert_eq!(d.shapes[0].transform.point(Vec3::ZERO), Vec3::X);
}

#[test]
fn values_are_read_leniently() {
    assert_eq!(values::integer(" 0x1F "), Ok(31));
    assert_eq!(values::integer("-12"), Ok(-12));
    assert!(values::integer("--3").is_err() && values::integer("1.5").is_err());
    assert_eq!(values::boolean("True"), Ok(true));
    assert_eq!(values::color("#ff8000").map(|c| c[1]), Ok(128.0 / 255.0));
    assert_eq!(values::color("0.5"), Ok([0.5; 3]));
    assert!(values::color("#ff80").is_err() && values::color("1 2").is_err());
    assert!(values::number("inf").is_err() && values::number("NaN").is_err());
    assert_eq!(values::triple("1,2 3", false), Ok([1.0, 2.0, 3.0]));
}

#[test]
fn integrators_and_their_depths() {
    let of = |xml: &str| scene(xml).integrator;
    let path = of(r#"<integrator type="path"><integer name="max_depth" value="6"/>
        <integer name="rr_depth" value="5"/><boolean name="hide_emitters" value="true"/>
        </integrator>"#);
    assert_eq!((path.name.as_str(), path.max_depth), ("path", Some(5)));
    assert_eq!((path.rr_depth, path.hide_emitters), (Some(4), true));
    let endless =
        of(r#"<integrator type="path"><integer name="max_depth" value="-1"/></integrator>"#);
    assert_eq!((endless.max_depth, endless.rr_depth), (None, None));
    assert_eq!(of(r#"<integrator type="direct"/>"#).max_depth, Some(1));
    let none = of("");
    assert_eq!((none.name.as_str(), none.max_depth), ("path", None));
    let inner = scene(
        r#"<integrator type="aov"><string name="aovs" value="dd.y:depth, nn:sh_normal,gn:geo_normal"/>
        <integrator type="moment"><integrator type="volpath">
            <integer name="max_depth" value="2"/></integrator></integrator></integrator>"#,
    );
    assert_eq!((inner.integrator.name.as_str(), inner.integrator.max_depth), ("volpath", Some(1)));
    assert_eq!(inner.cameras[0].film.aovs, ["depth", "sh_normal", "normal"]);
    let (depths, said) = read(
        "3.0.0",
        r#"<integrator type="aov"><integrator type="depth"/><integrator type="direct"/></integrator>"#,
    );
    assert_eq!(depths.cameras[0].film.aovs, ["depth"]);
    assert_eq!(depths.integrator.name, "direct");
    let note = "note 2:24 the distances of integrator `depth` are the layer Depth.Z";
    assert_eq!(said, [note]);
    let (alone, _) = read("3.0.0", r#"<integrator type="depth"/>"#);
    assert_eq!(alone.cameras[0].film.aovs, ["depth"]);
    let stokes = of(r#"<integrator type="stokes"><integrator type="path">
        <integer name="max_depth" value="4"/></integrator></integrator>"#);
    assert_eq!((stokes.name.as_str(), stokes.max_depth, stokes.polarized), ("path", Some(3), true));
    assert!(!inner.integrator.polarized);
    let strict = scene06(
        r#"<integrator type="path"><boolean name="strictNormals" value="true"/></integrator>"#,
    );
    assert!(strict.integrator.strict_normals);
}

#[test]
fn layers_that_are_not_there() {
    let layers = |kinds: &str| {
        let text = format!(
            "<scene version=\"3.0.0\">{CAMERA}<integrator type=\"aov\"><string name=\"aovs\" \
             value=\"{kinds}\"/></integrator></scene>"
        );
        let files = Files::new(&[("a.xml", &text)]);
        files.messages(&files.read("a.xml", &[]))
    };
    let left_out = layers("a:prim_index");
    assert!(left_out[0].starts_with("warning") && left_out[0].contains("layer `prim_index`"));
    let unknown = layers("a:depht");
    assert!(unknown[0].starts_with("error") && unknown[0].contains("unknown layer `depht`"));
    assert!(unknown[0].contains("depth"), "{unknown:?}");
}
