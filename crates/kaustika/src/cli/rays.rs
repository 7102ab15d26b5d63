//! `kaustika rays`: the speed of the ray core alone, on rays that other programs can trace too.

use super::args::RaysArgs;
use super::failure::Failure;
use super::stdout;
use kaustika::accel::{BuildOptions, TriangleBvh};
use kaustika::formats::mesh::{MeshOptions, read_mesh};
use kaustika::math::{Ray, Vec3};
use kaustika::transport::Workers;
use rayon::prelude::*;
use serde_json::json;
use std::path::Path;
use std::time::Instant;

/// Rays a task traces.
const CHUNK: usize = 4096;
/// Floats a ray: origin, direction, tmax.
const FLOATS: usize = 7;

/// Builds the tree over a mesh and traces given rays, several times.
///
/// # Errors
/// If a file can't be read.
pub fn run(args: &RaysArgs) -> Result<(), Failure> {
    let mesh = read_mesh(&args.mesh, &MeshOptions::default()).map_err(Failure::input)?;
    let rays = read_rays(&args.rays)?;
    let workers = Workers::new(args.threads, Default::default()).map_err(Failure::input)?;
    let start = Instant::now();
    let bvh = workers
        .install(|| TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default()));
    let build_seconds = start.elapsed().as_secs_f64();

    // One run to warm up, as Embree's driver does.
    let mut count = workers.install(|| trace(&bvh, &rays, args.occlusion));
    let mut seconds = Vec::new();
    for _ in 0..args.repeat.max(1) {
        let start = Instant::now();
        count = workers.install(|| trace(&bvh, &rays, args.occlusion));
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let mrays = |s: f64| rays.len() as f64 / s.max(1e-12) / 1e6;
    let triangles = bvh.triangle_count();
    let bytes = bvh.memory_bytes() as f64 / triangles.max(1) as f64;
    let report = json!({
        "rays_file": args.rays.display().to_string(),
        "kind": if args.occlusion { "any" } else { "closest" },
        "rays": rays.len(),
        "threads": workers.threads(),
        "best_mrays": mrays(seconds[0]),
        "median_mrays": mrays(seconds[seconds.len() / 2]),
        "hits": count.hits,
        "t_sum": count.t_sum,
        "triangles": triangles,
        "build_seconds": build_seconds,
        "bytes_per_triangle": bytes,
    });
    if args.json {
        return stdout::write(&format!("{report}\n"));
    }
    let (best, median) = (mrays(seconds[0]), mrays(seconds[seconds.len() / 2]));
    let (hits, all, sum) = (count.hits, rays.len(), count.t_sum);
    stdout::write(&format!(
        "{best:.3} Mrays/s at best, {median:.3} in the median\n\
         {hits} of {all} rays hit, sum of distances {sum:.3}\n\
         tree of {triangles} triangles in {build_seconds:.3} s, {bytes:.1} bytes each\n"
    ))
}

#[derive(Clone, Copy, Default)]
struct Count {
    hits: u64,
    /// Sum of hit distances; 0 for occlusion.
    t_sum: f64,
}

/// Traces all rays; the sums do not depend on the number of threads.
fn trace(bvh: &TriangleBvh, rays: &[(Ray, f32)], occlusion: bool) -> Count {
    let of_chunk = |chunk: &[(Ray, f32)]| {
        let mut count = Count::default();
        for (ray, t_max) in chunk {
            if occlusion {
                count.hits += bvh.occluded(ray, *t_max) as u64;
            } else if let Some(hit) = bvh.intersect(ray, *t_max) {
                count.hits += 1;
                count.t_sum += hit.t as f64;
            }
        }
        count
    };
    let counts: Vec<Count> = rays.par_chunks(CHUNK).map(of_chunk).collect();
    counts
        .iter()
        .fold(Count::default(), |a, b| Count { hits: a.hits + b.hits, t_sum: a.t_sum + b.t_sum })
}

fn read_rays(path: &Path) -> Result<Vec<(Ray, f32)>, Failure> {
    let failure = |cause: String| Failure::Input(format!("{}: {cause}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| failure(e.to_string()))?;
    if bytes.is_empty() || bytes.len() % (4 * FLOATS) != 0 {
        let message = format!("{} bytes are no whole number of rays of 7 floats", bytes.len());
        return Err(failure(message));
    }
    let ray = |b: &[u8]| {
        let f = |i: usize| f32::from_le_bytes([b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]]);
        (Ray::new(Vec3::new(f(0), f(1), f(2)), Vec3::new(f(3), f(4), f(5))), f(6))
    };
    Ok(bytes.chunks_exact(4 * FLOATS).map(ray).collect())
}
