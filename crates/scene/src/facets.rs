//! Every surface as flat triangles, for methods that calculate with patches.
//!
//! A triangle of a mesh is a facet by itself. A quadric is cut into rows and columns of pairs of
//! triangles with corners on it; a place on a facet is put onto the quadric by a projection from its
//! centre (spheres) or its axis (cylinders), so that points of facets are points that rays meet.
//! A sphere's rows end in circles, its facets in arcs of great circles beside them: a place in between
//! counts to the facet of its row, up to a hundredth of the radius away. Curves and signed distance grids have no facets.

use crate::geometry::{Geometry, Hit, Primitive};
use crate::shape::{Quadric, QuadricForm, QuadricHit};
use crate::surface::Surface;
use kaustika_math::{Ray, Vec2, Vec3, safe_acos};
use std::f32::consts::PI;

/// Columns of a whole turn; rows of a sphere turn as far as columns do.
const TURN: f32 = 32.0;
/// Rows at most.
const MOST_ROWS: f32 = 64.0;

/// Which facet of which surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FacetId {
    /// A triangle of the store.
    Triangle(u32),
    /// A quadric, and the number of the facet on it.
    Quadric(u32, u32),
}

/// A flat triangle that stands for a part of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Facet {
    /// Through which instance it is placed.
    pub instance: Option<u32>,
    /// Which.
    pub id: FacetId,
}

/// How a quadric is cut.
#[derive(Clone, Copy, Debug)]
struct Grid<'a> {
    quadric: &'a Quadric,
    columns: u32,
    rows: u32,
}

impl Geometry {
    /// The facets of all surfaces.
    pub fn facets(&self) -> Vec<Facet> {
        let mut all = Vec::new();
        self.add_facets(0, None, &mut all);
        for (i, instance) in self.instances.iter().enumerate() {
            self.add_facets(instance.group as usize, Some(i as u32), &mut all);
        }
        all
    }

    fn add_facets(&self, group: usize, instance: Option<u32>, all: &mut Vec<Facet>) {
        let g = &self.groups[group];
        let triangles = g.first_triangle..g.first_triangle + g.triangles.triangle_count() as u32;
        all.extend(triangles.map(|i| Facet { instance, id: FacetId::Triangle(i) }));
        for q in g.first_quadric..g.first_quadric + g.quadric_count {
            let ids = Grid::new(&self.quadrics[q as usize]).ids();
            all.extend(ids.map(|i| Facet { instance, id: FacetId::Quadric(q, i) }));
        }
    }

    /// The surface at a place on a facet: barycentric weights of its corners 1 and 2, and the
    /// shutter time.
    pub fn on_facet(&self, facet: &Facet, at: Vec2, time: f32) -> Surface {
        let b = [1.0 - at.x - at.y, at.x, at.y];
        let primitive = match facet.id {
            FacetId::Triangle(i) => Primitive::Triangle(i, b),
            FacetId::Quadric(q, i) => {
                let grid = Grid::new(&self.quadrics[q as usize]);
                let [c0, c1, c2] = grid.corners(i);
                let p = grid.onto(c0 * b[0] + c1 * b[1] + c2 * b[2]);
                Primitive::Quadric(q, QuadricHit { t: 1.0, p, phi: azimuth(p) })
            }
        };
        let hit = Hit { t: 1.0, primitive, instance: facet.instance };
        let ray = Ray { time, ..Ray::new(Vec3::ZERO, Vec3::Z) };
        self.surface(&hit, &ray)
    }

    /// The facet of a surface, and the place on it; `None` for curves and signed distance grids.
    pub fn facet_of(&self, s: &Surface) -> Option<(Facet, Vec2)> {
        if s.triangle != u32::MAX {
            let id = FacetId::Triangle(s.triangle);
            return Some((Facet { instance: s.instance, id }, s.barycentrics));
        }
        let quadric = self.quadrics.get(s.analytic as usize)?;
        let p =
            s.instance.map_or(s.p, |i| self.instances[i as usize].at(s.time).inverse().point(s.p));
        let grid = Grid::new(quadric);
        let (i, at) = grid.locate(quadric.to_world.inverse().point(p));
        Some((Facet { instance: s.instance, id: FacetId::Quadric(s.analytic, i) }, at))
    }
}

