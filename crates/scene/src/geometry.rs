//! All surfaces of a scene behind two questions: what does a ray meet first, and does it meet
//! anything at all.
//!
//! Surfaces live in groups. Group 0 is the world; the others are placed by instances. A group
//! has one hierarchy over its triangles and one over its analytic shapes (quadrics, pieces of
//! curves, cells of signed distance grids); the instances have one of their own.

use crate::batch::RayBatch;
use crate::shape::{
    CurveHit, CurveStore, Quadric, QuadricHit, RaySpace, SdfHit, SdfStore, TriangleStore,
};
use crate::surface::Surface;
use kaustika_accel::{BoxBvh, Segment, TriangleBvh, TriangleHit};
use kaustika_math::{Bounds3, Motion, Ray, Transform, Vec3};

/// Surfaces that are placed together.
#[derive(Debug)]
pub struct Group {
    /// Hierarchy of its triangles.
    pub triangles: TriangleBvh,
    /// Number of its first triangle in the store.
    pub first_triangle: u32,
    /// Hierarchy of its analytic shapes: quadrics, pieces of curves, cells of distance grids.
    pub analytic: BoxBvh,
    /// Number of its first quadric.
    pub first_quadric: u32,
    /// How many quadrics it has.
    pub quadric_count: u32,
    /// Number of its first piece of a curve.
    pub first_piece: u32,
    /// How many pieces of curves it has.
    pub piece_count: u32,
    /// Number of its first cell of a signed distance grid.
    pub first_cell: u32,
    /// How many analytic shapes it has.
    pub analytic_count: u32,
}

/// A group placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Which group.
    pub group: u32,
    /// Group space to world.
    pub to_world: Transform,
    /// World to group space.
    pub from_world: Transform,
    /// If it moves: group space to world at times from 0 to 1, in place of the two above.
    pub motion: Option<Box<Motion>>,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// A triangle of the store and barycentric weights.
    Triangle(u32, [f32; 3]),
    /// A quadric.
    Quadric(u32, QuadricHit),
    /// A piece of a curve.
    Curve(u32, CurveHit),
    /// A cell of a signed distance grid.
    Sdf(u32, SdfHit),
}

/// A hit; [`Geometry::surface`] makes a [`Surface`] of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// What.
    pub primitive: Primitive,
    /// Through which instance.
    pub instance: Option<u32>,
}

/// Every surface of a scene.
#[derive(Debug)]
pub struct Geometry {
    /// Triangles of all groups.
    pub triangles: TriangleStore,
    /// Quadrics of all groups.
    pub quadrics: Vec<Quadric>,
    /// Curves of all groups.
    pub curves: CurveStore,
    /// Signed distance grids of all groups.
    pub sdfs: SdfStore,
    /// Groups; the first is the world.
    pub groups: Vec<Group>,
    /// Placements.
    pub instances: Vec<Instance>,
    /// Hierarchy of the placements.
    pub instance_bvh: BoxBvh,
    /// True if some surface may let rays pass by its texture or material.
    pub has_holes: bool,
}

/// Decides whether a candidate hit counts: (primitive, ray in its group's space).
pub trait Accept: Fn(&Primitive, &Ray) -> bool {}
impl<F: Fn(&Primitive, &Ray) -> bool> Accept for F {}

impl Geometry {
    /// The box around everything.
    pub fn bounds(&self) -> Bounds3 {
        let world = self.groups.first().map_or(Bounds3::EMPTY, Group::bounds);
        world.union(self.instance_bvh.bounds())
    }

