//! Shapes, groups, instances, meshes.

use super::*;
use kaustika_math::Vec3;

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

#[test]
fn forms_and_their_placement() {
    let d = scene(
        r#"<shape type="sphere" id="ball"><point name="center" x="1" y="2" z="3"/>
            <float name="radius" value="0.5"/>
            <transform name="to_world"><scale value="2"/></transform></shape>
        <shape type="cylinder"><point name="p0" value="0,0,1"/><point name="p1" value="4,0,1"/>
            <float name="radius" value="2"/></shape>
        <shape type="rectangle"><boolean name="flip_normals" value="true"/></shape>
        <shape type="disk"/><shape type="cube"/>"#,
    );
    let ball = &d.shapes[0];
    assert_eq!(ball.name, "ball");
    assert!(matches!(ball.geometry, GeometryDesc::Sphere { radius: 0.5, z_min: -0.5, .. }));
    assert_eq!(ball.transform.point(Vec3::ZERO), Vec3::new(2.0, 4.0, 6.0));
    // Mitsuba's v grows away from +z.
    assert_eq!(ball.transform.vector(Vec3::Z), Vec3::new(0.0, 0.0, -2.0));
    assert!(!ball.flip_normals);
    let pipe = &d.shapes[1];
    let GeometryDesc::Cylinder { radius, z_min, z_max, .. } = pipe.geometry else { panic!() };
    assert_eq!((radius, z_min, z_max), (2.0, 0.0, 4.0));
    assert!((pipe.transform.point(Vec3::Z * 4.0) - Vec3::new(4.0, 0.0, 1.0)).length() < 1e-6);
    assert!(d.shapes[2].flip_normals);
    assert!(matches!(d.shapes[3].geometry, GeometryDesc::Disk { radius: 1.0, .. }));
    assert_eq!(d.shapes[4].geometry, GeometryDesc::Cube);
}

#[test]
fn mirrored_spheres_turn_inside_out_in_mitsuba_3() {
    let mirrored = |name: &str| {
        format!(
            r#"<shape type="sphere"><transform name="{name}"><scale x="-1"/></transform></shape>"#
        )
    };
    assert!(scene(&mirrored("to_world")).shapes[0].flip_normals);
    assert!(!scene06(&mirrored("toWorld")).shapes[0].flip_normals);
}

#[test]
fn materials_where_none_is_given() {
    let d = scene(
        r#"<shape type="cube"/>
        <shape type="cube"><emitter type="area"/></shape>"#,
    );
    let albedo = |i: usize| {
        let MaterialModel::Diffuse { reflectance } =
            d.materials[d.shapes[i].material.0 as usize].model
        else {
            panic!()
        };
        node(&d, reflectance).clone()
    };
    assert_eq!(albedo(0), TextureNode::Float(0.5));
    assert_eq!(albedo(1), TextureNode::Float(0.0));
}

#[test]
fn meshes_are_loaded_and_shared() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective"/>
        <shape type="obj"><string name="filename" value="m\tri.obj"/></shape>
        <shape type="obj"><string name="filename" value="m/tri.obj"/></shape>
        <shape type="obj"><string name="filename" value="m/tri.obj"/>
            <boolean name="flip_tex_coords" value="false"/>
            <boolean name="face_normals" value="true"/></shape>
        <shape type="shapegroup" id="g">
            <shape type="cube"/>
            <shape type="obj"><string name="filename" value="m/tri.obj"/></shape></shape>
        <shape type="instance"><ref id="g"/></shape>
        <shape type="instance"><ref id="g"/>
            <transform name="to_world"><translate x="3"/></transform></shape>
        </scene>"#;
    let files = Files::new(&[("a.xml", text), ("m/tri.obj", OBJ)]);
    let d = files.read("a.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    let mesh = |s: &ShapeDesc| match &s.geometry {
        GeometryDesc::Mesh(m) => m.clone(),
        other => panic!("{other:?}"),
    };
    assert!(std::sync::Arc::ptr_eq(&mesh(&d.shapes[0]), &mesh(&d.shapes[1])));
    assert_eq!(mesh(&d.shapes[0]).indices.len(), 1);
    assert_eq!(mesh(&d.shapes[0]).uvs[0].y, 0.75);
    assert_eq!(mesh(&d.shapes[0]).normals.len(), 3);
    assert_eq!(mesh(&d.shapes[2]).uvs[0].y, 0.25);
    assert!(mesh(&d.shapes[2]).normals.is_empty());
    assert_eq!((d.shapes.len(), d.groups.len(), d.instances.len()), (3, 1, 2));
    assert_eq!(d.groups[0].shapes[0].geometry, GeometryDesc::Cube);
    assert_eq!(mesh(&d.groups[0].shapes[1]).indices.len(), 1);
    assert_eq!(d.instances[0].group, d.instances[1].group);
    assert_eq!(d.instances[1].transform.point(Vec3::ZERO).x, 3.0);
}

