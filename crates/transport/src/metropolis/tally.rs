//! What chains count.

use crate::method::PassStats;
use crate::saved::saved;
use std::ops::AddAssign;

/// Proposals of one strategy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Count {
    /// How many.
    pub proposed: u64,
    /// Those that were no path with light.
    pub failed: u64,
    /// Σ of their acceptances.
    pub accepted: f64,
}
saved!(Count { proposed, failed, accepted });

impl AddAssign for Count {
    fn add_assign(&mut self, o: Count) {
        self.proposed += o.proposed;
        self.failed += o.failed;
        self.accepted += o.accepted;
    }
}

/// What a chain counts in a pass, or all in all passes: strategy by strategy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Proposals of each strategy.
    pub counts: Vec<Count>,
    /// Proposals rejected because their light was no number.
    pub bad: u64,
    /// Steps since the film was last moved on, and the most there ever were.
    pub still: [u64; 2],
    /// Work done.
    pub stats: PassStats,
}

impl Tally {
    /// Of so many strategies.
    pub fn new(strategies: usize) -> Tally {
        Tally { counts: vec![Count::default(); strategies], ..Tally::default() }
    }

    /// A proposal of a strategy, with the acceptance it found; `None` if it failed.
    pub fn proposed(&mut self, strategy: usize, acceptance: Option<f64>) {
        let count = &mut self.counts[strategy];
        count.proposed += 1;
        count.failed += u64::from(acceptance.is_none());
        count.accepted += acceptance.unwrap_or(0.0);
    }

    /// Share of all proposals that were of this strategy, and accepted.
    pub fn accepted(&self, strategy: usize) -> f64 {
        let all: u64 = self.counts.iter().map(|c| c.proposed).sum();
        self.counts.get(strategy).map_or(0.0, |c| c.accepted) / all.max(1) as f64
    }

    /// A step that moved the chain, or did not.
    pub fn moved(&mut self, moved: bool) {
        let [still, most] = &mut self.still;
        *still = if moved { 0 } else { *still + 1 };
        *most = (*most).max(*still);
    }

    /// The figures of a report: of each strategy how many of its proposals were light, and how many of
    /// those and of all were accepted.
    pub fn report(&self, names: &[&str]) -> Vec<(String, f64)> {
        let share = |part: f64, all: u64| if all > 0 { part / all as f64 } else { 0.0 };
        let of = |(name, c): (&&str, &Count)| {
            let lit = c.proposed - c.failed;
            [
                (format!("{name}.proposed"), c.proposed as f64),
                (format!("{name}.with_light"), share(lit as f64, c.proposed)),
                (format!("{name}.acceptance_with_light"), share(c.accepted, lit)),
                (format!("{name}.acceptance"), share(c.accepted, c.proposed)),
            ]
        };
        let mut report: Vec<(String, f64)> = names.iter().zip(&self.counts).flat_map(of).collect();
        report.push(("not_numbers".into(), self.bad as f64));
        report.push(("longest_stand".into(), self.still[1] as f64));
        report
    }

    /// Adds what another has counted.
    pub fn add(&mut self, o: &Tally) {
        self.counts.resize(self.counts.len().max(o.counts.len()), Count::default());
        self.counts.iter_mut().zip(&o.counts).for_each(|(a, b)| *a += *b);
        self.bad += o.bad;
        self.still[1] = self.still[1].max(o.still[1]);
        self.stats += o.stats;
    }
}

impl crate::saved::Saved for Tally {
    /// All but the work, which is counted anew.
    fn save(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        self.counts.save(out)?;
        self.bad.save(out)?;
        self.still.save(out)
    }

    fn load(from: &mut dyn std::io::Read) -> std::io::Result<Tally> {
        let (counts, bad) = (Vec::load(from)?, u64::load(from)?);
        let still = crate::saved::Saved::load(from)?;
        Ok(Tally { counts, bad, still, stats: PassStats::default() })
    }
}
