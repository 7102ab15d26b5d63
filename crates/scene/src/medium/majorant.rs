//! A coarse grid of majorants, walked cell by cell along a ray.
//!
//! σ̄ ≥ σₜ within each cell; the closer it lies, the fewer null collisions (Yue et al. 2010,
//! "Unbiased, adaptive stochastic sampling for rendering inhomogeneous participating media"). The
//! walk is Amanatides & Woo's (1987).

use kaustika_math::{Ray, Transform, Vec3};

/// Bounds of the extinction: in each cell σ̄ = a C(λ) + b, C being the constant coefficients.
#[derive(Debug)]
pub struct MajorantGrid {
    /// World to the unit cube that the cells fill.
    to_unit: Transform,
    resolution: [u32; 3],
    cells: Vec<[f32; 2]>,
}

/// A part of a ray within one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellSpan {
    /// Where it begins along the ray.
    pub t0: f32,
    /// Where it ends.
    pub t1: f32,
    /// a and b of the cell.
    pub bound: [f32; 2],
}

impl MajorantGrid {
    /// Cells over a box, `to_world` of the unit cube; `bound` gets the corners of each.
    pub fn new(
        to_world: &Transform,
        resolution: [u32; 3],
        mut bound: impl FnMut(&[Vec3; 8]) -> [f32; 2],
    ) -> MajorantGrid {
        let [nx, ny, nz] = resolution;
        let mut cells = Vec::with_capacity((nx * ny * nz) as usize);
        for i in 0..nx * ny * nz {
            let cell = [i % nx, i / nx % ny, i / (nx * ny)];
            let corners = std::array::from_fn(|k| {
                let c: [f32; 3] = std::array::from_fn(|axis| {
                    (cell[axis] + (k as u32 >> axis & 1)) as f32 / resolution[axis] as f32
                });
                to_world.point(c.into())
            });
            cells.push(bound(&corners));
        }
        MajorantGrid { to_unit: to_world.inverse(), resolution, cells }
    }

    /// The cells along a ray between two places inside the box.
    pub fn walk(&self, ray: &Ray, t0: f32, t1: f32) -> CellWalk<'_> {
        let local = self.to_unit.ray(ray);
        let start = local.at(t0);
        let mut walk = CellWalk {
            grid: self,
            t: t0,
            t_end: t1,
            cell: [0; 3],
            step: [0; 3],
            next: [f32::INFINITY; 3],
            delta: [f32::INFINITY; 3],
        };
        for axis in 0..3 {
            let n = self.resolution[axis] as f32;
            let (at, d) = (start[axis] * n, local.d[axis] * n);
            let cell = (at.floor() as i32).clamp(0, n as i32 - 1);
            walk.cell[axis] = cell;
            if d == 0.0 {
                continue;
            }
            let edge = if d > 0.0 { cell + 1 } else { cell };
            walk.step[axis] = if d > 0.0 { 1 } else { -1 };
            walk.delta[axis] = (1.0 / d).abs();
            walk.next[axis] = t0 + ((edge as f32 - at) / d).max(0.0);
        }
        walk
    }
}

/// Walks along a ray; see [`MajorantGrid::walk`].
#[derive(Clone, Debug)]
pub struct CellWalk<'a> {
    grid: &'a MajorantGrid,
    t: f32,
    t_end: f32,
    cell: [i32; 3],
    step: [i32; 3],
    next: [f32; 3],
    delta: [f32; 3],
}

impl Iterator for CellWalk<'_> {
    type Item = CellSpan;

    fn next(&mut self) -> Option<CellSpan> {
        if self.t >= self.t_end {
            return None;
        }
        let n = self.grid.resolution.map(|n| n as i32);
        let [x, y, z] = self.cell.map(|c| c as usize);
        let index = (z * n[1] as usize + y) * n[0] as usize + x;
        let bound = self.grid.cells[index];
        let axis = match self.next {
            [x, y, z] if x <= y && x <= z => 0,
            [_, y, z] if y <= z => 1,
            _ => 2,
        };
        let (t0, mut t1) = (self.t, self.next[axis]);
        let moved = self.cell[axis] + self.step[axis];
        if t1 >= self.t_end || !(0..n[axis]).contains(&moved) {
            // The last cell reaches to the end, whatever rounding did to its edge.
            t1 = self.t_end;
        } else {
            self.cell[axis] = moved;
            self.next[axis] += self.delta[axis];
        }
        self.t = t1.max(t0);
        Some(CellSpan { t0, t1: self.t, bound })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Bounds3;

    #[test]
    fn walks_cover_the_way_through_the_right_cells() {
        let to_world = Transform::translate(Vec3::new(-1.0, 2.0, 0.5))
            .then_after(&Transform::scale(Vec3::new(2.0, 1.0, 3.0)).expect("not singular"));
        let resolution = [5, 3, 7];
        let mut number = -1.0;
        let mut boxes = Vec::new();
        let grid = MajorantGrid::new(&to_world, resolution, |corners| {
            boxes.push(Bounds3::of_points(*corners));
            number += 1.0;
            [number, 0.0]
        });
        let whole = boxes.iter().fold(Bounds3::EMPTY, |b, o| b.union(*o));
        let mut seen = 0;
        for i in 0..2000u64 {
            let unit = |k: u64| {
                (kaustika_math::mix_bits(16 * i + k) >> 40) as f32 / (1 << 24) as f32 - 0.5
            };
            let o = whole.center() + Vec3::new(unit(1), unit(2), unit(3)) * 6.0;
            let size = whole.diagonal();
            let inside =
                whole.center() + Vec3::new(size.x * unit(4), size.y * unit(5), size.z * unit(6));
            // Some along an axis, the others toward a point of the box.
            let d = match i % 10 {
                0 => Vec3::X,
                1 => -Vec3::Z,
                _ => (inside - o).normalize(),
            };
            let ray = Ray::new(o, d);
            let Some((t0, t1)) = whole.intersect(o, d, 100.0) else { continue };
            let mut t = t0;
            for span in grid.walk(&ray, t0, t1) {
                assert_eq!(span.t0, t);
                assert!(span.t1 >= span.t0);
                t = span.t1;
                let middle = ray.at(0.5 * (span.t0 + span.t1));
                let b = &boxes[span.bound[0] as usize];
                let room = Vec3::splat(1e-4);
                let b = Bounds3 { min: b.min - room, max: b.max + room };
                assert!(b.contains(middle), "{middle:?} {b:?}");
                seen += 1;
            }
            assert!(t == t1 || t0 >= t1, "{t} of {t1}");
        }
        assert!(seen > 2000);
    }
}
