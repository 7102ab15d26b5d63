//! The SGGX distribution of microflakes: matter like fibres or sheets, whose flakes' normals are
//! distributed as those of an ellipsoid.
//!
//! ```text
//! σ(ω) = √(ωᵀ S ω)                                     projected area of the flakes            (1)
//! D(ω) = |S|^(3/2) / (π (ωᵀ adj(S) ω)²)                their normals, adj(S) = |S| S⁻¹         (2)
//! p(ωₒ, ωᵢ) = D(h) / (4 σ(ωₒ)),   h = (ωₒ + ωᵢ)/|ωₒ + ωᵢ|   of mirrors                         (3)
//! σₜ(ω) = ρ σ(ω),   and so σ(ωₒ) p(ωₒ, ωᵢ) = σ(ωᵢ) p(ωᵢ, ωₒ)                                   (4)
//! ```
//!
//! S is symmetric and positive definite; its eigenvalues are the squares of the projected areas
//! along the ellipsoid's axes. Heitz, Dupuy, Crassin & Dachsbacher 2015, "The SGGX microflake
//! distribution": eqs. 1, 5 and 8; visible normals are drawn as in its section 3.4. As in Mitsuba
//! 3 a grid's S is interpolated entry by entry and does not turn with the volume's transform.

use super::grid::Grid;
use crate::description::SggxDesc;
use kaustika_math::{Frame, Vec2, Vec3, warp};
use std::f64::consts::PI;

/// S, point by point.
#[derive(Debug)]
pub enum Sggx {
    /// The same everywhere.
    Constant(Flakes),
    /// Of six channels.
    Grid(Grid),
}

/// S: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flakes([f64; 6]);

impl Sggx {
    /// Prepares a description.
    pub(super) fn new(desc: &SggxDesc) -> Sggx {
        match desc {
            SggxDesc::Constant(s) => Sggx::Constant(Flakes(s.map(f64::from))),
            SggxDesc::Grid(grid) => Sggx::Grid(Grid::new(grid)),
        }
    }

    /// S at a point of the world.
    pub fn at(&self, p: Vec3) -> Flakes {
        match self {
            Sggx::Constant(flakes) => *flakes,
            Sggx::Grid(grid) => Flakes([0, 1, 2, 3, 4, 5].map(|c| grid.channel(p, c).into())),
        }
    }

    /// No less than (1) in any direction anywhere: interpolation makes (1)'s square a mean of the
    /// samples'.
    pub(super) fn most_area(&self) -> f32 {
        let square = match self {
            Sggx::Constant(flakes) => flakes.largest_row(),
            Sggx::Grid(grid) => (grid.desc().values.chunks_exact(6))
                .map(|s| Flakes(std::array::from_fn(|i| s[i].into())).largest_row())
                .fold(0.0, f64::max),
        };
        (square.sqrt() * 1.0001) as f32
    }
}

