//! The chains of a picture, and what is known of them.

use super::Draws;
use super::coverage::{Visited, Visitor};
use super::film::{self, Schedule};
use super::groups::{Errors, Groups};
use super::seeds::{Moments, Seeds, Startup};
use super::tally::Tally;
use super::tiles::Tiles;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError, Trust};
use crate::path_space::{Splat, add_splat};
use crate::saved::{Saved, saved};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use std::io::{self, Read, Write};

/// R̂ above which groups do not agree.
const AGREE: f64 = 1.1;
/// Coverage below which chains keep to parts of the picture or of path space.
const COVERED: f64 = 0.05;
/// Share of steps by which chains come from anywhere to anywhere below which they do not.
const FAR: f64 = 1e-5;
/// Steps of which that is told.
const TOLD: f64 = 5e4;

/// Chains that started together, in groups that are renders of their own.
#[derive(Clone, Debug)]
pub struct Generation<W> {
    /// What candidates tell of b, over all groups: the picture's brightness, summed over pixels, without
    /// what is rendered separately.
    candidates: Moments,
    /// Rays that candidates took.
    rays: u64,
    /// b of each group.
    of_groups: Vec<f64>,
    /// The group of each chain.
    group: Vec<u64>,
    walks: Vec<W>,
}
saved!(Generation<W> { candidates, rays, of_groups, group, walks });

impl<W> Default for Generation<W> {
    fn default() -> Self {
        Generation {
            candidates: Moments::default(),
            rays: 0,
            of_groups: Vec::new(),
            group: Vec::new(),
            walks: Vec::new(),
        }
    }
}

impl<W: Clone + Send + Sync> Generation<W> {
    /// That starts at some of `seeds`; `make` makes the chain of a start with its number.
    pub fn start(
        schedule: Schedule,
        seeds: &Seeds,
        startup: Startup,
        mut draws: Draws,
        mut make: impl FnMut(u64, u64) -> Option<W>,
    ) -> Generation<W> {
        let Schedule { groups, chains, .. } = schedule;
        let (mut walks, mut group) = (Vec::with_capacity(chains), Vec::with_capacity(chains));
        for g in 0..groups {
            let starts = seeds.choose(g, chains / groups, startup, &mut draws);
            for (i, start) in starts.into_iter().enumerate() {
                if let Some(walk) = make(start, (g * chains / groups + i) as u64) {
                    walks.push(walk);
                    group.push(g as u64);
                }
            }
        }
        let of_groups = (0..groups).map(|g| seeds.brightness_of(g)).collect();
        Generation { candidates: seeds.moments, rays: seeds.rays, of_groups, group, walks }
    }

    /// Steps of which nothing is kept.
    ///
    /// # Errors
    /// If cancelled.
    pub fn skip<S: Send>(
        &mut self,
        workers: &Workers,
        room: impl Fn() -> S + Sync + Send,
        step: impl Fn(&mut S, &mut W, f64, &mut Vec<Splat>) -> Tally + Sync + Send,
    ) -> Result<Vec<Tally>, RenderError> {
        let one = |room: &mut S, _: usize, walk: &mut W, out: &mut Vec<Splat>| {
            let tally = step(room, walk, 0.0, out);
            out.clear();
            tally
        };
        let (walks, tallies) = film::run(workers, &self.walks, room, one, |_, _| ())?;
        self.walks = walks;
        Ok(tallies)
    }
}

/// The chains of a picture, whose states are `W`.
///
/// Every generation of them is an estimate of the picture, right on average (see [`seeds`](super::seeds)), and so is the mean
/// of several: what one generation's candidates do not know of b, and where its chains do not come to, those after it tell.
#[derive(Debug)]
pub struct Chains<W> {
    /// What the candidates of all generations tell of b.
    pub candidates: Moments,
    size: [u32; 2],
    /// Steps that each has made, over all generations.
    steps: u64,
    /// Those of this generation.
    age: u64,
    /// Rays that steps took, over all generations, and before this one.
    rays: [u64; 2],
    /// Those that candidates took.
    rays_of_candidates: u64,
    now: Generation<W>,
    /// What generations before this one have visited.
    visited: Visited,
    groups: Groups,
    tally: Tally,
}

/// Where chains came to.
pub struct Moved<W> {
    walks: Vec<W>,
    /// The generation that they are of, if it is a new one, as it started.
    renewed: Option<Generation<W>>,
    groups: Groups,
    tally: Tally,
    steps: u64,
}

