//! Numbers in [0, 1) that stand for a path, as many as it asks for: a point of primary sample space
//! (Kelemen et al. 2002).
//!
//! ```text
//! u′ = u ± s₂ exp(-ln(s₂/s₁) ξ)  mod 1          small step, symmetric                (1)
//! u′ = ξ                                        large step                           (2)
//! ```
//!
//! A number that a path did not ask for is moved when one does: by as many small steps as it missed,
//! or anew where a large step was among them.

use super::Draws;
use crate::saved::saved;
use kaustika_math::ONE_MINUS_EPSILON;
use kaustika_sampling::PrimarySample;

/// s₂/s₁ of (1).
const SPREAD: f64 = 16.0;
/// Small steps after which a number is drawn anew: nothing is left of it that matters, and of
/// a number that no path asked for, any law that keeps it uniform will do.
const MOST_STEPS: u64 = 32;

/// Coordinates of one purpose, and when each was last moved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coordinates {
    values: Vec<f32>,
    moved: Vec<u64>,
}
saved!(Coordinates { values, moved });

impl Coordinates {
    /// Whose first number is this, at the first [`Moment`].
    pub fn of(first: f32) -> Coordinates {
        Coordinates { values: vec![first], moved: vec![0] }
    }

    /// Becomes another's copy, in the memory it has.
    pub fn copy_from(&mut self, other: &Coordinates) {
        self.values.clone_from(&other.values);
        self.moved.clone_from(&other.moved);
    }
}

/// When a state was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// Steps that were accepted before it, itself included.
    pub now: u64,
    /// The last large one of them.
    pub large: u64,
}
saved!(Moment { now, large });

/// Hands out coordinates, each moved to the present.
#[derive(Debug)]
pub struct Stepping<'r> {
    coordinates: &'r mut Coordinates,
    draws: &'r mut Draws,
    at: Moment,
    /// s₂.
    size: f64,
    next: usize,
}

impl<'r> Stepping<'r> {
    /// From the first coordinate on; `size` is s₂ of (1).
    pub fn new(
        coordinates: &'r mut Coordinates,
        draws: &'r mut Draws,
        at: Moment,
        size: f64,
    ) -> Stepping<'r> {
        Stepping { coordinates, draws, at, size, next: 0 }
    }

    /// (1)
    fn small(&mut self, u: f32) -> f32 {
        let xi = 2.0 * self.draws.f64();
        let (sign, xi) = if xi < 1.0 { (1.0, xi) } else { (-1.0, xi - 1.0) };
        let v = f64::from(u) + sign * self.size * (-SPREAD.ln() * xi).exp();
        ((v - v.floor()) as f32).min(ONE_MINUS_EPSILON)
    }
}

impl PrimarySample for Stepping<'_> {
    fn get_1d(&mut self) -> f32 {
        let i = self.next;
        self.next += 1;
        let Moment { now, large } = self.at;
        if i == self.coordinates.values.len() {
            self.coordinates.values.push(self.draws.f32());
            self.coordinates.moved.push(now);
            return self.coordinates.values[i];
        }
        let (mut u, moved) = (self.coordinates.values[i], self.coordinates.moved[i]);
        if moved < now {
            if moved < large {
                u = self.draws.f32(); // (2)
            }
            match now - moved.max(large) {
                missed if missed > MOST_STEPS => u = self.draws.f32(),
                missed => (0..missed).for_each(|_| u = self.small(u)),
            }
            self.coordinates.values[i] = u;
            self.coordinates.moved[i] = now;
        }
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_moved_when_they_are_asked_for() {
        let (mut c, mut r) = (Coordinates::default(), Draws::new(1, 1));
        let mut draw = |c: &mut Coordinates, at: Moment, n: usize| -> Vec<f32> {
            let mut s = Stepping::new(c, &mut r, at, 1.0 / 64.0);
            (0..n).map(|_| s.get_1d()).collect()
        };
        let first = draw(&mut c, Moment::default(), 3);
        assert_eq!(draw(&mut c, Moment::default(), 3), first, "nothing moves without a step");
        let next = draw(&mut c, Moment { now: 1, large: 0 }, 2);
        for (a, b) in first.iter().zip(&next) {
            let d = (a - b).abs();
            let d = d.min(1.0 - d);
            assert!(d > 0.9 / 1024.0 && d < 1.1 / 64.0, "{d}");
        }
        // The third one missed a step, then makes two at once.
        let third = draw(&mut c, Moment { now: 2, large: 0 }, 3)[2];
        let d = (third - first[2]).abs();
        assert!(d.min(1.0 - d) < 2.2 / 64.0);
        assert_eq!(c.moved, [2, 2, 2]);
        let anew = draw(&mut c, Moment { now: 3, large: 3 }, 3);
        assert!(anew.iter().zip(&first).all(|(a, b)| (a - b).abs() > 0.05), "{anew:?} {first:?}");
    }

    #[test]
    fn small_steps_keep_numbers_uniform() {
        // The mean and mean square of many walks that began anywhere.
        let (mut sum, mut squares) = (0.0, 0.0);
        let n = 20_000;
        for i in 0..n {
            let (mut c, mut r) = (Coordinates::default(), Draws::new(2, i));
            for now in 0..8 {
                Stepping::new(&mut c, &mut r, Moment { now, large: 0 }, 0.3).get_1d();
            }
            let u = f64::from(c.values[0]);
            sum += u;
            squares += u * u;
        }
        // Four standard errors: 0.289 / √n and 0.298 / √n.
        let n = n as f64;
        assert!((sum / n - 0.5).abs() < 4.0 * 0.289 / n.sqrt());
        assert!((squares / n - 1.0 / 3.0).abs() < 4.0 * 0.298 / n.sqrt());
    }
}
