//! Signed distance grids: surfaces where a trilinearly interpolated function is zero.
//!
//! Cells that the surface passes are primitives, each met in double precision by the zeros of a
//! cubic (`trilinear`). Their boxes hold no more than the surface: it reaches furthest on edges,
//! since inside a cell and inside its faces the function has saddles only (Hansson-Söderlund &
//! Akenine-Möller 2023, "Tight bounding boxes for voxels and bricks in a signed distance field
//! ray tracer", JCGT 12(1)).
//!
//! ```text
//! n = ∇f / |∇f|  in the cell                                               (1)
//! smooth: eight of (1), trilinearly blended between the centres of cells   (2)
//! ```
//!
//! (2) is Mitsuba 3's (sdfgrid.cpp): the eight gradients take each difference across another
//! pair of cells, at the place of the hit. It is of the hit's eight nearest cells; those beyond
//! the grid's border have no say.

mod trilinear;

#[cfg(test)]
mod tests;

use crate::description::{SdfGrid, SdfNormals};
use crate::surface::Surface;
use kaustika_math::{Bounds3, Ray, Transform, Vec2, Vec3, gamma};
use std::sync::Arc;
use trilinear::Trilinear;

/// Cells reach this far into their neighbours, in their own size: no ray slips through where
/// they join.
const OVERLAP: f64 = 1e-6;

/// A cell that the surface passes.
#[derive(Clone, Copy, Debug)]
pub struct SdfCell {
    /// Number of its grid.
    grid: u32,
    /// Number among the grid's cells.
    cell: u32,
}

/// A grid in its place.
#[derive(Clone, Debug)]
pub struct PlacedSdf {
    grid: Arc<SdfGrid>,
    /// The unit cube to the space of the group.
    to_world: Transform,
    flip: bool,
    /// Shape in the scene's list.
    pub shape: u32,
}

/// Where a ray meets a cell's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SdfHit {
    /// Ray parameter.
    pub t: f32,
    /// The point in the unit cube.
    pub p: Vec3,
}

/// All signed distance grids of a scene.
#[derive(Debug, Default)]
pub struct SdfStore {
    /// Cells, the primitives of hierarchies.
    pub cells: Vec<SdfCell>,
    /// One a shape.
    pub grids: Vec<PlacedSdf>,
}

impl SdfStore {
    /// Adds a shape.
    pub fn add(&mut self, grid: &Arc<SdfGrid>, to_world: Transform, shape: u32, flip: bool) {
        let number = self.grids.len() as u32;
        let placed = PlacedSdf { grid: grid.clone(), to_world, flip, shape };
        let cells = grid.crossed_cells().map(|c| SdfCell { grid: number, cell: placed.number(c) });
        self.cells.extend(cells);
        self.grids.push(placed);
    }

    /// The grid of a cell.
    #[inline]
    pub fn grid(&self, cell: u32) -> &PlacedSdf {
        &self.grids[self.cells[cell as usize].grid as usize]
    }

    /// The box around a cell's surface.
    pub fn bounds(&self, cell: u32) -> Bounds3 {
        self.grid(cell).bounds(self.cells[cell as usize].cell)
    }

    /// The nearest hit with t in (0, t_max).
    pub fn intersect(&self, cell: u32, ray: &Ray, t_max: f32) -> Option<SdfHit> {
        self.grid(cell).intersect(self.cells[cell as usize].cell, ray, t_max)
    }

    /// The surface at a hit of a cell; `number` is its own in the scene's list of analytic shapes.
    pub fn surface(&self, (cell, number): (u32, u32), hit: &SdfHit, time: f32) -> Surface {
        let grid = self.grid(cell);
        let (ng, ns) = grid.normals(self.cells[cell as usize].cell, hit.p);
        // The function's zero is known to a rounding of the whole cube.
        let own_error = Vec3::splat(gamma(5));
        Surface {
            p: grid.to_world.point(hit.p),
            p_error: grid.to_world.point_error(hit.p, own_error),
            t: hit.t,
            ng,
            ns,
            uv: Vec2::ZERO,
            footprint: 0.0,
            shape: grid.shape,
            triangle: u32::MAX,
            analytic: number,
            instance: None,
            barycentrics: Vec2::ZERO,
            light: None,
            time,
        }
    }
}

impl PlacedSdf {
    /// Cells along each axis.
    fn cells(&self) -> [u32; 3] {
        self.grid.resolution.map(|n| n - 1)
    }

    fn number(&self, [x, y, z]: [u32; 3]) -> u32 {
        let [cx, cy, _] = self.cells();
        x + cx * (y + cy * z)
    }

    fn place(&self, number: u32) -> [u32; 3] {
        let [cx, cy, _] = self.cells();
        [number % cx, number / cx % cy, number / (cx * cy)]
    }

    /// A point of the unit cube in units of cells.
    fn in_cells(&self, p: Vec3) -> [f64; 3] {
        let n = self.cells();
        std::array::from_fn(|i| f64::from(p[i]) * f64::from(n[i]))
    }

