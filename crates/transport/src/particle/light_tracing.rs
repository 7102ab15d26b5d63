//! Light tracing: paths start at the lights, and every surface they meet is shown to the camera
//! (Arvo 1986; Dutré, Lafortune & Willems 1993; Veach 1997, sec. 10.3.4: t = 1).
//!
//! ```text
//! Φ ≈ βᴸ f(ωₒ,ω_c)|cos θ_c| V Wₑ / p_C     at each vertex, added to the pixel where it shows     (1)
//! Φ ≈ βᴸ Wₑ                                where the path meets the lens by itself               (2)
//! ```
//!
//! βᴸ is the flux that arrives at a vertex over the density of the path. (1) is next event
//! estimation toward the lens; (2), its companion without, needs a lens with an area.
//!
//! Good at caustics that are seen directly; blind to all that is seen in a mirror or through
//! clear glass, and to the lights themselves.

use super::light_params::LightParams;
use crate::features::first_seen;
use crate::frame::Frame;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::{
    self, Closing, LightEnd, Splat, Subpath, Tracks, Vertex, Walker, emission_table, needs_lens,
    splat, splat_bands,
};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::Mode;
use kaustika_scene::{LightSelection, Scene, Segment};
use kaustika_spectra::Wavelengths;

/// What light tracing is.
pub static INFO: MethodInfo = MethodInfo {
    name: "light",
    summary: "light tracing: paths from the lights, every vertex connected to the lens",
    path_class: "L(D|S)*(D|S_G)E",
    misses: "lights seen directly, and all that mirrors or clear glass show last: L ... S_M E",
    bias: Bias::Unbiased,
    media: true,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one light path for each pixel",
    source: "Arvo 1986; Dutré, Lafortune & Willems 1993; Veach 1997, sec. 10.3",
};

/// Samples of a chunk.
const CHUNK: u32 = 4096;

/// The method.
#[derive(Debug)]
pub struct LightTracer {
    params: LightParams,
    /// How lights are chosen.
    emission: LightSelection,
}

impl LightTracer {
    /// With these parameters.
    pub fn new(params: LightParams) -> LightTracer {
        LightTracer { params, emission: LightSelection::default() }
    }
}

impl Method for LightTracer {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _: &Frame, _: &Workers) -> Result<(), RenderError> {
        needs_lens(scene)?;
        if !self.params.nee && scene.camera.aperture().is_none() {
            let message =
                "paths cannot meet the lens of this camera, which has no area: leave `nee` at true";
            return Err(RenderError::Failed(message.into()));
        }
        self.emission = emission_table(scene);
        Ok(())
    }

    fn pass(
        &mut self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Commit, RenderError> {
        let rows = CHUNK.div_ceil(out.width()).max(1);
        let tracer = Tracer::new(scene, frame, &self.params, &self.emission);
        let tracks = frame.paths.as_ref().map(|classes| Tracks::new(classes, scene));
        let room = || (Subpath::default(), tracks.clone());
        let bands = splat_bands(workers, frame, out, rows, room, |path, band, splats| {
            let mut stats = PassStats::default();
            for ([x, y], pixel) in frame.places(band) {
                tracer.sample(pixel, index, path, splats, &mut stats);
                let record = match band.wants_features() {
                    true => first_seen(scene, frame, pixel, index),
                    false => PixelRecord::default(),
                };
                band.add(x, y, &PixelRecord { weight: 1.0, ..record });
            }
            stats
        })?;
        let stats = bands.into_iter().sum();
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}

/// Traces light for one picture.
struct Tracer<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    emission: &'a LightSelection,
    walker: Walker<'a>,
    nee: bool,
    max_depth: usize,
    only_depth: Option<usize>,
    /// One over the paths of a pass.
    scale: f32,
}

impl<'a> Tracer<'a> {
    fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &LightParams,
        emission: &'a LightSelection,
    ) -> Tracer<'a> {
        let [w, h] = frame.size();
        Tracer {
            scene,
            frame,
            emission,
            walker: Walker::new(scene, params.roulette(), Mode::Importance),
            nee: params.nee,
            max_depth: params.max_bounces(),
            only_depth: params.only_bounces(),
            scale: 1.0 / (w as f32 * h as f32),
        }
    }

    /// One path; its number is a pixel's, which it need not show in.
    fn sample(
        &self,
        pixel: [u32; 2],
        index: u64,
        (path, tracks): &mut (Subpath<'a>, Option<Tracks>),
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let mut sampler: Sampler = self.frame.sampler.start(pixel, index);
        let u = sampler.get_2d();
        let lambda = Wavelengths::sample_for(self.scene.mode, u.x);
        let Some((end, start)) =
            LightEnd::emit(self.scene, self.emission, &lambda, u.y, &mut sampler)
        else {
            return;
        };
        self.walker.walk(&start, self.max_depth, &mut sampler, path, stats);
        if let Some(tracks) = tracks {
            tracks.follow_light(path, end.light);
        }
        for (i, vertex) in path.iter().enumerate() {
            if self.only_depth.is_none_or(|d| d == i + 1) {
                match self.nee {
                    true => self.to_lens((i, vertex), tracks.as_ref(), splats, stats),
                    false => self.at_lens((i, vertex), tracks.as_ref(), splats, stats),
                }
            }
        }
    }

    /// (1)
    fn to_lens(
        &self,
        (i, y): (usize, &Vertex),
        tracks: Option<&Tracks>,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        if !y.connects() {
            return;
        }
        let Some(c) = path_space::to_lens(self.scene, y) else { return };
        let passage = path_space::passage(self.scene, y, &c.segment, false, &y.lambda, stats);
        if let Some(passage) = passage {
            let value = c.value * passage.value * self.scale;
            let closing = Closing::ToLens(i, y, c.segment.ray.d.normalize());
            splat(self.frame, tracks, &closing, value, c.end.film, &y.lambda, splats, stats);
        }
    }

    /// (2)
    fn at_lens(
        &self,
        (i, y): (usize, &Vertex),
        tracks: Option<&Tracks>,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let Some((ray, beta)) = y.onward else { return };
        let Some(hit) = self.scene.camera.meet_lens(&ray) else { return };
        let segment = Segment { ray, t_max: (hit.p_near - ray.o).length() };
        if let Some(passage) = path_space::passage(self.scene, y, &segment, false, &y.lambda, stats)
        {
            let value = beta * passage.value * (hit.we * self.scale);
            let closing = Closing::AtLens(i + 1);
            splat(self.frame, tracks, &closing, value, hit.film, &y.lambda, splats, stats);
        }
    }
}