impl Grid<'_> {
    fn new(quadric: &Quadric) -> Grid<'_> {
        let columns = (TURN * quadric.phi_max / (2.0 * PI)).ceil().max(3.0);
        let rows = match quadric.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                let part = polar(z_max, radius) - polar(z_min, radius);
                TURN / (2.0 * PI) * part
            }
            QuadricForm::Cylinder { radius, z_min, z_max } => {
                (z_max - z_min) / (quadric.phi_max / columns * radius)
            }
            QuadricForm::Disk { radius, inner, .. } => 0.25 * TURN * (radius - inner) / radius,
        };
        let rows = rows.ceil().clamp(1.0, MOST_ROWS) as u32;
        Grid { quadric, columns: columns as u32, rows }
    }

    /// Numbers of the facets: two a cell, one at a pole or at a disk's centre.
    fn ids(&self) -> impl Iterator<Item = u32> + use<> {
        let (first, last) = self.poles();
        let (columns, rows) = (self.columns, self.rows);
        (0..2 * columns * rows).filter(move |i| {
            let row = i / 2 / columns;
            !(i % 2 == 0 && first && row == 0 || i % 2 == 1 && last && row + 1 == rows)
        })
    }

    /// Whether the first row begins in a point, and the last one ends in one.
    fn poles(&self) -> (bool, bool) {
        match self.quadric.form {
            QuadricForm::Sphere { radius, z_min, z_max } => (z_min <= -radius, z_max >= radius),
            QuadricForm::Cylinder { .. } => (false, false),
            QuadricForm::Disk { inner, .. } => (inner == 0.0, false),
        }
    }

    /// The corners of a facet, own space.
    fn corners(&self, i: u32) -> [Vec3; 3] {
        let (row, column) = (i / 2 / self.columns, i / 2 % self.columns);
        let at = |c: u32, r: u32| self.point(column + c, row + r);
        match i % 2 {
            0 => [at(0, 0), at(1, 0), at(1, 1)],
            _ => [at(0, 0), at(1, 1), at(0, 1)],
        }
    }

    /// A point between cells, own space.
    fn point(&self, column: u32, row: u32) -> Vec3 {
        let phi = self.quadric.phi_max * column as f32 / self.columns as f32;
        // A whole turn ends where it began.
        let whole = self.quadric.phi_max >= 2.0 * PI && column == self.columns;
        let (sin, cos) = if whole { (0.0, 1.0) } else { phi.sin_cos() };
        let r = row as f32 / self.rows as f32;
        match self.quadric.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                let (lo, hi) = (polar(z_min, radius), polar(z_max, radius));
                let theta = lo + (hi - lo) * r;
                let (sin_theta, z) = match (self.poles(), row) {
                    ((true, _), 0) => (0.0, -1.0),
                    ((_, true), n) if n == self.rows => (0.0, 1.0),
                    _ => (theta.sin(), -theta.cos()),
                };
                Vec3::new(sin_theta * cos, sin_theta * sin, z) * radius
            }
            QuadricForm::Cylinder { radius, z_min, z_max } => {
                Vec3::new(radius * cos, radius * sin, z_min + (z_max - z_min) * r)
            }
            QuadricForm::Disk { height, radius, inner } => {
                let rho = inner + (radius - inner) * r;
                Vec3::new(rho * cos, rho * sin, height)
            }
        }
    }

    /// The point of the quadric over a point of a facet, own space.
    fn onto(&self, p: Vec3) -> Vec3 {
        match self.quadric.form {
            QuadricForm::Sphere { radius, .. } => p * (radius / p.length().max(f32::MIN_POSITIVE)),
            QuadricForm::Cylinder { radius, .. } => {
                let k = radius / p.x.hypot(p.y).max(f32::MIN_POSITIVE);
                Vec3::new(p.x * k, p.y * k, p.z)
            }
            QuadricForm::Disk { .. } => p,
        }
    }

    /// The facet over which a point of the quadric lies, own space, and the place on it.
    fn locate(&self, p: Vec3) -> (u32, Vec2) {
        let r = match self.quadric.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                let (lo, hi) = (polar(z_min, radius), polar(z_max, radius));
                (polar(p.z, radius) - lo) / (hi - lo)
            }
            QuadricForm::Cylinder { z_min, z_max, .. } => (p.z - z_min) / (z_max - z_min),
            QuadricForm::Disk { radius, inner, .. } => (p.x.hypot(p.y) - inner) / (radius - inner),
        };
        let cell = |x: f32, n: u32| ((x * n as f32).max(0.0) as u32).min(n - 1);
        let column = cell(azimuth(p) / self.quadric.phi_max, self.columns);
        let row = cell(r, self.rows);
        let first = 2 * (row * self.columns + column);
        let (at_first, at_last) = self.poles();
        let places = [first, first + 1].map(|i| self.place(i, p));
        let upper = match (row == 0 && at_first, row + 1 == self.rows && at_last) {
            (true, _) => 1,
            (_, true) => 0,
            // The one that the point is less outside of.
            _ => {
                let outside = |b: Vec2| b.x.min(b.y).min(1.0 - b.x - b.y);
                usize::from(outside(places[1]) > outside(places[0]))
            }
        };
        let b = places[upper].max(Vec2::ZERO);
        (first + upper as u32, b / (b.x + b.y).max(1.0))
    }

    /// Where the projection of a point of the quadric lies on a facet, or beside it.
    fn place(&self, i: u32, p: Vec3) -> Vec2 {
        let [c0, c1, c2] = self.corners(i);
        let (e1, e2) = (c1 - c0, c2 - c0);
        let n = e1.cross(e2);
        let from = match self.quadric.form {
            QuadricForm::Sphere { .. } => Vec3::ZERO,
            QuadricForm::Cylinder { .. } => Vec3::new(0.0, 0.0, p.z),
            QuadricForm::Disk { .. } => p - Vec3::Z,
        };
        let t = n.dot(c0 - from) / n.dot(p - from);
        let q = from + (p - from) * t - c0;
        let inv = 1.0 / n.length_squared().max(f32::MIN_POSITIVE);
        Vec2::new(q.cross(e2).dot(n) * inv, e1.cross(q).dot(n) * inv)
    }
}