    fn bounds(&self, number: u32) -> Bounds3 {
        let cell = self.place(number);
        let corners = self.grid.corners(cell).map(f64::from);
        let (mut lo, mut hi) = ([1.0f64; 3], [0.0f64; 3]);
        for i in 0..8usize {
            for axis in 0..3 {
                let j = i | 1 << axis;
                let (a, b) = (corners[i], corners[j]);
                if i == j || (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0) {
                    continue;
                }
                // Where the edge from i to j is zero; all of it if both ends are.
                let ends = if a == b { [0.0, 1.0] } else { [a / (a - b); 2] };
                for w in ends {
                    for (k, (lo, hi)) in lo.iter_mut().zip(&mut hi).enumerate() {
                        let at = if k == axis { w } else { f64::from((i >> k & 1) as u8) };
                        (*lo, *hi) = (lo.min(at), hi.max(at));
                    }
                }
            }
        }
        let n = self.cells();
        let own = |x: &[f64; 3], margin: f64| {
            let at = |k: usize| ((f64::from(cell[k]) + x[k] + margin) / f64::from(n[k])) as f32;
            Vec3::new(at(0), at(1), at(2))
        };
        let own = Bounds3::new(own(&lo, -OVERLAP), own(&hi, OVERLAP));
        let b = self.to_world.bounds(&own);
        // Rounding of a hit in the unit cube, and on its way to the world.
        let margin = self.to_world.point_error(Vec3::splat(1.0), Vec3::splat(gamma(5)));
        Bounds3 { min: b.min - margin, max: b.max + margin }
    }

    fn intersect(&self, number: u32, ray: &Ray, t_max: f32) -> Option<SdfHit> {
        let r = self.to_world.inverse().ray(ray);
        let (o, d) = (self.in_cells(r.o), self.in_cells(r.d));
        let cell = self.place(number);
        let (mut t0, mut t1) = (0.0f64, f64::from(t_max));
        for k in 0..3 {
            let (lo, hi) = (f64::from(cell[k]) - OVERLAP, f64::from(cell[k]) + 1.0 + OVERLAP);
            if d[k] == 0.0 {
                if o[k] < lo || o[k] > hi {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo - o[k]) / d[k], (hi - o[k]) / d[k]);
            (t0, t1) = (t0.max(a.min(b)), t1.min(a.max(b)));
        }
        if t0 > t1 {
            return None;
        }
        let f = Trilinear::from_corners(self.grid.corners(cell));
        let start = std::array::from_fn(|k| o[k] + t0 * d[k] - f64::from(cell[k]));
        let t = t0 + f.first_crossing(start, d, t1 - t0)?;
        let n = self.cells();
        let p = |k: usize| ((o[k] + t * d[k]) / f64::from(n[k])) as f32;
        let p = Vec3::new(p(0), p(1), p(2));
        (t as f32 > 0.0 && (t as f32) < t_max).then_some(SdfHit { t: t as f32, p })
    }

    /// Geometric and shading normal at a point of the unit cube that lies in a cell.
    fn normals(&self, number: u32, p: Vec3) -> (Vec3, Vec3) {
        let cell = self.place(number);
        let at = self.in_cells(p);
        let f = Trilinear::from_corners(self.grid.corners(cell));
        let gradient = f.gradient(std::array::from_fn(|k| at[k] - f64::from(cell[k])));
        let ng = self.world_normal(self.own(gradient)); // (1)
        let ns = match self.grid.normals {
            SdfNormals::Analytic => ng,
            SdfNormals::Smooth => self.world_normal(self.smooth(at)),
        };
        (ng, if ns.dot(ng) == 0.0 { ng } else { ns })
    }

    /// A gradient per cell as one in the unit cube.
    fn own(&self, gradient: [f64; 3]) -> [f64; 3] {
        let n = self.cells();
        std::array::from_fn(|k| gradient[k] * f64::from(n[k]))
    }

    fn world_normal(&self, own: [f64; 3]) -> Vec3 {
        let n = unit(own).map(|v| v as f32);
        let n = self.to_world.normal(Vec3::new(n[0], n[1], n[2]));
        // Without a gradient there is no normal; any will do.
        let n = n.try_normalize().unwrap_or(Vec3::Z);
        if self.flip { -n } else { n }
    }

    /// (2) at a point in units of cells.
    fn smooth(&self, p: [f64; 3]) -> [f64; 3] {
        let n = self.cells();
        // On each axis the two cells whose centres are around p, and the share of the second.
        let mut weights = [[0.0; 2]; 3];
        let mut slopes = [[0.0; 2]; 3];
        for k in 0..3 {
            let first = (p[k] - 0.5).floor();
            let w = p[k] - 0.5 - first;
            for (i, share) in [1.0 - w, w].into_iter().enumerate() {
                let cell = first + i as f64;
                if cell < 0.0 || cell >= f64::from(n[k]) {
                    continue;
                }
                let side =
                    |x: f64| self.value(std::array::from_fn(|j| if j == k { x } else { p[j] }));
                weights[k][i] = share;
                slopes[k][i] = side(cell + 1.0) - side(cell);
            }
            let sum = weights[k][0] + weights[k][1];
            weights[k] = weights[k].map(|w| w / sum);
        }
        let mut blended = [0.0; 3];
        for i in 0..8usize {
            let bits: [usize; 3] = [i & 1, i >> 1 & 1, i >> 2];
            let weight: f64 = (0..3).map(|k| weights[k][bits[k]]).product();
            let normal = unit(self.own(std::array::from_fn(|k| slopes[k][bits[k]])));
            for (sum, v) in blended.iter_mut().zip(normal) {
                *sum += weight * v;
            }
        }
        blended
    }

    /// The function at a point in units of cells, that of the border beyond it.
    fn value(&self, p: [f64; 3]) -> f64 {
        let n = self.cells();
        let cell = std::array::from_fn(|k| (p[k].max(0.0) as u32).min(n[k] - 1));
        let local = std::array::from_fn(|k| (p[k] - f64::from(cell[k])).clamp(0.0, 1.0));
        Trilinear::from_corners(self.grid.corners(cell)).value(local)
    }
}

/// Made unit; zero stays.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { v }
}
