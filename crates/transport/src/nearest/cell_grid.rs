//! Points in cubic cells, which are named by a hash of their coordinates (Teschner et al. 2003).
//!
//! The k nearest are sought shell by shell of cells around the query's. Good where the density
//! of points is even; no size of the cells suits a caustic and the dark beside it.

use super::Item;
use super::found::Nearest;
use kaustika_math::{Bounds3, Vec3};
use kaustika_sampling::hash::combine;

/// Points of a cell, were they spread evenly over the surfaces of a box.
const POINTS: f32 = 12.0;

/// No cell's number is as large.
const FAR: f32 = 16_777_216.0;

/// The grid: 12 bytes a point, 4 for the names.
#[derive(Clone, Debug)]
pub struct CellGrid {
    pub(super) points: Vec<Vec3>,
    /// Where the points of each name begin, and one more.
    starts: Vec<u32>,
    low: Vec3,
    /// Cells along each axis.
    cells: [i32; 3],
    /// Their width.
    width: f32,
}

impl CellGrid {
    pub(super) fn new(items: Vec<Item>) -> (CellGrid, Vec<u32>) {
        let bounds = Bounds3::of_points(items.iter().map(|i| i.p));
        let mut grid = CellGrid {
            points: Vec::new(),
            starts: vec![0; (items.len() / 8).next_power_of_two() + 1],
            low: Vec3::ZERO,
            cells: [0; 3],
            width: 1.0,
        };
        if items.is_empty() {
            return (grid, Vec::new());
        }
        let size = bounds.diagonal();
        let area = (2.0 * bounds.half_area()).max(size.max_component().powi(2) * 1e-3);
        let width = (area * POINTS / items.len() as f32).sqrt();
        grid.low = bounds.min;
        grid.width = if width > 0.0 { width } else { 1.0 };
        grid.cells = [size.x, size.y, size.z].map(|s| (s / grid.width) as i32 + 1);
        let mut named: Vec<(u32, Item)> =
            items.into_iter().map(|i| (grid.name(grid.cell(i.p)), i)).collect();
        named.sort_by_key(|&(name, _)| name);
        named.iter().for_each(|&(name, _)| grid.starts[name as usize + 1] += 1);
        for i in 1..grid.starts.len() {
            grid.starts[i] += grid.starts[i - 1];
        }
        grid.points = named.iter().map(|(_, i)| i.p).collect();
        (grid, named.iter().map(|(_, i)| i.index).collect())
    }

    fn cell(&self, p: Vec3) -> [i32; 3] {
        let d = (p - self.low) / self.width;
        // Queries may lie far away.
        [d.x, d.y, d.z].map(|v| v.floor().clamp(-FAR, FAR) as i32)
    }

    fn name(&self, c: [i32; 3]) -> u32 {
        let [x, y, z] = c.map(|v| u64::from(v as u32));
        (combine(combine(x, y), z) & (self.starts.len() as u64 - 2)) as u32
    }

    /// Calls `each` with the points of one cell.
    fn visit(&self, q: Vec3, c: [i32; 3], each: &mut impl FnMut(u32, f32)) {
        let name = self.name(c) as usize;
        for i in self.starts[name]..self.starts[name + 1] {
            let p = self.points[i as usize];
            // Others may share the name.
            if self.cell(p) == c {
                each(i, (p - q).length_squared());
            }
        }
    }

    /// The part of the cells from `from` to `to`, both included, that there is.
    fn clamp(&self, axis: usize, from: i32, to: i32) -> std::ops::RangeInclusive<i32> {
        from.max(0)..=to.min(self.cells[axis] - 1)
    }

    pub(super) fn nearest(&self, q: Vec3, found: &mut Nearest) {
        let c = self.cell(q);
        let outside = |k: usize| (-c[k]).max(c[k] - self.cells[k] + 1).max(0);
        let inside = |k: usize| c[k].max(self.cells[k] - 1 - c[k]);
        let first = (0..3).map(outside).max().unwrap_or(0);
        let last = (0..3).map(inside).max().unwrap_or(0);
        for shell in first..=last {
            // Whatever lies in a shell is farther away than all shells within are wide.
            let inner = (shell - 1).max(0) as f32 * self.width;
            if inner * inner >= found.bound() {
                return;
            }
            let whole = |k: usize| self.clamp(k, c[k] - shell, c[k] + shell);
            for z in whole(2) {
                for y in whole(1) {
                    let edge = (z - c[2]).abs() == shell || (y - c[1]).abs() == shell;
                    let mut offer = |x: i32| {
                        self.visit(q, [x, y, z], &mut |i, d2| {
                            if d2 < found.bound() {
                                found.offer(d2, i);
                            }
                        });
                    };
                    match edge {
                        true => whole(0).for_each(offer),
                        false => [c[0] - shell, c[0] + shell]
                            .into_iter()
                            .filter(|x| (0..self.cells[0]).contains(x))
                            .for_each(&mut offer),
                    }
                }
            }
            found.settle();
        }
    }

    pub(super) fn within(&self, q: Vec3, r2: f32, each: &mut impl FnMut(u32, f32)) {
        let r = Vec3::splat(r2.sqrt() * 1.000_001);
        let (from, to) = (self.cell(q - r), self.cell(q + r));
        for z in self.clamp(2, from[2], to[2]) {
            for y in self.clamp(1, from[1], to[1]) {
                for x in self.clamp(0, from[0], to[0]) {
                    self.visit(q, [x, y, z], &mut |i, d2| {
                        if d2 < r2 {
                            each(i, d2);
                        }
                    });
                }
            }
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.points.len() * size_of::<Vec3>() + 4 * self.starts.len()
    }
}