    /// The first surface along the ray with t in (0, t_max) that `accept` takes.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f32, accept: impl Accept) -> Option<Hit> {
        let best = self.groups[0].intersect(self, ray, t_max, &accept);
        self.with_instances(best, ray, t_max, &accept)
    }

    /// As [`Geometry::intersect`] for many rays; `batch` tells what each met.
    pub fn intersect_all(&self, segments: &[Segment], batch: &mut RayBatch, accept: impl Accept) {
        batch.for_hits(segments);
        let world = &self.groups[0];
        if self.has_holes {
            world.triangles.intersect_all_filtered(segments, &mut batch.triangles, |i, h| {
                accept(&world.triangle(h), &segments[i].ray)
            });
        } else {
            world.triangles.intersect_all(segments, &mut batch.triangles);
        }
        if world.analytic_count == 0 && self.instances.is_empty() {
            return;
        }
        let hits = batch.triangles.iter().zip(segments).map(|(hit, s)| {
            let best = hit.map(|h| world.hit(&h));
            let best = world.with_analytic(best, self, &s.ray, s.t_max, &accept);
            self.with_instances(best, &s.ray, s.t_max, &accept)
        });
        batch.others.extend(hits);
    }

    /// The nearer of `best` and what instances have.
    #[inline]
    fn with_instances(
        &self,
        best: Option<Hit>,
        ray: &Ray,
        t_max: f32,
        accept: &impl Accept,
    ) -> Option<Hit> {
        if self.instances.is_empty() {
            return best;
        }
        let limit = best.map_or(t_max, |h| h.t);
        let nearest = self.instance_bvh.intersect(ray, limit, |i, t_max| {
            let instance = &self.instances[i as usize];
            let local = instance.local(ray);
            let hit =
                self.groups[instance.group as usize].intersect(self, &local, t_max, accept)?;
            Some((hit.t, hit))
        });
        nearest.map_or(best, |(_, i, hit)| Some(Hit { instance: Some(i), ..hit }))
    }

    /// True if `accept` takes any surface along the ray with t in (0, t_max).
    #[inline]
    pub fn occluded(&self, ray: &Ray, t_max: f32, accept: impl Accept) -> bool {
        let world = &self.groups[0];
        world.occluded_by_triangles(self, ray, t_max, &accept)
            || world.occluded_by_analytic(self, ray, t_max, &accept)
            || self.occluded_by_instances(ray, t_max, &accept)
    }

    /// As [`Geometry::occluded`] for many rays, into `batch.occluded`.
    pub fn occluded_all(&self, segments: &[Segment], batch: &mut RayBatch, accept: impl Accept) {
        batch.for_occlusion(segments);
        let world = &self.groups[0];
        if self.has_holes {
            world.triangles.occluded_all_filtered(segments, &mut batch.occluded, |i, h| {
                accept(&world.triangle(h), &segments[i].ray)
            });
        } else {
            world.triangles.occluded_all(segments, &mut batch.occluded);
        }
        for (occluded, s) in batch.occluded.iter_mut().zip(segments) {
            *occluded = *occluded
                || world.occluded_by_analytic(self, &s.ray, s.t_max, &accept)
                || self.occluded_by_instances(&s.ray, s.t_max, &accept);
        }
    }

    #[inline]
    fn occluded_by_instances(&self, ray: &Ray, t_max: f32, accept: &impl Accept) -> bool {
        !self.instances.is_empty()
            && self.instance_bvh.any(ray, t_max, |i, t_max| {
                let instance = &self.instances[i as usize];
                let local = instance.local(ray);
                let group = &self.groups[instance.group as usize];
                group.occluded_by_triangles(self, &local, t_max, accept)
                    || group.occluded_by_analytic(self, &local, t_max, accept)
            })
    }

    /// The surface at a hit.
    #[inline(always)]
    pub fn surface(&self, hit: &Hit, ray: &Ray) -> Surface {
        let Some(i) = hit.instance else { return self.unplaced(&hit.primitive, hit.t, ray) };
        let instance = &self.instances[i as usize];
        let mut surface = match &hit.primitive {
            // Only curves ask for the ray.
            Primitive::Curve(..) => self.unplaced(&hit.primitive, hit.t, &instance.local(ray)),
            primitive => self.unplaced(primitive, hit.t, ray),
        };
        match &instance.motion {
            None => place(&mut surface, i, &instance.to_world),
            Some(motion) => place(&mut surface, i, &motion.at(ray.time)),
        }
        surface
    }

    /// The surface of a primitive that `ray` met at `t`, both in its group's space.
    #[inline(always)]
    pub(crate) fn unplaced(&self, primitive: &Primitive, t: f32, ray: &Ray) -> Surface {
        match primitive {
            Primitive::Triangle(i, b) => self.triangles.surface(*i, *b, t, ray.time),
            Primitive::Quadric(i, h) => self.quadrics[*i as usize].surface(*i, h, ray.time),
            Primitive::Curve(i, h) => self.curve_surface(*i, h, ray),
            Primitive::Sdf(i, h) => self.sdf_surface(*i, h, ray.time),
        }
    }

    #[inline(never)]
    fn curve_surface(&self, piece: u32, hit: &CurveHit, ray: &Ray) -> Surface {
        let number = self.quadrics.len() as u32 + piece;
        self.curves.surface((piece, number), hit, ray)
    }

    #[inline(never)]
    fn sdf_surface(&self, cell: u32, hit: &SdfHit, time: f32) -> Surface {
        let number = (self.quadrics.len() + self.curves.pieces.len()) as u32 + cell;
        self.sdfs.surface((cell, number), hit, time)
    }

    /// ∂p/∂u and ∂p/∂v at a surface, world space; some tangents where the uvs are degenerate.
    pub fn tangents(&self, s: &Surface) -> (Vec3, Vec3) {
        let to_world = s.instance.map(|i| self.instances[i as usize].at(s.time));
        let (dpdu, dpdv) = match s.triangle {
            u32::MAX => match s.analytic.checked_sub(self.quadrics.len() as u32) {
                None => {
                    let p = to_world.map_or(s.p, |t| t.inverse().point(s.p));
                    self.quadrics[s.analytic as usize].tangents_at(p)
                }
                Some(piece) => {
                    let ns = to_world.map_or(s.ns, |t| t.inverse().normal(s.ns).normalize());
                    match (piece as usize) < self.curves.pieces.len() {
                        true => self.curves.tangents(piece, s.uv, ns),
                        // Distance grids have no uv.
                        false => ns.coordinate_system(),
                    }
                }
            },
            triangle => self.triangles.tangents(triangle),
        };
        match to_world {
            Some(t) => (t.vector(dpdu), t.vector(dpdv)),
            None => (dpdu, dpdv),
        }
    }

    /// Bytes held by the hierarchies.
    pub fn memory_bytes(&self) -> usize {
        let bytes = |g: &Group| g.triangles.memory_bytes() + g.analytic.memory_bytes();
        self.groups.iter().map(bytes).sum()
    }
}

