//! Form factors from points of both patches.
//!
//! ```text
//! F_ij ≈ A_j/n Σₖ V(xₖ,yₖ) cos θ_i cos θ_j / (π r² + A_j/n)                         (1)
//! F_ij ≈ 1/n Σₖ V(xₖ,yₖ) F(xₖ → patch j)                                           (2)
//! ```
//!
//! (1) sees disks of area A_j/n around the points yₖ (Wallace et al. 1989), which tames the pole where
//! patches touch. (2) takes the unhidden factor by Lambert's formula, exact where nothing is hidden.

use super::polygon::point_to_triangle;
use super::{FormFactorKind, FormFactors, Row};
use crate::radiosity::mesh::{Element, Point};
use kaustika_math::mix_bits;
use kaustika_scene::RayBatch;
use std::f32::consts::PI;

/// Pairs of points whose rays are traced together.
const BATCH: usize = 4096;

impl FormFactors<'_> {
    /// (1) or (2).
    pub(super) fn by_pairs(&self, i: usize) -> Row {
        let mut row = Row::default();
        let n = self.samples as usize;
        let from = self.element(i);
        let (mut batch, mut segments, mut terms) = (RayBatch::default(), Vec::new(), Vec::new());
        let mut others = Vec::new();
        for j in 0..self.len() {
            if j != i && faces(from, self.element(j)) && faces(self.element(j), from) {
                // Another pairing of the same points for each pair of patches.
                let turn = mix_bits((i.min(j) as u64) << 32 | i.max(j) as u64) as usize % n;
                for k in 0..n {
                    let (a, b) = if i < j { (k, (k + turn) % n) } else { ((k + turn) % n, k) };
                    let (x, y) = (&self.points[i * n + a], &self.points[j * n + b]);
                    segments.push(x.sight(y));
                    terms.push(self.term(x, y, j));
                }
                others.push(j as u32);
            }
            if segments.len() >= BATCH || j + 1 == self.len() {
                self.scene.occluded_all(&segments, &mut batch);
                for (k, &j) in others.iter().enumerate() {
                    let terms = terms[k * n..][..n].iter().zip(&batch.occluded[k * n..][..n]);
                    let sum: f32 = terms.filter(|(_, hidden)| !**hidden).map(|(t, _)| t).sum();
                    if sum > 0.0 {
                        row.seen.push((j, sum));
                    }
                }
                others.clear();
                segments.clear();
                terms.clear();
            }
        }
        row
    }

    fn term(&self, x: &Point, y: &Point, j: usize) -> f32 {
        let n = self.samples as f32;
        let other = self.element(j);
        if self.kind == FormFactorKind::Analytic {
            return point_to_triangle(x.p, x.n, &other.corners) as f32 / n; // (2)
        }
        let d = y.p - x.p;
        let (r2, disk) = (d.length_squared(), other.area / n);
        let cosines = x.n.dot(d).max(0.0) * (-y.n.dot(d)).max(0.0) / r2.max(f32::MIN_POSITIVE);
        disk * cosines / (PI * r2 + disk) // (1)
    }
}

/// True if some of `b` is on the side of `a` that light leaves.
fn faces(a: &Element, b: &Element) -> bool {
    let slack = 1e-5 * (a.area.sqrt() + b.area.sqrt());
    b.corners.iter().any(|c| a.normal.dot(*c - a.corners[0]) > slack)
}