impl Flakes {
    /// aᵀ S b.
    fn form(&self, a: Vec3, b: Vec3) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let [ax, ay, az] = [a.x, a.y, a.z].map(f64::from);
        let [bx, by, bz] = [b.x, b.y, b.z].map(f64::from);
        xx * ax * bx
            + yy * ay * by
            + zz * az * bz
            + xy * (ax * by + ay * bx)
            + xz * (ax * bz + az * bx)
            + yz * (ay * bz + az * by)
    }

    fn determinant(&self) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    }

    /// An eigenvalue is at most the largest sum of a row's absolute values (Gershgorin).
    fn largest_row(&self) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.0.map(f64::abs);
        (xx + xy + xz).max(yy + xy + yz).max(zz + xz + yz)
    }

    /// (1).
    pub fn area(&self, w: Vec3) -> f32 {
        self.form(w, w).max(0.0).sqrt() as f32
    }

    /// (2), 1/sr; 0 where S is singular.
    pub fn normals(&self, m: Vec3) -> f32 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let adjugate = Flakes([
            yy * zz - yz * yz,
            xx * zz - xz * xz,
            xx * yy - xy * xy,
            xz * yz - zz * xy,
            xy * yz - yy * xz,
            xy * xz - xx * yz,
        ]);
        let (det, q) = (self.determinant(), adjugate.form(m, m));
        if det <= 0.0 || q <= 0.0 {
            return 0.0;
        }
        (det * det.sqrt() / (PI * q * q)) as f32 // (2)
    }

    /// (3), 1/sr.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        let area = self.area(wo);
        match (wo + wi).try_normalize() {
            Some(h) if area > 0.0 => self.normals(h) / (4.0 * area),
            _ => 0.0,
        }
    }

    /// `wi` with density (3): a visible normal, and the mirror image in it.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let frame = Frame::from_normal(wo);
        // S in the frame: k and j across, i along `wo`.
        let (k, j, i) = (frame.s, frame.t, frame.n);
        let (ii, ji, jj) = (self.form(i, i), self.form(j, i), self.form(j, j));
        let (ki, kj) = (self.form(k, i), self.form(k, j));
        let minor = (jj * ii - ji * ji).max(0.0).sqrt();
        if ii <= 0.0 || minor <= 0.0 {
            return -wo;
        }
        // The ellipsoid's half-axes conjugate to `wo`: a sphere's visible normals, stretched.
        let root = ii.sqrt();
        let m_k = self.determinant().max(0.0).sqrt() / minor;
        let m_j = [-(ki * ji - kj * ii) / (root * minor), minor / root];
        let m_i = [ki / root, ji / root, root];
        let disk = warp::cosine_hemisphere(u);
        let [x, y, z] = [disk.x, disk.y, disk.z].map(f64::from);
        let local = [x * m_k + y * m_j[0] + z * m_i[0], y * m_j[1] + z * m_i[1], z * m_i[2]];
        let [a, b, c] = local.map(|v| v as f32);
        match frame.to_world(Vec3::new(a, b, c)).try_normalize() {
            Some(m) => (m * (2.0 * m.dot(wo)) - wo).normalize(),
            None => -wo,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Phase;
    use kaustika_math::special::gamma_q;

    fn directions(n: u64) -> impl Iterator<Item = (Vec3, Vec3, Vec2)> {
        (0..n).map(|i| {
            let f = |k: u64| (kaustika_math::mix_bits(8 * i + k) >> 40) as f32 / (1 << 24) as f32;
            let w = |k| warp::uniform_sphere(Vec2::new(f(k), f(k + 1)));
            (w(1), w(3), Vec2::new(f(5), f(6)))
        })
    }

    /// A sphere, a sheet, a fibre along a slanted axis, three unlike axes that are turned.
    fn all() -> Vec<Flakes> {
        let axis = Vec3::new(0.48, 0.6, 0.64);
        let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let about = |across: f64, along: f64, a: Vec3| {
            Flakes(entries.map(|(r, c)| {
                let one = if r == c { 1.0 } else { 0.0 };
                across * one + (along - across) * f64::from(a[r]) * f64::from(a[c])
            }))
        };
        let turned = {
            let f = Frame::from_normal(axis);
            let axes = [(f.s, 0.9), (f.t, 0.3), (f.n, 0.04)];
            Flakes(entries.map(|(r, c)| {
                axes.iter().map(|(a, l)| l * f64::from(a[r]) * f64::from(a[c])).sum()
            }))
        };
        vec![
            Flakes([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
            about(0.06, 1.0, Vec3::new(0.6, 0.0, 0.8)),
            about(1.0, 0.05, axis),
            turned,
        ]
    }

    /// ∫ ⟨ω·m⟩ D(m) dm = σ(ω) (Heitz et al. 2015, eq. 3): (1) and (2) belong together.
    #[test]
    fn areas_are_those_of_the_normals() {
        const N: usize = 400;
        for (k, flakes) in all().iter().enumerate() {
            for (w, ..) in directions(4) {
                let mut area = 0.0;
                for i in 0..N * N {
                    let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                    let m = warp::uniform_sphere(u);
                    let d = f64::from(flakes.normals(m)) * 4.0 * PI / (N * N) as f64;
                    area += d * f64::from(w.dot(m).max(0.0));
                }
                let expected = f64::from(flakes.area(w));
                assert!((area - expected).abs() < 2e-3, "{k}: {area}, expected {expected}");
            }
        }
    }

    #[test]
    fn spheres_scatter_alike_and_all_are_reciprocal() {
        let sphere = Flakes([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        for (wo, wi, _) in directions(200) {
            assert!((sphere.eval(wo, wi) - 0.25 / PI as f32).abs() < 1e-6);
            for f in all() {
                let (there, back) = (f.area(wo) * f.eval(wo, wi), f.area(wi) * f.eval(wi, wo));
                assert!((there - back).abs() <= 1e-5 * there, "{f:?}"); // (4)
            }
        }
    }

    /// χ² of samples over 20 × 20 cells of equal area, at a family-wise level of 1 %.
    #[test]
    fn samples_follow_the_value() {
        const SIDE: usize = 20;
        const FINE: usize = 60;
        const N: u64 = 100_000;
        let wos: Vec<Vec3> = directions(3).map(|d| d.0).collect();
        let level = 0.01 / (all().len() * wos.len()) as f64;
        for (k, flakes) in all().into_iter().enumerate() {
            let phase = Phase::Sggx(Sggx::Constant(flakes));
            for wo in &wos {
                let mut seen = vec![0.0; SIDE * SIDE];
                for (.., u) in directions(N) {
                    let (wi, pdf) = phase.sample(Vec3::ZERO, *wo, u);
                    assert_eq!(pdf, phase.eval(Vec3::ZERO, *wo, wi));
                    let z = ((0.5 * (wi.z + 1.0)) * SIDE as f32) as usize;
                    let turn = wi.y.atan2(wi.x) / (2.0 * PI as f32) + 0.5;
                    let a = (turn * SIDE as f32) as usize;
                    seen[z.min(SIDE - 1) * SIDE + a.min(SIDE - 1)] += 1.0;
                }
                let at = |cell: usize, fine: usize| {
                    (cell as f32 + (fine as f32 + 0.5) / FINE as f32) / SIDE as f32
                };
                let (mut chi2, mut cells, mut rest) = (0.0, 0, (0.0, 0.0));
                for (cell, o) in seen.iter().enumerate() {
                    let mut e = 0.0;
                    for i in 0..FINE * FINE {
                        let z = 2.0 * at(cell / SIDE, i / FINE) - 1.0;
                        let turn = 2.0 * PI as f32 * (at(cell % SIDE, i % FINE) - 0.5);
                        let r = (1.0 - z * z).sqrt();
                        let wi = Vec3::new(r * turn.cos(), r * turn.sin(), z);
                        e += f64::from(flakes.eval(*wo, wi));
                    }
                    e *= 4.0 * PI * N as f64 / ((SIDE * FINE) * (SIDE * FINE)) as f64;
                    match e < 5.0 {
                        true => rest = (rest.0 + o, rest.1 + e),
                        false => {
                            chi2 += (o - e) * (o - e) / e;
                            cells += 1;
                        }
                    }
                }
                if rest.1 >= 5.0 {
                    chi2 += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
                    cells += 1;
                }
                let p = gamma_q(0.5 * (cells - 1) as f64, 0.5 * chi2);
                assert!(p > level, "{k} {wo:?}: chi² = {chi2:.1} over {cells} cells");
            }
        }
    }
}
