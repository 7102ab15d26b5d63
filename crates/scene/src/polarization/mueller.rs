//! Stokes vectors, Mueller matrices and the turning of their frames.
//!
//! ```text
//! frame turned by θ from x toward y:  S' = R(θ) S,  R(θ) = | 1    0      0    0 |
//!                                                          | 0  cos 2θ sin 2θ 0 |
//!                                                          | 0 -sin 2θ cos 2θ 0 |     (1)
//!                                                          | 0    0      0    1 |
//! M' = R(θ_out) M R(θ_in)ᵀ                                                            (2)
//! ```

use kaustika_math::{Vec3, sqr};
use kaustika_spectra::Spectrum;
use std::ops::{AddAssign, Mul};

/// The x axis of the frame in which light along `w` (unit) is described where no other frame is
/// named; the y axis is `w` × x.
#[inline]
pub fn stokes_basis(w: Vec3) -> Vec3 {
    w.coordinate_system().0
}

/// Light with its polarization, at the path's wavelengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stokes(pub [Spectrum; 4]);

impl Stokes {
    /// S in a frame that is turned.
    #[inline]
    pub fn turned(self, turn: Turn) -> Stokes {
        let [s0, s1, s2, s3] = self.0;
        let (s1, s2) = turn.apply(s1, s2);
        Stokes([s0, s1, s2, s3])
    }
}

impl AddAssign for Stokes {
    #[inline]
    fn add_assign(&mut self, o: Stokes) {
        self.0.iter_mut().zip(o.0).for_each(|(s, o)| *s += o);
    }
}

impl Mul<Spectrum> for Stokes {
    type Output = Stokes;
    #[inline]
    fn mul(self, k: Spectrum) -> Stokes {
        Stokes(self.0.map(|s| s * k))
    }
}

/// cos 2θ and sin 2θ of a frame turned by θ about the light's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    cos2: f32,
    sin2: f32,
}

impl Turn {
    /// From the frame with axis `x` to that with axis `to`, both perpendicular to the light's
    /// direction `w`; lengths do not matter.
    #[inline]
    pub fn between(w: Vec3, x: Vec3, to: Vec3) -> Turn {
        let (cos, sin) = (x.dot(to), w.dot(x.cross(to)));
        let norm = sqr(cos) + sqr(sin);
        if norm == 0.0 {
            return Turn { cos2: 1.0, sin2: 0.0 };
        }
        Turn { cos2: (sqr(cos) - sqr(sin)) / norm, sin2: 2.0 * cos * sin / norm }
    }

    /// The middle rows of (1).
    #[inline]
    fn apply(self, s1: Spectrum, s2: Spectrum) -> (Spectrum, Spectrum) {
        (s1 * self.cos2 + s2 * self.sin2, s2 * self.cos2 - s1 * self.sin2)
    }
}

/// What an event does to Stokes vectors, row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mueller(pub [[Spectrum; 4]; 4]);

impl Mueller {
    /// Nothing happens.
    pub const IDENTITY: Mueller = {
        const O: Spectrum = Spectrum::ZERO;
        const I: Spectrum = Spectrum::ONE;
        Mueller([[I, O, O, O], [O, I, O, O], [O, O, I, O], [O, O, O, I]])
    };

    /// Light leaves unpolarized, `value` times what arrived.
    #[inline]
    pub fn depolarizer(value: Spectrum) -> Mueller {
        let mut m = Mueller::default();
        m.0[0][0] = value;
        m
    }

    /// What scatters or passes of unpolarized light: the value that unpolarized rendering uses.
    #[inline]
    pub fn m00(&self) -> Spectrum {
        self.0[0][0]
    }

    /// What becomes of unpolarized light of radiance 1.
    #[inline]
    pub fn of_unpolarized(&self) -> Stokes {
        Stokes(self.0.map(|row| row[0]))
    }

    /// The matrix in turned frames of the light that leaves and that arrives: (2).
    #[inline]
    pub fn turned(mut self, leaving: Turn, arriving: Turn) -> Mueller {
        let [_, r1, r2, _] = &mut self.0;
        for (a, b) in r1.iter_mut().zip(r2) {
            (*a, *b) = leaving.apply(*a, *b);
        }
        for row in &mut self.0 {
            (row[1], row[2]) = arriving.apply(row[1], row[2]);
        }
        self
    }

