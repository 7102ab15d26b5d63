//! Learning where light comes from, for methods that sample lights; so far `path` does.
//!
//! Camera paths without light find the points that matter; the scene's lights are tried from
//! there ([`LearnedLights`]). How many paths depends on the picture's size alone, so that what
//! is learned is the same for every share, crop, budget and number of threads.

use crate::frame::Frame;
use crate::workers::Workers;
use kaustika_math::Vec2;
use kaustika_sampling::hash::combine;
use kaustika_sampling::{SamplerConfig, SamplerKind, SamplerPlan};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{LearnedLights, LightSelection, Scene, Segment, ShadingPoint, ShapeSample};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;

/// One path for as many pixels.
const PIXELS: usize = 4;
/// Paths at most.
const MOST_PATHS: usize = 1 << 15;
/// Points of a path at most: later ones carry little.
const MOST_POINTS: usize = 6;
/// Paths of a chunk.
const CHUNK: usize = 256;

/// What the picture teaches about the scene's lights; `None` if the scene does not ask for it or
/// there is nothing to learn. Points lie up to `max_depth` bounces deep.
pub fn learn(
    scene: &Scene,
    frame: &Frame,
    max_depth: u32,
    workers: &Workers,
) -> Option<LightSelection> {
    if !scene.learns_lights {
        return None;
    }
    let [width, height] = frame.resolution.map(|n| n as usize);
    let paths = (width * height).div_ceil(PIXELS).min(MOST_PATHS);
    let seed = combine(frame.sampler.config().seed, 0x6c69_6768_7473);
    let config = SamplerConfig { kind: SamplerKind::Independent, seed, ..frame.sampler.config() };
    let plan = SamplerPlan::new(config);
    let deepest = max_depth.min(MOST_POINTS as u32);
    workers.install(|| {
        let chunks: Vec<Vec<ShadingPoint>> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut points = Vec::new();
                for path in chunk * CHUNK..paths.min((chunk + 1) * CHUNK) {
                    // Pixels at random: an even pattern might meet one of the scene's.
                    let pixel = combine(seed, path as u64) as usize % (width * height);
                    let pixel = [(pixel % width) as u32, (pixel / width) as u32];
                    follow(scene, frame, &plan, pixel, path as u64, deepest, &mut points);
                }
                points
            })
            .collect();
        LearnedLights::new(scene, chunks.concat(), seed).map(LightSelection::learned)
    })
}

/// Adds the points of one path where light is sampled.
fn follow(
    scene: &Scene,
    frame: &Frame,
    plan: &SamplerPlan,
    pixel: [u32; 2],
    index: u64,
    deepest: u32,
    points: &mut Vec<ShadingPoint>,
) {
    let mut sampler = plan.start(pixel, index);
    let u = sampler.get_vertex();
    let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
    let mut lambda = Wavelengths::sample_for(scene.mode, u[5]);
    let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
    if let Some(ShapeSample { p, p_error, n }) = camera.receiver {
        points.push(ShadingPoint { p, p_error, n, transmits: false });
    }
    let mut segment = Segment { ray: camera.ray, t_max: camera.t_max };
    let mut beta = Spectrum::ONE;
    let mut bsdf = Bsdf::default();
    for _ in 0..deepest {
        let Some(surface) = scene.intersect(&segment.ray, segment.t_max) else { return };
        let wo = -segment.ray.d;
        if !scene.bsdf_into(&surface, wo, &mut lambda, &mut bsdf) {
            segment = Segment { ray: surface.spawn(segment.ray.d), t_max: f32::INFINITY };
            continue;
        }
        if bsdf.lobes().has(Lobes::SMOOTH) {
            points.push(ShadingPoint {
                p: surface.p,
                p_error: surface.p_error,
                n: surface.facing(wo),
                transmits: bsdf.lobes().has(Lobes::TRANSMISSION),
            });
        }
        let u = sampler.get_vertex();
        let (uc, u2) = (u[5], Vec2::new(u[2], u[3]));
        let Some(s) = bsdf.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL) else { return };
        beta *= s.weight;
        // Roulette by throughput from the start: points weigh as they do in the picture.
        let q = beta.max_component().min(1.0);
        if u[6] >= q {
            return;
        }
        beta /= q;
        segment = Segment { ray: surface.spawn(s.wi), t_max: f32::INFINITY };
    }
}
