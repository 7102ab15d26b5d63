//! Boxes with rounded edges.

use kaustika_math::Vec3;
use kaustika_scene::description::TriMesh;
use std::f32::consts::FRAC_PI_2;

/// The box [-half, half] whose edges have the radius `radius` (less than the smallest half extent),
/// each quarter turn in `steps` parts: a sphere pulled apart along the axes.
pub fn rounded_box(half: Vec3, radius: f32, steps: u32) -> TriMesh {
    let core = half - Vec3::splat(radius);
    let mut mesh = TriMesh::default();
    // Azimuths and elevations come once for either neighbour where two octants meet: the cells
    // between the two are the flat faces.
    let n = steps + 1;
    let (columns, rows) = (4 * n, 2 * n);
    let angle = |k: u32| (k % n) as f32 / steps as f32 * FRAC_PI_2;
    for row in 0..rows {
        let up = if row < n { -1.0 } else { 1.0 };
        let elevation = angle(row) + if row < n { -FRAC_PI_2 } else { 0.0 };
        for column in 0..columns {
            let quarter = column / n;
            let azimuth = angle(column) + quarter as f32 * FRAC_PI_2;
            let x = if quarter == 0 || quarter == 3 { 1.0 } else { -1.0 };
            let z = if quarter < 2 { -1.0 } else { 1.0 };
            let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
            let normal = Vec3::new(ce * ca, se, -ce * sa);
            mesh.positions.push(Vec3::new(x, up, z) * core + normal * radius);
            mesh.normals.push(normal);
        }
    }
    let at = |column: u32, row: u32| row * columns + column % columns;
    for row in 0..rows - 1 {
        for column in 0..columns {
            let [a, b] = [at(column, row), at(column + 1, row)];
            let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
            // At the poles the azimuths of an octant are one point.
            let between_octants = column % n == steps;
            if row > 0 || between_octants {
                mesh.indices.push([a, b, c]);
            }
            if row + 2 < rows || between_octants {
                mesh.indices.push([a, c, d]);
            }
        }
    }
    let corner = |row: u32| [0, 1, 2, 3].map(|quarter| at(quarter * n, row));
    let ([a, b, c, d], [e, f, g, h]) = (corner(0), corner(rows - 1));
    mesh.indices.extend([[a, c, b], [a, d, c], [e, f, g], [e, g, h]]);
    mesh
}

#[cfg(test)]
mod tests {
    use super::super::grid::{defects, volume};
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn volume_is_a_minkowski_sum() {
        let (half, r) = (Vec3::new(0.5, 0.7, 0.4), 0.1f32);
        let mesh = rounded_box(half, r, 12);
        assert_eq!(defects(&mesh), Vec::<String>::new());
        // Steiner: V + S r + Σ (edges) π r²/4 + 4π r³/3 of the core.
        let [a, b, c] = [0, 1, 2].map(|i| 2.0 * (half[i] - r));
        let faces = 2.0 * (a * b + b * c + c * a) * r;
        let expected = a * b * c + faces + (a + b + c) * PI * r * r + 4.0 / 3.0 * PI * r * r * r;
        let got = volume(&mesh);
        assert!((got / expected - 1.0).abs() < 2e-3, "volume {got}, expected {expected}");
    }
}
