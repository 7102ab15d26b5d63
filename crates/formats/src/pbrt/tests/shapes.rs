//! Shapes and their defaults.

use super::{messages, number, read, world};
use kaustika_scene::description::GeometryDesc;

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
fn shapes_we_lack() {
    let s = read(
        "WorldBegin Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ]
Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ] \"integer levels\" 2",
    );
    assert_eq!(
        messages(&s),
        "warning 1:18 <\"curve\"> shape `curve` is not rendered yet, left out\n\
         warning 2:7 <\"loopsubdiv\"> shape `loopsubdiv` is not subdivided, its control mesh is \
         smoothed\n"
    );
    let GeometryDesc::Mesh(m) = &s.shapes[0].geometry else { panic!() };
    assert_eq!((s.shapes.len(), m.normals[0].z), (1, 1.0));
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
