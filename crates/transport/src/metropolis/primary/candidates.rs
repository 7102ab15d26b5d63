//! Candidates for the starts of multiplexed chains: all strategies of one pair of subpaths, of which one is
//! kept.
//!
//! ```text
//! W = Σ_{s,t} W_{s,t},   W_{s,t} = w_{s,t} C_{s,t}(u) / (R(t - 1) R(s - 1))                     (1)
//! P(s, t is kept) = W_{s,t} / W,     v = (s + ξ) / n                                          (2)
//! R(c) = ρ^max(0, c - c₀)                             a subpath may have c vertices            (3)
//! ```
//!
//! A chain's state (u, v) shows n w C, of one strategy. E[W] is the light of all lengths, and W times what is
//! kept a sample of it: candidates that chose a strategy and a length by chance would need some n times as
//! many for each length. The numbers u that the kept strategy asks for come first in the
//! subpaths', so that the state asks for the same ones.

use super::estimator::Sources;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::metropolis::Draws;
use crate::metropolis::film::{Field, modulus};
use crate::path_space::Splat;
use crate::strategies::{Origin, Pairs, Piece};
use kaustika_math::Vec2;
use kaustika_sampling::Sampler;
use kaustika_scene::Scene;
use kaustika_spectra::Wavelengths;

/// ρ and c₀ of (3), without the end on the light or the lens.
const SURVIVAL: f64 = 0.75;
const SURE: usize = 3;

/// A strategy of paths of some bounces: the coordinate v of a state of its.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kept {
    pub(super) depth: usize,
    pub(super) v: f32,
}

/// (3)
fn reached(vertices: usize) -> f64 {
    SURVIVAL.powi(vertices.saturating_sub(SURE) as i32)
}

/// Most vertices of a subpath, by (3).
fn limit(most: usize, draws: &mut Draws) -> usize {
    let mut vertices = SURE.min(most);
    while vertices < most && draws.f64() < SURVIVAL {
        vertices += 1;
    }
    vertices
}

/// Vertices of the subpaths of a strategy: the eye's and the light's.
pub(super) fn subpaths((s, t): (usize, usize)) -> [usize; 2] {
    // At the lens the path has no vertex of the eye's.
    let of_light = if t == 0 { s.saturating_sub(2) } else { s.saturating_sub(1) };
    [t.saturating_sub(1), of_light]
}

/// Finds candidates.
pub(super) struct Candidates<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    field: Field,
    pairs: Pairs<'a>,
    splats: Vec<Splat>,
    /// Strategies, where they end, and what they found there.
    found: Vec<Piece>,
}

impl<'a> Candidates<'a> {
    /// Of pairs over the field that tell their pieces.
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        field: Field,
        pairs: Pairs<'a>,
    ) -> Candidates<'a> {
        Candidates { scene, frame, field, pairs, splats: Vec::new(), found: Vec::new() }
    }

    /// A candidate whose paths are made of these numbers: W of (1), and what is kept. `strategies` of paths of
    /// so many bounces.
    pub(super) fn find(
        &mut self,
        [eye, light, _]: Sources,
        draws: &mut Draws,
        strategies: impl Fn(usize) -> usize,
        stats: &mut PassStats,
    ) -> (f64, Option<Kept>) {
        let bad = stats.bad_samples;
        let mut eye = Sampler::from_primary(eye);
        let mut light = Sampler::from_primary(light);
        let most = self.pairs.longest().map(|most| limit(most, draws));
        let (_, origin) = origin(self.scene, &self.field, &mut eye, most);
        self.splats.clear();
        self.pairs.pair(&origin, [&mut eye, &mut light], false, &mut self.splats, stats);
        if stats.bad_samples > bad {
            return (f64::NAN, None);
        }
        self.found.clear();
        for piece in self.pairs.pieces() {
            let mine = |p: &&mut Piece| p.film.is_none() && p.strategy == piece.strategy;
            match (piece.film, self.found.iter_mut().find(mine)) {
                // Several lights that a ray meets.
                (None, Some(p)) => p.rgb.iter_mut().zip(piece.rgb).for_each(|(a, b)| *a += b),
                (Some(film), _) if !self.field.has(film) => (),
                _ => self.found.push(*piece),
            }
        }
        let (mut total, mut kept) = (0.0, None);
        for piece in &self.found {
            let [of_eye, of_light] = subpaths(piece.strategy);
            let f = self.field.area() * modulus(self.frame.clamp(piece.rgb));
            let weight = f / (reached(of_eye) * reached(of_light)); // (1)
            total += weight;
            if draws.f64() * total < weight {
                let (s, t) = piece.strategy;
                let (depth, n) = (s + t - 2, strategies(s + t - 2) as f64);
                let v = ((s as f64 + draws.f64()) / n) as f32; // (2)
                // Rounding may not choose another one.
                let v = if (n as f32 * v) as usize == s { v } else { (s as f32 + 0.5) / n as f32 };
                kept = Some(Kept { depth, v });
            }
        }
        (total, kept)
    }
}

/// Where pairs begin, by the eye's numbers: the place on the film, and what follows from it.
pub(super) fn origin(
    scene: &Scene,
    field: &Field,
    eye: &mut Sampler,
    most: [usize; 2],
) -> (Vec2, Origin) {
    let u = eye.get_vertex();
    let film = field.place(Vec2::new(u[0], u[1]));
    let camera = scene.camera.sample_we(film, Vec2::new(u[2], u[3]), u[4]);
    let lambda = Wavelengths::sample_for(scene.mode, u[5]);
    (film, Origin { camera, lambda, most })
}
