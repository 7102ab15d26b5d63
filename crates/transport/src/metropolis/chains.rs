//! The chains of a picture, and what is known of them.

use super::Draws;
use super::coverage::{Visitor, coverage};
use super::film::{self, Schedule};
use super::groups::{Errors, Groups};
use super::seeds::{Moments, Seeds, Startup};
use super::tally::Tally;
use super::tiles::Tiles;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError, Trust};
use crate::path_space::{Splat, add_splat};
use crate::saved::Saved;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use std::io::{self, Read, Write};

/// R̂ above which groups do not agree.
const AGREE: f64 = 1.1;
/// Coverage below which chains keep to parts of the picture or of path space.
const COVERED: f64 = 0.5;

/// Chains whose states are `W`, in groups that are renders of their own.
#[derive(Debug)]
pub struct Chains<W> {
    /// What candidates tell of b, over all groups: the picture's brightness, summed over pixels, without
    /// what is rendered separately.
    pub candidates: Moments,
    size: [u32; 2],
    /// Steps that each has made.
    steps: u64,
    /// b of each group.
    of_groups: Vec<f64>,
    /// The group of each chain.
    group: Vec<usize>,
    walks: Vec<W>,
    groups: Groups,
    tally: Tally,
}

/// Where chains came to.
pub struct Moved<W> {
    walks: Vec<W>,
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
            of_groups: Vec::new(),
            group: Vec::new(),
            walks: Vec::new(),
            groups: Groups::default(),
            tally: Tally::default(),
        }
    }
}

