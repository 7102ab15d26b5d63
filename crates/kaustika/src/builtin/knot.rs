//! A tube along a torus knot.

use super::grid::grid;
use kaustika_math::Vec3;
use kaustika_scene::description::TriMesh;
use std::f32::consts::TAU;

/// The knot that winds `p` times around the axis of a torus and `q` times through its hole.
#[derive(Clone, Copy, Debug)]
pub struct TorusKnot {
    /// Turns about the axis; with `q` coprime.
    pub p: u32,
    /// Turns through the hole.
    pub q: u32,
    /// Distance of the torus' core from its axis.
    pub major: f32,
    /// Distance of the curve from the core.
    pub minor: f32,
    /// Radius of the tube.
    pub tube: f32,
}

impl TorusKnot {
    /// The curve at `t` in [0,1], its unit tangent and the torus' unit normal there.
    ///
    /// ```text
    /// c(t) = (ρ cos pτ, ρ sin pτ, a sin qτ),  ρ = R + a cos qτ,  τ = 2π t
    /// ```
    fn curve(&self, t: f32) -> (Vec3, Vec3, Vec3) {
        let (p, q, tau) = (self.p as f32, self.q as f32, t * TAU);
        let ((sp, cp), (sq, cq)) = ((p * tau).sin_cos(), (q * tau).sin_cos());
        let rho = self.major + self.minor * cq;
        let c = Vec3::new(rho * cp, rho * sp, self.minor * sq);
        let d_rho = -self.minor * q * sq;
        let d =
            Vec3::new(d_rho * cp - rho * p * sp, d_rho * sp + rho * p * cp, self.minor * q * cq);
        (c, d.normalize(), Vec3::new(cq * cp, cq * sp, sq))
    }

    /// The tube in `along` by `around` cells; u runs along it, v around it. The axis is z.
    pub fn mesh(&self, along: u32, around: u32) -> TriMesh {
        grid(along, around, |u, v| {
            // The curve lies on the torus, whose normal is thus across the tangent everywhere and
            // closes with the curve: a frame without twist to repair.
            let (c, tangent, normal) = self.curve(u);
            let binormal = normal.cross(tangent);
            let (s, k) = (v * TAU).sin_cos();
            // At s = 0 this is the normal, and ∂p/∂u x ∂p/∂v = T x (N x T) = N.
            let n = normal * k + binormal * s;
            (c + n * self.tube, n)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::{defects, volume};
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn tube_is_closed_and_faces_outward() {
        let knot = TorusKnot { p: 2, q: 3, major: 1.0, minor: 0.4, tube: 0.15 };
        let mesh = knot.mesh(512, 32);
        assert_eq!(defects(&mesh), Vec::<String>::new());
        // Pappus: the cross section times the length of the curve.
        let n = 10_000;
        let at = |i: i32| knot.curve(i as f32 / n as f32).0;
        let length: f32 = (0..n).map(|i| (at(i + 1) - at(i)).length()).sum();
        let expected = PI * 0.15 * 0.15 * length;
        let got = volume(&mesh);
        assert!((got / expected - 1.0).abs() < 0.01, "volume {got}, expected {expected}");
    }
}
