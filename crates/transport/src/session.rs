//! Runs passes of a method until a budget is met.

use crate::frame::Frame;
use crate::method::{CommitKind, Method, PassStats, RenderError};
use crate::registry::with_layers;
use crate::workers::Workers;
use kaustika_film::accumulate::{PassTree, Total};
use kaustika_scene::Scene;
use std::time::{Duration, Instant};

/// When to stop: whichever is met first. Without any, one pass is rendered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget {
    /// Stop before this pass; passes are numbered from 0.
    pub end_pass: Option<u64>,
    /// Stop after this time, but not without any pass.
    pub time: Option<Duration>,
    /// Stop when 95 % of the pixels have an estimated relative error of at most this.
    pub noise: Option<f32>,
}

/// Where a render stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Passes done in all, earlier runs included.
    pub passes: u64,
    /// Passes of this run.
    pub fresh: u64,
    /// First pass after the budget, if it is known.
    pub end_pass: Option<u64>,
    /// Time spent in this run.
    pub elapsed: Duration,
    /// What of it went by before the first pass began.
    pub preparation: Duration,
    /// Estimated relative error, if one was computed lately.
    pub error: Option<RelativeError>,
}

/// Estimated relative error of the image, over pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeError {
    /// Mean.
    pub mean: f32,
    /// 95 % of the pixels are below.
    pub p95: f32,
}

/// Someone who wants to know how it goes.
pub trait Observer {
    /// After each committed pass.
    fn committed(&mut self, progress: &Progress, tree: &PassTree);
}

/// How a run ended.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// True if it was cancelled before the budget was met.
    pub cancelled: bool,
    /// True if it ended because the noise asked for was reached.
    pub reached_noise: bool,
    /// Time spent in passes.
    pub elapsed: Duration,
    /// Passes of this run.
    pub fresh: u64,
    /// Work of this run.
    pub stats: PassStats,
    /// Estimated relative error at the end.
    pub error: Option<RelativeError>,
}

/// A method on its way through the passes of one picture.
pub struct Session<'a> {
    /// What is rendered.
    pub scene: &'a Scene,
    /// The picture.
    pub frame: &'a Frame,
    /// How.
    pub method: Box<dyn Method>,
    /// Sum of the passes so far.
    pub tree: PassTree,
    /// First pass of this share.
    pub first_pass: u64,
    /// True once the method is ready for its first pass.
    is_prepared: bool,
}

