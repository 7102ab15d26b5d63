//! A render with its files: resumed, rendered in stretches, delivered whatever happens.

use super::args::RenderArgs;
use super::failure::Failure;
use super::progress::Watch;
use super::viewer::Viewer;
use super::{counted, duration, picture};
use kaustika::checkpoint::{self, Checkpoint};
use kaustika::denoiser;
use kaustika::film::Picture;
use kaustika::film::accumulate::Feature;
use kaustika::stats::{Phases, Run, Stats};
use kaustika::transport::session::RelativeError;
use kaustika::transport::{Budget, PassStats, RenderError, Session, Workers};
use kaustika::{Record, output};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);

/// One render with its files.
pub struct Job<'a> {
    args: &'a RenderArgs,
    record: &'a Record,
    outputs: &'a [PathBuf],
    /// Features that are kept for the filter alone.
    unasked: &'a [Feature],
    checkpoint: PathBuf,
    /// Seconds spent by earlier programs.
    seconds_before: f64,
    /// Passes rendered by them.
    passes_before: u64,
    /// Time spent rendering by this one.
    elapsed: Duration,
    /// Passes it has rendered.
    fresh: u64,
    work: PassStats,
    error: Option<RelativeError>,
}

/// How the passes ended.
pub enum End {
    /// A budget was met.
    Done,
    /// By Ctrl-C.
    Cancelled,
}