impl Instance {
    /// A ray in the group's space, at the ray's time.
    #[inline]
    fn local(&self, ray: &Ray) -> Ray {
        match &self.motion {
            None => self.from_world.ray(ray),
            Some(motion) => motion.at(ray.time).inverse().ray(ray),
        }
    }

    /// Group space to world at a time.
    pub fn at(&self, time: f32) -> Transform {
        self.motion.as_ref().map_or(self.to_world, |m| m.at(time))
    }

    /// The box around all places where it puts its group with these bounds.
    pub(crate) fn bounds(&self, group: &Bounds3) -> Bounds3 {
        match &self.motion {
            None => self.to_world.bounds(group),
            Some(motion) => motion.bounds(group),
        }
    }
}

impl Group {
    /// The box around the group.
    pub fn bounds(&self) -> Bounds3 {
        self.triangles.bounds().union(self.analytic.bounds())
    }

    fn triangle(&self, hit: &TriangleHit) -> Primitive {
        Primitive::Triangle(self.first_triangle + hit.prim, hit.b)
    }

    #[inline]
    fn intersect(
        &self,
        all: &Geometry,
        ray: &Ray,
        t_max: f32,
        accept: &impl Accept,
    ) -> Option<Hit> {
        let hit = if all.has_holes {
            self.triangles.intersect_filtered(ray, t_max, |h| accept(&self.triangle(h), ray))
        } else {
            self.triangles.intersect(ray, t_max)
        };
        let best = hit.map(|h| self.hit(&h));
        self.with_analytic(best, all, ray, t_max, accept)
    }

    #[inline]
    fn hit(&self, h: &TriangleHit) -> Hit {
        Hit { t: h.t, primitive: self.triangle(h), instance: None }
    }

    /// The nearer of `best` and what analytic shapes have.
    #[inline]
    fn with_analytic(
        &self,
        best: Option<Hit>,
        all: &Geometry,
        ray: &Ray,
        t_max: f32,
        accept: &impl Accept,
    ) -> Option<Hit> {
        if self.analytic_count == 0 {
            return best;
        }
        let limit = best.map_or(t_max, |h| h.t);
        let mut space = None;
        let nearest = self.analytic.intersect(ray, limit, |i, t_max| {
            let (t, primitive) = self.meet(all, i, ray, &mut space, t_max)?;
            (!all.has_holes || accept(&primitive, ray)).then_some((t, primitive))
        });
        nearest.map_or(best, |(t, _, primitive)| Some(Hit { t, primitive, instance: None }))
    }

