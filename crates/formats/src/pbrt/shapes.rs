//! `Shape`, `AreaLightSource` and instances (pbrt-v4, shapes.cpp, util/mesh.cpp, lights.cpp).
//!
//! Which side is the front: pbrt crosses the edges of a triangle in world space and turns the
//! normal around if `ReverseOrientation` and the mirroring of the transform are not both on or
//! off. A mirroring transform has turned the cross product around already, so this is the normal
//! of object space, transformed as a normal, turned around by `ReverseOrientation` alone: our
//! `flip_normals`. If the mesh has shading normals, pbrt's geometric normal faces them whatever
//! the order of the corners; so triangles whose corners run the other way are turned around here.
//!
//! For spheres, disks and cylinders under a mirroring transform pbrt-v4 disagrees with itself:
//! points that are hit get the turned normal, points that are sampled on lights the other. Ours is
//! the latter, the transformed normal.

use super::build::Builder;
use super::entity::{Entity, ShapeEntity};
use super::param::{ParamType, Text};
use super::spectrum::unit_luminance;
use crate::resources::{self, MeshRequest, NormalMode};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, EmissionDesc, GeometryDesc, GroupDesc, GroupId,
    InstanceDesc, ShapeDesc, TextureMapping, TextureNode, TriMesh, Wrap,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::collections::HashMap;
use std::f32::consts::PI;
use std::sync::Arc;

const KINDS: [&str; 8] = [
    "bilinearmesh",
    "curve",
    "cylinder",
    "disk",
    "loopsubdiv",
    "plymesh",
    "sphere",
    "trianglemesh",
];

/// A mesh file and who asked for it.
struct Wanted {
    request: usize,
    name: Text,
    /// Group, or the world.
    group: Option<usize>,
    shape: usize,
}

/// Meshes that are loaded at the end.
#[derive(Default)]
struct Meshes {
    requests: Vec<MeshRequest>,
    known: HashMap<std::path::PathBuf, usize>,
    wanted: Vec<Wanted>,
}

impl Builder {
    /// All shapes, objects and instances.
    pub fn shapes(&mut self) {
        let mut meshes = Meshes::default();
        for s in std::mem::take(&mut self.scene.shapes) {
            if let Some(shape) = self.shape(s, None, &mut meshes) {
                self.desc.shapes.push(shape);
            }
        }
        for (g, object) in std::mem::take(&mut self.scene.objects).into_iter().enumerate() {
            let name = object.name.text;
            self.desc.groups.push(GroupDesc { name, shapes: Vec::new() });
            for s in object.shapes {
                if let Some(shape) = self.shape(s, Some(g), &mut meshes) {
                    self.desc.groups[g].shapes.push(shape);
                }
            }
        }
        self.instances();
        self.load_meshes(meshes);
        for group in std::iter::once(&mut self.desc.shapes)
            .chain(self.desc.groups.iter_mut().map(|g| &mut g.shapes))
        {
            group.retain(|s| !matches!(&s.geometry, GeometryDesc::Mesh(m) if m.indices.is_empty()));
        }
        self.powers();
    }

    fn instances(&mut self) {
        for i in std::mem::take(&mut self.scene.instances) {
            let (name, names) = (&i.object.name, &self.scene.object_names);
            match names.find(&name.text, i.object.order) {
                Some(g) => {
                    let group = GroupId(g as u32);
                    let span = Some(i.span);
                    self.desc.instances.push(InstanceDesc { group, transform: i.transform, span });
                }
                None => {
                    let message = format!("no object is called `{}`", name.text);
                    self.desc.diagnostics.error(name.span, message).hint = names.hint(&name.text);
                }
            }
        }
    }

    fn shape(
        &mut self,
        mut s: ShapeEntity,
        group: Option<usize>,
        meshes: &mut Meshes,
    ) -> Option<ShapeDesc> {
        let (material, material_kind) = self.shape_material(&s.material);
        let e = &mut s.entity;
        let geometry = self.geometry(e, group, meshes);
        let alpha = self.alpha(e);
        let what = format!("shape `{}`", e.kind.text);
        if geometry.is_some() {
            e.params.report_unused(&mut self.desc.diagnostics, &what);
        }
        let mut emission = match s.area_light {
            Some(l) => self.emission_of(l),
            None => None,
        };
        if emission.is_some() && group.is_some() {
            let message = "lights on shapes inside objects do not shine, as in pbrt";
            self.notes.warning(s.entity.span, message);
            emission = None;
        }
        if emission.is_some() && material_kind == "interface" {
            let message = "lights on shapes of material `interface` do not shine, as in pbrt";
            self.notes.warning(s.entity.span, message);
            emission = None;
        }
        let (interior, exterior) = (self.medium(&s.inside), self.medium(&s.outside));
        Some(ShapeDesc {
            name: String::new(),
            geometry: geometry?,
            transform: s.transform,
            flip_normals: s.reverse,
            material,
            emission,
            alpha,
            interior,
            exterior,
            span: Some(s.entity.span),
        })
    }

