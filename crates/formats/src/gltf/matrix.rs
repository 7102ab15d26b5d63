//! Matrices of nodes, in double precision until they are whole.

use super::json::{Fault, Json};
use kaustika_math::{Transform, Vec3};

/// Rows of an affine map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matrix(pub [[f64; 4]; 3]);

impl Matrix {
    pub const IDENTITY: Matrix =
        Matrix([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// The node's own: `matrix`, or translation, rotation and scale.
    pub fn of_node(node: &Json) -> Result<Matrix, Fault> {
        if let Some(m) = node.floats_if::<16>("matrix")? {
            // Columns one after another.
            return Ok(Matrix(std::array::from_fn(|r| {
                std::array::from_fn(|c| f64::from(m[4 * c + r]))
            })));
        }
        let t = node.floats("translation", [0.0; 3])?;
        let r = node.floats("rotation", [0.0, 0.0, 0.0, 1.0])?;
        let s = node.floats("scale", [1.0; 3])?;
        Ok(Matrix::compose(t, r, s))
    }

    /// T R S with the rotation of a quaternion x, y, z, w, which is made unit.
    pub fn compose(t: [f32; 3], r: [f32; 4], s: [f32; 3]) -> Matrix {
        let length = r.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        let [x, y, z, w] = match length > 0.0 {
            true => r.map(|v| f64::from(v) / length),
            false => [0.0, 0.0, 0.0, 1.0],
        };
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Matrix(std::array::from_fn(|i| {
            let [a, b, c] = rotation[i];
            [a * f64::from(s[0]), b * f64::from(s[1]), c * f64::from(s[2]), f64::from(t[i])]
        }))
    }

    /// This map after `inner`.
    pub fn after(&self, inner: &Matrix) -> Matrix {
        let (a, b) = (&self.0, &inner.0);
        Matrix(std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let sum: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
                if j == 3 { sum + a[i][3] } else { sum }
            })
        }))
    }

    /// `None` where it flattens space.
    pub fn transform(&self) -> Option<Transform> {
        let rows = self.0.map(|r| r.map(|v| v as f32));
        Transform::from_rows([rows[0], rows[1], rows[2], [0.0, 0.0, 0.0, 1.0]])
    }

    fn column(&self, c: usize) -> Vec3 {
        let m = &self.0;
        Vec3::new(m[0][c] as f32, m[1][c] as f32, m[2][c] as f32)
    }

    /// Where an observer stands who looks along -z with +y up, as a transform from a space with
    /// +x right, +y up and +z forward; scales are left out.
    pub fn observer(&self) -> Option<Transform> {
        let forward = (-self.column(2)).try_normalize()?;
        let up = self.column(1);
        let up = (up - forward * up.dot(forward)).try_normalize()?;
        let mut right = forward.cross(up);
        if right.dot(self.column(0)) < 0.0 {
            right = -right;
        }
        let p = self.column(3);
        let row = |i: usize| [right[i], up[i], forward[i], p[i]];
        Transform::from_rows([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
    }
}
