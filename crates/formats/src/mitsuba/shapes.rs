//! Shapes, shape groups and instances.

use super::convert::{Converter, old, vec3};
use super::document::{Kind, Object, ObjectId, Value};
use super::matrix;
use super::resources::MeshPlace;
use super::textures::Role;
use crate::resources::{MeshRequest, NormalMode};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    EmissionDesc, GeometryDesc, GroupDesc, GroupId, InstanceDesc, MediumId, ShapeDesc, Span,
    TriMesh,
};
use std::sync::Arc;

/// Shapes that Mitsuba knows.
const KNOWN: &[&str] = &[
    "obj",
    "ply",
    "serialized",
    "rectangle",
    "cube",
    "sphere",
    "disk",
    "cylinder",
    "shapegroup",
    "instance",
    "merge",
    "bsplinecurve",
    "linearcurve",
    "sdfgrid",
    "ellipsoids",
];

/// Geometry with its own placement, and a mesh file if there is one to load.
struct Form {
    geometry: GeometryDesc,
    /// Object space to the space `to_world` starts from.
    local: Transform,
    mesh: Option<(MeshRequest, Span)>,
}

impl From<GeometryDesc> for Form {
    fn from(geometry: GeometryDesc) -> Form {
        Form { geometry, local: Transform::IDENTITY, mesh: None }
    }
}

impl<'a> Converter<'a> {
    /// A shape of the scene.
    pub(super) fn shape(&mut self, id: ObjectId) {
        let object = self.object(id);
        match object.plugin.as_str() {
            // Groups are made when an instance places them.
            "shapegroup" => {}
            "merge" => {
                for (_, child) in self.children(object, Kind::Shape) {
                    self.shape(child);
                }
                self.finish(id);
            }
            "instance" => {
                self.instance(id);
                self.finish(id);
            }
            _ if self.moves(object) => self.moving_shape(id),
            _ => {
                if let Some(desc) = self.form_of(id, None, self.out.shapes.len()) {
                    self.out.shapes.push(desc);
                }
            }
        }
    }

    /// True if a shape moves; light sources do not.
    fn moves(&self, object: &'a Object) -> bool {
        let moving = object.get("to_world").is_some_and(|p| matches!(p.value, Value::Motion(_)));
        moving && self.children(object, Kind::Emitter).is_empty()
    }

    /// A shape that moves: a group of its own, placed once.
    fn moving_shape(&mut self, id: ObjectId) {
        let object = self.object(id);
        let (transform, motion) = self.placement(object, "to_world");
        let group = GroupId(self.out.groups.len() as u32);
        self.out.groups.push(GroupDesc::default());
        if let Some(mut desc) = self.form_of(id, Some(group), 0) {
            // Curves stand where they were read.
            desc.transform = transform.inverse() * desc.transform;
            self.out.groups[group.0 as usize].shapes.push(desc);
            let span = Some(object.span);
            self.out.instances.push(InstanceDesc { group, transform, motion, span });
        }
    }

    fn instance(&mut self, id: ObjectId) {
        let object = self.object(id);
        let (transform, motion) = self.placement(object, "to_world");
        let group = self.child(object, Kind::Shape);
        let Some((p, group)) = group else {
            self.out.diagnostics.error(object.span, "an instance needs a `shapegroup`");
            return;
        };
        if self.object(group).plugin != "shapegroup" {
            let message =
                format!("an instance needs a `shapegroup`, found `{}`", self.object(group).plugin);
            self.out.diagnostics.error(p.value_span, message);
            return;
        }
        let group = self.group(group);
        let span = Some(object.span);
        self.out.instances.push(InstanceDesc { group, transform, motion, span });
    }

    fn group(&mut self, id: ObjectId) -> GroupId {
        if let Some(known) = self.groups.get(&id) {
            return *known;
        }
        let object = self.object(id);
        let group = GroupId(self.out.groups.len() as u32);
        self.groups.insert(id, group);
        self.out.groups.push(GroupDesc { name: object.id.clone(), shapes: Vec::new() });
        for (p, child) in self.children(object, Kind::Shape) {
            if matches!(self.object(child).plugin.as_str(), "instance" | "shapegroup" | "merge") {
                let message =
                    format!("a `shapegroup` can't hold a `{}`", self.object(child).plugin);
                self.out.diagnostics.error(p.span, message);
                continue;
            }
            let at = self.out.groups[group.0 as usize].shapes.len();
            if let Some(desc) = self.form_of(child, Some(group), at) {
                if desc.emission.is_some() {
                    let message = "light sources can't be instanced";
                    self.out.diagnostics.error(desc.span, message);
                }
                self.out.groups[group.0 as usize].shapes.push(desc);
            }
        }
        self.finish(id);
        group
    }