    /// `alpha`, unless it is the number 1 or more.
    fn alpha(&mut self, e: &mut Entity) -> Option<kaustika_scene::description::TextureId> {
        let id = self.float_texture_or_none(e, "alpha")?;
        match self.desc.textures[id.0 as usize].node {
            TextureNode::Float(a) if a >= 1.0 => None,
            _ => Some(id),
        }
    }

    fn geometry(
        &mut self,
        e: &mut Entity,
        group: Option<usize>,
        meshes: &mut Meshes,
    ) -> Option<GeometryDesc> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        match e.kind.text.as_str() {
            "sphere" => {
                let radius = p.float(diag, "radius", 1.0);
                let z_min = p.float(diag, "zmin", -radius);
                let z_max = p.float(diag, "zmax", radius);
                let phi_max = p.float(diag, "phimax", 360.0);
                self.positive(e, radius)?;
                let (low, high) = (z_min.min(z_max), z_min.max(z_max));
                Some(GeometryDesc::Sphere {
                    radius,
                    z_min: low.clamp(-radius, radius),
                    z_max: high.clamp(-radius, radius),
                    phi_max: phi_max.clamp(0.0, 360.0),
                })
            }
            "disk" => {
                let height = p.float(diag, "height", 0.0);
                let radius = p.float(diag, "radius", 1.0);
                let inner_radius = p.float(diag, "innerradius", 0.0);
                let phi_max = p.float(diag, "phimax", 360.0).clamp(0.0, 360.0);
                self.positive(e, radius)?;
                Some(GeometryDesc::Disk { height, radius, inner_radius, phi_max })
            }
            "cylinder" => {
                let radius = p.float(diag, "radius", 1.0);
                let (a, b) = (p.float(diag, "zmin", -1.0), p.float(diag, "zmax", 1.0));
                let phi_max = p.float(diag, "phimax", 360.0).clamp(0.0, 360.0);
                self.positive(e, radius)?;
                Some(GeometryDesc::Cylinder { radius, z_min: a.min(b), z_max: a.max(b), phi_max })
            }
            "trianglemesh" => self.triangle_mesh(e),
            "loopsubdiv" => {
                p.int(diag, "levels", 3);
                p.string(diag, "scheme");
                let message = "shape `loopsubdiv` is not subdivided, its control mesh is used";
                self.notes.warning(e.kind.span, message);
                self.triangle_mesh(e)
            }
            "bilinearmesh" => self.bilinear_mesh(e),
            "plymesh" => self.ply_mesh(e, group, meshes),
            "curve" => {
                p.ignore_rest();
                let message = "shape `curve` is not rendered yet, left out";
                self.notes.warning(e.kind.span, message);
                None
            }
            kind => {
                p.ignore_rest();
                let message = format!("unknown shape `{kind}`");
                diag.error(e.kind.span, message).nearest(kind, &KINDS);
                None
            }
        }
    }

    fn positive(&mut self, e: &Entity, radius: f32) -> Option<()> {
        if radius > 0.0 {
            return Some(());
        }
        let message = format!("the radius of the {} must be above 0, not {radius}", e.kind.text);
        self.desc.diagnostics.error(e.params.place("radius"), message);
        None
    }

    fn triangle_mesh(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let (positions, corners) = self.corners::<3>(e)?;
        let n = positions.len();
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let uvs = p.points2(diag, "uv").unwrap_or_default();
        let normals = p.triples(diag, "N", ParamType::Normal).unwrap_or_default();
        // Tangents are made from uv; face numbers serve ptex only.
        p.triples(diag, "S", ParamType::Vector3);
        p.ints(diag, "faceIndices");
        let uvs = self.per_vertex(e, "uv", uvs, n);
        let normals = self.per_vertex(e, "N", normals, n);
        let mesh = TriMesh { positions, normals, uvs, indices: corners, attributes: Vec::new() };
        Some(GeometryDesc::Mesh(face_normals(Arc::new(mesh))))
    }

    fn bilinear_mesh(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let (positions, indices) = self.corners::<4>(e)?;
        let n = positions.len();
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let uvs = p.points2(diag, "uv").unwrap_or_default();
        let normals = p.triples(diag, "N", ParamType::Normal).unwrap_or_default();
        p.ints(diag, "faceIndices");
        // Only says how pbrt samples the patch as a light.
        p.string(diag, "emissionfilename");
        let uvs = self.per_vertex(e, "uv", uvs, n);
        let normals = self.per_vertex(e, "N", normals, n);
        Some(GeometryDesc::BilinearPatches { positions, indices, normals, uvs })
    }

    /// `P` and `indices`, `N` a face.
    fn corners<const N: usize>(&mut self, e: &mut Entity) -> Option<(Vec<Vec3>, Vec<[u32; N]>)> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let positions = p.triples(diag, "P", ParamType::Point3);
        let indices = p.ints(diag, "indices");
        let Some(positions) = positions else {
            if !p.has("P") {
                let message = format!("shape `{}` needs \"point3 P\"", e.kind.text);
                diag.error(e.kind.span, message);
            }
            p.ignore_rest();
            return None;
        };
        let indices = match indices {
            Some(i) => i,
            None if p.has("indices") => return None,
            // A single face needs none.
            None if positions.len() == N => (0..N as i32).collect(),
            None => {
                let message = format!("shape `{}` needs \"integer indices\"", e.kind.text);
                diag.error(e.kind.span, message);
                p.ignore_rest();
                return None;
            }
        };
        let rest = indices.len() % N;
        if rest != 0 {
            let message =
                format!("{} indices are no multiple of {N}, {rest} ignored", indices.len());
            diag.warning(p.place("indices"), message);
        }
        if let Some(bad) = indices.iter().find(|&&i| i < 0 || i as usize >= positions.len()) {
            let message =
                format!("index {bad} is out of range, `P` has {} points", positions.len());
            diag.error(p.place("indices"), message);
            return None;
        }
        let faces = indices.chunks_exact(N).map(|c| std::array::from_fn(|i| c[i] as u32)).collect();
        Some((positions, faces))
    }

    /// Values on vertices, dropped with a warning if their number is wrong.
    fn per_vertex<T>(&mut self, e: &Entity, name: &str, values: Vec<T>, n: usize) -> Vec<T> {
        if values.is_empty() || values.len() == n {
            return values;
        }
        let message = format!("{} values of `{name}` for {n} points are ignored", values.len());
        self.desc.diagnostics.warning(e.params.place(name), message);
        Vec::new()
    }

    /// A mesh file: an empty mesh until all are loaded.
    fn ply_mesh(
        &mut self,
        e: &mut Entity,
        group: Option<usize>,
        meshes: &mut Meshes,
    ) -> Option<GeometryDesc> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        if p.has("displacement") {
            let message = "meshes are not displaced yet, the plain one is used";
            self.notes.warning(p.place("displacement"), message);
            p.own.iter_mut().filter(|p| p.name == "displacement").for_each(|p| p.used = true);
        }
        p.float(diag, "edgelength", 1.0);
        let Some(name) = p.string(diag, "filename") else {
            if !p.has("filename") {
                diag.error(e.kind.span, "shape `plymesh` needs \"string filename\"");
            }
            return None;
        };
        let path = self.file(&name, "mesh")?;
        let request = *meshes.known.entry(path.clone()).or_insert_with(|| {
            let normals = NormalMode::AsFile;
            meshes.requests.push(MeshRequest { path, flip_v: false, sub_mesh: 0, normals });
            meshes.requests.len() - 1
        });
        let shape = match group {
            Some(g) => self.desc.groups[g].shapes.len(),
            None => self.desc.shapes.len(),
        };
        meshes.wanted.push(Wanted { request, name, group, shape });
        Some(GeometryDesc::Mesh(Arc::new(TriMesh::default())))
    }

    /// Loads the mesh files and gives them to their shapes.
    fn load_meshes(&mut self, meshes: Meshes) {
        let loaded = resources::load_meshes(&meshes.requests);
        let loaded: Vec<_> = loaded.into_iter().map(|m| m.map(face_normals)).collect();
        let mut told = vec![false; loaded.len()];
        for w in meshes.wanted {
            match &loaded[w.request] {
                Ok(mesh) => {
                    let shapes = match w.group {
                        Some(g) => &mut self.desc.groups[g].shapes,
                        None => &mut self.desc.shapes,
                    };
                    shapes[w.shape].geometry = GeometryDesc::Mesh(mesh.clone());
                }
                Err(cause) if !told[w.request] => {
                    told[w.request] = true;
                    let message = format!("can't read mesh `{}`: {cause}", w.name.text);
                    self.desc.diagnostics.error(w.name.span, message);
                }
                Err(_) => {}
            }
        }
    }

    /// What an `AreaLightSource` makes a shape emit.
    fn emission_of(&mut self, light: usize) -> Option<EmissionDesc> {
        if let Some(known) = &self.emissions[light] {
            return known.clone();
        }
        let mut e = std::mem::take(&mut self.scene.area_lights[light]);
        let emission = self.area_light(&mut e);
        if emission.is_some() {
            let what = format!("area light `{}`", e.kind.text);
            e.params.report_unused(&mut self.desc.diagnostics, &what);
        }
        self.emissions[light] = Some(emission.clone());
        emission
    }

    fn area_light(&mut self, e: &mut Entity) -> Option<EmissionDesc> {
        if e.kind.text != "diffuse" {
            let message = format!("unknown area light `{}`", e.kind.text);
            let error = self.desc.diagnostics.error(e.kind.span, message);
            error.nearest(&e.kind.text, &["diffuse"]);
            return None;
        }
        let spectrum = self.spectrum(e, "L");
        let diag = &mut self.desc.diagnostics;
        let mut scale = e.params.float(diag, "scale", 1.0);
        let two_sided = e.params.boolean(diag, "twosided", false);
        let power = e.params.float_or_none(diag, "power").filter(|p| *p > 0.0);
        let filename = e.params.string(diag, "filename");
        let mut mean = 1.0;
        let node = if let Some(name) = filename {
            if spectrum.is_some() {
                let message = "an area light has `L` or `filename`, not both";
                self.desc.diagnostics.error(e.params.place("L"), message);
                return None;
            }
            let bitmap = self.light_image(&name)?;
            if power.is_some() {
                mean = super::images::mean(&bitmap, |x, y| super::images::luminance(&bitmap, x, y));
            }
            TextureNode::Bitmap(BitmapTexture {
                bitmap,
                channels: BitmapChannels::Color,
                filter: BitmapFilter::Bilinear,
                wrap: [Wrap::Clamp; 2],
                mapping: TextureMapping::default(),
                scale: 1.0,
                invert: false,
                raw: false,
                space: ColorSpace::Srgb,
            })
        } else {
            let white = SpectrumDesc::Rgb { rgb: [1.0; 3], space: e.params.space };
            let spectrum = spectrum.unwrap_or(white);
            scale *= unit_luminance(&spectrum);
            TextureNode::Spectrum(spectrum)
        };
        let radiance = self.desc.add_texture(node, Some(e.params.place("L")));
        // Divided by the area and the sides once the meshes are there.
        let power = power.map(|p| if mean > 0.0 { p / mean } else { 0.0 });
        Some(EmissionDesc { radiance, scale, power, two_sided, span: Some(e.span) })
    }

    /// Turns `power` into a factor of `scale`: radiance = power / (area π sides). pbrt's lights
    /// are single triangles or patches, each of which emits `power`; where their areas differ we
    /// give all the same radiance.
    fn powers(&mut self) {
        for s in self.desc.shapes.iter_mut() {
            let Some(emission) = &mut s.emission else { continue };
            let Some(power) = emission.power.take() else { continue };
            let (area, count, equal) = area(&s.geometry, &s.transform);
            let sides = if emission.two_sided { 2.0 } else { 1.0 };
            emission.scale *= power * count as f32 / (area * PI * sides);
            if !emission.scale.is_finite() {
                emission.scale = 0.0;
            }
            if !equal {
                let message = "pbrt gives `power` to each triangle; all shine equally here";
                self.notes.warning(emission.span.unwrap_or_default(), message);
            }
        }
    }
}

