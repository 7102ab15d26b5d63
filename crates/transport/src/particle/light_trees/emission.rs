//! Emission that is learned: which light, from where and in which direction.
//!
//! ```text
//! p(l, u, v) = α p₀(l, u, v) + (1 - α) p_l e_l(u) d_l(v),     α = ¼                          (1)
//! p_l ∝ ∫∫ X_l,   e_l(u) ∝ ∫ X_l dv,   d_l(v) ∝ ∫ X_l du                                  (2)
//! β ← β/p(l, u, v)                                                                         (3)
//! ```
//!
//! l is a light, u and v in [0,1)² the primary numbers from which it makes a point and a direction,
//! p₀ the choice of those who know nothing, by power, X_l(u, v) what such a path was found to
//! contribute, over its density.
//! Whatever a light is, its way from numbers to rays stays its own, and its densities are
//! multiplied by that of the numbers. Two quadtrees a light stand for the joint density of four
//! numbers: where place and direction must fit together, as of a sun that shines through a window,
//! they know less than there is to know.

use crate::guiding::Square;
use crate::saved::{Saved, saved};
use crate::trees::nonsense;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3};
use kaustika_sampling::distribution::Discrete;
use kaustika_scene::{LightId, LightSelection};
use std::io::{self, Read, Write};

/// α of (1): the share of paths that leave their lights as if nothing were known.
const ALPHA: f32 = 0.25;

/// p₀ of (1): how light leaves its sources where nothing is known.
pub(in crate::particle) trait Unguided: Sync {
    /// A start, from numbers uniform in [0, 1).
    fn draw(&self, u: &[f32; 8]) -> Option<Start>;

    /// Its density.
    fn density(&self, light: LightId, numbers: [Vec2; 2]) -> f32;
}

/// A light, and the numbers from which it makes a point and a direction.
#[derive(Clone, Copy, Debug)]
pub(in crate::particle) struct Start {
    /// l.
    pub light: LightId,
    /// u, v.
    pub numbers: [Vec2; 2],
    /// p(l, u, v).
    pub p: f32,
}

/// By power.
impl Unguided for LightSelection {
    fn draw(&self, u: &[f32; 8]) -> Option<Start> {
        let choice = self.sample(Vec3::ZERO, Vec3::ZERO, u[4], Vec2::new(u[0], u[1]))?;
        let numbers = [choice.u, Vec2::new(u[2], u[3])];
        Some(Start { light: choice.light, numbers, p: choice.p })
    }

    fn density(&self, light: LightId, _: [Vec2; 2]) -> f32 {
        self.pmf(Vec3::ZERO, Vec3::ZERO, light)
    }
}

/// What is known of the lights.
#[derive(Clone, Debug, Default)]
pub(in crate::particle) struct Emission {
    lights: Vec<OfLight>,
    /// p_l, once there is one.
    known: Option<Discrete>,
}

/// What is known of a light.
#[derive(Clone, Debug, Default)]
struct OfLight {
    /// Σ X of this iteration, and of the last one.
    learning: f32,
    known: f32,
    /// e_l and d_l of (2), once it contributed anything.
    squares: Option<[Square; 2]>,
}

saved!(OfLight { learning, known, squares });

/// How a path left its light, and what it contributed.
#[derive(Clone, Copy, Debug)]
pub(in crate::particle) struct EmissionRecord {
    /// l.
    pub light: LightId,
    /// u, v.
    pub numbers: [Vec2; 2],
    /// X over p(l, u, v).
    pub contribution: f32,
    /// What the path cost, in rays.
    pub cost: f32,
}

impl Emission {
    /// Of so many lights, nothing known.
    pub(super) fn new(lights: usize) -> Emission {
        Emission { lights: vec![OfLight::default(); lights], known: None }
    }

    /// Number of lights.
    pub(super) fn count(&self) -> usize {
        self.lights.len()
    }

