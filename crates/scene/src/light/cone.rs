//! Cones of directions.

use kaustika_math::{Vec3, safe_acos, safe_sqrt};
use std::f32::consts::PI;

/// Directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Axis, unit.
    pub axis: Vec3,
    /// cos of the half-angle; -1 is every direction.
    pub cos: f32,
}

impl Cone {
    /// Every direction.
    pub const ALL: Cone = Cone { axis: Vec3::Z, cos: -1.0 };

    /// One direction.
    pub fn around(axis: Vec3) -> Cone {
        Cone { axis, cos: 1.0 }
    }

    /// The smallest cone about two (Conty Estevez & Kulla 2018, algorithm 1).
    pub fn union(&self, o: &Cone) -> Cone {
        let (a, b) = if self.cos <= o.cos { (self, o) } else { (o, self) };
        let (half_a, half_b) = (safe_acos(a.cos), safe_acos(b.cos));
        let between = safe_acos(a.axis.dot(b.axis));
        if between + half_b <= half_a {
            return *a;
        }
        let half = 0.5 * (half_a + between + half_b);
        if half >= PI {
            return Cone::ALL;
        }
        // Turn a's axis toward b's until the cone's border has grown on b's side alone.
        let turn = half - half_a;
        let across = b.axis - a.axis * a.axis.dot(b.axis);
        match across.try_normalize() {
            Some(across) => {
                let axis = (a.axis * turn.cos() + across * turn.sin()).normalize();
                // Rounding must not leave a direction out.
                Cone { axis, cos: (half.cos() - 1e-6).max(-1.0) }
            }
            // The same axis needs no turn, the opposite one has none.
            None if between < 0.5 * PI => *a,
            None => Cone::ALL,
        }
    }

    /// M(Ω): ∫ of the cosine to the nearest direction of the cone, over the directions within
    /// `emission` of it (Conty Estevez & Kulla 2018, eq. 1).
    pub fn measure(&self, emission: f32) -> f32 {
        let half = safe_acos(self.cos);
        let sin = safe_sqrt(1.0 - self.cos * self.cos);
        let wide = (half + emission).min(PI);
        2.0 * PI * (1.0 - self.cos)
            + 0.5
                * PI
                * (2.0 * wide * sin - (half - 2.0 * wide).cos() - 2.0 * half * sin + self.cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::{Frame, Vec2, warp};

    #[test]
    fn unions_hold_both_cones() {
        for i in 0..300u64 {
            let f =
                |k: u64| (kaustika_math::mix_bits(10 * i + k) >> 40) as f32 / (1u64 << 24) as f32;
            let cone = |k| Cone {
                axis: warp::uniform_sphere(Vec2::new(f(k), f(k + 1))),
                cos: 1.0 - 2.0 * f(k + 2) * f(k + 2),
            };
            let (a, b) = (cone(0), cone(3));
            let both = a.union(&b);
            for c in [a, b] {
                for j in 0..50 {
                    let u = Vec2::new(((j * 7) % 50) as f32 / 49.0, j as f32 / 50.0);
                    let w = Frame::from_normal(c.axis).to_world(warp::uniform_cone(u, 1.0 - c.cos));
                    assert!(both.axis.dot(w) >= both.cos - 1e-5, "{a:?} {b:?} {both:?}");
                }
            }
        }
        let up = Cone::around(Vec3::Z);
        assert_eq!(up.union(&up).cos, 1.0);
        assert_eq!(up.union(&Cone::around(-Vec3::Z)), Cone::ALL);
    }

    #[test]
    fn the_measure_of_known_cones() {
        // A flat light: ∫ cos over a hemisphere. Everything: 4π.
        assert!((Cone::around(Vec3::Z).measure(0.5 * PI) - PI).abs() < 1e-5);
        assert!((Cone::ALL.measure(0.5 * PI) - 4.0 * PI).abs() < 1e-4);
    }
}
