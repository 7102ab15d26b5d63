//! Shapes and their defaults.

use super::{messages, number, read, world};
use kaustika_math::Vec3;
use kaustika_scene::description::{CurveProfile, GeometryDesc, ShapeDesc};

fn geometry(text: &str) -> GeometryDesc {
    world(text).shapes[0].geometry.clone()
}

#[test]
fn quadrics() {
    let sphere = GeometryDesc::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
    assert_eq!(geometry("Shape \"sphere\""), sphere);
    let text = "Shape \"sphere\" \"float radius\" 2 \"float zmin\" 1 \"float zmax\" -9 \"float phimax\" 90";
    let cut = GeometryDesc::Sphere { radius: 2.0, z_min: -2.0, z_max: 1.0, phi_max: 90.0 };
    assert_eq!(geometry(text), cut);
    let disk = GeometryDesc::Disk { height: 0.0, radius: 1.0, inner_radius: 0.0, phi_max: 360.0 };
    assert_eq!(geometry("Shape \"disk\""), disk);
    let tube = GeometryDesc::Cylinder { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
    assert_eq!(geometry("Shape \"cylinder\""), tube);
}

#[test]
fn meshes() {
    let one = geometry("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]");
    let GeometryDesc::Mesh(m) = one else { panic!() };
    assert_eq!((m.indices.as_slice(), m.positions.len()), ([[0, 1, 2]].as_slice(), 3));
    let text = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 2 0 1 ]
        \"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ] \"point2 uv\" [ 0 0 1 0 0 1 ] \"vector3 S\" [ 1 0 0 1 0 0 1 0 0 ]
        \"integer faceIndices\" [ 0 ]";
    let GeometryDesc::Mesh(m) = geometry(text) else { panic!() };
    // The corners are turned so that the front faces the normals.
    assert_eq!(m.indices, [[2, 1, 0]]);
    assert_eq!((m.normals.len(), m.uvs.len(), m.uvs[1].x), (3, 3, 1.0));
    let text = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ]";
    let GeometryDesc::BilinearPatches { indices, positions, .. } = geometry(text) else { panic!() };
    assert_eq!((indices.as_slice(), positions.len()), ([[0, 1, 2, 3]].as_slice(), 4));
}

#[test]
fn orientation_is_that_of_reverse_orientation_alone() {
    let text = "Scale -1 1 1 Shape \"sphere\" ReverseOrientation Shape \"sphere\"";
    let s = world(text);
    assert_eq!([0, 1].map(|i| s.shapes[i].flip_normals), [false, true]);
}

#[test]
fn alpha_cuts_out() {
    let s = world("Shape \"sphere\" \"float alpha\" .3 Shape \"sphere\" \"float alpha\" 1");
    assert_eq!(s.shapes[0].alpha.map(|a| number(&s, a)), Some(0.3));
    assert!(s.shapes[1].alpha.is_none());
    let s = world(
        "Texture \"a\" \"float\" \"constant\" \"float value\" .5
        Shape \"sphere\" \"texture alpha\" \"a\"",
    );
    assert_eq!(s.shapes[0].alpha.map(|a| number(&s, a)), Some(0.5));
}

#[test]
fn subdivision_surfaces_are_their_limits() {
    // A flat square stays flat, its boundary becomes a B-spline: the corner two thirds of itself.
    let s = world(
        "Shape \"loopsubdiv\" \"integer levels\" 2
        \"point3 P\" [ 0 0 0  1 0 0  1 1 0  0 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]",
    );
    let GeometryDesc::Mesh(m) = &s.shapes[0].geometry else { panic!() };
    assert_eq!(m.indices.len(), 32);
    assert!(m.normals.iter().all(|n| (n.z + 1.0).abs() < 1e-6), "the side pbrt has as front");
    assert!((m.positions[0] - Vec3::new(1.0, 1.0, 0.0) / 6.0).length() < 1e-6);
    let s = read(
        "WorldBegin Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 1 0 2 0 1 2 ]",
    );
    assert_eq!(
        messages(&s),
        "error 1:64 <\"integer indices\"> can't subdivide: the triangles at point 0 do not form one \
         fan of one orientation\n"
    );
}

