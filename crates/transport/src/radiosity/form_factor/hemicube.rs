//! The hemicube (Cohen & Greenberg 1985): half a cube around the patch's middle, onto whose five faces
//! all patches are drawn with a depth buffer.
//!
//! ```text
//! top:   ΔF = ΔA / π (x² + y² + 1)²                                                 (1)
//! sides: ΔF = z ΔA / π (y² + z² + 1)²                                               (2)
//! F_ij ≈ Σ ΔF over the cells that show patch j                                      (3)
//! ```
//!
//! Cells alias, and the middle stands for the patch: patches that touch are seen wrongly. Surfaces
//! without patches (curves, distance grids, cut-outs) are not seen to hide anything.

use super::{FormFactors, Row};
use kaustika_math::{Frame, Vec3};
use std::f32::consts::PI;

/// Nearer than this part of a cell's depth nothing is drawn.
const NEAR: f32 = 1e-4;

/// A face: what is right, up and ahead in the patch's frame.
struct Face {
    right: Vec3,
    up: Vec3,
    ahead: Vec3,
}

/// What a cell shows, and how near (1/depth).
#[derive(Clone, Copy)]
struct Cell {
    nearness: f32,
    patch: u32,
}

/// Nothing, or the back of something.
const NOTHING: u32 = u32::MAX;

impl FormFactors<'_> {
    /// (3), with faces of `samples`² cells; of the sides the upper half is used.
    pub(super) fn by_hemicube(&self, i: usize) -> Row {
        let element = self.element(i);
        let frame = Frame::from_normal(element.normal);
        let (origin, size) = (element.center(), self.samples.max(2));
        let near = NEAR * element.radius();
        let mut sums = vec![0.0f32; self.len()];
        for face in &FACES {
            let mut cells = vec![Cell { nearness: 0.0, patch: NOTHING }; (size * size) as usize];
            for j in (0..self.len()).filter(|&j| j != i) {
                let other = self.element(j);
                let shown = other.normal.dot(origin - other.center()) > 0.0;
                let corners = other.corners.map(|c| {
                    let local = frame.to_local(c - origin);
                    Vec3::new(local.dot(face.right), local.dot(face.up), local.dot(face.ahead))
                });
                let patch = if shown { j as u32 } else { NOTHING };
                draw(&mut cells, size, &corners, near, patch);
            }
            for (k, cell) in cells.iter().enumerate().filter(|(_, c)| c.patch != NOTHING) {
                let at = |k: u32| 2.0 * (k as f32 + 0.5) / size as f32 - 1.0;
                let (x, y) = (at(k as u32 % size), at(k as u32 / size));
                sums[cell.patch as usize] += face.delta(x, y) * 4.0 / (size * size) as f32;
            }
        }
        let seen = sums.iter().enumerate().filter(|(_, f)| **f > 0.0);
        Row { seen: seen.map(|(j, f)| (j as u32, *f)).collect(), ..Row::default() }
    }
}

const NEGATIVE_X: Vec3 = Vec3::new(-1.0, 0.0, 0.0);
const NEGATIVE_Y: Vec3 = Vec3::new(0.0, -1.0, 0.0);
const FACES: [Face; 5] = [
    Face { right: Vec3::X, up: Vec3::Y, ahead: Vec3::Z },
    Face { right: Vec3::Y, up: Vec3::Z, ahead: Vec3::X },
    Face { right: Vec3::Y, up: Vec3::Z, ahead: NEGATIVE_X },
    Face { right: Vec3::X, up: Vec3::Z, ahead: Vec3::Y },
    Face { right: Vec3::X, up: Vec3::Z, ahead: NEGATIVE_Y },
];

impl Face {
    /// (1) or (2) over ΔA, at a place in [-1, 1]² of the face.
    fn delta(&self, x: f32, y: f32) -> f32 {
        let r2 = x * x + y * y + 1.0;
        let height = self.up.z * y + self.ahead.z;
        height.max(0.0) / (PI * r2 * r2)
    }
}

/// Draws a triangle in a face's coordinates, the depth last.
fn draw(cells: &mut [Cell], size: u32, corners: &[Vec3; 3], near: f32, patch: u32) {
    let mut polygon = arrayvec::ArrayVec::<Vec3, 4>::new();
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        if a.z > near {
            polygon.push(a);
        }
        if (a.z > near) != (b.z > near) {
            polygon.push(a.lerp(b, (near - a.z) / (b.z - a.z)));
        }
    }
    // On the picture plane nearness 1/z is linear. In double precision: what is cut near the eye lies
    // far outside the face.
    let projected: arrayvec::ArrayVec<[f64; 3], 4> = polygon
        .iter()
        .map(|p| {
            let nearness = 1.0 / f64::from(p.z);
            [f64::from(p.x) * nearness, f64::from(p.y) * nearness, nearness]
        })
        .collect();
    for k in 2..projected.len() {
        fill(cells, size, [projected[0], projected[k - 1], projected[k]], patch);
    }
}

fn fill(cells: &mut [Cell], size: u32, [a, b, c]: [[f64; 3]; 3], patch: u32) {
    let side = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (e1, e2) = (side(b), side(c));
    let whole = e1[0] * e2[1] - e1[1] * e2[0];
    if whole == 0.0 {
        return;
    }
    let size_f = f64::from(size);
    let range = |k: usize| {
        let cell = |x: f64| 0.5 * (x + 1.0) * size_f - 0.5;
        let first = cell(a[k].min(b[k]).min(c[k])).ceil().clamp(0.0, size_f);
        let end = (cell(a[k].max(b[k]).max(c[k])).floor() + 1.0).clamp(first, size_f);
        first as u32..end as u32
    };
    let at = |k: u32| 2.0 * (f64::from(k) + 0.5) / size_f - 1.0;
    for row in range(1) {
        let dy = at(row) - a[1];
        for column in range(0) {
            let dx = at(column) - a[0];
            let u = (dx * e2[1] - dy * e2[0]) / whole;
            let v = (e1[0] * dy - e1[1] * dx) / whole;
            if u < 0.0 || v < 0.0 || u + v > 1.0 {
                continue;
            }
            let nearness = (a[2] + u * e1[2] + v * e2[2]) as f32;
            let cell = &mut cells[(row * size + column) as usize];
            if nearness > cell.nearness {
                *cell = Cell { nearness, patch };
            }
        }
    }
}
