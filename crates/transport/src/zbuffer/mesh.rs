//! All surfaces of a scene as triangles in the world: instances placed as they are when the shutter opens,
//! spheres, disks and cylinders tessellated. Curves and distance grids are left out.

use kaustika_math::{Bounds3, Transform, Vec2, Vec3};
use kaustika_scene::description::TriMesh;
use kaustika_scene::{Geometry, Hit, Primitive, Scene, Surface};

/// Triangles that are culled, set up and sorted together.
pub const CHUNK: usize = 1024;
/// Cells of a tessellated shape around its axis, and along it.
const CELLS: [u32; 2] = [96, 48];

/// Where a triangle came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Triangle in the scene's list; `u32::MAX` where it stands for an analytic shape.
    pub triangle: u32,
    /// The analytic shape.
    pub analytic: u32,
    /// The instance that placed it; `u32::MAX`: none.
    pub instance: u32,
    /// Shape in the scene's list.
    pub shape: u32,
}

/// Triangles in the world.
#[derive(Debug, Default)]
pub struct Meshes {
    /// Positions of vertices.
    pub positions: Vec<Vec3>,
    /// Their normals, not unit; zero where there are none.
    pub normals: Vec<Vec3>,
    /// Their texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertices of triangles.
    pub indices: Vec<[u32; 3]>,
    /// Geometric normals, unit.
    pub facets: Vec<Vec3>,
    /// How far uv go along a unit of the world, the mean over directions.
    pub stretch: Vec<f32>,
    /// Where triangles came from.
    pub sources: Vec<Source>,
    /// A box around each [`CHUNK`] of triangles.
    pub bounds: Vec<Bounds3>,
    /// True if triangles are seen from the side alone from which their corners are anticlockwise.
    pub one_sided: bool,
}

impl Meshes {
    /// Of the shapes that `drawn` takes, in the scene's order.
    pub fn new(scene: &Scene, drawn: impl Fn(u32) -> bool) -> Meshes {
        let mut meshes = Meshes::default();
        let geometry = &scene.geometry;
        meshes.add_group(geometry, 0, None, &drawn);
        for (i, instance) in geometry.instances.iter().enumerate() {
            let place = (i as u32, instance.at(0.0));
            meshes.add_group(geometry, instance.group as usize, Some(place), &drawn);
        }
        meshes.bound();
        meshes
    }

    /// Of a mesh by itself, seen from its front.
    pub fn of_front(mesh: &TriMesh) -> Meshes {
        let mut meshes = Meshes { one_sided: true, ..Meshes::default() };
        let none = u32::MAX;
        meshes.add_mesh(
            mesh,
            None,
            Source { triangle: none, analytic: none, instance: none, shape: 0 },
        );
        meshes.bound();
        meshes
    }

    fn bound(&mut self) {
        for chunk in self.indices.chunks(CHUNK) {
            let corners = chunk.iter().flatten().map(|&i| self.positions[i as usize]);
            self.bounds.push(Bounds3::of_points(corners));
        }
    }

    fn add_group(
        &mut self,
        geometry: &Geometry,
        group: usize,
        place: Option<(u32, Transform)>,
        drawn: &impl Fn(u32) -> bool,
    ) {
        let group = &geometry.groups[group];
        let store = &geometry.triangles;
        let instance = place.map_or(u32::MAX, |(i, _)| i);
        // Vertices of a group lie together.
        let all =
            group.first_triangle..group.first_triangle + group.triangles.triangle_count() as u32;
        let triangles = all.filter(|&t| drawn(store.mesh(t).shape));
        let used = triangles.clone().flat_map(|t| store.indices[t as usize]);
        let (first, last) = used.fold((u32::MAX, 0), |(a, b), i| (a.min(i), b.max(i)));
        if first <= last {
            let base = self.positions.len() as u32;
            let range = first as usize..=last as usize;
            let normals = store.normals.get(range.clone());
            let uvs = store.uvs.get(range.clone());
            let count = range.clone().count();
            let zero = || std::iter::repeat_n(Vec3::ZERO, count);
            self.positions.extend(&store.positions[range]);
            match normals {
                Some(normals) => self.normals.extend(normals),
                None => self.normals.extend(zero()),
            }
            match uvs {
                Some(uvs) => self.uvs.extend(uvs),
                None => self.uvs.extend(std::iter::repeat_n(Vec2::ZERO, count)),
            }
            self.place(base as usize, place);
            for t in triangles {
                let shape = store.mesh(t).shape;
                let source = Source { triangle: t, analytic: u32::MAX, instance, shape };
                self.add(store.indices[t as usize].map(|i| i - first + base), source);
            }
        }
        for q in group.first_quadric..group.first_quadric + group.quadric_count {
            let quadric = &geometry.quadrics[q as usize];
            if drawn(quadric.shape) {
                let [around, along] = CELLS;
                let source =
                    Source { triangle: u32::MAX, analytic: q, instance, shape: quadric.shape };
                self.add_mesh(&quadric.tessellated(around, along), place, source);
            }
        }
    }