#[test]
fn curves_of_all_bases_and_degrees() {
    let curve = |p: &str| {
        let s = world(&format!("Shape \"curve\" {p}"));
        let GeometryDesc::Curves(c) = &s.shapes[0].geometry else { panic!() };
        (**c).clone()
    };
    let points = "\"point3 P\" [ 0 0 0  1 0 0  2 0 0  3 0 0  4 0 0 ]";
    let c =
        curve("\"point3 P\" [ 0 0 0  1 2 0  2 2 0  3 0 0 ] \"float width0\" 2 \"float width1\" 4");
    assert_eq!((c.profile, c.segments.len()), (CurveProfile::Flat, 1));
    assert_eq!(c.segments[0].points[1], Vec3::new(1.0, 2.0, 0.0));
    assert_eq!([0, 3].map(|i| c.segments[0].radii[i]), [1.0, 2.0]);
    // Quadratic: two segments; their ends are every second point.
    let c = curve(&format!(
        "{points} \"integer degree\" 2 \"string type\" \"cylinder\" \"float width\" 1"
    ));
    assert_eq!((c.profile, c.segments.len()), (CurveProfile::Cylinder, 2));
    assert_eq!(c.segments[1].points[3], Vec3::X * 4.0);
    // B-splines do not reach their end points.
    let c = curve(&format!("{points} \"string basis\" \"bspline\""));
    assert_eq!(c.segments.len(), 2);
    assert!((c.segments[0].points[0] - Vec3::X).length() < 1e-6);
    assert!((c.segments[1].points[3] - Vec3::X * 3.0).length() < 1e-6);
    let c = curve(&format!("{points} \"string basis\" \"bspline\" \"integer degree\" 2"));
    assert_eq!((c.segments.len(), c.segments[2].points[3]), (3, Vec3::X * 3.5));
    let c = curve(&format!(
        "{points} \"string basis\" \"bspline\" \"string type\" \"ribbon\"
        \"normal N\" [ 0 0 2  0 1 0  1 0 0 ]"
    ));
    assert_eq!(c.normals, [[Vec3::Z, Vec3::Y], [Vec3::Y, Vec3::X]]);
}

#[test]
fn curves_that_share_all_else_are_one_shape() {
    let curve = "Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ]";
    let s = world(&format!(
        "{curve} {curve} Translate 1 0 0 {curve} Material \"conductor\" {curve} {curve} Shape \"sphere\" {curve}"
    ));
    let count = |s: &ShapeDesc| match &s.geometry {
        GeometryDesc::Curves(c) => c.segments.len(),
        _ => 0,
    };
    assert_eq!(s.shapes.iter().map(count).collect::<Vec<_>>(), [2, 1, 2, 0, 1]);
}

#[test]
fn faults_of_curves() {
    let fault = |p: &str| messages(&read(&format!("WorldBegin Shape \"curve\" {p}")));
    let points = "\"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 1 1 1 ]";
    for (p, expected) in [
        ("", "error 1:18 <\"curve\"> shape `curve` needs \"point3 P\"\n"),
        (
            points,
            "error 1:26 <\"point3 P\"> 5 points for a curve of degree 3; give 4 and 3 for each \
             further segment\n",
        ),
        (
            "\"point3 P\" [ 0 0 0 ] \"string basis\" \"bspline\"",
            "error 1:26 <\"point3 P\"> 1 points for a curve of degree 3; give at least 4\n",
        ),
        (
            "\"integer degree\" 4",
            "error 1:26 <\"integer degree\"> a curve has degree 2 or 3, not 4\n",
        ),
        (
            "\"string type\" \"cylindre\"",
            "error 1:40 <\"cylindre\"> unknown type `cylindre` of a curve; did you mean \
             `cylinder`?\n",
        ),
        (
            "\"float width0\" -1",
            "error 1:26 <\"float width0\"> the width of a curve must not be negative\n",
        ),
        (
            "\"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ] \"string type\" \"ribbon\" \"normal N\" [ 0 0 1 ]",
            "error 1:88 <\"normal N\"> 1 normals for a ribbon of 1 segments, not 2\n",
        ),
    ] {
        assert_eq!(fault(p), expected, "{p}");
    }
    let s = read(
        "WorldBegin AreaLightSource \"diffuse\" Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ]",
    );
    assert_eq!(messages(&s), "warning 1:38 <Shape> lights on curves do not shine\n");
}

#[test]
fn a_large_mesh_is_read_whole() {
    let n = 10_000;
    let points: String = (0..3 * n).map(|i| format!("{}.5 ", i % 977)).collect();
    let indices: String = (0..3 * n).map(|i| format!("{} ", i % n)).collect();
    let text = format!(
        "WorldBegin Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}]"
    );
    let s = read(&text);
    assert_eq!(messages(&s), "");
    let GeometryDesc::Mesh(m) = &s.shapes[0].geometry else { panic!() };
    assert_eq!((m.positions.len(), m.indices.len()), (n, n));
    assert_eq!(
        (m.positions[n - 1].z, m.indices[n - 1][2]),
        (((3 * n - 1) % 977) as f32 + 0.5, n as u32 - 1)
    );
}
