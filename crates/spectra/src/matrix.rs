//! 3×3 matrices between colour coordinates.

use std::ops::Mul;

/// A linear map of colour coordinates, row-major; products and inverses are formed in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix3(pub [[f32; 3]; 3]);

impl Matrix3 {
    /// The identity.
    pub const IDENTITY: Matrix3 = Matrix3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// The matrix with this diagonal.
    pub const fn diagonal(d: [f32; 3]) -> Matrix3 {
        Matrix3([[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]])
    }

    /// Matrix times column vector.
    #[inline]
    pub fn apply(&self, v: [f32; 3]) -> [f32; 3] {
        self.0.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }

    /// The inverse, or `None` if the determinant is zero.
    pub fn inverse(&self) -> Option<Matrix3> {
        let m = self.0.map(|r| r.map(f64::from));
        // Cofactors of a 3×3 matrix need no signs when rows and columns wrap around.
        let cofactor = |i: usize, j: usize| {
            let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        };
        let det: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
        (det != 0.0).then(|| {
            Matrix3(std::array::from_fn(|i| std::array::from_fn(|j| (cofactor(j, i) / det) as f32)))
        })
    }
}

impl Mul for Matrix3 {
    type Output = Matrix3;
    fn mul(self, o: Matrix3) -> Matrix3 {
        Matrix3(std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (0..3).map(|k| self.0[i][k] as f64 * o.0[k][j] as f64).sum::<f64>() as f32
            })
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes() {
        let m = Matrix3([[2.0, -1.0, 0.5], [0.1, 3.0, 0.2], [-0.7, 0.4, 1.0]]);
        let p = m.inverse().expect("the determinant is about 7") * m;
        for i in 0..3 {
            for j in 0..3 {
                assert!((p.0[i][j] - Matrix3::IDENTITY.0[i][j]).abs() < 1e-6, "{p:?}");
            }
        }
        assert_eq!(Matrix3([[1.0, 2.0, 3.0]; 3]).inverse(), None);
    }
}
