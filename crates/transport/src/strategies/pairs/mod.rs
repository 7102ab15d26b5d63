//! The estimator of one pair of subpaths.
//!
//! ```text
//! L ≈ Σ_{s,t} w_{s,t} C_{s,t}                                                          (1)
//! C_{0,t} = βᴱ Lₑ(x₀→x₁)                            the eye finds a light              (2)
//! C_{1,t} = βᴱ f |cos| Lₑ V / p_D                   next event estimation              (3)
//! C_{s,t} = βᴸ f |cos| V / d² f |cos| βᴱ            inner vertices are joined          (4)
//! ```
//!
//! βᴸ and βᴱ are what arrives at a vertex of the light's and of the eye's subpath, over the density
//! of the subpath; what ends at the lens is in `lens.rs`; `join.rs` tells [`super::weight`] what it weighs by.

mod join;
mod lens;
mod pixel;

use self::join::Join;
use self::pixel::Lit;
use super::Settings;
use super::pyramid::Pyramid;
use super::weight::Link;
use crate::features::describe_vertex;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::path_space::{
    self, CameraEnd, Closing, Guides, LightEnd, Splat, Subpath, Tracks, Vertex, Walker,
};
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::Vec2;
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{CameraRay, LightSelection, Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Branch of the sampler for light paths.
const LIGHT_BRANCH: u64 = 0x006c_6967_6874;

/// Joins subpaths of one picture.
#[derive(Debug)]
pub struct Pairs<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    lights: &'a LightSelection,
    emission: &'a LightSelection,
    settings: Settings,
    /// Of the eye's subpaths.
    guides: Option<&'a Guides>,
    /// See [`Pairs::on_both_sides`].
    both_sides: bool,
    /// One over the light paths of a pass.
    splat_scale: f32,
    /// Light paths for each camera path of the whole picture.
    light_paths: f64,
    light: Subpath<'a>,
    eye: Subpath<'a>,
    links: Vec<Link>,
    densities: Vec<f32>,
    /// The classes of paths, if there are layers of them.
    tracks: Option<Tracks<'a>>,
    /// Pictures of single strategies, if they are asked for.
    pyramid: Option<Pyramid>,
    /// What each strategy found of the last pair, if that is asked for.
    pieces: Option<Vec<Piece>>,
}

/// What a strategy found, weighted: one term of (1).
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Vertices from the light and from the eye.
    pub strategy: (usize, usize),
    /// Where it is on the film; `None`: where the camera's ray is.
    pub film: Option<Vec2>,
    /// Linear RGB.
    pub rgb: [f32; 3],
}

/// Where a pair of subpaths begins.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The ray from the camera.
    pub camera: CameraRay,
    /// The wavelengths of both.
    pub lambda: Wavelengths,
    /// Most vertices of the eye's subpath and of the light's.
    pub most: [usize; 2],
}

