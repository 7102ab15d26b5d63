//! Against amplitudes by complex arithmetic in double precision, and figures by hand.

use super::super::{Mueller, Stokes};
use super::*;
use crate::bsdf::fresnel::{fresnel_conductor, fresnel_dielectric};

/// A complex number.
#[derive(Clone, Copy, Debug)]
struct C(f64, f64);

impl C {
    fn add(self, o: C) -> C {
        C(self.0 + o.0, self.1 + o.1)
    }
    fn sub(self, o: C) -> C {
        C(self.0 - o.0, self.1 - o.1)
    }
    fn mul(self, o: C) -> C {
        C(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn conj(self) -> C {
        C(self.0, -self.1)
    }
    fn norm(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
    fn div(self, o: C) -> C {
        let C(a, b) = self.mul(o.conj());
        C(a / o.norm(), b / o.norm())
    }
    /// The root with an imaginary part that is not negative: waves die out behind the surface.
    fn sqrt(self) -> C {
        let r = self.norm().sqrt();
        let (re, im) = ((0.5 * (r + self.0)).max(0.0).sqrt(), (0.5 * (r - self.0)).max(0.0).sqrt());
        C(if self.1 < 0.0 { -re } else { re }, im)
    }
}

/// rₛ and r_p of (1), from Snell's law: cos θₜ, then the textbook's quotients.
fn textbook(theta: f64, n: C) -> (C, C) {
    let (s, c) = theta.sin_cos();
    let sin_t = C(s, 0.0).div(n);
    let q = n.mul(n).sub(C(s * s, 0.0)).sqrt();
    let cos_t = q.div(n);
    assert!(cos_t.mul(cos_t).add(sin_t.mul(sin_t)).sub(C(1.0, 0.0)).norm() < 1e-20);
    let c = C(c, 0.0);
    let rs = c.sub(n.mul(cos_t)).div(c.add(n.mul(cos_t)));
    let rp = n.mul(c).sub(cos_t).div(n.mul(c).add(cos_t));
    (rs, rp)
}

/// Directions in the x-z plane, the normal +z.
fn mirrored(theta: f64) -> (Vec3, Vec3) {
    let (s, c) = (theta.sin() as f32, theta.cos() as f32);
    (Vec3::new(s, 0.0, c), Vec3::new(-s, 0.0, c))
}

fn element(m: &Oriented, i: usize, j: usize) -> f64 {
    f64::from(m.mueller.0[i][j][0])
}

fn near(what: &str, a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() < tolerance, "{what}: {a}, expected {b}");
}

fn specular(theta: f64, eta: f64, k: f64) -> Oriented {
    let (wo, wi) = mirrored(theta);
    reflection(wo, wi, Spectrum::splat(eta as f32), Spectrum::splat(k as f32))
}

/// Glass from both sides, totally reflecting too, and metals.
#[test]
fn reflection_is_the_textbooks() {
    let indices =
        [(1.5, 0.0), (1.33, 0.0), (1.0 / 1.5, 0.0), (0.143, 3.98), (2.0, 0.6), (0.0, 1.0)];
    for (eta, k) in indices {
        for i in 0..90 {
            let theta = f64::from(i).to_radians();
            let (rs, rp) = textbook(theta, C(eta, k));
            let m = specular(theta, eta, k);
            let mean = 0.5 * (rs.norm() + rp.norm());
            let cross = rs.mul(rp.conj()); // C - iD
            let what = format!("{eta} + {k}i at {i}°");
            near(&what, element(&m, 0, 1), 0.5 * (rs.norm() - rp.norm()) / mean, 3e-5);
            near(&what, element(&m, 2, 2), cross.0 / mean, 3e-5);
            near(&what, element(&m, 2, 3), -cross.1 / mean, 3e-5);
            near(&what, element(&m, 3, 2), cross.1 / mean, 3e-5);
            // The mean is what unpolarized rendering uses.
            let cos = theta.cos() as f32;
            let unpolarized = match k == 0.0 {
                true => fresnel_dielectric(cos, eta as f32).reflectance,
                false => {
                    fresnel_conductor(cos, Spectrum::splat(eta as f32), Spectrum::splat(k as f32))
                        [0]
                }
            };
            near(&what, f64::from(unpolarized), mean, 3e-5);
        }
    }
}

/// Gold at 60°, η = 0.143 + 3.98i, worked by hand: q² = -16.569951 + 1.13828i,
/// q = 0.139734 + 4.073018i, ρ = (0.75 - q/2)/(0.75 + q/2) = -0.744831 - 0.633827i (|ρ| = 0.978),
/// its phase -139.603°.
#[test]
fn the_phase_of_gold() {
    let m = specular(60f64.to_radians(), 0.143, 3.98);
    let phase = element(&m, 2, 3).atan2(element(&m, 2, 2)).to_degrees();
    near("phase", phase, -139.603, 0.001);
}

/// At Brewster's angle, atan 1.5 = 56.31°, all that is reflected is s-polarized.
#[test]
fn brewster() {
    let m = specular(1.5f64.atan(), 1.5, 0.0);
    near("b", element(&m, 0, 1), 1.0, 1e-6);
    near("c", element(&m, 2, 2), 0.0, 1e-3);
    // And at normal incidence the p axis turns round: diag(1, 1, -1, -1).
    let m = specular(0.0, 1.5, 0.0);
    near("b", element(&m, 0, 1), 0.0, 1e-6);
    near("c", element(&m, 2, 2), -1.0, 1e-6);
}

/// Fresnel's rhomb: glass of 1.51, two total reflections at 54.62°, make circular light of light
/// at 45°: phases of 45° each (Born & Wolf, sec. 1.5.4).
#[test]
fn fresnels_rhomb() {
    let m = specular(54.62f64.to_radians(), 1.0 / 1.51, 0.0);
    let light = Stokes([1.0, 0.0, 1.0, 0.0].map(Spectrum::splat));
    let out = m.mueller * (m.mueller * light);
    near("S₀", f64::from(out.0[0][0]), 1.0, 1e-5);
    near("S₂", f64::from(out.0[2][0]), 0.0, 1e-3);
    near("|S₃|", f64::from(out.0[3][0]).abs(), 1.0, 1e-5);
}

/// tₛ and t_p of (1) squared, from both sides, and through facets that only the directions tell.
#[test]
fn refraction_is_the_textbooks() {
    for eta in [1.5f64, 1.33, 1.0 / 1.5, 1.0] {
        for i in 0..90 {
            let theta = f64::from(i).to_radians();
            let sin_t = theta.sin() / eta;
            if sin_t >= 1.0 {
                continue;
            }
            let (ct, c) = ((1.0 - sin_t * sin_t).sqrt(), theta.cos());
            let (ts, tp) = (2.0 * c / (c + eta * ct), 2.0 * c / (eta * c + ct));
            let mean = 0.5 * (ts * ts + tp * tp);
            let wo = Vec3::new(theta.sin() as f32, 0.0, c as f32);
            let m = refraction(wo, Vec3::new(-sin_t as f32, 0.0, -ct as f32));
            let what = format!("{eta} at {i}°");
            near(&what, element(&m, 0, 1), 0.5 * (ts * ts - tp * tp) / mean, 1e-5);
            near(&what, element(&m, 2, 2), ts * tp / mean, 1e-5);
            assert!(m.x.dot(wo).abs() < 1e-6 && (m.x.length() - 1.0).abs() < 1e-6);
        }
    }
}

/// The orders of reflection within a pane, one after the other, as matrices.
#[test]
fn a_pane_is_the_sum_of_its_orders() {
    for i in [0, 10, 30, 50, 56, 70, 85] {
        let theta = f64::from(i).to_radians();
        let (rs, rp) = textbook(theta, C(1.5, 0.0));
        let (s, p, x) = (rs.norm(), rp.norm(), rs.mul(rp).0);
        // (s, p, cross) of each event; two entries or exits are squares of roots.
        let r = [s, p, x];
        let t2 = [1.0 - s, 1.0 - p, (1.0 - s) * (1.0 - p)].map(|v| v.max(0.0));
        let (mut back, mut through) = (r, [0.0; 3]);
        let mut inside = [(1.0 - s) * (1.0 - s), (1.0 - p) * (1.0 - p), t2[2]];
        for order in 0..400 {
            let sum = if order % 2 == 0 { &mut through } else { &mut back };
            (0..3).for_each(|k| sum[k] += inside[k]);
            (0..3).for_each(|k| inside[k] *= r[k]);
        }
        let (wo, wi) = mirrored(theta);
        for (m, e) in
            [(pane_reflection(wo, wi, 1.5), back), (pane_transmission(wo, Vec3::Z, 1.5), through)]
        {
            let mean = 0.5 * (e[0] + e[1]);
            near(&format!("b {i}°"), element(&m, 0, 1), 0.5 * (e[0] - e[1]) / mean, 1e-5);
            near(&format!("c {i}°"), element(&m, 2, 2), e[2] / mean, 1e-5);
        }
    }
}

/// Nothing becomes more than fully polarized, nothing is NaN: grazing, unused lanes, equal indices.
#[test]
fn matrices_are_sound_at_every_edge() {
    for eta in [0.0f32, 0.3, 1.0, 1.5, 4.0] {
        for k in [0.0f32, 1.0] {
            for i in 0..=200 {
                let theta = f64::from(i) * 0.45f64.to_radians();
                let (wo, wi) = mirrored(theta);
                let (n, k) = (Spectrum([eta, 1.5, 0.0, 2.0]), Spectrum([k, 0.0, 0.0, 3.0]));
                let mut all =
                    vec![reflection(wo, wi, n, k), refraction(wo, -wo), refraction(wo, -wi)];
                if eta > 0.0 {
                    all.extend([pane_reflection(wo, wi, eta), pane_transmission(wo, Vec3::Z, eta)]);
                }
                for m in all {
                    let world = m.aligned(wo, wi);
                    assert!(m.mueller.is_finite() && world.is_finite(), "{eta} {i} {m:?}");
                    assert!((m.x.length() - 1.0).abs() < 1e-5);
                    for lane in 0..4 {
                        let [b, c, d] =
                            [(0, 1), (2, 2), (2, 3)].map(|(i, j)| m.mueller.0[i][j][lane]);
                        assert!(b * b + c * c + d * d < 1.0 + 1e-4, "{eta} {i} {m:?}");
                    }
                }
            }
        }
    }
    assert_eq!(Mueller::IDENTITY.m00(), Spectrum::ONE);
}