impl<W: Saved + Clone + Send + Sync + Visitor> Chains<W> {
    /// That start at some of `seeds`; `make` makes the chain of a start with its number.
    pub fn start(
        (frame, schedule): (&Frame, Schedule),
        seeds: &Seeds,
        startup: Startup,
        mut draws: Draws,
        mut make: impl FnMut(u64, u64) -> Option<W>,
    ) -> Chains<W> {
        let Schedule { groups, chains, .. } = schedule;
        let (mut walks, mut group) = (Vec::with_capacity(chains), Vec::with_capacity(chains));
        for g in 0..groups {
            let starts = seeds.choose(g, chains / groups, startup, &mut draws);
            for (i, start) in starts.into_iter().enumerate() {
                if let Some(walk) = make(start, (g * chains / groups + i) as u64) {
                    walks.push(walk);
                    group.push(g);
                }
            }
        }
        Chains {
            candidates: seeds.moments,
            size: frame.size(),
            steps: 0,
            of_groups: (0..groups).map(|g| seeds.brightness_of(g)).collect(),
            group,
            walks,
            groups: Groups::new(frame, groups),
            tally: Tally::default(),
        }
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

    /// A pass: `step` moves a chain by the schedule's steps, of which each leaves so much light. `out` shows
    /// what is rendered separately.
    ///
    /// # Errors
    /// If cancelled.
    pub fn pass<S: Send>(
        &self,
        workers: &Workers,
        (frame, schedule): (&Frame, Schedule),
        out: &mut PassImage,
        room: impl Fn() -> S + Sync + Send,
        step: impl Fn(&mut S, &mut W, f64, &mut Vec<Splat>) -> Tally + Sync + Send,
    ) -> Result<Moved<W>, RenderError> {
        // A cancelled pass leaves no trace.
        let mut groups = self.groups.clone();
        groups.begin(out);
        let one = |room: &mut S, i: usize, walk: &mut W, out: &mut Vec<Splat>| {
            step(room, walk, schedule.unit(self.of_groups[self.group[i]]), out)
        };
        let (walks, tallies) = film::run(workers, &self.walks, room, one, |i, splats| {
            for s in splats {
                add_splat(frame, out, s);
                groups.add(frame, self.group[i], s);
            }
        })?;
        groups.end();
        let mut tally = Tally::default();
        tallies.iter().for_each(|t| tally.add(t));
        Ok(Moved { walks, groups, tally, steps: schedule.steps })
    }

    /// They are there now.
    pub fn moved(&mut self, moved: Moved<W>) {
        self.walks = moved.walks;
        self.groups = moved.groups;
        self.tally.add(&moved.tally);
        self.steps += moved.steps;
    }

    /// Share of the chains that were in a part.
    fn share(&self, was_there: impl Fn(&W) -> bool) -> f64 {
        self.walks.iter().filter(|w| was_there(w)).count() as f64 / self.walks.len().max(1) as f64
    }

    /// Share of the chains that were in each tile.
    fn visitors(&self) -> Vec<f64> {
        let tiles = 0..Tiles::new(self.size).count();
        tiles.map(|t| self.share(|w| w.visits().seen(t))).collect()
    }

    /// Coverage of the picture, and of lengths of paths.
    fn coverage(&self, errors: &Errors) -> [Option<f64>; 2] {
        let seen = errors.light.iter().copied().zip(self.visitors());
        let longest = self.walks.iter().map(|w| w.visits().lengths.len()).max().unwrap_or(0);
        let at = |w: &W, n: usize| w.visits().lengths.get(n).copied().unwrap_or(0);
        let of_length = |n: usize| {
            let steps: u64 = self.walks.iter().map(|w| at(w, n)).sum();
            (steps as f64, self.share(|w| at(w, n) > 0))
        };
        let lengths: Vec<(f64, f64)> = (0..longest).map(of_length).collect();
        [
            coverage(seen.collect::<Vec<_>>().into_iter(), self.steps),
            coverage(lengths.into_iter(), self.steps),
        ]
    }

    /// Share of the chains' light in tiles of which groups do not agree.
    fn apart(errors: &Errors) -> f64 {
        let all: f64 = errors.light.iter().sum();
        let apart = errors.light.iter().zip(&errors.r_hat).filter(|(_, r)| **r > AGREE);
        apart.map(|(l, _)| l).sum::<f64>() / all.max(1e-300)
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
        layers.push(("Coverage".into(), tiles.spread(&self.visitors())));
        Some(Trust { error: errors.pixels, layers })
    }

    /// See [`Method::remarks`](crate::Method::remarks).
    pub fn remarks(&self) -> Vec<String> {
        let (Some(errors), true) = (self.groups.errors(), self.candidates.mean() > 0.0) else {
            return Vec::new();
        };
        let percent = |x: f64| 100.0 * x;
        let [tiles, lengths] = self.coverage(&errors);
        let mut remarks = vec![format!(
            "{} chains of {} steps: brightness known to {:.1} %, groups disagree (R-hat > {AGREE}) on tiles with {:.0} % of their light, longest stand {} steps",
            self.walks.len(),
            self.steps,
            percent(self.candidates.error() / self.candidates.mean()),
            percent(Self::apart(&errors)),
            self.tally.still[1],
        )];
        for (what, covered) in [("tile of the picture", tiles), ("length of paths", lengths)] {
            if let Some(covered) = covered.filter(|c| *c < COVERED) {
                remarks.push(format!(
                    "warning: chains keep to parts: a {what} with light was visited by {:.0} % of them; more mutations of other kinds, larger steps, more chains or more time are needed",
                    percent(covered),
                ));
            }
        }
        remarks.extend(self.candidates.warning());
        remarks
    }

    /// See [`Method::report`](crate::Method::report); the strategies by name.
    pub fn report(&self, strategies: &[&str]) -> Vec<(String, f64)> {
        let mut report = self.candidates.report();
        report.push(("chains".into(), self.walks.len() as f64));
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
        self.walks.save(out)?;
        self.tally.save(out)?;
        self.groups.save(out)?;
        self.steps.save(out)
    }

    /// Reads it back; as many chains must have been started.
    pub fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        let walks = Vec::<W>::load(from)?;
        if walks.len() != self.walks.len() {
            return Err(io::Error::other("the number of chains differs"));
        }
        self.walks = walks;
        self.tally = Tally::load(from)?;
        self.groups = Groups::load(from)?;
        self.steps = u64::load(from)?;
        Ok(())
    }
}