    /// True if no lane of any element is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(Spectrum::is_finite)
    }
}

impl Mul for Mueller {
    type Output = Mueller;
    #[inline]
    fn mul(self, o: Mueller) -> Mueller {
        let element = |i: usize, j: usize| {
            (0..4).fold(Spectrum::ZERO, |sum, k| sum + self.0[i][k] * o.0[k][j])
        };
        Mueller(std::array::from_fn(|i| std::array::from_fn(|j| element(i, j))))
    }
}

impl Mul<Stokes> for Mueller {
    type Output = Stokes;
    #[inline]
    fn mul(self, s: Stokes) -> Stokes {
        Stokes(self.0.map(|row| (0..4).fold(Spectrum::ZERO, |sum, k| sum + row[k] * s.0[k])))
    }
}

impl Mul<Spectrum> for Mueller {
    type Output = Mueller;
    #[inline]
    fn mul(self, k: Spectrum) -> Mueller {
        Mueller(self.0.map(|row| row.map(|m| m * k)))
    }
}

impl AddAssign for Mueller {
    #[inline]
    fn add_assign(&mut self, o: Mueller) {
        self.0.iter_mut().flatten().zip(o.0.iter().flatten()).for_each(|(m, o)| *m += *o);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stokes(s: [f32; 4]) -> Stokes {
        Stokes(s.map(Spectrum::splat))
    }

    fn near(a: Stokes, b: [f32; 4]) {
        (0..4).for_each(|i| assert!((a.0[i][0] - b[i]).abs() < 1e-6, "{a:?} {b:?}"));
    }

    /// Light at 45° lies along the x axis of a frame that is turned by 45° toward y.
    #[test]
    fn frames_turn_toward_y() {
        let (w, x, y) = (Vec3::Z, Vec3::X, Vec3::Y);
        let turn = Turn::between(w, x, x + y);
        near(stokes([1.0, 0.0, 1.0, 0.0]).turned(turn), [1.0, 1.0, 0.0, 0.0]);
        near(stokes([1.0, 1.0, 0.0, 0.5]).turned(turn), [1.0, 0.0, -1.0, 0.5]);
        // Half a turn is none, and the axes' exchange turns all signs of linear polarization.
        near(stokes([1.0, 0.3, 0.4, 0.5]).turned(Turn::between(w, x, -x)), [1.0, 0.3, 0.4, 0.5]);
        near(stokes([1.0, 0.3, 0.4, 0.5]).turned(Turn::between(w, x, y)), [1.0, -0.3, -0.4, 0.5]);
        // Seen from the other side, the turn is the other way.
        let back = Turn::between(-w, x, x + y);
        near(stokes([1.0, 0.0, 1.0, 0.0]).turned(back), [1.0, -1.0, 0.0, 0.0]);
    }

    /// (M S) turned is (M turned) (S turned).
    #[test]
    fn matrices_turn_with_their_vectors() {
        let value = |i: usize, j: usize| Spectrum::splat(((3 * i + 7 * j + 1) as f32).sin());
        let m = Mueller(std::array::from_fn(|i| std::array::from_fn(|j| value(i, j))));
        let s = stokes([1.0, 0.2, -0.5, 0.3]);
        let turn = |a: f32| Turn::between(Vec3::Z, Vec3::X, Vec3::new(a.cos(), a.sin(), 0.0));
        let (leaving, arriving) = (turn(0.4), turn(-1.1));
        let a = m.turned(leaving, arriving) * s.turned(arriving);
        near(a, (m * s).turned(leaving).0.map(|s| s[0]));
        let product = m * m.turned(leaving, arriving);
        near(product * s, (m * (m.turned(leaving, arriving) * s)).0.map(|s| s[0]));
        assert_eq!(Mueller::IDENTITY * m, m);
        assert_eq!(m.of_unpolarized().0[2], m.0[2][0]);
    }
}