impl<W> Moved<W> {
    /// Work done.
    pub fn stats(&self) -> PassStats {
        self.tally.stats
    }
}

impl<W> Default for Chains<W> {
    fn default() -> Self {
        Chains {
            candidates: Moments::default(),
            size: [0; 2],
            steps: 0,
            age: 0,
            rays: [0; 2],
            rays_of_candidates: 0,
            now: Generation::default(),
            visited: Visited::default(),
            groups: Groups::default(),
            tally: Tally::default(),
        }
    }
}

impl<W: Saved + Clone + Send + Sync + Visitor> Chains<W> {
    /// Of a first generation, that have not moved yet.
    pub fn new((frame, schedule): (&Frame, Schedule), first: Generation<W>) -> Chains<W> {
        Chains {
            candidates: first.candidates,
            rays_of_candidates: first.rays,
            size: frame.size(),
            now: first,
            groups: Groups::new(frame, schedule.groups),
            ..Chains::default()
        }
    }

    /// The number of the generation that is due, and of its candidates, which are as many as this one's: if that has made
    /// `renew` steps for each of them, or, as long as all candidates so far are too few, if its steps took as many rays as its
    /// candidates, and made a step for each; never if `renew` is 0.
    pub fn due(&self, schedule: Schedule, renew: u32) -> Option<(u64, u64)> {
        let made = self.age * schedule.chains as u64;
        let candidates = self.now.candidates.count();
        let hurries = self.candidates.are_too_few() && self.rays[0] - self.rays[1] >= self.now.rays;
        let asked = candidates * if hurries { 1 } else { u64::from(renew) };
        (renew > 0 && made >= asked).then(|| (self.visited.generations() + 1, candidates))
    }

    /// A pass, of a new generation if there is one: `step` moves a chain by the schedule's steps, of which each leaves so much light.
    /// `out` shows what is rendered separately.
    ///
    /// # Errors
    /// If cancelled.
    pub fn pass<S: Send>(
        &self,
        renewed: Option<Generation<W>>,
        workers: &Workers,
        (frame, schedule): (&Frame, Schedule),
        out: &mut PassImage,
        room: impl Fn() -> S + Sync + Send,
        step: impl Fn(&mut S, &mut W, f64, &mut Vec<Splat>) -> Tally + Sync + Send,
    ) -> Result<Moved<W>, RenderError> {
        // A cancelled pass leaves no trace.
        let mut groups = self.groups.clone();
        groups.begin(out);
        let now = renewed.as_ref().unwrap_or(&self.now);
        let of = |chain: usize| now.group[chain] as usize;
        let one = |room: &mut S, i: usize, walk: &mut W, out: &mut Vec<Splat>| {
            step(room, walk, schedule.unit(now.of_groups[of(i)]), out)
        };
        let (walks, tallies) = film::run(workers, &now.walks, room, one, |i, splats| {
            for s in splats {
                add_splat(frame, out, s);
                groups.add(frame, of(i), s);
            }
        })?;
        groups.end();
        let mut tally = Tally::default();
        tallies.iter().for_each(|t| tally.add(t));
        Ok(Moved { walks, renewed, groups, tally, steps: schedule.steps })
    }

    /// They are there now.
    pub fn moved(&mut self, moved: Moved<W>) {
        if let Some(next) = moved.renewed {
            self.visited.add(self.visited_now());
            self.candidates.add(&next.candidates);
            self.age = 0;
            self.rays[1] = self.rays[0];
            self.rays_of_candidates += next.rays;
            self.now = next;
        }
        self.now.walks = moved.walks;
        self.groups = moved.groups;
        self.tally.add(&moved.tally);
        self.steps += moved.steps;
        self.age += moved.steps;
        self.rays[0] += moved.tally.stats.rays();
    }

    /// What this generation has visited.
    fn visited_now(&self) -> Visited {
        Visited::of(&self.now.walks, self.age, Tiles::new(self.size).count())
    }

    /// What the generations that are over have visited; the one that is going on, if it is the first.
    fn visited(&self) -> Visited {
        match self.visited.generations() {
            0 => self.visited_now(),
            _ => self.visited.clone(),
        }
    }

    /// Coverage of the picture, and of lengths of paths.
    fn coverage(&self, errors: &Errors) -> [Option<f64>; 2] {
        self.visited().coverage(&errors.light)
    }

    /// Share of the chains' light in tiles of which groups do not agree.
    fn apart(errors: &Errors) -> f64 {
        let all: f64 = errors.light.iter().sum();
        let apart = errors.light.iter().zip(&errors.r_hat).filter(|(_, r)| **r > AGREE);
        // None would sum up to -0.
        apart.fold(0.0, |sum, (l, _)| sum + l) / all.max(1e-300)
    }

