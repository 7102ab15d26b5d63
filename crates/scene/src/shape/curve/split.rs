//! Segments cut into pieces, and the pieces' boxes.

use super::bezier::{Point, cross, dot, part, sub, unit, widest, xyz};
use super::ray_space::RaySpace;
use super::round::OVERLAP;
use super::{CurvePiece, CurveSet, CurveStore};
use crate::description::{CurveProfile, Curves};
use kaustika_math::{Bounds3, Transform, Vec3};

/// A piece turns by no more than about this, radians.
const MOST_TURN: f64 = 0.3;
/// A piece is no longer than this many widths, if that takes no more pieces than [`MOST_PIECES`].
const MOST_WIDTHS: f64 = 16.0;
/// Pieces of a segment, at most, to have small boxes.
const MOST_PIECES: f64 = 8.0;
/// Deviation from a straight line that does not show, in widths (pbrt-v4, shapes.cpp).
const STRAIGHT: f64 = 0.05;
/// Times a piece is halved, at most.
const MOST_HALVINGS: f64 = 10.0;

impl CurveStore {
    /// Adds the curves of a shape. Radii grow as the cube root of volumes does under the transform.
    pub fn add(&mut self, curves: &Curves, transform: &Transform, shape: u32, flip: bool) {
        let volume = {
            let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|a| transform.vector(a));
            x.dot(y.cross(z)).abs()
        };
        let grown = volume.cbrt();
        let set = self.sets.len() as u32;
        for (number, segment) in curves.segments.iter().enumerate() {
            let place = |i: usize| {
                let p = transform.point(segment.points[i]);
                [p.x, p.y, p.z, segment.radii[i] * grown].map(f64::from)
            };
            let points = [place(0), place(1), place(2), place(3)];
            let count = pieces_of(&points);
            for i in 0..count {
                let u = [i, i + 1].map(|k| f64::from(k) / f64::from(count));
                let piece = part(&points, u[0], u[1]);
                self.pieces.push(CurvePiece {
                    points: piece.map(|p| p.map(|v| v as f32)),
                    sagitta: (sagitta(&piece) * 1.000_001) as f32,
                    u: u.map(|u| u as f32),
                    set,
                    segment: number as u32,
                    depth: halvings(&piece),
                });
            }
        }
        let normal = |n: Vec3| transform.normal(n).try_normalize().unwrap_or(Vec3::Z);
        self.sets.push(CurveSet {
            shape,
            profile: curves.profile,
            segments: curves.segments.len() as u32,
            flip,
            normals: match curves.profile {
                CurveProfile::Ribbon => curves.normals.iter().map(|n| n.map(normal)).collect(),
                _ => Vec::new(),
            },
        });
    }
}

/// How many pieces a segment is cut into.
fn pieces_of(p: &[Point; 4]) -> u32 {
    let legs = [sub(p[1], p[0]), sub(p[2], p[1]), sub(p[3], p[2])].map(xyz);
    let turn: f64 = [(0, 1), (1, 2)]
        .map(|(i, j)| {
            dot(cross(legs[i], legs[j]), cross(legs[i], legs[j]))
                .sqrt()
                .atan2(dot(legs[i], legs[j]))
        })
        .iter()
        .sum();
    let length: f64 = legs.iter().map(|l| dot(*l, *l).sqrt()).sum();
    let widths = length / (2.0 * widest(p)).max(f64::MIN_POSITIVE);
    let slender = (widths / MOST_WIDTHS).min(MOST_PIECES);
    (turn / MOST_TURN).max(slender).ceil().clamp(1.0, 64.0) as u32
}

/// Largest distance of the inner control points from the line between the ends.
fn sagitta(p: &[Point; 4]) -> f64 {
    let chord = xyz(sub(p[3], p[0]));
    let length2 = dot(chord, chord);
    let stray = |q: Point| {
        let d = xyz(sub(q, p[0]));
        let t = if length2 > 0.0 { (dot(d, chord) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let away = [0, 1, 2].map(|i| d[i] - chord[i] * t);
        dot(away, away).sqrt()
    };
    stray(p[1]).max(stray(p[2]))
}

/// Halvings after which a strip is straight for its width (Wang 1984; pbrt-v4, shapes.cpp).
fn halvings(p: &[Point; 4]) -> u32 {
    let bend = |a: Point, b: Point, c: Point| {
        (0..3).map(|i| (a[i] - 2.0 * b[i] + c[i]).abs()).fold(0.0, f64::max)
    };
    let most = bend(p[0], p[1], p[2]).max(bend(p[1], p[2], p[3]));
    let width = 2.0 * widest(p);
    let levels = (std::f64::consts::SQRT_2 * 6.0 * most / (8.0 * STRAIGHT * width)).log(4.0);
    levels.clamp(0.0, MOST_HALVINGS) as u32
}

impl CurvePiece {
    /// The box around it.
    pub(super) fn bounds(&self) -> Bounds3 {
        let at = |p: [f32; 4]| Vec3::new(p[0], p[1], p[2]);
        let hull = Bounds3::of_points(self.points.map(at));
        let r = self.points.iter().map(|p| p[3]).fold(0.0, f32::max);
        // What overlaps is within, and so is rounding.
        let more = r * 1.002
            + hull.diagonal().max_component() * (4.0 * OVERLAP as f32)
            + hull.min.abs().max(hull.max.abs()).max_component() * 2.0 * f32::EPSILON;
        Bounds3 { min: hull.min - Vec3::splat(more), max: hull.max + Vec3::splat(more) }
    }

    /// True if a ray surely passes by: what costs least to be told.
    pub(super) fn is_beside(&self, space: &RaySpace) -> bool {
        let (a, b) = (space.project(self.points[0]), space.project(self.points[3]));
        let r = self.points.iter().map(|p| p[3]).fold(0.0, f32::max);
        let reach = f64::from(r + self.sagitta) * 1.002 + OVERLAP * unit_length(xyz(sub(b, a)));
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length2 = dx * dx + dy * dy;
        let t = if length2 > 0.0 { -(a[0] * dx + a[1] * dy) / length2 } else { 0.0 };
        let t = t.clamp(0.0, 1.0);
        let (x, y) = (a[0] + dx * t, a[1] + dy * t);
        x * x + y * y > reach * reach
    }

    /// u at `w`.
    pub(super) fn u_at(&self, w: f32) -> f32 {
        self.u[0] + (self.u[1] - self.u[0]) * w
    }

    /// Direction in which the piece runs at `w`, unit; of its chord where it stands still.
    pub(super) fn direction(&self, d: Point) -> [f64; 3] {
        let chord = || {
            let ends = [self.points[0], self.points[3]].map(|p| p.map(f64::from));
            unit(xyz(sub(ends[1], ends[0])))
        };
        unit(xyz(d)).or_else(chord).unwrap_or([0.0, 0.0, 1.0])
    }
}

fn unit_length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}