/// Angle from the pole at -z, radians.
fn polar(z: f32, radius: f32) -> f32 {
    safe_acos(-(z / radius).clamp(-1.0, 1.0))
}

/// In [0, 2π).
fn azimuth(p: Vec3) -> f32 {
    let phi = p.y.atan2(p.x);
    if phi < 0.0 { (phi + 2.0 * PI).min(2.0 * PI) } else { phi }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Transform;

    const FORMS: [QuadricForm; 6] = [
        QuadricForm::Sphere { radius: 1.5, z_min: -1.5, z_max: 1.5 },
        QuadricForm::Sphere { radius: 1.5, z_min: -1.0, z_max: 1.5 },
        QuadricForm::Sphere { radius: 1.5, z_min: -1.5, z_max: 0.3 },
        QuadricForm::Cylinder { radius: 1.0, z_min: -2.0, z_max: 1.0 },
        QuadricForm::Disk { height: 0.3, radius: 2.0, inner: 0.5 },
        QuadricForm::Disk { height: 0.3, radius: 2.0, inner: 0.0 },
    ];

    fn quadric(form: QuadricForm, phi_max: f32) -> Quadric {
        let to_world = Transform::IDENTITY;
        Quadric { form, phi_max, to_world, flip: false, shape: 0, light: None, from_outside: false }
    }

    #[test]
    fn places_on_facets_are_found_again() {
        for form in FORMS {
            for phi_max in [2.0 * PI, 4.0] {
                let quadric = quadric(form, phi_max);
                let grid = Grid::new(&quadric);
                for i in grid.ids() {
                    for at in [Vec2::new(0.3, 0.3), Vec2::new(0.1, 0.7), Vec2::new(0.8, 0.1)] {
                        let [a, b, c] = grid.corners(i);
                        let p = grid.onto(a * (1.0 - at.x - at.y) + b * at.x + c * at.y);
                        let (j, found) = grid.locate(p);
                        let off = (found - at).length();
                        assert!(i == j && off < 1e-3, "{form:?}: {i} {at:?}, {j} {found:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn facets_cover_the_surface() {
        for form in FORMS {
            for phi_max in [2.0 * PI, 4.0] {
                let quadric = quadric(form, phi_max);
                let grid = Grid::new(&quadric);
                let area = |i: u32| {
                    let [a, b, c] = grid.corners(i);
                    0.5 * (b - a).cross(c - a).length()
                };
                let (sum, whole) = (grid.ids().map(area).sum::<f32>(), quadric.own_area());
                assert!((sum / whole - 1.0).abs() < 0.015, "{form:?}: {sum} of {whole}");
            }
        }
    }

    #[test]
    fn every_point_has_a_facet() {
        for form in FORMS {
            let quadric = quadric(form, 2.0 * PI);
            let grid = Grid::new(&quadric);
            let ids: Vec<u32> = grid.ids().collect();
            for k in 0..10_000u32 {
                let u = Vec2::new((k % 100) as f32 + 0.5, (k / 100) as f32 + 0.5) * 0.01;
                let p = quadric.sample(u).0.p;
                let (i, at) = grid.locate(p);
                assert!(ids.contains(&i), "{form:?}: {i}");
                let [a, b, c] = grid.corners(i);
                let q = grid.onto(a * (1.0 - at.x - at.y) + b * at.x + c * at.y);
                // Beside a disk's rim there are points beyond the chord, and the sides of a sphere's
                // facets are arcs of great circles, which leave the circles between rows a little.
                let reach = match form {
                    QuadricForm::Cylinder { .. } => 1e-4,
                    _ => 0.011,
                };
                assert!((p - q).length() < reach, "{form:?}: {p:?} {q:?}");
            }
        }
    }
}