    /// See [`Method::trust`](crate::Method::trust).
    pub fn trust(&self) -> Option<Trust> {
        let errors = self.groups.errors()?;
        let tiles = Tiles::new(self.size);
        let channel = |c: usize| errors.tiles.iter().map(|e| e[c]).collect::<Vec<f64>>();
        let mut layers: Vec<(String, Vec<f32>)> = ["R", "G", "B"]
            .iter()
            .enumerate()
            .map(|(c, name)| (format!("TileError.{name}"), tiles.spread(&channel(c))))
            .collect();
        layers.push(("RHat".into(), tiles.spread(&errors.r_hat)));
        layers.push(("Coverage".into(), tiles.spread(&self.visited().tiles().collect::<Vec<_>>())));
        Some(Trust { error: errors.pixels, layers })
    }

    /// See [`Method::remarks`](crate::Method::remarks); by the strategy `far`, which is the first, chains come from anywhere to anywhere.
    pub fn remarks(&self, far: &str) -> Vec<String> {
        let (Some(errors), true) = (self.groups.errors(), self.candidates.mean() > 0.0) else {
            return Vec::new();
        };
        let percent = |x: f64| 100.0 * x;
        let [tiles, lengths] = self.coverage(&errors);
        let mut remarks = vec![format!(
            "{} chains of {} steps{}: brightness known to {:.1} %, groups disagree (R-hat > {AGREE}) on tiles with {:.0} % of their light, longest stand {} steps",
            self.now.walks.len(),
            self.steps,
            match self.visited.generations() {
                0 => String::new(),
                n => format!(" in {} generations", n + 1),
            },
            percent(self.candidates.error() / self.candidates.mean()),
            percent(Self::apart(&errors)),
            self.tally.still[1],
        )];
        for (what, covered) in [("tile of the picture", tiles), ("length of paths", lengths)] {
            if let Some(covered) = covered.filter(|c| *c < COVERED) {
                remarks.push(format!(
                    "warning: chains keep to parts: {:.0} % as many came to another {what} as should; more mutations of other kinds, larger steps or more time are needed",
                    percent(covered.max(0.0)),
                ));
            }
        }
        let (steps, jumps) =
            (self.steps as f64 * self.now.walks.len() as f64, self.tally.accepted(0));
        if steps >= TOLD && jumps < FAR {
            remarks.push(format!(
                "warning: chains keep to parts: {:.0} of {steps:.1e} steps were {far}, which come from anywhere to anywhere; more of these are needed",
                jumps * steps,
            ));
        }
        remarks.extend(self.candidates.warning());
        remarks
    }

    /// See [`Method::report`](crate::Method::report); the strategies by name.
    pub fn report(&self, strategies: &[&str]) -> Vec<(String, f64)> {
        let mut report = self.candidates.report();
        report.push(("candidates.rays".into(), self.rays_of_candidates as f64));
        report.push(("steps.rays".into(), self.rays[0] as f64));
        report.push(("chains".into(), self.now.walks.len() as f64));
        report.push(("generations".into(), (self.visited.generations() + 1) as f64));
        report.extend(self.tally.report(strategies));
        if let Some(errors) = self.groups.errors() {
            let [tiles, lengths] = self.coverage(&errors);
            let known = [("coverage_of_tiles", tiles), ("coverage_of_lengths", lengths)];
            report.extend(known.into_iter().filter_map(|(k, v)| Some((k.to_string(), v?))));
            report.push(("light_without_agreement".into(), Self::apart(&errors)));
        }
        report
    }

    /// Writes where they are.
    pub fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.now.save(out)?;
        self.tally.save(out)?;
        self.groups.save(out)?;
        self.steps.save(out)?;
        self.age.save(out)?;
        self.rays.save(out)?;
        self.rays_of_candidates.save(out)?;
        self.visited.save(out)?;
        self.candidates.save(out)
    }

    /// Reads it back.
    pub fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.now = Generation::load(from)?;
        self.tally = Tally::load(from)?;
        self.groups = Groups::load(from)?;
        self.steps = u64::load(from)?;
        self.age = u64::load(from)?;
        self.rays = <[u64; 2]>::load(from)?;
        self.rays_of_candidates = u64::load(from)?;
        self.visited = Visited::load(from)?;
        self.candidates = Moments::load(from)?;
        Ok(())
    }
}