#[test]
fn curves_stand_where_they_are_placed_and_keep_their_radii() {
    let text = "0 0 0 0.1\n1 0 0 0.1\n2 0 0 0.2\n3 0 0 0.2\n4 0 0 0.3\n\n0 1 0 1\n1 1 0 1\n2 1 0 1\n3 1 0 1\n";
    let shape = |kind: &str| {
        format!(
            r#"<shape type="{kind}"><string name="filename" value="hair.txt"/>
            <transform name="to_world"><scale value="2"/></transform></shape>"#
        )
    };
    let xml = format!(
        r#"<scene version="3.0.0">{}{}</scene>"#,
        shape("bsplinecurve"),
        shape("linearcurve")
    );
    let files = Files::new(&[("scene.xml", &xml), ("hair.txt", text)]);
    let d = files.read("scene.xml", &[]);
    let curves = |i: usize| match &d.shapes[i].geometry {
        GeometryDesc::Curves(c) => c.clone(),
        _ => panic!(),
    };
    let (splines, lines) = (curves(0), curves(1));
    assert_eq!((splines.profile, splines.segments.len()), (CurveProfile::Tube, 3));
    assert!((splines.segments[0].points[0] - Vec3::X * 2.0).length() < 1e-6);
    assert!((splines.segments[0].radii[0] - (0.1 + 0.4 + 0.2) / 6.0).abs() < 1e-6);
    assert_eq!((lines.profile, lines.segments.len()), (CurveProfile::Spheres, 7));
    assert_eq!(lines.segments[3].points[3], Vec3::X * 8.0);
    assert_eq!(lines.segments[3].radii[3], 0.3);
}

#[test]
fn faults_of_curve_files_are_told_where_they_are_named() {
    let xml = r#"<scene version="3.0.0"><shape type="bsplinecurve">
<string name="filename" value="hair.txt"/></shape></scene>"#;
    let files = Files::new(&[("scene.xml", xml), ("hair.txt", "0 0 0 1\n0 0 1 1\n")]);
    let d = files.read("scene.xml", &[]);
    let messages = files.messages(&d);
    assert_eq!(
        messages[0],
        "error 2:32 can't read curves hair.txt:2: a curve ends after 2 of at least 4 points"
    );
}

/// A volume file of these samples.
fn vol(resolution: [i32; 3], samples: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for i in [1, resolution[0], resolution[1], resolution[2], 1] {
        bytes.extend(i.to_le_bytes());
    }
    let floats = [0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0];
    bytes.extend(floats.iter().chain(samples).flat_map(|f| f.to_le_bytes()));
    bytes
}

#[test]
fn distance_grids() {
    let shape = |file: &str, more: &str| {
        format!(
            "<shape type=\"sdfgrid\"><string name=\"filename\" value=\"{file}\"/>{more}</shape>\n"
        )
    };
    let normals = r#"<string name="normals" value="analytic"/>"#;
    let place = r#"<transform name="to_world"><scale value="2"/></transform>"#;
    let lamp = r#"<emitter type="area"/>"#;
    let xml = format!(
        "<scene version=\"3.0.0\">\n{}{}{}{}{}</scene>",
        shape("a.vol", place),
        shape("a.vol", normals),
        shape("flat.vol", ""),
        shape("full.vol", ""),
        shape("a.vol", lamp),
    );
    let files = Files::new(&[("scene.xml", &xml)]);
    let distances = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
    for (name, bytes) in [
        ("a.vol", vol([2, 2, 2], &distances)),
        ("flat.vol", vol([2, 2, 1], &distances[..4])),
        ("full.vol", vol([2, 2, 2], &[-1.0; 8])),
    ] {
        std::fs::write(files.folder.path().join(name), bytes).expect("files can be written");
    }
    let d = files.read("scene.xml", &[]);
    let grid = |i: usize| match &d.shapes[i].geometry {
        GeometryDesc::SdfGrid(grid) => grid.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!((grid(0).resolution, grid(0).normals), ([2; 3], SdfNormals::Smooth));
    assert_eq!(grid(0).values, distances);
    assert_eq!(d.shapes[0].transform.point(Vec3::X), Vec3::X * 2.0);
    assert_eq!(grid(1).normals, SdfNormals::Analytic);
    assert_eq!(
        files.messages(&d),
        [
            "error 4:54 can't read the distance grid `flat.vol`: 2 x 2 x 1 samples enclose no cells",
            "error 5:54 can't read the distance grid `full.vol`: its distances are all of one sign: \
             there is no surface",
            "warning 6:1 light sources on a `sdfgrid` are not supported | does not shine",
        ]
    );
}

#[test]
fn ellipsoids_have_their_extent() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty float opacity\nproperty float scale_0\nproperty float scale_1\n\
        property float scale_2\nproperty float rot_0\nproperty float rot_1\nproperty float rot_2\n\
        property float rot_3\nend_header\n\
        1 2 3 40 0 0 0.5 1 0 0 0\n4 0 0 -40 0 0 0 1 0 0 0\n";
    let shape = |more: &str| {
        format!(
            "<shape type=\"ellipsoids\"><string name=\"filename\" value=\"g.ply\"/>{more}</shape>\n"
        )
    };
    let adaptive = r#"<boolean name="extent_adaptive_clamping" value="true"/>"#;
    let sized = r#"<float name="extent" value="2"/><float name="scale_factor" value="0.5"/>
        <transform name="to_world"><translate x="1"/></transform>"#;
    let body = [shape(""), shape(sized), shape(adaptive)].concat();
    let xml = format!("<scene version=\"3.0.0\">{CAMERA}{body}</scene>");
    let files = Files::new(&[("scene.xml", &xml), ("g.ply", ply)]);
    let d = files.read("scene.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    let all = |i: usize| match &d.shapes[i].geometry {
        GeometryDesc::Ellipsoids(all) => all.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(all(0)[0].center, Vec3::new(1.0, 2.0, 3.0));
    assert!((all(0)[0].radii - Vec3::new(3.0, 3.0, 3.0 * 0.5f32.exp())).length() < 1e-5);
    assert_eq!(all(1)[1].radii, Vec3::splat(1.0));
    assert_eq!(d.shapes[1].transform.point(Vec3::ZERO), Vec3::X);
    // √(2 ln(opacity / 0.01)); the second is too faint to be there.
    let extent = (2.0 * 100f32.ln()).sqrt();
    assert_eq!(all(2).len(), 1);
    assert!((all(2)[0].radii.x - extent).abs() < 1e-4);
}
