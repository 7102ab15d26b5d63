//! What a render cost, as `--stats` writes it.

use crate::record::Record;
use kaustika_transport::PassStats;
use kaustika_transport::session::RelativeError;
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::Duration;

/// One JSON object a render; field names are the keys.
#[derive(Clone, Debug, Serialize)]
pub struct Stats {
    /// Method by name.
    pub method: String,
    /// The scene file.
    pub scene: String,
    /// Wall time by phase.
    pub seconds: Phases,
    /// Passes in the picture, earlier runs included.
    pub passes: u64,
    /// Samples a pixel: of every method here so far, one a pass.
    pub spp: u64,
    /// Samples of this run a second of rendering.
    pub samples_per_second: f64,
    /// Rays of this run.
    pub rays: Rays,
    /// Rays of this run a second of rendering.
    pub rays_per_second: f64,
    /// Samples that were not numbers and count as black.
    pub bad_samples: u64,
    /// Most memory ever held; `None` where the system does not say.
    pub peak_memory_bytes: Option<u64>,
    /// Threads.
    pub threads: usize,
    /// Seed.
    pub seed: u64,
    /// Version of the program.
    pub version: String,
    /// Estimated relative error of the picture; `None` without passes.
    pub relative_error: Option<Error>,
    /// What only the method knows of itself, by name.
    pub report: Map<String, Value>,
}

/// Wall time of each phase in seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Phases {
    /// Reading files.
    pub load: f64,
    /// Building the scene.
    pub build: f64,
    /// Passes of this run.
    pub render: f64,
    /// Writing pictures.
    pub write: f64,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rays {
    /// To the nearest surface.
    pub closest: u64,
    /// To find whether anything is in the way.
    pub shadow: u64,
}

/// Estimated relative error over the pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Error {
    /// Mean.
    pub mean: f32,
    /// 95 % of the pixels are below.
    pub p95: f32,
}

/// A run as the session tells it.
#[derive(Clone, Debug)]
pub struct Run {
    /// Passes in the picture.
    pub passes: u64,
    /// Passes of this run.
    pub fresh: u64,
    /// Time in passes.
    pub elapsed: Duration,
    /// Work done.
    pub work: PassStats,
    /// Estimated error.
    pub error: Option<RelativeError>,
    /// The method's report.
    pub report: Vec<(String, f64)>,
}

impl Stats {
    /// The statistics of a run; rates are 0 where no time was measured.
    pub fn new(record: &Record, run: &Run, phases: Phases, threads: usize) -> Stats {
        let seconds = Phases { render: run.elapsed.as_secs_f64(), ..phases };
        let rate = |n: u64| if seconds.render > 0.0 { n as f64 / seconds.render } else { 0.0 };
        let [width, height] = record.size();
        let samples = run.fresh * width as u64 * height as u64;
        Stats {
            method: record.method.clone(),
            scene: record.scene.clone(),
            seconds,
            passes: run.passes,
            spp: run.passes,
            samples_per_second: rate(samples),
            rays: Rays { closest: run.work.closest_rays, shadow: run.work.shadow_rays },
            rays_per_second: rate(run.work.closest_rays + run.work.shadow_rays),
            bad_samples: run.work.bad_samples,
            peak_memory_bytes: peak_memory_bytes(),
            threads,
            seed: record.seed,
            version: record.version.clone(),
            relative_error: run.error.map(|e| Error { mean: e.mean, p95: e.p95 }),
            report: run.report.iter().map(|(k, v)| (k.clone(), Value::from(*v))).collect(),
        }
    }
}

/// The most memory this process ever held: Linux's `VmHWM`.
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