impl<'a> Session<'a> {
    /// A session that has not rendered anything.
    pub fn new(scene: &'a Scene, frame: &'a Frame, method: Box<dyn Method>) -> Session<'a> {
        let [width, height] = frame.size();
        let tree = PassTree::new(width, height, frame.layers.clone());
        Session { scene, frame, method, tree, first_pass: 0, is_prepared: false }
    }

    /// Makes the method ready for its first pass, once; [`Session::run`] does so by itself. To
    /// go on from a saved state, prepare, then [`Method::load`].
    ///
    /// # Errors
    /// If the method can't render this scene, or is cancelled.
    pub fn prepare(&mut self, workers: &Workers) -> Result<(), RenderError> {
        if !self.is_prepared {
            let info = self.method.info();
            if !self.method.knows_media(self.scene) {
                let message = format!(
                    "method `{}` knows no participating media such as this scene has: use `path` or `bdpt`",
                    info.name
                );
                return Err(RenderError::Failed(message));
            }
            if self.frame.paths.is_some() && !info.layers {
                let others: Vec<&str> = with_layers().collect();
                let message = format!(
                    "method `{}` does not tell its paths apart: leave `--layer` out, or use one of {}",
                    info.name,
                    others.join(", ")
                );
                return Err(RenderError::Failed(message));
            }
            self.method.prepare(self.scene, self.frame, workers)?;
            self.is_prepared = true;
        }
        Ok(())
    }

    /// Renders until the budget is met or the workers are cancelled. May be called again to go
    /// on with another budget.
    ///
    /// # Errors
    /// If the method can't go on. Passes committed before stay in `tree`.
    pub fn run(
        &mut self,
        budget: &Budget,
        workers: &Workers,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RenderError> {
        let start = Instant::now();
        let mut outcome = Outcome {
            cancelled: false,
            reached_noise: false,
            elapsed: Duration::ZERO,
            fresh: 0,
            stats: PassStats::default(),
            error: None,
        };
        self.prepare(workers)?;
        let preparation = start.elapsed();
        let end = match (budget.end_pass, budget.time, budget.noise) {
            (Some(end), ..) => Some(end),
            (None, None, None) => Some(self.first_pass + 1),
            _ => None,
        };
        loop {
            let pass = self.tree.next_missing(self.first_pass);
            // However short the time, a picture comes of it.
            let is_late = budget.time.is_some_and(|t| start.elapsed() >= t);
            if end.is_some_and(|end| pass >= end) || (is_late && self.tree.passes() > 0) {
                break;
            }
            let mut image = self.tree.blank();
            match self.method.pass(pass, self.scene, self.frame, &mut image, workers) {
                Ok(commit) => {
                    outcome.stats += commit.stats;
                    let joined = match commit.kind {
                        CommitKind::Average => workers.install(|| self.tree.push(pass, image)),
                        CommitKind::Weighted(weight) => {
                            workers.install(|| self.tree.push_weighted(pass, image, weight))
                        }
                        CommitKind::Replace | CommitKind::TrainingOnly => {
                            return Err(RenderError::Failed(
                                "this session only averages passes".into(),
                            ));
                        }
                    };
                    joined.map_err(|e| RenderError::Failed(e.to_string()))?;
                }
                Err(RenderError::Cancelled) => {
                    outcome.cancelled = true;
                    break;
                }
                Err(e) => return Err(e),
            }
            outcome.fresh += 1;
            outcome.elapsed = start.elapsed();
            // An estimate costs a walk over the image: only where the number of passes has
            // grown by about an eighth since the last one.
            let passes = self.tree.passes();
            if passes >= 4 && passes.is_multiple_of((passes / 8).next_power_of_two()) {
                outcome.error = self.error();
                let reached = |e: RelativeError| budget.noise.is_some_and(|n| e.p95 <= n);
                if passes >= 16 && outcome.error.is_some_and(reached) {
                    outcome.reached_noise = true;
                    break;
                }
            }
            let progress = Progress {
                passes,
                fresh: outcome.fresh,
                end_pass: end,
                elapsed: outcome.elapsed,
                preparation,
                error: outcome.error,
            };
            observer.committed(&progress, &self.tree);
            if workers.cancelled() {
                outcome.cancelled = end.is_none_or(|end| pass + 1 < end);
                break;
            }
        }
        outcome.elapsed = start.elapsed();
        outcome.error = self.error();
        Ok(outcome)
    }

    fn error(&self) -> Option<RelativeError> {
        let total = self.tree.total()?;
        Some(match self.method.trust() {
            Some(trust) => relative_error(&total, &self.tree, |i| trust.error[i].map(|e| e * e)),
            None => {
                let n = total.passes as f32;
                relative_error(&total, &self.tree, |i| total.variance(i).map(|v| v / n))
            }
        })
    }
}

/// Estimated relative error of each pixel, standard error of the mean over the mean, from the
/// variance of the mean: what the method knows, or what passes tell if the
/// samples of a pixel are taken as independent: for stratified samplers an upper bound. Dark
/// pixels count against a hundredth of the image's mean, so that black corners do not rule.
pub fn relative_error(
    total: &Total,
    tree: &PassTree,
    variance: impl Fn(usize) -> [f32; 3],
) -> RelativeError {
    let pixels = tree.width() as usize * tree.height() as usize;
    let luminance = |c: [f32; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let mean = (0..pixels).map(|i| luminance(total.rgb(i)).max(0.0) as f64).sum::<f64>()
        / pixels.max(1) as f64;
    let floor = (0.01 * mean as f32).max(1e-12);
    let mut errors: Vec<f32> = (0..pixels)
        .map(|i| luminance(variance(i)).sqrt() / luminance(total.rgb(i)).max(floor))
        .collect();
    let sum: f64 = errors.iter().map(|&e| e as f64).sum();
    let k = (errors.len() * 95 / 100).min(errors.len().saturating_sub(1));
    let p95 = match errors.is_empty() {
        true => 0.0,
        false => *errors.select_nth_unstable_by(k, f32::total_cmp).1,
    };
    RelativeError { mean: (sum / pixels.max(1) as f64) as f32, p95 }
}
