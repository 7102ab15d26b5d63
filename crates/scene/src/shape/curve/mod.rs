//! Thin curves with a width: hair, fur, grass.
//!
//! Cubic Bézier segments are cut into pieces that bend little, each a primitive with a box of its
//! own: boxes about long slanting curves are nearly empty. A ray meets a piece in coordinates
//! whose z runs along it, in double precision, since widths are small against distances.
//!
//! Along a segment u runs from 0 to 1; w is the same along one piece.

mod bezier;
mod facing;
mod ray_space;
mod round;
mod split;
mod surface;

#[cfg(test)]
mod tests;

pub use ray_space::RaySpace;

use crate::description::CurveProfile;
use kaustika_math::{Bounds3, Vec3};

/// Part of a segment.
#[derive(Clone, Copy, Debug)]
pub struct CurvePiece {
    /// Bézier control points with their radii.
    points: [[f32; 4]; 4],
    /// How far the piece strays from the line between its ends, no less.
    sagitta: f32,
    /// u at both ends.
    u: [f32; 2],
    /// Number of its set.
    set: u32,
    /// Number of its segment in the set.
    segment: u32,
    /// Times a facing piece is halved until it is straight.
    depth: u32,
}

/// The curves of one shape.
#[derive(Clone, Debug)]
pub struct CurveSet {
    /// Shape in the scene's list.
    pub shape: u32,
    profile: CurveProfile,
    /// Segments it has.
    segments: u32,
    /// True if normals point the other way.
    flip: bool,
    /// Normals at both ends of each segment of a ribbon.
    normals: Vec<[Vec3; 2]>,
}

/// Where a ray meets a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveHit {
    /// Ray parameter.
    pub t: f32,
    /// Along the piece, w in [0, 1] or beyond it by rounding.
    pub w: f32,
    /// Across a strip in [0, 1]; around a tube in turns; not used for spheres.
    pub v: f32,
}

/// All curves of a scene.
#[derive(Debug, Default)]
pub struct CurveStore {
    /// Pieces, the primitives of hierarchies.
    pub pieces: Vec<CurvePiece>,
    /// One a shape.
    pub sets: Vec<CurveSet>,
}

impl CurveStore {
    /// The curves that a piece belongs to.
    #[inline]
    pub fn set(&self, piece: u32) -> &CurveSet {
        &self.sets[self.pieces[piece as usize].set as usize]
    }

    /// The box around a piece.
    pub fn bounds(&self, piece: u32) -> Bounds3 {
        self.pieces[piece as usize].bounds()
    }

    /// The nearest hit with t in (0, t_max) of the ray whose coordinates are `space`.
    pub fn intersect(&self, piece: u32, space: &RaySpace, t_max: f32) -> Option<CurveHit> {
        let p = &self.pieces[piece as usize];
        if p.is_beside(space) {
            return None;
        }
        let set = &self.sets[p.set as usize];
        let points = p.points.map(|q| space.project(q));
        let hit = match set.profile {
            CurveProfile::Tube => round::tube(&points, space.z_max(t_max)),
            CurveProfile::Spheres => round::spheres(&points, space.z_max(t_max)),
            CurveProfile::Flat | CurveProfile::Cylinder => {
                facing::strip(&points, p.depth, space.z_max(t_max), |_| 1.0)
            }
            CurveProfile::Ribbon => {
                let foreshortened = |w| {
                    let n = set.ribbon_normal(p.segment, p.u_at(w as f32));
                    space.along([n.x, n.y, n.z].map(f64::from)).abs()
                };
                facing::strip(&points, p.depth, space.z_max(t_max), foreshortened)
            }
        }?;
        let t = (hit.z / space.length()) as f32;
        (t > 0.0 && t < t_max).then(|| {
            let v = match set.profile {
                CurveProfile::Tube => p.turns(space, &hit),
                _ => hit.v,
            };
            CurveHit { t, w: hit.w, v: v as f32 }
        })
    }
}
