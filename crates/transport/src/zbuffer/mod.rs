//! The classical pipeline: visibility by z-buffer (Straßer 1974, Catmull 1974), local lighting models,
//! textures with mip maps, shadow maps.

mod ambient;
mod flight;
mod lamps;
mod looks;
mod mesh;
mod painted;
mod params;
mod raster;
mod rasterizer;
mod setup;
mod shade;
mod shadow;
mod view;

pub use flight::Flight;
pub use mesh::{Meshes, Source};
pub use painted::Painted;
pub use params::{Model, ZBufferParams, parameters};
pub use rasterizer::{Rasterizer, Seen};
pub use view::View;

use crate::features::describe;
use crate::frame::{FilmSample, Frame, pass_number};
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_math::Vec2;
use kaustika_sampling::hash::combine;
use kaustika_scene::{FlatView, Scene, ShapeInfo};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// What the z-buffer is.
pub static INFO: MethodInfo = MethodInfo {
    name: "zbuffer",
    summary: "z-buffer: triangles, local lighting models, shadow maps; for looking around",
    path_class: "L[D|S]E",
    misses: "mirrors, glass, light from surface to surface; lamps with an area are points",
    bias: Bias::Biased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one sample a pixel",
    source: "Catmull 1974; Bouknight 1970; Gouraud 1971; Phong 1975; Blinn 1977; Williams 1978, 1983",
};

/// Rows that are written together.
const ROWS: u32 = 32;
/// Most columns or rows of a picture.
const MOST: u32 = 65_535;

/// Most triangles with those of instances: some 10 GB.
const MOST_TRIANGLES: usize = 1 << 27;

/// The method.
#[derive(Debug)]
pub struct ZBuffer {
    params: ZBufferParams,
    rasterizer: Option<Rasterizer>,
}

impl ZBuffer {
    /// With these parameters.
    pub fn new(params: ZBufferParams) -> ZBuffer {
        ZBuffer { params, rasterizer: None }
    }
}

/// A view from which the z-buffer can draw.
///
/// # Errors
/// If the camera has no flat film, or is singular.
pub fn flat_view(scene: &Scene) -> Result<FlatView, RenderError> {
    scene.camera.flat(0.0).ok_or_else(|| {
        let message = "a z-buffer draws what perspective and orthographic cameras show: use \
                       another camera or the method `path`";
        RenderError::Failed(message.into())
    })
}

/// For whoever draws with a z-buffer.
///
/// # Errors
/// If it can't draw this scene.
pub fn can_draw(scene: &Scene, size: [u32; 2]) -> Result<(), RenderError> {
    let failed = |message: &str| Err(RenderError::Failed(message.into()));
    if scene.mode != ColorMode::Rgb {
        return failed("a z-buffer computes in red, green and blue: leave out `--spectral`");
    }
    if size.iter().any(|&n| n > MOST) {
        return failed("a z-buffer draws at most 65535 columns and rows: choose a smaller picture");
    }
    let geometry = &scene.geometry;
    let triangles = |group: u32| geometry.groups[group as usize].triangles.triangle_count();
    let placed = geometry.instances.iter().map(|i| triangles(i.group)).sum::<usize>();
    if triangles(0) + placed > MOST_TRIANGLES {
        return failed(
            "a z-buffer takes at most 2^27 triangles, each instance's counted: use `path`",
        );
    }
    flat_view(scene).map(|_| ())
}

/// The view of a part of a frame through a camera, sampled at a place in each pixel.
///
/// # Errors
/// If the camera is singular.
pub fn view(
    scene: &Scene,
    camera: &FlatView,
    frame: &Frame,
    sample: Vec2,
) -> Result<View, RenderError> {
    let [x0, y0, ..] = frame.region;
    let origin = [f64::from(x0) + f64::from(sample.x), f64::from(y0) + f64::from(sample.y)];
    View::of_camera(camera, origin, frame.size(), scene.radius).ok_or_else(|| {
        RenderError::Failed("the camera's transform is singular: nothing can be seen".into())
    })
}

impl Method for ZBuffer {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn mode(&self) -> Option<ColorMode> {
        Some(ColorMode::Rgb)
    }

    fn strays(&self, scene: &Scene) -> Option<&'static str> {
        let is_glass = |s: &ShapeInfo| !s.interface && scene.materials.looks(s.material).glass;
        let strays = !self.params.clear && scene.shapes.iter().any(is_glass);
        strays.then_some(
            "leaves out this scene's glass and shows what is behind it: draw it opaque with \
             `zbuffer(clear=true)`, or give the class to `path`",
        )
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        can_draw(scene, frame.size())?;
        self.rasterizer = Some(workers.install(|| Rasterizer::new(scene, &self.params)));
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
        let camera = flat_view(scene)?;
        let params = &self.params;
        let rasterizer = self
            .rasterizer
            .get_or_insert_with(|| workers.install(|| Rasterizer::new(scene, params)));
        // All pixels of a pass are sampled at the same place, the passes at places spread over the filter.
        let seed = frame.sampler.config().seed;
        let u = Vec2::new(pass_number(index, seed), golden(index, seed));
        let FilmSample { film: sample, weight } = frame.film_sample([0, 0], u);
        let view = view(scene, &camera, frame, sample)?;
        workers.install(|| rasterizer.draw(scene, &view));
        let rasterizer = &*rasterizer;
        workers.bands(
            out,
            ROWS,
            || (),
            |(), band| {
                for y in 0..band.height() {
                    for x in 0..band.width() {
                        let (px, py) = (x, band.y + y);
                        let mut record = PixelRecord::default();
                        if let (true, Some(seen)) =
                            (band.wants_features(), rasterizer.seen(&view, px, py))
                        {
                            features(scene, &view, rasterizer, &seen, &mut record);
                        }
                        let color = Spectrum::from_rgb(rasterizer.color(px, py));
                        record.rgb = frame.clamp(frame.sensor.rgb(color, &Wavelengths::rgb()));
                        record.weight = weight;
                        band.add(x, y, &record);
                    }
                }
            },
        )?;
        Ok(Commit { kind: CommitKind::Average, stats: PassStats::default() })
    }
}

/// A number in [0, 1) for a pass: multiples of the golden ratio, shifted.
fn golden(index: u64, seed: u64) -> f32 {
    let shift = combine(seed, 0x7a62) >> 11;
    let x = (index as f64 * 0.618_033_988_749_894_9 + shift as f64 / (1u64 << 53) as f64).fract();
    (x as f32).min(kaustika_math::ONE_MINUS_EPSILON)
}

/// Features of what a pixel shows.
fn features(
    scene: &Scene,
    view: &View,
    rasterizer: &Rasterizer,
    seen: &Seen,
    record: &mut PixelRecord,
) {
    let wo = view.toward_eye(seen.p);
    let t = view.distance(seen.p);
    let surface = rasterizer.surface(scene, seen, t);
    let mut lambda = Wavelengths::rgb();
    if let Some(bsdf) = scene.bsdf(&surface, wo, &mut lambda) {
        describe(scene, &surface, &bsdf, wo, &lambda, record);
    }
}
