//! Affine transforms of space and of the uv plane.

use crate::{Bounds3, Ray, Vec2, Vec3};

/// A 4x4 matrix with its inverse. [`Transform::point`], [`Transform::vector`] and
/// [`Transform::normal`] say what is transformed; rows are stored first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// The matrix, row by row.
    pub m: [[f32; 4]; 4],
    /// Its inverse.
    pub inv: [[f32; 4]; 4],
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl Default for Transform {
    fn default() -> Self {
        Transform::IDENTITY
    }
}

impl Transform {
    /// Leaves everything as it is.
    pub const IDENTITY: Transform = Transform { m: IDENTITY, inv: IDENTITY };

    /// From a matrix given by rows; `None` if it is singular or not finite.
    pub fn from_rows(m: [[f32; 4]; 4]) -> Option<Transform> {
        Some(Transform { m, inv: invert(m)? })
    }

    /// Translation by `d`.
    pub fn translate(d: Vec3) -> Transform {
        let mut m = IDENTITY;
        let mut inv = IDENTITY;
        for i in 0..3 {
            m[i][3] = d[i];
            inv[i][3] = -d[i];
        }
        Transform { m, inv }
    }

    /// Scaling by `s` along the axes; `None` if a factor is zero or not finite.
    pub fn scale(s: Vec3) -> Option<Transform> {
        let mut m = IDENTITY;
        for i in 0..3 {
            m[i][i] = s[i];
        }
        Transform::from_rows(m)
    }

    /// Right-handed rotation by `degrees` about `axis`; `None` if the axis is zero.
    pub fn rotate(degrees: f32, axis: Vec3) -> Option<Transform> {
        let a = axis.try_normalize()?;
        let (s, c) = (degrees as f64).to_radians().sin_cos();
        let (x, y, z) = (a.x as f64, a.y as f64, a.z as f64);
        let k = 1.0 - c;
        let rows = [
            [x * x * k + c, x * y * k - z * s, x * z * k + y * s],
            [x * y * k + z * s, y * y * k + c, y * z * k - x * s],
            [x * z * k - y * s, y * z * k + x * s, z * z * k + c],
        ];
        let mut t = Transform::IDENTITY;
        for i in 0..3 {
            for j in 0..3 {
                t.m[i][j] = rows[i][j] as f32;
                t.inv[j][i] = rows[i][j] as f32;
            }
        }
        t.m.iter().flatten().all(|v| v.is_finite()).then_some(t)
    }

    /// The frame of an observer at `origin` that looks at `target` along its +z, with +y near
    /// `up` and +x = up x z ("camera to world", left-handed on screen as in pbrt when
    /// `x_sign` is 1: x = up x direction). `None` if the three do not span a frame.
    pub fn look_at(origin: Vec3, target: Vec3, up: Vec3) -> Option<Transform> {
        let dir = (target - origin).try_normalize()?;
        let right = up.cross(dir).try_normalize()?;
        let new_up = dir.cross(right);
        let row = |i: usize| [right[i], new_up[i], dir[i], origin[i]];
        Transform::from_rows([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
    }

    /// The inverse.
    #[inline]
    pub fn inverse(&self) -> Transform {
        Transform { m: self.inv, inv: self.m }
    }

    /// First `o`, then `self`: the matrix product self·o.
    pub fn then_after(&self, o: &Transform) -> Transform {
        Transform { m: product(&self.m, &o.m), inv: product(&o.inv, &self.inv) }
    }

    /// A point, with the homogeneous division.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        let r =
            |i: usize| self.m[i][0] * p.x + self.m[i][1] * p.y + self.m[i][2] * p.z + self.m[i][3];
        let (q, w) = (Vec3::new(r(0), r(1), r(2)), r(3));
        if w == 1.0 { q } else { q / w }
    }

    /// A vector: translation does not move it.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        let r = |i: usize| self.m[i][0] * v.x + self.m[i][1] * v.y + self.m[i][2] * v.z;
        Vec3::new(r(0), r(1), r(2))
    }

    /// A normal, by the inverse transpose; not normalised.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let c = |j: usize| self.inv[0][j] * n.x + self.inv[1][j] * n.y + self.inv[2][j] * n.z;
        Vec3::new(c(0), c(1), c(2))
    }

    /// A ray; its parameter `t` keeps its meaning.
    #[inline]
    pub fn ray(&self, r: &Ray) -> Ray {
        Ray { o: self.point(r.o), d: self.vector(r.d), time: r.time }
    }

    /// Bound of the rounding error of [`Transform::point`] when `p` itself is uncertain by
    /// `p_error` (Pharr et al. 2023, sec. 6.8.5).
    pub fn point_error(&self, p: Vec3, p_error: Vec3) -> Vec3 {
        let g = crate::gamma(3);
        let row = |i: usize| {
            let m = &self.m[i];
            (g + 1.0) * (m[0].abs() * p_error.x + m[1].abs() * p_error.y + m[2].abs() * p_error.z)
                + g * ((m[0] * p.x).abs() + (m[1] * p.y).abs() + (m[2] * p.z).abs() + m[3].abs())
        };
        Vec3::new(row(0), row(1), row(2))
    }

    /// The box around the transformed corners.
    pub fn bounds(&self, b: &Bounds3) -> Bounds3 {
        if b.is_empty() {
            return *b;
        }
        Bounds3::of_points((0..8).map(|i| self.point(b.corner(i))))
    }

    /// True if a right-handed frame becomes left-handed.
    pub fn swaps_handedness(&self) -> bool {
        let m = &self.m;
        let row = |i: usize| Vec3::new(m[i][0], m[i][1], m[i][2]);
        row(0).dot(row(1).cross(row(2))) < 0.0
    }

    /// True if nothing moves.
    pub fn is_identity(&self) -> bool {
        self.m == IDENTITY
    }
}

