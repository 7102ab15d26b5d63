//! Candidates for the starts of chains: paths of a sample of bidirectional path tracing, of which one is kept
//! (Veach & Guibas 1997, sec. 5.1).
//!
//! ```text
//! W_{s,t} = f(x) / Σ_σ R(σ) R(k + 1 - σ) q̄_σ(x)       balance heuristic over σ of k + 1             (1)
//! W = Σ W_{s,t},    P(x is kept) = W_{s,t} / W                                              (2)
//! R(c) = ρ^max(0, c - c₀)                             a subpath comes to c vertices           (3)
//! q̄ = (q + q') / 2                                    every other sample is guided            (4)
//! ```
//!
//! E[W] is the film's brightness, and W times what is kept a sample of f. Roulette knows nothing but numbers
//! of vertices, so that (1) can have it in closed form. q' is the density of what [`guided`](super::guided) draws: with (4) no path weighs
//! more than twice what it would without.

use super::bidirectional::Lengths;
use super::path::{Path, Sensed, Source, Turn, toward};
use super::tracer::{Met, Tracer};
use crate::metropolis::Draws;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::bsdf::Mode;
use kaustika_spectra::Wavelengths;

/// ρ and c₀ of (3), the light's or the lens's point counted.
const SURVIVAL: f64 = 0.75;
const SURE: usize = 4;

/// (3)
fn reached(vertices: usize) -> f64 {
    SURVIVAL.powi(vertices.saturating_sub(SURE) as i32)
}

/// A sample's subpaths, and what was kept of its paths.
struct Sample<'t, 'a> {
    tracer: &'t mut Tracer<'a>,
    lengths: Lengths,
    draws: &'t mut Draws,
    lambda: Wavelengths,
    /// The number that chose the wavelengths, and time.
    begun: (f32, f32),
    /// True of the other half of (4).
    guided: bool,
    total: f64,
    kept: Option<Path<'a>>,
    /// q'/q of a path.
    ratios: Vec<f64>,
}

/// A subpath: inner vertices from its end on.
type Subpath<'a> = Vec<Turn<'a>>;

/// A path by chance, and its weight W of (2).
pub(super) fn candidate<'a>(
    tracer: &mut Tracer<'a>,
    lengths: Lengths,
    draws: &mut Draws,
) -> Option<(Path<'a>, f64)> {
    let begun = (draws.f32(), draws.f32());
    let lambda = Wavelengths::sample_for(tracer.scene.mode, begun.0);
    let guided = tracer.guides.is_some() && draws.f32() < 0.5;
    let (total, kept, ratios) = (0.0, None, Vec::new());
    let mut sample = Sample { tracer, lengths, draws, lambda, begun, guided, total, kept, ratios };
    sample.connect_all();
    let total = sample.total;
    sample.kept.map(|path| (path, total))
}