impl<'a> Pairs<'a> {
    /// For pairs of this frame, one for each pixel of its region; `lights` is how surfaces choose
    /// lights, `emission` how lights are chosen to emit.
    pub fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        settings: Settings,
        lights: &'a LightSelection,
        emission: &'a LightSelection,
    ) -> Pairs<'a> {
        let pixels = |[w, h]: [u32; 2]| f64::from(w) * f64::from(h);
        let light_paths = pixels(frame.size());
        Pairs {
            scene,
            frame,
            lights,
            emission,
            settings,
            guides: None,
            both_sides: false,
            splat_scale: (1.0 / light_paths) as f32,
            light_paths: light_paths / pixels(frame.resolution),
            light: Subpath::default(),
            eye: Subpath::default(),
            links: Vec::new(),
            densities: Vec::new(),
            tracks: frame.paths.as_ref().map(|classes| Tracks::new(classes, scene)),
            pyramid: None,
            pieces: None,
        }
    }

    /// The same, the eye's subpaths guided.
    pub fn guided(self, guides: Option<&'a Guides>) -> Pairs<'a> {
        Pairs { guides, ..self }
    }

    /// The same; a mirror or clear glass that the eye meets first shows what lies in both directions instead of one of them by chance:
    /// a small lamp's image in glass is then found as often as if it were a mirror's. Not in media, where chance says what is met first.
    pub fn on_both_sides(self) -> Pairs<'a> {
        Pairs { both_sides: !self.scene.has_media(), ..self }
    }

    /// True if the eye's subpath first met a surface of Dirac lobes alone, and both its sides are asked for.
    fn has_two_sides(&self, eye: &[Vertex]) -> bool {
        self.both_sides && eye.first().is_some_and(|z| Lobes::DELTA.contains(z.bsdf.lobes()))
    }

    /// The same, telling the [`pieces`](Pairs::pieces) of pairs.
    pub fn with_pieces(self) -> Pairs<'a> {
        Pairs { pieces: Some(Vec::new()), ..self }
    }

    /// What strategies found of the last pair, in no order; those that end in one place may have several.
    pub fn pieces(&self) -> &[Piece] {
        self.pieces.as_deref().unwrap_or_default()
    }

    /// The same, with pictures of single strategies.
    pub fn with_pyramid(mut self) -> Pairs<'a> {
        let first = self.frame.paths.as_ref().map_or(0, |classes| classes.layers().len());
        self.pyramid = Some(Pyramid::new(self.settings.depths[1] as usize, first));
        self
    }

    /// One sample of one pixel: what the pixel gets, and what others get.
    pub fn sample(
        &mut self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut eye = frame.sampler.start(pixel, index);
        let mut root = frame.sampler.start(pixel, index);
        let u = eye.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
        let lambda = Wavelengths::sample_for(scene.mode, u[5]);
        let origin = Origin { camera, lambda, most: self.longest() };
        let samplers = [&mut eye, &mut root.fork(LIGHT_BRANCH)];
        let record = self.pair(&origin, samplers, features, splats, stats);
        PixelRecord { weight: film.weight, ..record }
    }

    /// One pair of subpaths whose numbers come from these samplers, the eye's and the light's: what
    /// the film gets at the camera ray's place, and what it gets elsewhere.
    pub fn pair(
        &mut self,
        origin: &Origin,
        samplers: [&mut Sampler; 2],
        features: bool,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (mut light, mut eye) = (std::mem::take(&mut self.light), std::mem::take(&mut self.eye));
        let paths = (&mut light, &mut eye);
        let record = self.join_all(origin, samplers, features, paths, splats, stats);
        (self.light, self.eye) = (light, eye);
        record
    }

    /// Most vertices of the eye's and of the light's subpath that paths may need.
    pub fn longest(&self) -> [usize; 2] {
        let [_, most] = self.settings.depths;
        [1, 0].map(|more| most.saturating_add(more) as usize)
    }

    /// For pairs whose camera rays lie anywhere in `area` pixels of the film instead: what each finds
    /// counts one pixel.
    pub fn over(mut self, area: f64) -> Pairs<'a> {
        let [w, h] = self.frame.resolution;
        self.splat_scale = (1.0 / area) as f32;
        self.light_paths = area / (f64::from(w) * f64::from(h));
        self
    }

    /// From now on makes paths of this strategy alone.
    pub fn keep_to(&mut self, s: usize, t: usize) {
        self.settings.strategy = Some((s, t));
    }

    /// What the layers got of the last sample: those by path, then those of strategies.
    pub fn layers(&self) -> [&[[f32; 3]]; 2] {
        let by_path = self.tracks.as_ref().map_or(&[][..], Tracks::found);
        [by_path, self.pyramid.as_ref().map_or(&[][..], Pyramid::found)]
    }

    fn join_all(
        &mut self,
        origin: &Origin,
        [eye_sampler, light_sampler]: [&mut Sampler; 2],
        features: bool,
        (light, eye): (&mut Subpath<'a>, &mut Subpath<'a>),
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let scene = self.scene;
        let Origin { camera, lambda, most } = *origin;
        // The eye's subpath.
        let camera_end = CameraEnd::new(scene, &camera.ray);
        let start = camera_end.start(scene, &camera, lambda);
        let walker = |mode| Walker::new(scene, self.settings.roulette, mode);
        let of_eye = Walker { guides: self.guides, ..walker(Mode::Radiance) };
        let escape = of_eye.walk(&start, most[0], eye_sampler, eye, stats);

        // The light's.
        let time = camera.ray.time;
        let emitted = LightEnd::emit(scene, self.emission, &lambda, time, light_sampler);
        light.clear();
        if let Some((_, start)) = &emitted {
            walker(Mode::Importance).walk(start, most[1], light_sampler, light, stats);
        }

        if let Some(tracks) = &mut self.tracks {
            tracks.follow_eye(eye);
            if let Some((end, _)) = &emitted {
                tracks.follow_light(light, end.light);
            }
        }

        if let Some(pyramid) = &mut self.pyramid {
            pyramid.clear();
        }
        if let Some(pieces) = &mut self.pieces {
            pieces.clear();
        }

        // (1), the strategies that end in this pixel.
        let mut record = PixelRecord::default();
        if let (Some(z), true) = (eye.first(), features) {
            describe_vertex(scene, z, &mut record);
        }
        let lit = Lit { light: &*light, end: emitted.as_ref().map(|(end, _)| end) };
        let rgb = match self.has_two_sides(eye) {
            false => self.in_pixel(&lit, (eye, escape.as_ref()), &camera_end, stats),
            true => {
                let mut sum = [0.0; 3];
                let fewest = self.settings.depths[0];
                for side in [Lobes::REFLECTION, Lobes::TRANSMISSION] {
                    let of_side = Walker { lobes: side, ..of_eye };
                    let numbers = &mut eye_sampler.fork(u64::from(side.0));
                    let escape = of_side.walk(&start, most[0], numbers, eye, stats);
                    if let Some(tracks) = &mut self.tracks {
                        tracks.turn_eye(eye);
                    }
                    let rgb = self.in_pixel(&lit, (eye, escape.as_ref()), &camera_end, stats);
                    sum.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
                    // What the surface itself emits is of one side alone.
                    self.settings.depths[0] = fewest.max(1);
                }
                self.settings.depths[0] = fewest;
                sum
            }
        };

        // Those that end in others.
        if let Some((end, _)) = &emitted {
            for j in 0..light.len() {
                self.connect_lens(&light[..=j], end, splats, stats);
            }
        }
        let rgb = self.frame.clamp(rgb);
        PixelRecord { rgb, ..record }
    }

    /// True if the strategy with `s` vertices from the light and `t` from the eye is wanted.
    fn wanted(&self, s: usize, t: usize) -> bool {
        let depth = (s + t - 2) as u32;
        let [fewest, most] = self.settings.depths;
        (fewest..=most).contains(&depth) && self.settings.strategy.is_none_or(|only| only == (s, t))
    }

    /// Adds a contribution and its weight to the layers.
    fn sort(
        &mut self,
        (s, t): (usize, usize),
        closing: &Closing,
        (value, w): (Spectrum, f32),
        lambda: &Wavelengths,
    ) {
        let sensor = &self.frame.sensor;
        if let Some(tracks) = &mut self.tracks {
            tracks.add(closing, value * w, lambda, sensor);
        }
        if let Some(pyramid) = &mut self.pyramid {
            pyramid.add(s, t, [value * w, value].map(|v| sensor.rgb(v, lambda)));
        }
        if let Some(pieces) = &mut self.pieces {
            let rgb = sensor.rgb(value * w, lambda);
            pieces.push(Piece { strategy: (s, t), film: None, rgb });
        }
    }

    /// What passes of a contribution along `segment`, which begins at `from`, and its weight.
    fn close(
        &mut self,
        from: &Vertex,
        segment: &Segment,
        far: bool,
        lambda: &Wavelengths,
        stats: &mut PassStats,
        weight: impl FnOnce(&mut Self, f64) -> f32,
    ) -> Option<(Spectrum, f32)> {
        let scene = self.scene;
        let mut passage = || path_space::passage(scene, from, segment, far, lambda, stats);
        // Only in media does the weight depend on the way.
        if scene.has_media() {
            let passage = passage()?;
            return Some((passage.value, weight(self, passage.passing)));
        }
        let w = weight(self, 1.0);
        let counts = w > 0.0 || self.pyramid.is_some();
        (counts && passage().is_some()).then_some((Spectrum::ONE, w))
    }
}