impl std::ops::Mul for Transform {
    type Output = Transform;
    /// The matrix product: `a * b` applies `b` first.
    fn mul(self, o: Transform) -> Transform {
        self.then_after(&o)
    }
}

fn product(a: &[[f32; 4]; 4], b: &[[f32; 4]; 4]) -> [[f32; 4]; 4] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..4).map(|k| a[i][k] as f64 * b[k][j] as f64).sum::<f64>() as f32)
    })
}

/// Gauss-Jordan elimination with full pivoting, in double precision.
fn invert(m: [[f32; 4]; 4]) -> Option<[[f32; 4]; 4]> {
    if !m.iter().flatten().all(|v| v.is_finite()) {
        return None;
    }
    let mut a = m.map(|r| r.map(|v| v as f64));
    let mut b = IDENTITY.map(|r| r.map(|v| v as f64));
    for col in 0..4 {
        let pivot = (col..4).max_by(|&i, &j| a[i][col].abs().total_cmp(&a[j][col].abs()))?;
        if a[pivot][col].abs() < 1e-30 {
            return None;
        }
        a.swap(col, pivot);
        b.swap(col, pivot);
        let inv = 1.0 / a[col][col];
        for k in 0..4 {
            a[col][k] *= inv;
            b[col][k] *= inv;
        }
        for i in 0..4 {
            if i != col {
                let f = a[i][col];
                for k in 0..4 {
                    a[i][k] -= f * a[col][k];
                    b[i][k] -= f * b[col][k];
                }
            }
        }
    }
    let r = b.map(|r| r.map(|v| v as f32));
    r.iter().flatten().all(|v| v.is_finite()).then_some(r)
}

/// An affine map of the uv plane: (m00 u + m01 v + m02, m10 u + m11 v + m12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine2 {
    /// Two rows of three.
    pub m: [[f32; 3]; 2],
}

impl Default for Affine2 {
    fn default() -> Self {
        Affine2::IDENTITY
    }
}

impl Affine2 {
    /// Leaves uv as it is.
    pub const IDENTITY: Affine2 = Affine2 { m: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };

    /// Scale, then shift: (su u + du, sv v + dv).
    pub fn scale_shift(su: f32, sv: f32, du: f32, dv: f32) -> Affine2 {
        Affine2 { m: [[su, 0.0, du], [0.0, sv, dv]] }
    }

    /// A point of the plane.
    #[inline]
    pub fn point(&self, p: Vec2) -> Vec2 {
        Vec2::new(
            self.m[0][0] * p.x + self.m[0][1] * p.y + self.m[0][2],
            self.m[1][0] * p.x + self.m[1][1] * p.y + self.m[1][2],
        )
    }

    /// A vector of the plane.
    #[inline]
    pub fn vector(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.m[0][0] * v.x + self.m[0][1] * v.y, self.m[1][0] * v.x + self.m[1][1] * v.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes() {
        let t = Transform::translate(Vec3::new(1.0, -2.0, 3.0))
            * Transform::rotate(37.0, Vec3::new(1.0, 2.0, -0.5)).unwrap()
            * Transform::scale(Vec3::new(2.0, 0.5, -3.0)).unwrap();
        let p = Vec3::new(0.3, 4.0, -1.5);
        assert!((t.inverse().point(t.point(p)) - p).length() < 1e-5);
        assert!(t.swaps_handedness());
        let full = Transform::from_rows(t.m).unwrap();
        for i in 0..4 {
            for j in 0..4 {
                assert!((full.inv[i][j] - t.inv[i][j]).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn normals_stay_perpendicular() {
        let t = Transform::scale(Vec3::new(1.0, 5.0, 0.2)).unwrap()
            * Transform::rotate(30.0, Vec3::X).unwrap();
        let (v, n) = (Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, -1.0, 7.0));
        assert!(t.vector(v).dot(t.normal(n)).abs() < 1e-5);
    }

    #[test]
    fn singular_is_refused() {
        assert!(Transform::scale(Vec3::new(1.0, 0.0, 1.0)).is_none());
        assert!(Transform::scale(Vec3::new(1.0, f32::NAN, 1.0)).is_none());
        assert!(Transform::look_at(Vec3::ZERO, Vec3::Z, Vec3::Z).is_none());
    }
}
