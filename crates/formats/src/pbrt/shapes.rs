//! `Shape` and `ObjectInstance` (pbrt-v4, shapes.cpp, util/mesh.cpp).
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
use super::curves::join;
use super::entity::{Entity, ShapeEntity};
use super::meshes::face_normals;
use super::param::Text;
use crate::resources::{self, MeshRequest, NormalMode};
use kaustika_math::Transform;
use kaustika_scene::description::{
    DisplacedMesh, GeometryDesc, GroupDesc, GroupId, InstanceDesc, ShapeDesc, TextureId,
    TextureNode, TriMesh,
};
use std::collections::HashMap;
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
    /// The texture that displaces it, and the length of edges.
    displacement: Option<(TextureId, f32)>,
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
        let shapes = std::mem::take(&mut self.scene.shapes);
        let (still, moving): (Vec<_>, Vec<_>) =
            shapes.into_iter().partition(|s| self.stands_still(s));
        for s in still {
            if let Some(shape) = self.shape(s, None, &mut meshes) {
                let shape = join(self.desc.shapes.last_mut(), shape);
                self.desc.shapes.extend(shape);
            }
        }
        for (g, object) in std::mem::take(&mut self.scene.objects).into_iter().enumerate() {
            let name = object.name.text;
            self.desc.groups.push(GroupDesc { name, shapes: Vec::new() });
            for s in object.shapes {
                if !s.place.is_still() {
                    let message = "shapes do not move inside objects, using the start";
                    self.notes.warning(s.entity.span, message);
                }
                if let Some(shape) = self.shape(s, Some(g), &mut meshes) {
                    let shapes = &mut self.desc.groups[g].shapes;
                    let shape = join(shapes.last_mut(), shape);
                    shapes.extend(shape);
                }
            }
        }
        self.moving_shapes(moving, &mut meshes);
        self.instances();
        self.load_meshes(meshes);
        for group in std::iter::once(&mut self.desc.shapes)
            .chain(self.desc.groups.iter_mut().map(|g| &mut g.shapes))
        {
            group.retain(|s| !matches!(&s.geometry, GeometryDesc::Mesh(m) if m.indices.is_empty()));
        }
        self.powers();
    }

    /// False if the shape moves; shapes that shine do not.
    fn stands_still(&mut self, s: &ShapeEntity) -> bool {
        if s.place.is_still() {
            return true;
        }
        if s.area_light.is_some() {
            self.notes.warning(s.entity.span, "shapes that shine do not move, using the start");
        }
        s.area_light.is_some()
    }

    /// Shapes that move: those of one motion that follow one another become a group, placed once.
    fn moving_shapes(&mut self, shapes: Vec<ShapeEntity>, meshes: &mut Meshes) {
        let mut last = None;
        for mut s in shapes {
            let (place, span) = (s.place, Some(s.entity.span));
            if last != Some(place) {
                last = Some(place);
                let group = GroupId(self.desc.groups.len() as u32);
                self.desc.groups.push(GroupDesc::default());
                let (transform, motion) = (place.transforms[0], place.motion());
                self.desc.instances.push(InstanceDesc { group, transform, motion, span });
            }
            let g = self.desc.groups.len() - 1;
            s.place.transforms = [Transform::IDENTITY; 2];
            if let Some(shape) = self.shape(s, Some(g), meshes) {
                let shapes = &mut self.desc.groups[g].shapes;
                let shape = join(shapes.last_mut(), shape);
                shapes.extend(shape);
            }
        }
    }

    fn instances(&mut self) {
        for i in std::mem::take(&mut self.scene.instances) {
            let (name, names) = (&i.object.name, &self.scene.object_names);
            match names.find(&name.text, i.object.order) {
                Some(g) => {
                    let group = GroupId(g as u32);
                    let span = Some(i.span);
                    let (transform, motion) = (i.place.transforms[0], i.place.motion());
                    self.desc.instances.push(InstanceDesc { group, transform, motion, span });
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
        if emission.is_some() && matches!(geometry, Some(GeometryDesc::Curves(_))) {
            let message = "lights on curves do not shine";
            self.notes.warning(s.entity.span, message);
            emission = None;
        }
        let (interior, exterior) = (self.medium(&s.inside), self.medium(&s.outside));
        // Matter that scatters below the surface fills the shape.
        let interior = self.insides.get(&material).copied().or(interior);
        Some(ShapeDesc {
            name: String::new(),
            geometry: geometry?,
            transform: s.place.transforms[0],
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
    fn alpha(&mut self, e: &mut Entity) -> Option<TextureId> {
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
            "loopsubdiv" => self.subdivision(e),
            "bilinearmesh" => self.bilinear_mesh(e),
            "plymesh" => self.ply_mesh(e, group, meshes),
            "curve" => self.curve(e),
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

    /// A mesh file: an empty mesh until all are loaded.
    fn ply_mesh(
        &mut self,
        e: &mut Entity,
        group: Option<usize>,
        meshes: &mut Meshes,
    ) -> Option<GeometryDesc> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
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
        let displacement = self.displacement(e);
        meshes.wanted.push(Wanted { request, name, displacement, group, shape });
        Some(GeometryDesc::Mesh(Arc::new(TriMesh::default())))
    }

    /// `displacement` and `edgelength`.
    fn displacement(&mut self, e: &mut Entity) -> Option<(TextureId, f32)> {
        let diag = &mut self.desc.diagnostics;
        let scale = self.scene.edge_scale.unwrap_or(1.0);
        let edge_length = e.params.float(diag, "edgelength", 1.0) * scale;
        let height = self.float_texture_or_none(e, "displacement")?;
        if edge_length > 0.0 {
            return Some((height, edge_length));
        }
        let message = format!("edges of a displaced mesh must be above 0, not {edge_length}");
        self.desc.diagnostics.error(e.params.place("edgelength"), message);
        None
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
                    let mesh = mesh.clone();
                    shapes[w.shape].geometry = match w.displacement {
                        Some((height, edge_length)) => {
                            GeometryDesc::Displaced(DisplacedMesh { mesh, height, edge_length })
                        }
                        None => GeometryDesc::Mesh(mesh),
                    };
                }
                Err(cause) if !told[w.request] => {
                    told[w.request] = true;
                    let message = format!("can't read mesh {cause}");
                    self.desc.diagnostics.error(w.name.span, message);
                }
                Err(_) => {}
            }
        }
    }
}
