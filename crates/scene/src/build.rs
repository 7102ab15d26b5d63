//! From a description to a scene.

mod analytic;
mod emitter;
mod relief;
mod roles;

use crate::camera::Camera;
use crate::description::{
    GeometryDesc, MaterialModel, MediumId, SceneDescription, ShapeDesc, SourceFormat, TriMesh,
};
use crate::error::BuildError;
use crate::geometry::{Geometry, Group, Instance};
use crate::lanes::{Lamps, Plain};
use crate::light::{AreaShape, Light, LightSelection, LightSelectionKind, mean_power};
use crate::material::Materials;
use crate::medium::Medium;
use crate::moving::Placement;
use crate::scene::{Scene, ShapeInfo};
use crate::shape::{CurveStore, MeshRange, Quadric, QuadricForm, SdfStore, TriangleStore};
use crate::surface::LightId;
use crate::tessellate;
use crate::texture::{AttributeRange, AttributeTable, Textures};
use emitter::Emitter;
use kaustika_accel::{BoxBvh, BuildOptions, TriangleBvh};
use kaustika_math::{Bounds3, Vec2, Vec3};
use kaustika_spectra::ColorMode;
use roles::Roles;

/// Choices made outside the scene file.
#[derive(Clone, Debug)]
pub struct SceneOptions {
    /// RGB or spectral.
    pub mode: ColorMode,
    /// Which camera.
    pub camera: usize,
    /// Width and height; `None`: as the camera's film says.
    pub resolution: Option<[u32; 2]>,
    /// How lights are chosen; `None`: as the file says, else the default.
    pub light_selection: Option<LightSelectionKind>,
}

/// Everything gathered before hierarchies are built.
#[derive(Default)]
struct Gathered {
    triangles: TriangleStore,
    quadrics: Vec<Quadric>,
    curves: CurveStore,
    sdfs: SdfStore,
    shapes: Vec<ShapeInfo>,
    lights: Vec<Light>,
    attributes: Vec<(String, AttributeRange)>,
    emissions: Vec<(Option<f32>, std::ops::Range<usize>)>,
    has_holes: bool,
    /// The textures, if there are displaced meshes.
    heights: Textures,
}