    #[inline]
    fn occluded_by_triangles(
        &self,
        all: &Geometry,
        ray: &Ray,
        t_max: f32,
        accept: &impl Accept,
    ) -> bool {
        if all.has_holes {
            self.triangles.occluded_filtered(ray, t_max, |h| accept(&self.triangle(h), ray))
        } else {
            self.triangles.occluded(ray, t_max)
        }
    }

    #[inline]
    fn occluded_by_analytic(
        &self,
        all: &Geometry,
        ray: &Ray,
        t_max: f32,
        accept: &impl Accept,
    ) -> bool {
        if self.analytic_count == 0 {
            return false;
        }
        let mut space = None;
        self.analytic.any(ray, t_max, |i, t_max| {
            self.meet(all, i, ray, &mut space, t_max)
                .is_some_and(|(_, primitive)| !all.has_holes || accept(&primitive, ray))
        })
    }

    /// Where a ray meets the group's analytic shape `i`; `space` keeps the ray's coordinates for
    /// the next curve.
    #[inline(always)]
    fn meet(
        &self,
        all: &Geometry,
        i: u32,
        ray: &Ray,
        space: &mut Option<RaySpace>,
        t_max: f32,
    ) -> Option<(f32, Primitive)> {
        if i < self.quadric_count {
            let index = self.first_quadric + i;
            let hit = all.quadrics[index as usize].intersect(ray, t_max)?;
            return Some((hit.t, Primitive::Quadric(index, hit)));
        }
        let i = i - self.quadric_count;
        if i >= self.piece_count {
            let cell = self.first_cell + i - self.piece_count;
            let hit = all.sdfs.intersect(cell, ray, t_max)?;
            return Some((hit.t, Primitive::Sdf(cell, hit)));
        }
        if space.is_none() {
            *space = RaySpace::new(ray);
        }
        let piece = self.first_piece + i;
        let hit = all.curves.intersect(piece, space.as_ref()?, t_max)?;
        Some((hit.t, Primitive::Curve(piece, hit)))
    }
}

/// Puts a surface of a group where an instance has it.
fn place(s: &mut Surface, instance: u32, to_world: &Transform) {
    s.p_error = to_world.point_error(s.p, s.p_error);
    s.p = to_world.point(s.p);
    s.ng = to_world.normal(s.ng).normalize();
    s.ns = to_world.normal(s.ns).normalize();
    s.instance = Some(instance);
}

impl Hit {
    /// Index of the shape in the scene's list.
    pub fn shape(&self, geometry: &Geometry) -> u32 {
        self.primitive.shape(geometry)
    }
}

impl Primitive {
    /// Index of the shape in the scene's list.
    #[inline]
    pub fn shape(&self, geometry: &Geometry) -> u32 {
        match self {
            Primitive::Triangle(i, _) => geometry.triangles.mesh(*i).shape,
            Primitive::Quadric(i, _) => geometry.quadrics[*i as usize].shape,
            Primitive::Curve(i, _) => geometry.curves.set(*i).shape,
            Primitive::Sdf(i, _) => geometry.sdfs.grid(*i).shape,
        }
    }

    /// A number that tells rays and places apart, for repeatable stochastic decisions.
    pub fn hash(&self, ray: &Ray) -> u64 {
        let (id, t) = match self {
            Primitive::Triangle(i, b) => (*i as u64, b[1].to_bits()),
            Primitive::Quadric(i, h) => (*i as u64 | 1 << 40, h.t.to_bits()),
            Primitive::Curve(i, h) => (*i as u64 | 1 << 41, h.t.to_bits()),
            Primitive::Sdf(i, h) => (*i as u64 | 1 << 42, h.t.to_bits()),
        };
        let bits = |v: Vec3| {
            (v.x.to_bits() as u64) ^ (v.y.to_bits() as u64) << 21 ^ (v.z.to_bits() as u64) << 42
        };
        let mix = kaustika_math::mix_bits;
        mix(mix(id ^ (t as u64) << 32)
            ^ bits(ray.o).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ mix(bits(ray.d)))
    }
}
