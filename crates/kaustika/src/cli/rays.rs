//! `kaustika rays`: the speed of the ray core alone, on rays that other programs can trace too.

use super::args::RaysArgs;
use super::failure::Failure;
use super::stdout;
use kaustika::accel::{BuildOptions, Segment, TriangleBvh};
use kaustika::formats::mesh::{MeshOptions, read_mesh};
use kaustika::math::{Ray, Vec3};
use kaustika::transport::Workers;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Rays a task traces, in one call.
const CHUNK: usize = 2048;
/// Floats a ray: origin, direction, tmax.
const FLOATS: usize = 7;

/// Builds the tree over a mesh and traces files of rays, each several times.
///
/// # Errors
/// If a file can't be read.
pub fn run(args: &RaysArgs) -> Result<(), Failure> {
    let workers = Workers::new(args.threads, Default::default()).map_err(Failure::input)?;
    let tree = Tree::build(&args.mesh, &workers)?;
    for name in &args.rays {
        let (query, path) = query_of(name, args.occlusion);
        let rays = read_rays(path)?;
        let traced = measure(&tree.bvh, query, &rays, args.repeat, &workers);
        let text = match args.json {
            true => format!("{}\n", json(&tree, path, query, &traced, workers.threads())),
            false => text(&tree, path, query, &traced),
        };
        stdout::write(&text)?;
    }
    Ok(())
}

/// What is asked of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Query {
    /// Which hit is the nearest.
    Closest,
    /// Whether there is a hit.
    Any,
}

impl Query {
    fn name(self) -> &'static str {
        match self {
            Query::Closest => "closest",
            Query::Any => "any",
        }
    }
}

/// The query that a file's name asks for by its prefix, and the rest of the name.
fn query_of(name: &Path, occlusion: bool) -> (Query, &Path) {
    let default = if occlusion { Query::Any } else { Query::Closest };
    let Some(text) = name.to_str() else { return (default, name) };
    [Query::Closest, Query::Any]
        .into_iter()
        .find_map(|q| Some((q, Path::new(text.strip_prefix(q.name())?.strip_prefix(':')?))))
        .unwrap_or((default, name))
}

/// A tree, and what it took to get it.
struct Tree {
    bvh: TriangleBvh,
    load_seconds: f64,
    build_seconds: f64,
}

impl Tree {
    fn build(mesh: &Path, workers: &Workers) -> Result<Tree, Failure> {
        let start = Instant::now();
        let mesh =
            workers.install(|| read_mesh(mesh, &MeshOptions::default())).map_err(Failure::input)?;
        let load_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let bvh = workers.install(|| {
            TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default())
        });
        Ok(Tree { bvh, load_seconds, build_seconds: start.elapsed().as_secs_f64() })
    }

    fn bytes_per_triangle(&self) -> f64 {
        self.bvh.memory_bytes() as f64 / self.bvh.triangle_count().max(1) as f64
    }
}

/// What tracing a file of rays gave.
struct Traced {
    rays: usize,
    count: Count,
    /// Seconds of each timed run, rising.
    seconds: Vec<f64>,
}

impl Traced {
    fn best_mrays(&self) -> f64 {
        self.mrays(self.seconds[0])
    }

    fn median_mrays(&self) -> f64 {
        self.mrays(self.seconds[self.seconds.len() / 2])
    }

    fn mrays(&self, seconds: f64) -> f64 {
        self.rays as f64 / seconds.max(1e-12) / 1e6
    }
}

/// Traces all rays `repeat` > 0 times, after once that is not timed.
fn measure(
    bvh: &TriangleBvh,
    query: Query,
    rays: &[Segment],
    repeat: u64,
    workers: &Workers,
) -> Traced {
    let timed = || {
        let start = Instant::now();
        let count = workers.install(|| trace(bvh, query, rays));
        (count, start.elapsed().as_secs_f64())
    };
    let (count, _) = timed();
    let mut seconds: Vec<f64> = (0..repeat).map(|_| timed().1).collect();
    seconds.sort_by(f64::total_cmp);
    Traced { rays: rays.len(), count, seconds }
}

/// What the rays met.
#[derive(Clone, Copy, Default)]
struct Count {
    hits: u64,
    /// Sum of hit distances; 0 for [`Query::Any`].
    t_sum: f64,
}

/// Traces all rays; the sums do not depend on the number of threads.
fn trace(bvh: &TriangleBvh, query: Query, rays: &[Segment]) -> Count {
    let counts: Vec<Count> =
        rays.par_chunks(CHUNK).map(|chunk| trace_chunk(bvh, query, chunk)).collect();
    counts
        .iter()
        .fold(Count::default(), |a, b| Count { hits: a.hits + b.hits, t_sum: a.t_sum + b.t_sum })
}

fn trace_chunk(bvh: &TriangleBvh, query: Query, rays: &[Segment]) -> Count {
    match query {
        Query::Any => {
            let mut occluded = [false; CHUNK];
            let occluded = &mut occluded[..rays.len()];
            bvh.occluded_all(rays, occluded);
            Count { hits: occluded.iter().filter(|&&o| o).count() as u64, t_sum: 0.0 }
        }
        Query::Closest => {
            let mut hits = [None; CHUNK];
            let hits = &mut hits[..rays.len()];
            bvh.intersect_all(rays, hits);
            hits.iter().flatten().fold(Count::default(), |c, hit| Count {
                hits: c.hits + 1,
                t_sum: c.t_sum + hit.t as f64,
            })
        }
    }
}

fn json(tree: &Tree, file: &Path, query: Query, traced: &Traced, threads: usize) -> Value {
    json!({
        "rays_file": file.display().to_string(),
        "kind": query.name(),
        "rays": traced.rays,
        "threads": threads,
        "best_mrays": traced.best_mrays(),
        "median_mrays": traced.median_mrays(),
        "hits": traced.count.hits,
        "t_sum": traced.count.t_sum,
        "triangles": tree.bvh.triangle_count(),
        "load_seconds": tree.load_seconds,
        "build_seconds": tree.build_seconds,
        "bytes_per_triangle": tree.bytes_per_triangle(),
    })
}

fn text(tree: &Tree, file: &Path, query: Query, traced: &Traced) -> String {
    let sum = match query {
        Query::Closest => format!(", sum of distances {:.3}", traced.count.t_sum),
        Query::Any => String::new(),
    };
    format!(
        "{}, {} hit\n  {:.3} Mrays/s at best, {:.3} in the median\n  {} of {} rays hit{sum}\n  \
         tree of {} triangles in {:.3} s (mesh read in {:.3} s), {:.1} bytes each\n",
        file.display(),
        query.name(),
        traced.best_mrays(),
        traced.median_mrays(),
        traced.count.hits,
        traced.rays,
        tree.bvh.triangle_count(),
        tree.build_seconds,
        tree.load_seconds,
        tree.bytes_per_triangle(),
    )
}

fn read_rays(path: &Path) -> Result<Vec<Segment>, Failure> {
    let failure = |cause: String| Failure::Input(format!("{}: {cause}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| failure(e.to_string()))?;
    if bytes.is_empty() || bytes.len() % (4 * FLOATS) != 0 {
        let message = format!("{} bytes are no whole number of rays of 7 floats", bytes.len());
        return Err(failure(message));
    }
    let ray = |b: &[u8]| {
        let f = |i: usize| f32::from_le_bytes([b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]]);
        let ray = Ray::new(Vec3::new(f(0), f(1), f(2)), Vec3::new(f(3), f(4), f(5)));
        Segment { ray, t_max: f(6) }
    };
    Ok(bytes.chunks_exact(4 * FLOATS).map(ray).collect())
}
