//! Coordinates whose origin is that of a ray and whose z runs along it.

use super::bezier::{Point, cross, dot, unit};
use kaustika_math::Ray;

/// A ray's own coordinates.
#[derive(Clone, Copy, Debug)]
pub struct RaySpace {
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    length: f64,
}

/// Where a ray meets a piece, in the ray's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Distance from the origin.
    pub z: f64,
    /// Along the piece.
    pub w: f32,
    /// Across it.
    pub v: f64,
}

impl RaySpace {
    /// Those of `ray`; `None` if it has no direction.
    pub fn new(ray: &Ray) -> Option<RaySpace> {
        let [o, d] = [ray.o, ray.d].map(|v| [v.x, v.y, v.z].map(f64::from));
        let z = unit(d)?;
        let least = (0..3).min_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs()))?;
        let mut away = [0.0; 3];
        away[least] = 1.0;
        let x = unit(cross(away, z))?;
        Some(RaySpace { origin: o, axes: [x, cross(z, x), z], length: dot(d, d).sqrt() })
    }

    /// Length of the ray's direction.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// z of the ray parameter `t_max`.
    pub(super) fn z_max(&self, t_max: f32) -> f64 {
        f64::from(t_max) * self.length
    }

    /// A point in these coordinates, and its radius.
    pub(super) fn project(&self, p: [f32; 4]) -> Point {
        let q = [0, 1, 2].map(|i| f64::from(p[i]) - self.origin[i]);
        let [x, y, z] = self.axes.map(|a| dot(q, a));
        [x, y, z, f64::from(p[3])]
    }

    /// The point of the ray at `z`, in its group's coordinates.
    pub(super) fn at(&self, z: f64) -> [f64; 3] {
        [0, 1, 2].map(|i| self.origin[i] + self.axes[2][i] * z)
    }

    /// z of a direction.
    pub(super) fn along(&self, d: [f64; 3]) -> f64 {
        dot(d, self.axes[2])
    }
}