    /// The description of a shape that will be number `at` of the scene or of a group.
    fn form_of(&mut self, id: ObjectId, group: Option<GroupId>, at: usize) -> Option<ShapeDesc> {
        let object = self.object(id);
        let form = self.form(object)?;
        let is_curve = matches!(form.geometry, GeometryDesc::Curves(_));
        // Curves stand where they were read; their radii do not grow.
        let to_world = match is_curve {
            true => Transform::IDENTITY,
            false if group.is_none() => self.transform(object, "to_world"),
            false => self.placement(object, "to_world").0,
        };
        let mut flip_normals = self.boolean(object, "flip_normals", false);
        // Mitsuba 3 turns spheres and cylinders inside out when they are mirrored.
        let quadric =
            matches!(form.geometry, GeometryDesc::Sphere { .. } | GeometryDesc::Cylinder { .. });
        if quadric && !old(object) && to_world.swaps_handedness() {
            flip_normals = !flip_normals;
        }
        let mut emission = self.emission(object);
        let is_dark = is_curve || matches!(form.geometry, GeometryDesc::SdfGrid(_));
        if emission.is_some() && is_dark {
            let message = format!("light sources on a `{}` are not supported", object.plugin);
            self.out.diagnostics.warning(object.span, message).label("does not shine");
            emission = None;
        }
        let material = match self.child(object, Kind::Bsdf) {
            Some((_, bsdf)) => self.material(bsdf),
            None => self.default_material(emission.is_some()),
        };
        let (interior, exterior) = self.sides(object);
        if let Some((p, _)) = self.child(object, Kind::Subsurface) {
            self.out
                .diagnostics
                .warning(p.span, "subsurface scattering is not supported")
                .label("left out");
        }
        if let Some((p, sensor)) = self.child(object, Kind::Sensor) {
            match group {
                None => {
                    let camera = self.camera(sensor, Some(at));
                    self.out.cameras.extend(camera);
                }
                Some(_) => {
                    let message = "a sensor can't stand on a shape of a group";
                    self.out.diagnostics.error(p.span, message);
                }
            }
        }
        object.ignore(&["silhouette_sampling_weight", "silhouette_offset"]);
        if let Some((request, span)) = form.mesh {
            self.pending.mesh(request, span, MeshPlace { group, shape: at });
        }
        self.finish(id);
        Some(ShapeDesc {
            name: object.id.clone(),
            geometry: form.geometry,
            transform: to_world * form.local,
            flip_normals,
            material,
            emission,
            alpha: None,
            interior,
            exterior,
            span: Some(object.span),
        })
    }

    fn form(&mut self, object: &'a Object) -> Option<Form> {
        Some(match object.plugin.as_str() {
            "obj" | "ply" | "serialized" => self.mesh(object),
            "rectangle" => GeometryDesc::Rectangle.into(),
            "cube" => GeometryDesc::Cube.into(),
            "bsplinecurve" | "linearcurve" => GeometryDesc::Curves(self.curves(object)?).into(),
            "sdfgrid" => self.sdf_grid(object)?.into(),
            "ellipsoids" => self.ellipsoids(object)?.into(),
            "disk" => {
                GeometryDesc::Disk { height: 0.0, radius: 1.0, inner_radius: 0.0, phi_max: 360.0 }
                    .into()
            }
            "sphere" => {
                let radius = self.positive(object, "radius", 1.0);
                let center = self.vector(object, "center").unwrap_or([0.0; 3]);
                let geometry =
                    GeometryDesc::Sphere { radius, z_min: -radius, z_max: radius, phi_max: 360.0 };
                // Mitsuba's v is 0 at the north pole, the description's at the south pole.
                let mut mirror = Transform::IDENTITY;
                mirror.m[2][2] = -1.0;
                mirror.inv[2][2] = -1.0;
                let local = Transform::translate(vec3(center)) * mirror;
                Form { geometry, local, mesh: None }
            }
            "cylinder" => self.cylinder(object)?,
            _ => {
                self.unknown_plugin(object, KNOWN);
                return None;
            }
        })
    }

    pub(super) fn positive(&mut self, object: &'a Object, name: &'static str, default: f32) -> f32 {
        let value = self.number(object, name, default);
        if value > 0.0 {
            return value;
        }
        let span = object.get(name).map_or(object.span, |p| p.value_span);
        self.out.diagnostics.error(span, format!("`{name}` must be positive"));
        default
    }