/// Area as pbrt finds it (quadrics: in object space), the number of pbrt's shapes, and whether
/// they are all of the same area.
fn area(geometry: &GeometryDesc, t: &Transform) -> (f32, usize, bool) {
    match geometry {
        GeometryDesc::Mesh(m) => {
            let corner = |i: u32| t.point(m.positions[i as usize]);
            sum(m.indices.iter().map(|&[a, b, c]| {
                let (a, b, c) = (corner(a), corner(b), corner(c));
                0.5 * (b - a).cross(c - a).length()
            }))
        }
        GeometryDesc::BilinearPatches { positions, indices, .. } => {
            let corner = |i: u32| t.point(positions[i as usize]);
            sum(indices.iter().map(|&[a, b, c, d]| patch_area([a, b, c, d].map(corner))))
        }
        GeometryDesc::Sphere { radius, z_min, z_max, phi_max } => {
            (phi_max.to_radians() * radius * (z_max - z_min), 1, true)
        }
        GeometryDesc::Disk { radius, inner_radius, phi_max, .. } => {
            let rings = radius * radius - inner_radius * inner_radius;
            (phi_max.to_radians() * 0.5 * rings, 1, true)
        }
        GeometryDesc::Cylinder { radius, z_min, z_max, phi_max } => {
            ((z_max - z_min) * radius * phi_max.to_radians(), 1, true)
        }
        GeometryDesc::Rectangle => (4.0, 1, true),
        GeometryDesc::Cube => (24.0, 1, true),
    }
}