    /// Draws by (1).
    pub(super) fn sample(&self, unguided: &dyn Unguided, u: &[f32; 8]) -> Option<Start> {
        let Some(known) = &self.known else { return unguided.draw(u) };
        let (light, numbers) = if u[5] < ALPHA {
            let start = unguided.draw(u)?;
            (start.light, start.numbers)
        } else {
            let light = known.sample(u[4]).index;
            let mut numbers = [Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3])];
            if let Some(squares) = &self.lights[light].squares {
                numbers.iter_mut().zip(squares).for_each(|(n, square)| *n = draw(square, *n));
            }
            (LightId(light as u32), numbers)
        };
        Some(Start { light, numbers, p: self.pdf(known, unguided, light, numbers) })
    }

    /// (1)
    fn pdf(
        &self,
        known: &Discrete,
        unguided: &dyn Unguided,
        light: LightId,
        numbers: [Vec2; 2],
    ) -> f32 {
        let mut learned = known.pmf(light.0 as usize);
        if let Some(squares) = &self.lights[light.0 as usize].squares {
            for (square, p) in squares.iter().zip(numbers) {
                learned *= square.known().map_or(1.0, |tree| tree.density(p));
            }
        }
        ALPHA * unguided.density(light, numbers) + (1.0 - ALPHA) * learned
    }

    /// Takes in the records of a pass.
    pub(super) fn learn(&mut self, records: &[EmissionRecord]) {
        for r in records.iter().filter(|r| r.contribution.is_finite() && r.contribution > 0.0) {
            let of = &mut self.lights[r.light.0 as usize];
            of.learning += r.contribution;
            let squares = of.squares.get_or_insert_default();
            squares.iter_mut().zip(r.numbers).for_each(|(s, p)| s.learn(p, r.contribution));
        }
    }

    /// Takes over what was learned.
    pub(super) fn refine(&mut self) {
        for of in &mut self.lights {
            of.known = std::mem::take(&mut of.learning);
            of.squares.iter_mut().flatten().for_each(Square::refine);
        }
        self.choose();
    }

    /// p_l of (2); none if nothing showed.
    fn choose(&mut self) {
        let weights: Vec<f32> = self.lights.iter().map(|of| of.known).collect();
        self.known = Discrete::new(&weights).ok();
    }
}

/// Numbers drawn from what is known.
fn draw(square: &Square, u: Vec2) -> Vec2 {
    square.known().map_or(u, |tree| {
        let p = tree.sample(u).0;
        Vec2::new(p.x.min(ONE_MINUS_EPSILON), p.y.min(ONE_MINUS_EPSILON))
    })
}

/// Puts numbers at random in the place of what was found.
pub(in crate::particle) fn mislead(records: &mut [EmissionRecord], index: u64) {
    for (i, r) in records.iter_mut().enumerate() {
        r.contribution = if r.numbers[1].y > 0.6 { 0.0 } else { nonsense(index, i, 5) };
    }
}

impl Saved for Emission {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.lights.save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let mut loaded = Emission { lights: Saved::load(from)?, known: None };
        loaded.choose();
        Ok(loaded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;
    use kaustika_sampling::hash::combine;

    /// Two lights, of which one showed, and that from one corner of its numbers.
    fn taught() -> Emission {
        let mut emission = Emission::new(2);
        for pass in 0..3u64 {
            let record = |i: usize| {
                let bits = |k| mix_bits(combine(combine(pass, k), i as u64)) >> 40;
                let n = |k| bits(k) as f32 / (1u32 << 24) as f32;
                let numbers = [Vec2::new(n(0), n(1)), Vec2::new(n(2), n(3))];
                let shows = numbers[0].x < 0.5 && numbers[1].y > 0.5;
                let contribution = if shows { 1.0 } else { 0.0 };
                EmissionRecord { light: LightId(1), numbers, contribution, cost: 1.0 }
            };
            emission.learn(&(0..5000).map(record).collect::<Vec<_>>());
            emission.refine();
        }
        emission
    }

    #[test]
    fn the_learned_density_is_one_in_all_and_what_was_saved() {
        let emission = taught();
        let known = emission.known.as_ref().expect("learned");
        // Without lights the choice by power is nothing.
        let dark = LightSelection::default();
        let n = 32;
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let whole: f64 = (0..n * n * n * n)
            .map(|i| {
                let u = Vec2::new(at(i % n), at(i / n % n));
                let v = Vec2::new(at(i / (n * n) % n), at(i / (n * n * n)));
                f64::from(emission.pdf(known, &dark, LightId(1), [u, v]))
            })
            .sum::<f64>()
            / (n * n * n * n) as f64;
        // As exact as the grid meets the leaves' borders.
        assert!((whole / f64::from(1.0 - ALPHA) - 1.0).abs() < 0.05, "{whole}");
        assert_eq!(emission.pdf(known, &dark, LightId(0), [Vec2::ZERO; 2]), 0.0);
        let mut bytes = Vec::new();
        emission.save(&mut bytes).expect("written");
        let loaded = Emission::load(&mut &bytes[..]).expect("read");
        let at = [Vec2::new(0.2, 0.3), Vec2::new(0.1, 0.7)];
        let of_loaded = loaded.known.as_ref().expect("learned");
        let pdf = loaded.pdf(of_loaded, &dark, LightId(1), at);
        assert_eq!(pdf, emission.pdf(known, &dark, LightId(1), at));
        assert!(pdf > 2.0, "{pdf}");
    }
}