impl Scene {
    /// Builds the scene that `description` describes.
    pub fn build(
        description: &SceneDescription,
        options: &SceneOptions,
    ) -> Result<Scene, BuildError> {
        let camera_desc = description
            .cameras
            .get(options.camera)
            .ok_or_else(|| BuildError::new(None, "the scene has no camera"))?;
        let resolution = options.resolution.unwrap_or(camera_desc.film.resolution);

        let heights = relief::heights(description);
        let mut gathered = Gathered { heights, ..Gathered::default() };
        let mut groups = Vec::new();
        let mut ranges = vec![gathered.add_shapes(description, &description.shapes, false)?];
        for group in &description.groups {
            ranges.push(gathered.add_shapes(description, &group.shapes, true)?);
        }
        for Ranges { triangles, quadrics, pieces, cells } in ranges {
            let indices = &gathered.triangles.indices[triangles.clone()];
            let of_quadrics = gathered.quadrics[quadrics.clone()].iter().map(Quadric::bounds);
            let of_pieces = pieces.clone().map(|p| gathered.curves.bounds(p as u32));
            let of_cells = cells.clone().map(|c| gathered.sdfs.bounds(c as u32));
            let bounds: Vec<Bounds3> = of_quadrics.chain(of_pieces).chain(of_cells).collect();
            groups.push(Group {
                triangles: TriangleBvh::build(
                    &gathered.triangles.positions,
                    indices,
                    &BuildOptions::default(),
                ),
                first_triangle: triangles.start as u32,
                analytic: BoxBvh::build(&bounds),
                first_quadric: quadrics.start as u32,
                quadric_count: quadrics.len() as u32,
                first_piece: pieces.start as u32,
                piece_count: pieces.len() as u32,
                first_cell: cells.start as u32,
                analytic_count: bounds.len() as u32,
            });
        }
        let mut instances = Vec::new();
        for i in &description.instances {
            let (to_world, motion) =
                match Placement::new(&i.transform, &i.motion, camera_desc.shutter) {
                    Placement::Still(transform) => (transform, None),
                    Placement::Moving(motion) => (motion.at(0.0), Some(Box::new(motion))),
                };
            let (group, from_world) = (i.group.0 + 1, to_world.inverse());
            instances.push(Instance { group, to_world, from_world, motion });
        }
        let instance_bounds: Vec<Bounds3> =
            instances.iter().map(|i| i.bounds(&groups[i.group as usize].bounds())).collect();
        let geometry = Geometry {
            triangles: gathered.triangles,
            quadrics: gathered.quadrics,
            curves: gathered.curves,
            sdfs: gathered.sdfs,
            groups,
            instances,
            instance_bvh: BoxBvh::build(&instance_bounds),
            has_holes: gathered.has_holes,
        };

        let roles = Roles::of(description);
        let attributes = gathered.attributes;
        let textures = Textures::new(
            description,
            options.mode,
            |id| roles.of_texture(id),
            |name| AttributeTable {
                ranges: attributes
                    .iter()
                    .filter(|(n, _)| n == name)
                    .map(|(_, r)| r.clone())
                    .collect(),
                scale: 1.0,
            },
        );
        let materials = Materials::new(description, &textures, options.mode);
        let camera = Camera::new(camera_desc, resolution, &description.shapes, &geometry)?;
        let in_media = camera_desc.medium.is_some()
            || gathered.shapes.iter().any(|s| s.boundary.is_some_and(|b| b != [None; 2]));
        let media = match in_media {
            true => description.media.iter().map(|m| Medium::new(m, options.mode)).collect(),
            false => Vec::new(),
        };

        let bounds = geometry.bounds().union(camera.bounds());
        let (center, radius) = bounds.bounding_sphere();
        let mut scene = Scene {
            geometry,
            shapes: gathered.shapes,
            textures,
            materials,
            media,
            camera_medium: camera_desc.medium,
            light_media: Vec::new(),
            lights: gathered.lights,
            light_names: description.lights.iter().map(|l| l.name.clone()).collect(),
            environments: Vec::new(),
            light_selection: LightSelection::default(),
            plains: Vec::new(),
            lamps: None,
            learns_lights: false,
            camera,
            mode: options.mode,
            center,
            radius: (radius * 1.001).max(1e-3),
            footprint_scale: match description.format {
                SourceFormat::Mitsuba3 => 0.0,
                _ => 0.125,
            },
            format: description.format,
        };
        scene.normalise_powers(&gathered.emissions);
        for light in &description.lights {
            let built = Light::build(light, &description.textures, options.mode);
            if matches!(built, Light::Environment(_)) {
                scene.environments.push(LightId(scene.lights.len() as u32));
            }
            scene.lights.push(built);
        }
        if scene.has_media() {
            let given: Vec<_> = description.lights.iter().map(|l| l.medium).collect();
            scene.light_media = scene.find_light_media(&given);
        }
        let kind = options.light_selection.or_else(|| {
            description.integrator.light_sampler.as_deref().and_then(|s| s.parse().ok())
        });
        let kind = kind.unwrap_or_else(|| LightSelectionKind::for_lights(&scene.lights));
        scene.light_selection = LightSelection::new(kind, &scene);
        scene.lamps = Lamps::of(&scene);
        let plain = |s| Plain::of(s, &scene.materials, &scene.textures, scene.mode);
        scene.plains = scene.shapes.iter().map(plain).collect();
        scene.learns_lights = kind == LightSelectionKind::Learned;
        Ok(scene)
    }