    /// From `p0` to `p1`.
    fn cylinder(&mut self, object: &'a Object) -> Option<Form> {
        let radius = self.positive(object, "radius", 1.0);
        let p0 = self.vector(object, "p0").unwrap_or([0.0; 3]);
        let p1 = self.vector(object, "p1").unwrap_or([0.0, 0.0, 1.0]);
        let axis = [p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]];
        let Some(dir) = matrix::normalize(axis) else {
            self.out.diagnostics.error(object.span, "`p0` and `p1` of the cylinder are equal");
            return None;
        };
        let length = axis.iter().zip(dir).map(|(a, d)| a * d).sum::<f64>() as f32;
        let frame = matrix::product(&matrix::translate(p0), &matrix::to_frame(dir));
        let local = super::document::invertible(&frame)?;
        let geometry = GeometryDesc::Cylinder { radius, z_min: 0.0, z_max: length, phi_max: 360.0 };
        Some(Form { geometry, local, mesh: None })
    }

    fn mesh(&mut self, object: &'a Object) -> Form {
        let obj = object.plugin == "obj";
        let flip_v = match object.plugin.as_str() {
            "serialized" => false,
            _ => self.boolean(object, "flip_tex_coords", obj),
        };
        let faceted = self.boolean(object, "face_normals", false);
        let angle = match old(object) {
            true => self.optional_number(object, "max_smooth_angle"),
            false => None,
        };
        let normals = match (faceted, angle) {
            (true, Some(_)) => {
                let message = "`faceNormals` and `maxSmoothAngle` exclude each other";
                self.out.diagnostics.error(object.span, message);
                NormalMode::Faceted
            }
            (true, None) => NormalMode::Faceted,
            (false, Some(angle)) => NormalMode::SmoothBelow(angle),
            (false, None) => NormalMode::SmoothIfMissing,
        };
        let sub_mesh = match object.plugin.as_str() {
            "serialized" => self.integer(object, "shape_index").unwrap_or(0),
            _ => 0,
        };
        let sub_mesh = u32::try_from(sub_mesh).unwrap_or_else(|_| {
            let span = object.get("shape_index").map(|p| p.value_span);
            self.out.diagnostics.error(span, "`shape_index` must not be negative");
            0
        });
        if old(object) {
            object.ignore(&["load_materials", "collapse", "srgb"]);
        }
        let mesh = self
            .file(object, "filename")
            .map(|(path, span)| (MeshRequest { path, flip_v, sub_mesh, normals }, span));
        let geometry = GeometryDesc::Mesh(Arc::new(TriMesh::default()));
        Form { geometry, local: Transform::IDENTITY, mesh }
    }

    /// The area light on a shape.
    fn emission(&mut self, object: &'a Object) -> Option<EmissionDesc> {
        let (_, id) = self.child(object, Kind::Emitter)?;
        let emitter = self.object(id);
        match emitter.plugin.as_str() {
            "area" => {}
            "directionalarea" => self.note_unconnected(emitter),
            other => {
                let message = format!("emitter `{other}` can't stand on a shape");
                self.out.diagnostics.error(emitter.type_span, message);
                return None;
            }
        }
        emitter.ignore(&["sampling_weight"]);
        // 0.6's documentation calls it `intensity` in places.
        let name = match old(emitter) && emitter.has("intensity") && !emitter.has("radiance") {
            true => "intensity",
            false => "radiance",
        };
        let radiance = self.texture(emitter, name, 1.0, Role::Illuminant);
        self.finish(id);
        let (span, along_normal) = (Some(emitter.span), emitter.plugin == "directionalarea");
        Some(EmissionDesc {
            radiance,
            scale: 1.0,
            power: None,
            two_sided: false,
            along_normal,
            span,
        })
    }

    /// The media inside and outside.
    fn sides(&mut self, object: &'a Object) -> (Option<MediumId>, Option<MediumId>) {
        let mut sides = (None, None);
        for (p, id) in self.children(object, Kind::Medium) {
            match p.name.as_str() {
                "interior" => sides.0 = Some(self.medium(id)),
                "exterior" => sides.1 = Some(self.medium(id)),
                _ => {
                    self.out
                        .diagnostics
                        .warning(p.span, "a medium of a shape needs a name")
                        .hint("name=\"interior\" or name=\"exterior\"");
                }
            }
        }
        sides
    }
}

/// Mitsuba's cameras have +x to the left, the description's to the right.
pub(super) fn mirror_x() -> Transform {
    let mut mirror = Transform::IDENTITY;
    mirror.m[0][0] = -1.0;
    mirror.inv[0][0] = -1.0;
    mirror
}

/// The frame whose +z is `direction`.
pub(super) fn along(direction: [f64; 3]) -> Option<Transform> {
    super::document::invertible(&matrix::to_frame(matrix::normalize(direction)?))
}

/// A translation to a point.
pub(super) fn at(position: [f64; 3]) -> Transform {
    let p: Vec3 = vec3(position);
    Transform::translate(p)
}