    fn add_mesh(&mut self, mesh: &TriMesh, place: Option<(u32, Transform)>, source: Source) {
        let base = self.positions.len();
        self.positions.extend(&mesh.positions);
        self.normals.extend(&mesh.normals);
        self.normals.resize(self.positions.len(), Vec3::ZERO);
        self.uvs.extend(&mesh.uvs);
        self.uvs.resize(self.positions.len(), Vec2::ZERO);
        self.place(base, place);
        for triangle in &mesh.indices {
            self.add(triangle.map(|i| i + base as u32), source);
        }
    }

    /// Takes the vertices from `base` on into the world.
    fn place(&mut self, base: usize, place: Option<(u32, Transform)>) {
        if let Some((_, to_world)) = place {
            self.positions[base..].iter_mut().for_each(|p| *p = to_world.point(*p));
            self.normals[base..].iter_mut().for_each(|n| *n = to_world.normal(*n));
        }
    }

    fn add(&mut self, indices: [u32; 3], source: Source) {
        let [a, b, c] = indices.map(|i| self.positions[i as usize]);
        // Without an area there is nothing to be seen.
        let Some(facet) = (b - a).cross(c - a).try_normalize() else { return };
        let [u, v, w] = indices.map(|i| self.uvs[i as usize]);
        let (d, e) = (v - u, w - u);
        let share = (d.x * e.y - d.y * e.x).abs() / (b - a).cross(c - a).length();
        self.indices.push(indices);
        self.facets.push(facet);
        self.stretch.push(if share.is_finite() { share.sqrt() } else { 0.0 });
        self.sources.push(source);
    }

    /// Corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.indices[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// The scene's surface at barycentric weights of a triangle, `t` along a ray.
    pub fn surface(&self, scene: &Scene, triangle: u32, b: [f32; 3], t: f32) -> Surface {
        let source = self.sources[triangle as usize];
        let instance = Some(source.instance).filter(|&i| i != u32::MAX);
        let ray = kaustika_math::Ray::new(Vec3::ZERO, Vec3::Z);
        if source.triangle != u32::MAX {
            let primitive = Primitive::Triangle(source.triangle, b);
            return scene.geometry.surface(&Hit { t, primitive, instance }, &ray);
        }
        let vertices = self.indices[triangle as usize].map(|i| i as usize);
        let mix =
            |v: &[Vec3]| v[vertices[0]] * b[0] + v[vertices[1]] * b[1] + v[vertices[2]] * b[2];
        let uv = vertices.map(|i| self.uvs[i]);
        let facet = self.facets[triangle as usize];
        let ns = mix(&self.normals).try_normalize().unwrap_or(facet);
        let light = scene.geometry.quadrics[source.analytic as usize].light;
        Surface {
            p: mix(&self.positions),
            p_error: Vec3::ZERO,
            t,
            ng: facet.face_forward(ns),
            ns,
            uv: uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2],
            footprint: 0.0,
            shape: source.shape,
            triangle: u32::MAX,
            analytic: source.analytic,
            instance,
            barycentrics: Vec2::new(b[1], b[2]),
            light,
            time: 0.0,
        }
    }
}