    /// Scales emitters that are given by their power, shape by shape.
    fn normalise_powers(&mut self, emissions: &[(Option<f32>, std::ops::Range<usize>)]) {
        for (power, lights) in emissions {
            let Some(power) = power else { continue };
            let emitted: f32 =
                self.lights[lights.clone()].iter().map(|l| mean_power(l, self)).sum();
            if emitted > 0.0 {
                for light in &mut self.lights[lights.clone()] {
                    if let Light::Area(a) = light {
                        a.scale *= power / emitted;
                    }
                }
            }
        }
    }
}

/// What belongs to a group.
struct Ranges {
    triangles: std::ops::Range<usize>,
    quadrics: std::ops::Range<usize>,
    pieces: std::ops::Range<usize>,
    cells: std::ops::Range<usize>,
}

impl Gathered {
    fn add_shapes(
        &mut self,
        description: &SceneDescription,
        shapes: &[ShapeDesc],
        instanced: bool,
    ) -> Result<Ranges, BuildError> {
        let lengths = |g: &Gathered| {
            let (triangles, quadrics) = (g.triangles.indices.len(), g.quadrics.len());
            [triangles, quadrics, g.curves.pieces.len(), g.sdfs.cells.len()]
        };
        let start = lengths(self);
        for shape in shapes {
            self.add_shape(description, shape, instanced)?;
        }
        let end = lengths(self);
        let [triangles, quadrics, pieces, cells] = [0, 1, 2, 3].map(|i| start[i]..end[i]);
        Ok(Ranges { triangles, quadrics, pieces, cells })
    }

    fn add_shape(
        &mut self,
        description: &SceneDescription,
        desc: &ShapeDesc,
        instanced: bool,
    ) -> Result<(), BuildError> {
        let index = self.shapes.len() as u32;
        let material = &description.materials[desc.material.0 as usize].model;
        let interface = matches!(material, MaterialModel::Null { counts: false });
        self.has_holes |= interface || desc.alpha.is_some();
        self.shapes.push(ShapeInfo {
            name: desc.name.clone(),
            material: desc.material,
            alpha: desc.alpha,
            interface,
            boundary: boundary(description.format, desc),
        });
        let first_light = self.lights.len();
        // An instance has no lights of its own: its emission would need one for each placement.
        let emission = Emitter::of(description, desc).filter(|_| !instanced);
        match &desc.geometry {
            GeometryDesc::Mesh(mesh) => self.add_mesh(desc, mesh, index, emission)?,
            GeometryDesc::Displaced(of) => {
                let mesh = self.displace(desc, of)?;
                self.add_mesh(desc, &mesh, index, emission)?;
            }
            GeometryDesc::Curves(curves) => {
                self.curves.add(curves, &desc.transform, index, desc.flip_normals);
            }
            GeometryDesc::Ellipsoids(all) => self.add_ellipsoids(desc, all, index, emission)?,
            GeometryDesc::SdfGrid(grid) => self.add_sdf(desc, grid, index)?,
            GeometryDesc::Rectangle => {
                self.add_mesh(desc, &tessellate::rectangle(), index, emission)?;
            }
            GeometryDesc::Cube => self.add_mesh(desc, &tessellate::cube(), index, emission)?,
            GeometryDesc::BilinearPatches { positions, indices, normals, uvs } => {
                let mesh = tessellate::bilinear_patches(positions, indices, normals, uvs);
                self.add_mesh(desc, &mesh, index, emission)?;
            }
            GeometryDesc::Sphere { radius, z_min, z_max, phi_max } => {
                let form = QuadricForm::Sphere { radius: *radius, z_min: *z_min, z_max: *z_max };
                self.add_quadric(Quadric::of(desc, form, *phi_max, index), emission);
            }
            GeometryDesc::Cylinder { radius, z_min, z_max, phi_max } => {
                let form = QuadricForm::Cylinder { radius: *radius, z_min: *z_min, z_max: *z_max };
                self.add_quadric(Quadric::of(desc, form, *phi_max, index), emission);
            }
            GeometryDesc::Disk { height, radius, inner_radius, phi_max } => {
                let form =
                    QuadricForm::Disk { height: *height, radius: *radius, inner: *inner_radius };
                self.add_quadric(Quadric::of(desc, form, *phi_max, index), emission);
            }
        }
        if let Some(e) = emission {
            self.emissions.push((e.desc.power, first_light..self.lights.len()));
        }
        Ok(())
    }