impl<'a> Sample<'_, 'a> {
    fn connect_all(&mut self) {
        let light = self.tracer.emit(&self.lambda, self.begun.1, self.draws);
        let (source, light) = match light {
            Some((source, node)) => {
                let from = match source.end.infinite {
                    true => -source.end.w,
                    false => toward(node.p(), source.end.p),
                };
                let (subpath, _) = self.walk(Turn { node, dirac: None }, from, Mode::Importance);
                (Some(source), subpath)
            }
            None => (None, Vec::new()),
        };
        let film = self.tracer.field.place(Vec2::new(self.draws.f32(), self.draws.f32()));
        let lens = Vec2::new(self.draws.f32(), self.draws.f32());
        let (camera, t_max) = self.tracer.see(film, lens, self.begun.1);
        let (mut eye, mut found) = (Vec::new(), Vec::new());
        if let Some(node) = self.tracer.node(camera.ray, t_max, &self.lambda) {
            let from = -camera.ray.d;
            (eye, found) = self.walk(Turn { node, dirac: None }, from, Mode::Radiance);
        }
        for (vertices, light) in found {
            self.close(&[], &eye[..vertices], Some(light), Some(camera)); // s = 0
        }
        for i in 0..eye.len() {
            if !eye[i].node.connects() {
                continue;
            }
            if self.wanted(i + 1) {
                let asked = self.tracer.ask(&eye[i], &self.lambda, self.draws);
                self.close_at_end(&[], &eye[..=i], asked, Some(camera)); // s = 1
            }
            for j in 0..light.len() {
                if self.wanted(i + j + 2)
                    && light[j].node.connects()
                    && self.tracer.sees(&light[j].node, &eye[i].node)
                {
                    self.close_at_end(&light[..=j], &eye[..=i], source, Some(camera));
                }
            }
        }
        for j in 0..light.len() {
            if self.wanted(j + 1) && light[j].node.connects() {
                let lens = Vec2::new(self.draws.f32(), self.draws.f32());
                let seen = self.tracer.ask_lens(&light[j].node, lens, self.begun.1);
                self.close_at_end(&light[..=j], &[], source, seen); // s = k
            }
        }
    }

    /// True of so many inner vertices.
    fn wanted(&self, inner: usize) -> bool {
        (self.lengths.fewest..=self.lengths.most).contains(&inner)
    }

    /// A subpath from its first inner vertex on, which came from the direction `from`, and the lights that it
    /// met after so many vertices.
    fn walk(
        &mut self,
        first: Turn<'a>,
        from: Vec3,
        mode: Mode,
    ) -> (Subpath<'a>, Vec<(usize, Source)>) {
        let (mut path, mut found) = (vec![first], Vec::new());
        let mut wo = from;
        while path.len() < self.lengths.most + usize::from(mode == Mode::Radiance) {
            let i = path.len() - 1;
            // The next one, with the subpath's end, is vertex i + 3.
            let survives = reached(i + 3) / reached(i + 2);
            if survives < 1.0 && self.draws.f64() >= survives {
                break;
            }
            let node = path[i].node.clone();
            let onward = match self.guided && mode == Mode::Radiance {
                true => self.tracer.scatter_guided(&node, wo, self.draws),
                false => self.tracer.scatter(&node, wo, mode, self.draws),
            };
            let Some(onward) = onward else { break };
            path[i].dirac = onward.dirac;
            wo = -onward.ray.d;
            let met = self.tracer.meet(onward.ray, f32::INFINITY, &self.lambda);
            if mode == Mode::Radiance && self.wanted(path.len()) {
                found.extend(self.light_of(met.as_ref()).map(|light| (path.len(), light)));
            }
            match met {
                Some(Met::Surface(node)) => path.push(Turn { node, dirac: None }),
                _ => break,
            }
        }
        (path, found)
    }

    /// The light that a ray met.
    fn light_of(&mut self, met: Option<&Met<'a>>) -> Option<Source> {
        match met? {
            Met::Surface(node) => self.tracer.found(node, &self.lambda),
            Met::Nothing(ray) => {
                let ray: &Ray = ray;
                let nth = self.draws.below(self.tracer.scene.environments.len());
                self.tracer.escaped(ray, nth, &self.lambda)
            }
        }
    }

    /// As [`Sample::close`], where the last vertices of both sides are connected.
    fn close_at_end(
        &mut self,
        light: &[Turn<'a>],
        eye: &[Turn<'a>],
        source: Option<Source>,
        sensed: Option<Sensed>,
    ) {
        let anyhow = |side: &[Turn<'a>]| {
            let mut side = side.to_vec();
            side.iter_mut().last().into_iter().for_each(|turn| turn.dirac = None);
            side
        };
        self.close(&anyhow(light), &anyhow(eye), source, sensed);
    }

    /// (1) and (2) of the path of these inner vertices, each side's from its end on.
    fn close(
        &mut self,
        light: &[Turn<'a>],
        eye: &[Turn<'a>],
        source: Option<Source>,
        sensed: Option<Sensed>,
    ) {
        let (Some(source), Some(sensed)) = (source, sensed) else { return };
        let turns = light.iter().chain(eye.iter().rev()).cloned().collect();
        let measure = self.tracer.measure;
        let Some(path) = Path::new(&measure, self.begun, source, turns, sensed) else { return };
        let weight = path.f / self.density(&path);
        if !weight.is_finite() {
            return;
        }
        self.total += weight;
        if self.draws.f64() * self.total < weight {
            self.kept = Some(path);
        }
    }

    /// The denominator of (1).
    fn density(&mut self, path: &Path) -> f64 {
        let vertices = path.len() + 2;
        let roulette = |s: usize| reached(s) * reached(vertices - s);
        let ways = path.q.iter().enumerate().map(|(s, q)| roulette(s) * q);
        if self.tracer.guides.is_none() {
            return ways.sum();
        }
        self.tracer.guided(path, &mut self.ratios);
        ways.zip(&self.ratios).map(|(q, ratio)| 0.5 * (q + q * ratio)).sum() // (4)
    }
}
