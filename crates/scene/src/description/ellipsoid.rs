//! Many ellipsoids as one shape.

use kaustika_math::{Transform, Vec3};

/// An ellipsoid, met from outside only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Its centre.
    pub center: Vec3,
    /// Half lengths of its axes, positive.
    pub radii: Vec3,
    /// Turns the axes from x, y, z: a quaternion (x, y, z, w) of any length but 0.
    pub rotation: [f32; 4],
}

impl Ellipsoid {
    /// Takes the unit sphere to the ellipsoid. `None` if the quaternion or a radius is 0 or not
    /// finite.
    pub fn place(&self) -> Option<Transform> {
        let [x, y, z, w] = self.rotation.map(f64::from);
        let norm = x * x + y * y + z * z + w * w;
        let s = 2.0 / norm;
        let rotation = [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
        ];
        let mut turn = Transform::IDENTITY;
        for (i, row) in rotation.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                turn.m[i][j] = *v as f32;
                turn.inv[j][i] = *v as f32;
            }
        }
        let finite = norm > 0.0 && s.is_finite();
        let stretch = Transform::scale(self.radii).filter(|_| finite)?;
        Some(Transform::translate(self.center) * turn * stretch)
    }
}