impl<'a> Job<'a> {
    /// Nothing rendered yet.
    ///
    /// # Errors
    /// Without outputs.
    pub fn new(
        args: &'a RenderArgs,
        record: &'a Record,
        outputs: &'a [PathBuf],
        unasked: &'a [Feature],
    ) -> Result<Job<'a>, Failure> {
        let first = outputs.first().ok_or(Failure::Usage("no output".into()))?;
        Ok(Job {
            args,
            record,
            outputs,
            unasked,
            checkpoint: checkpoint::beside(first),
            seconds_before: 0.0,
            passes_before: 0,
            elapsed: Duration::ZERO,
            fresh: 0,
            work: PassStats::default(),
            error: None,
        })
    }

    fn tell(&self, text: &str) {
        if !self.args.quiet {
            eprintln!("{text}");
        }
    }

    /// Puts the session where the checkpoint stands, if one is to be resumed; moves one that is
    /// not out of the way.
    ///
    /// # Errors
    /// If the checkpoint is damaged or of another render.
    pub fn resume(&mut self, session: &mut Session, workers: &Workers) -> Result<(), Failure> {
        let path = &self.checkpoint;
        if !path.exists() {
            return Ok(());
        }
        let shown = path.display();
        if !self.args.resume {
            let aside = path.with_extension("ckpt.old");
            std::fs::rename(path, &aside)
                .map_err(|e| Failure::Input(format!("{shown}: can't be moved aside: {e}")))?;
            let aside = aside.display();
            self.tell(&format!(
                "note: there was a checkpoint, now {aside}; --resume would have gone on from it"
            ));
            return Ok(());
        }
        let advice = "without --resume the render begins anew";
        let found = Checkpoint::read(path).map_err(|e| Failure::Input(format!("{e}; {advice}")))?;
        if let Some(difference) = self.record.difference(&found.record) {
            return Err(Failure::Input(format!("{shown} is of {difference}; {advice}")));
        }
        if !found.method_state.is_empty() {
            session.prepare(workers).map_err(Failure::input)?;
            session.method.load(&mut found.method_state.as_slice()).map_err(|e| {
                Failure::Input(format!("{shown}: the method can't go on from it: {e}"))
            })?;
        }
        self.seconds_before = found.seconds;
        self.passes_before = found.tree.passes();
        session.tree = found.tree;
        let passes = counted::passes(session.tree.passes());
        self.tell(&format!("going on after {passes} in {shown}"));
        Ok(())
    }

    /// Renders until a budget is met, in stretches between which checkpoints are written.
    ///
    /// # Errors
    /// If the method can't go on; the session keeps what it has.
    pub fn render(
        &mut self,
        session: &mut Session,
        workers: &Workers,
        spp: u64,
        viewer: Option<Viewer>,
    ) -> Result<End, RenderError> {
        let args = self.args;
        let has_other_budget = args.time.is_some() || args.noise.is_some();
        let end_pass = match args.passes {
            Some([_, end]) => Some(end),
            None if args.spp.is_none() && has_other_budget => None,
            None => Some(spp),
        };
        session.first_pass = args.passes.map_or(0, |[start, _]| start);
        let to_render = end_pass.map(|end| missing(session, end));
        let [width, height] = self.record.size();
        let pixels = width as u64 * height as u64;
        let mut watch = Watch::new(args.quiet, viewer, pixels, to_render, args.time);
        let end = loop {
            let left = args.time.map(|t| t.saturating_sub(self.elapsed));
            let stretch = left.map_or(CHECKPOINT_INTERVAL, |l| l.min(CHECKPOINT_INTERVAL));
            let budget = Budget { end_pass, time: Some(stretch), noise: args.noise };
            let start = Instant::now();
            let run = session.run(&budget, workers, &mut watch);
            self.elapsed += start.elapsed();
            self.fresh = session.tree.passes() - self.passes_before;
            watch.before = (self.elapsed, self.fresh);
            let outcome = match run {
                Ok(outcome) => outcome,
                // While the method was still getting ready.
                Err(RenderError::Cancelled) => break Ok(End::Cancelled),
                Err(e) => break Err(e),
            };
            self.work += outcome.stats;
            self.error = outcome.error;
            if outcome.cancelled {
                break Ok(End::Cancelled);
            }
            let is_last = end_pass.is_some_and(|end| missing(session, end) == 0)
                || args.time.is_some_and(|t| self.elapsed >= t)
                || outcome.reached_noise;
            if is_last {
                break Ok(End::Done);
            }
            if let Err(e) = self.save(session) {
                self.tell(&format!("warning: no checkpoint: {e}"));
            }
        };
        if let Some(mut viewer) = watch.finish() {
            let mut picture = self.picture(session);
            denoiser::drop_features(&mut picture, self.unasked);
            viewer.finish(&picture);
        }
        end
    }

    /// Writes what there is to write, and says how it ended.
    ///
    /// # Errors
    /// If the render failed or something can't be written; what can be is.
    pub fn deliver(
        &self,
        session: &Session,
        workers: &Workers,
        mut phases: Phases,
        rendered: Result<End, RenderError>,
    ) -> Result<(), Failure> {
        let passes = session.tree.passes();
        if passes == 0 {
            return Err(match rendered {
                Err(e) => Failure::input(e),
                Ok(_) => Failure::Input("stopped before the first pass: no picture".into()),
            });
        }
        let start = Instant::now();
        let is_open_ended = self.args.time.is_some() || self.args.noise.is_some();
        let is_share = self.args.resume || self.args.passes.is_some();
        let mut picture = self.picture(session);
        let denoised = self.args.denoise.map(|d| workers.install(|| d.apply(&mut picture)));
        denoiser::drop_features(&mut picture, self.unasked);
        let written = picture::write(self.outputs, &picture, &self.args.look);
        let is_complete = matches!(rendered, Ok(End::Done)) && written.is_ok();
        let keeps = is_share || is_open_ended || !is_complete;
        let kept = match keeps {
            true => self.save(session).map_err(Failure::input),
            false => remove_if_there(&self.checkpoint),
        };
        phases.write = start.elapsed().as_secs_f64();
        let run = Run {
            passes,
            fresh: self.fresh,
            elapsed: self.elapsed,
            work: self.work,
            error: self.error,
            report: session.method.report(),
        };
        let stats = Stats::new(self.record, &run, phases, workers.threads());
        let counted = self.args.stats.as_deref().map_or(Ok(()), |path| write_stats(path, &stats));
        session.method.remarks().iter().for_each(|remark| self.tell(remark));
        self.summarise(passes, written.is_ok(), keeps && kept.is_ok(), &rendered);
        match denoised.transpose() {
            Ok(report) => report.iter().for_each(|report| self.tell(report)),
            Err(e) => return Err(Failure::Input(format!("the picture keeps its noise: {e}"))),
        }
        written.and(kept).and(counted)?;
        rendered.map(|_| ()).map_err(Failure::input)
    }

    fn summarise(
        &self,
        passes: u64,
        written: bool,
        kept: bool,
        rendered: &Result<End, RenderError>,
    ) {
        let time = duration::show(self.elapsed);
        let how = match rendered {
            Ok(End::Done) => "rendered",
            Ok(End::Cancelled) => "stopped after",
            Err(_) => "failed after",
        };
        let all = match passes == self.fresh {
            true => String::new(),
            false => format!(", {passes} in all"),
        };
        self.tell(&format!("{how} {} in {time}{all}", counted::passes(self.fresh)));
        if self.work.bad_samples > 0 {
            let n = self.work.bad_samples;
            self.tell(&format!("warning: {n} samples were not numbers and count as black"));
        }
        if self.args.quiet {
            return;
        }
        if written {
            picture::tell(self.outputs);
        }
        if kept {
            eprintln!("kept {} to go on from", self.checkpoint.display());
        }
    }

    fn seconds(&self) -> f64 {
        self.seconds_before + self.elapsed.as_secs_f64()
    }

    fn picture(&self, session: &Session) -> Picture {
        let trust = session.method.trust();
        output::picture(&session.tree, trust.as_ref(), self.record, self.seconds())
    }

    fn save(&self, session: &Session) -> Result<(), String> {
        let mut state = Vec::new();
        session.method.save(&mut state).map_err(|e| e.to_string())?;
        checkpoint::write(&self.checkpoint, self.record, &session.tree, &state, self.seconds())
            .map_err(|e| e.to_string())
    }
}

/// Passes from the session's first up to `end` that it does not hold yet.
fn missing(session: &Session, end: u64) -> u64 {
    let start = session.first_pass;
    let held = |[a, b]: [u64; 2]| b.min(end).saturating_sub(a.max(start));
    let held: u64 = session.tree.ranges().into_iter().map(held).sum();
    end.saturating_sub(start) - held
}

fn remove_if_there(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::Input(format!("{}: {e}", path.display())))
        }
        _ => Ok(()),
    }
}

fn write_stats(path: &Path, stats: &Stats) -> Result<(), Failure> {
    let failure = |e: String| Failure::Input(format!("{}: {e}", path.display()));
    let mut text = serde_json::to_string_pretty(stats).map_err(|e| failure(e.to_string()))?;
    text.push('\n');
    kaustika::film::files::replace(path, text.as_bytes()).map_err(|e| failure(e.to_string()))
}
