//! Points of sixteen surfaces: the twin of [`TriangleStore::surface`].

use crate::shape::TriangleStore;
use crate::surface::Surface;
use kaustika_math::Vec3;
use kaustika_math::lanes::{
    LANES, Lanes, Row, Vec3s, is_finite, mask_of, offset_origin, triangle_point_error,
};

/// What sixteen rays met, gathered lane by lane: triangles, whose points are computed together,
/// or points that are known.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct SurfaceHits {
    corners: [[Row; 3]; 3],
    normals: [[Row; 3]; 3],
    /// Barycentric weights.
    b: [Row; 3],
    /// -1 where the mesh's normals point the other way.
    side: Row,
    /// Lanes whose mesh has shading normals.
    smooth: u32,
    /// Lanes whose points are known: they, their errors and normals.
    known: u32,
    p: [Row; 3],
    p_error: [Row; 3],
    ng: [Row; 3],
    ns: [Row; 3],
}

impl Default for SurfaceHits {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        SurfaceHits {
            corners: [zero; 3],
            normals: [zero; 3],
            b: zero,
            side: [1.0; LANES],
            smooth: 0,
            known: 0,
            p: zero,
            p_error: zero,
            ng: zero,
            ns: zero,
        }
    }
}

/// Sixteen points as [`Surface`] has them.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces {
    /// The points, world space.
    pub p: Vec3s,
    /// Bounds of their rounding errors.
    pub p_error: Vec3s,
    /// Geometric normals, unit.
    pub ng: Vec3s,
    /// Shading normals, unit.
    pub ns: Vec3s,
}

impl Surfaces {
    /// Origins of rays along `d`, safe from meeting their surfaces again.
    #[inline(always)]
    pub fn origins(&self, d: Vec3s) -> Vec3s {
        offset_origin(self.p, self.p_error, self.ng, d)
    }
}

fn set(rows: &mut [Row; 3], lane: usize, v: Vec3) {
    [rows[0][lane], rows[1][lane], rows[2][lane]] = [v.x, v.y, v.z];
}

impl SurfaceHits {
    /// Notes the triangle that the ray of `lane` met at barycentric weights `b`.
    #[inline(always)]
    pub fn set_triangle(&mut self, lane: usize, store: &TriangleStore, triangle: u32, b: [f32; 3]) {
        let lane = lane % LANES;
        self.known &= !(1 << lane);
        let mesh = store.mesh(triangle);
        let indices = store.indices[triangle as usize];
        for (rows, i) in self.corners.iter_mut().zip(indices) {
            set(rows, lane, store.positions[i as usize]);
        }
        for (row, b) in self.b.iter_mut().zip(b) {
            row[lane] = b;
        }
        self.side[lane] = if mesh.flip { -1.0 } else { 1.0 };
        self.smooth &= !(1 << lane);
        if mesh.has_normals {
            self.smooth |= 1 << lane;
            for (rows, i) in self.normals.iter_mut().zip(indices) {
                set(rows, lane, store.normals[i as usize]);
            }
        }
    }

    /// Notes a point that the ray of `lane` met.
    pub fn set_surface(&mut self, lane: usize, s: &Surface) {
        let lane = lane % LANES;
        self.known |= 1 << lane;
        set(&mut self.p, lane, s.p);
        set(&mut self.p_error, lane, s.p_error);
        set(&mut self.ng, lane, s.ng);
        set(&mut self.ns, lane, s.ns);
    }

    /// The points. Lanes that were not set have any numbers.
    #[inline(always)]
    pub fn surfaces(&self) -> Surfaces {
        let p = self.corners.each_ref().map(Vec3s::load);
        let b = self.b.map(Lanes::new);
        let side = Lanes::new(self.side);
        let mut ng = (p[1] - p[0]).cross(p[2] - p[0]).normalize() * side;
        let mut ns = ng;
        if self.smooth != 0 {
            let n = self.normals.each_ref().map(Vec3s::load);
            let n = (n[0] * b[0]).plus(n[1], b[1]).plus(n[2], b[2]) * side;
            let smooth = mask_of(self.smooth);
            ng = ng.face_forward(n).or(smooth, ng);
            let length2 = n.dot(n);
            let sound = length2.simd_gt(Lanes::splat(0.0)) & is_finite(length2) & smooth;
            ns = (n * (Lanes::splat(1.0) / length2.sqrt())).or(sound, ng);
        }
        let p_error = triangle_point_error(p, b);
        let p = (p[0] * b[0]).plus(p[1], b[1]).plus(p[2], b[2]);
        if self.known == 0 {
            return Surfaces { p, p_error, ng, ns };
        }
        let known = mask_of(self.known);
        let or = |rows: &[Row; 3], computed: Vec3s| Vec3s::load(rows).or(known, computed);
        Surfaces {
            p: or(&self.p, p),
            p_error: or(&self.p_error, p_error),
            ng: or(&self.ng, ng),
            ns: or(&self.ns, ns),
        }
    }
}
