//! How the render is going: a bar on a terminal, lines elsewhere.

use super::viewer::Viewer;
use super::{counted, duration};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use kaustika::film::accumulate::PassTree;
use kaustika::transport::{Observer, Progress};
use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two lines where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Watches the passes of a render and tells of them.
pub struct Watch {
    teller: Teller,
    viewer: Option<Viewer>,
    pixels: u64,
    time_budget: Option<Duration>,
    /// Time and passes of this program's earlier calls of the session.
    pub before: (Duration, u64),
    /// Time before its first pass began.
    preparation: Duration,
    /// Passes that this program is to render in all, if known.
    to_render: Option<u64>,
}

enum Teller {
    Silent,
    Lines { last: Instant },
    Bar(ProgressBar),
}

impl Watch {
    /// For pictures of `pixels` pixels of which `to_render` passes are missing, if that is known.
    pub fn new(
        quiet: bool,
        viewer: Option<Viewer>,
        pixels: u64,
        to_render: Option<u64>,
        time_budget: Option<Duration>,
    ) -> Watch {
        let teller = match (quiet, stderr().is_terminal()) {
            (true, _) => Teller::Silent,
            (_, false) => Teller::Lines { last: Instant::now() },
            (_, true) => Teller::Bar(bar(to_render)),
        };
        Watch {
            teller,
            viewer,
            pixels,
            time_budget,
            before: (Duration::ZERO, 0),
            preparation: Duration::ZERO,
            to_render,
        }
    }

    /// Takes the bar away and gives the viewer back.
    pub fn finish(self) -> Option<Viewer> {
        if let Teller::Bar(bar) = self.teller {
            bar.finish_and_clear();
        }
        self.viewer
    }

    /// Rate, times and error in one line.
    fn describe(&self, p: &Progress, elapsed: Duration, fresh: u64) -> String {
        // Getting ready is not done again for the passes that are left.
        let seconds = elapsed.saturating_sub(self.preparation).as_secs_f64().max(1e-9);
        let rate = samples_per_second((fresh * self.pixels) as f64 / seconds);
        let mut text = format!("{rate}, {}", duration::show(elapsed));
        let by_passes = self.to_render.map(|all| {
            let left = all.saturating_sub(fresh) as f64;
            Duration::from_secs_f64(left * seconds / fresh.max(1) as f64)
        });
        let by_time = self.time_budget.map(|t| t.saturating_sub(elapsed));
        if let Some(left) = by_passes.into_iter().chain(by_time).min() {
            text += &format!(", {} left", duration::show(left));
        }
        if let Some(e) = p.error {
            text += &format!(", error {:.1} % (p95 {:.1} %)", 100.0 * e.mean, 100.0 * e.p95);
        }
        text
    }
}

impl Observer for Watch {
    fn committed(&mut self, p: &Progress, tree: &PassTree) {
        let (elapsed, fresh) = (self.before.0 + p.elapsed, self.before.1 + p.fresh);
        // Later stretches find the method ready.
        self.preparation = self.preparation.max(p.preparation);
        let text = self.describe(p, elapsed, fresh);
        match &mut self.teller {
            Teller::Silent => {}
            Teller::Lines { last } if last.elapsed() >= LINE_INTERVAL => {
                let done = match self.to_render {
                    Some(all) => format!("{fresh} of {}", counted::passes(all)),
                    None => counted::passes(fresh),
                };
                let mut out = stderr().lock();
                // A closed stderr is no reason to stop rendering.
                let _ = writeln!(out, "{done}, {text}").and_then(|()| out.flush());
                *last = Instant::now();
            }
            Teller::Lines { .. } => {}
            Teller::Bar(bar) => {
                bar.set_position(fresh);
                bar.set_message(text);
            }
        }
        if let Some(viewer) = &mut self.viewer {
            viewer.update(tree);
        }
    }
}

/// Tells of the way to the first pass: over one line of a terminal, a line now and then elsewhere.
pub fn preparing() -> impl Fn(&str) + Send + Sync + 'static {
    let is_terminal = stderr().is_terminal();
    let interval = if is_terminal { Duration::from_millis(200) } else { LINE_INTERVAL };
    let last = Mutex::new(Instant::now());
    move |text| {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() < interval {
            return;
        }
        *last = Instant::now();
        let mut out = stderr().lock();
        let told = match is_terminal {
            // Erased to its end: the next line may be shorter. A bar takes its place later.
            true => write!(out, "\r{text}\x1b[K\r"),
            false => writeln!(out, "{text}"),
        };
        let _ = told.and_then(|()| out.flush());
    }
}

fn samples_per_second(rate: f64) -> String {
    match rate {
        1e6.. => format!("{:.2} Msamples/s", rate / 1e6),
        _ => format!("{:.1} ksamples/s", rate / 1e3),
    }
}

fn bar(to_render: Option<u64>) -> ProgressBar {
    let target = ProgressDrawTarget::stderr();
    let (bar, template) = match to_render {
        Some(all) => (ProgressBar::new(all), "{bar:16.cyan/blue} {pos}/{len} passes, {wide_msg}"),
        None => (ProgressBar::no_length(), "{spinner} {pos} passes, {wide_msg}"),
    };
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("█▉▊▋▌▍▎▏ ");
    bar.set_draw_target(target);
    bar.set_style(style);
    bar.set_message("starting");
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn getting_ready_is_not_in_the_time_that_is_left() {
        let mut watch = Watch::new(true, None, 1000, Some(4), None);
        watch.preparation = Duration::from_secs(60);
        let p = Progress {
            passes: 1,
            fresh: 1,
            end_pass: Some(4),
            elapsed: Duration::from_secs(61),
            preparation: watch.preparation,
            error: None,
        };
        let text = watch.describe(&p, p.elapsed, 1);
        assert_eq!(text, "1.0 ksamples/s, 1 min 01 s, 3.0 s left");
    }
}