    fn add_mesh(
        &mut self,
        desc: &ShapeDesc,
        mesh: &TriMesh,
        shape: u32,
        emission: Option<Emitter>,
    ) -> Result<(), BuildError> {
        let store = &mut self.triangles;
        let (first, vertices) = (store.indices.len() as u32, store.positions.len());
        let total = vertices + mesh.positions.len();
        if total > u32::MAX as usize || store.indices.len() + mesh.indices.len() > 1 << 31 {
            return Err(BuildError::new(desc.span, "the scene has more than 2^31 triangles"));
        }
        let t = &desc.transform;
        let identity = t.is_identity();
        store
            .positions
            .extend(mesh.positions.iter().map(|p| if identity { *p } else { t.point(*p) }));
        let has_normals = mesh.normals.len() == mesh.positions.len() && !mesh.normals.is_empty();
        let has_uvs = mesh.uvs.len() == mesh.positions.len() && !mesh.uvs.is_empty();
        if has_normals {
            store.normals.resize(vertices, Vec3::ZERO);
            store.normals.extend(mesh.normals.iter().map(|n| {
                let n = if identity { *n } else { t.normal(*n) };
                n.try_normalize().unwrap_or(Vec3::ZERO)
            }));
        }
        if has_uvs {
            store.uvs.resize(vertices, Vec2::ZERO);
            store.uvs.extend_from_slice(&mesh.uvs);
        }
        let base = vertices as u32;
        // A mirroring transform turns the winding over; swapping two corners keeps the front
        // where the object-space normal, carried along as a normal, points.
        let mirrored = t.swaps_handedness();
        store.indices.extend(mesh.indices.iter().map(|[a, b, c]| {
            let (b, c) = if mirrored { (c, b) } else { (b, c) };
            [base + a, base + b, base + c]
        }));
        let number = store.meshes.len() as u32;
        store.mesh_of.resize(store.indices.len(), number);
        let count = mesh.indices.len() as u32;
        store.meshes.push(MeshRange {
            shape,
            first,
            count,
            has_normals,
            has_uvs,
            flip: desc.flip_normals,
            first_light: emission.map(|_| self.lights.len() as u32),
        });
        if let Some(e) = emission {
            for i in first..first + count {
                let shape = AreaShape::Triangle(i, store.area(i).max(f32::MIN_POSITIVE));
                self.lights.push(e.light(shape));
            }
        }
        for a in &mesh.attributes {
            let value = |element: u32| -> [f32; 3] {
                let at = (element * a.channels) as usize;
                std::array::from_fn(|c| {
                    let c = if a.channels == 1 { 0 } else { c };
                    a.values.get(at + c).copied().unwrap_or(0.0)
                })
            };
            let corners = mesh
                .indices
                .iter()
                .enumerate()
                .map(|(f, [i, j, k])| match a.per_face {
                    true => [value(f as u32); 3],
                    false if mirrored => [value(*i), value(*k), value(*j)],
                    false => [value(*i), value(*j), value(*k)],
                })
                .collect();
            let range = AttributeRange { triangles: first..first + count, corners };
            self.attributes.push((a.name.clone(), range));
        }
        Ok(())
    }
}

/// What a shape bounds. The same medium on both sides is no boundary for pbrt: light stays in the
/// medium it is in.
fn boundary(format: SourceFormat, desc: &ShapeDesc) -> Option<[Option<MediumId>; 2]> {
    let sides = [desc.interior, desc.exterior];
    let bounds = match format {
        SourceFormat::Pbrt => desc.interior != desc.exterior,
        _ => sides != [None; 2],
    };
    bounds.then_some(sides)
}