fn sum(areas: impl Iterator<Item = f32> + Clone) -> (f32, usize, bool) {
    let (min, max) = areas.clone().fold((f32::INFINITY, 0f32), |(l, h), a| (l.min(a), h.max(a)));
    let total: f64 = areas.clone().map(|a| a as f64).sum();
    (total as f32, areas.count(), max - min <= 1e-3 * max)
}

/// Area of a bilinear patch with corners p00, p10, p01, p11, by small quadrilaterals.
fn patch_area([p00, p10, p01, p11]: [Vec3; 4]) -> f32 {
    const N: usize = 8;
    let p = |i: usize, j: usize| {
        let (u, v) = (i as f32 / N as f32, j as f32 / N as f32);
        p00.lerp(p10, u).lerp(p01.lerp(p11, u), v)
    };
    let cells = (0..N).flat_map(|i| (0..N).map(move |j| (i, j)));
    let areas = cells.map(|(i, j)| {
        let diagonals = (p(i + 1, j + 1) - p(i, j)).cross(p(i, j + 1) - p(i + 1, j));
        0.5 * diagonals.length()
    });
    areas.sum()
}

/// The mesh with every triangle's corners in the order that makes its front face its shading
/// normals; the same mesh if all are, or if it has no normals.
fn face_normals(mesh: Arc<TriMesh>) -> Arc<TriMesh> {
    if mesh.normals.len() != mesh.positions.len() {
        return mesh;
    }
    let away = |m: &TriMesh, &[a, b, c]: &[u32; 3]| {
        let p = |i: u32| m.positions[i as usize];
        let n = |i: u32| m.normals[i as usize];
        (p(b) - p(a)).cross(p(c) - p(a)).dot(n(a) + n(b) + n(c)) < 0.0
    };
    if !mesh.indices.iter().any(|t| away(&mesh, t)) {
        return mesh;
    }
    let mut turned = Arc::unwrap_or_clone(mesh);
    let mut indices = std::mem::take(&mut turned.indices);
    for t in indices.iter_mut().filter(|t| away(&turned, t)) {
        t.swap(1, 2);
    }
    turned.indices = indices;
    Arc::new(turned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_turned_to_their_normals_and_others_stay() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut mesh = TriMesh { positions, indices: vec![[0, 1, 2]], ..TriMesh::default() };
        let plain = Arc::new(mesh.clone());
        assert!(Arc::ptr_eq(&face_normals(plain.clone()), &plain));
        mesh.normals = vec![-Vec3::Z; 3];
        assert_eq!(face_normals(Arc::new(mesh.clone())).indices, [[0, 2, 1]]);
        mesh.normals = vec![Vec3::Z; 3];
        let right = Arc::new(mesh);
        assert!(Arc::ptr_eq(&face_normals(right.clone()), &right));
    }

    #[test]
    fn areas_are_those_of_pbrt() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0, Vec3::new(2.0, 3.0, 0.0)];
        assert!((patch_area(corners) - 6.0).abs() < 1e-4);
        let double = Transform::scale(Vec3::splat(2.0)).unwrap();
        let ball = GeometryDesc::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
        assert!((area(&ball, &double).0 - 4.0 * PI).abs() < 1e-4);
        let mesh = TriMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            indices: vec![[0, 1, 2], [0, 2, 3]],
            ..TriMesh::default()
        };
        assert_eq!(area(&GeometryDesc::Mesh(Arc::new(mesh)), &double), (4.0, 2, true));
    }
}
