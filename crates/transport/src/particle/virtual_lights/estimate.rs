//! The estimator of one pass.
//!
//! ```text
//! L ≈ Σₜ Wₜ [ L_d(zₜ) + 1/N Σ_y b(y,zₜ) βᴸ f(y) |cos| V / d² |cos| f(zₜ) βᴱ ]       (1)
//! b(y,z) = min(1, c / G),  G = |cos θ_y| |cos θ_z| / d²                               (2)
//! Wₜ₊₁ = Wₜ (1 - b(zₜ₊₁,zₜ))                                                          (3)
//! ```
//!
//! z₁, z₂ … are the vertices of the eye path, L_d is direct light, the y are the vertices of all N light
//! paths of the pass. Of a path that can be cut into a light's and an eye's side at several places,
//! the cut nearest to the eye gets b, the next b of the rest, and so on: the shares add up to 1,
//! so the sum is unbiased (Kollig & Keller 2004, who arrive there from the integral equation).
//! Without compensation W is 0 after the first cut.
//!
//! b is 0 where one of the two is too smooth, and where the path turns by a Dirac lobe at one of
//! them, as no connection makes that.

use super::params::VplParams;
use crate::features::describe_vertex;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::path_space::{
    self, CameraEnd, Closing, Direct, LightEnd, OfPass, Subpath, Tracks, Vertex, Walker,
};
use kaustika_film::accumulate::PixelRecord;
use kaustika_film::path_expression::Back;
use kaustika_math::Vec2;
use kaustika_sampling::MisHeuristic;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{LightSelection, Scene};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Branch of the sampler for light paths.
const LIGHT_BRANCH: u64 = 0x006c_6967_6874;

/// Estimates one pass of a picture.
pub(super) struct Estimator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    params: &'a VplParams,
    direct: Direct<'a>,
    index: u64,
    of_pass: OfPass,
    max_depth: usize,
    only_depth: Option<usize>,
    /// c.
    bound: f32,
}

/// A vertex of a light path.
pub(super) struct VirtualLight<'a> {
    y: Vertex<'a>,
    /// Vertices met before.
    depth: usize,
    /// The classes of its path, if there are layers of them.
    classes: Vec<(Back, Spectrum)>,
}

/// Room for one eye path.
pub(super) struct Room<'a> {
    eye: Subpath<'a>,
    /// The classes of paths, if there are layers of them.
    tracks: Option<Tracks<'a>>,
}

impl Room<'_> {
    /// What the layers by path got of the last sample.
    pub(super) fn layers(&self) -> &[[f32; 3]] {
        self.tracks.as_ref().map_or(&[], Tracks::found)
    }
}

impl<'a> Estimator<'a> {
    /// For pass `index`; `lights` are those for surfaces and those for emission.
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &'a VplParams,
        (lights, emission): (&'a LightSelection, &'a LightSelection),
        index: u64,
    ) -> Estimator<'a> {
        let (mis, walked) = (MisHeuristic::default(), Lobes::ALL);
        Estimator {
            scene,
            frame,
            params,
            direct: Direct { scene, lights, emission, mis, walked },
            index,
            of_pass: OfPass::new(scene, frame, index),
            max_depth: params.max_bounces() as usize,
            only_depth: usize::try_from(params.only_depth).ok(),
            bound: params.clamp / (scene.radius * scene.radius),
        }
    }

    pub(super) fn room(&self) -> Room<'a> {
        let tracks = self.frame.paths.as_ref().map(|classes| Tracks::new(classes, self.scene));
        Room { eye: Subpath::default(), tracks }
    }

    fn walker(&self, mode: Mode) -> Walker<'a> {
        let (scene, roulette) = (self.scene, self.params.roulette());
        Walker::new(scene, roulette, mode)
    }

    /// Those of the pass: the same for every pixel, whatever part of the picture is rendered.
    pub(super) fn virtual_lights(&self, stats: &mut PassStats) -> Vec<VirtualLight<'a>> {
        let mut all = Vec::new();
        // The shortest path with one has two bounces.
        let most = self.max_depth.saturating_sub(1);
        let walker = self.walker(Mode::Importance);
        let OfPass { lambda, time } = self.of_pass;
        let Room { eye: mut path, mut tracks } = self.room();
        for i in 0..u64::from(self.params.paths) {
            // One sequence through all passes, so that the paths of a pass are stratified.
            let number = self.index.wrapping_mul(u64::from(self.params.paths)).wrapping_add(i);
            let mut root = self.frame.sampler.start([0, 0], number);
            let mut sampler = root.fork(LIGHT_BRANCH);
            let emission = self.direct.emission;
            let emitted = LightEnd::emit(self.scene, emission, &lambda, time, &mut sampler);
            let Some((end, start)) = emitted else { continue };
            walker.walk(&start, most, &mut sampler, &mut path, stats);
            if let Some(tracks) = &mut tracks {
                tracks.follow_light(&path, end.light);
            }
            for (depth, y) in path.iter().enumerate() {
                if self.takes_part(y) {
                    let y = y.clone();
                    let classes = tracks.as_ref().map_or(Vec::new(), |t| t.back(depth).to_vec());
                    all.push(VirtualLight { y, depth, classes });
                }
            }
        }
        all
    }

    /// One sample of one pixel.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        features: bool,
        virtual_lights: &[VirtualLight],
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut sampler = frame.sampler.start(pixel, self.index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let OfPass { lambda, time } = self.of_pass;
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), time);
        let start = CameraEnd::new(scene, &camera.ray).start(scene, &camera, lambda);
        let Room { eye, tracks } = room;
        let most = self.max_depth.saturating_add(1);
        let escape = self.walker(Mode::Radiance).walk(&start, most, &mut sampler, eye, stats);
        if let Some(tracks) = tracks {
            tracks.follow_eye(eye);
        }

        let mut found = Found { frame, rgb: [0.0; 3], tracks };
        let mut record = PixelRecord::default();
        if let Some(z) = eye.first().filter(|_| features) {
            describe_vertex(scene, z, &mut record);
        }
        // W of the ray that leads to each vertex, and after the last.
        let mut w = 1.0;
        let mut glows = eye.glows.iter().peekable();
        for i in 0..=eye.len() {
            while let Some(glow) = glows.next_if(|g| g.depth <= i) {
                if self.counts(i) {
                    found.add(glow.value * w, &glow.lambda, &Closing::Glow(i), stats);
                }
            }
            let Some(z) = eye.get(i) else { break };
            if let (true, Some((l, id))) = (self.shows(i), self.direct.met(eye, i)) {
                found.add(l * w, &z.lambda, &Closing::Found(i, id), stats);
            }
            // (3): a connection ends here, unless the path turns by a Dirac lobe before or here.
            let before = i.checked_sub(1).map(|k| &eye[k]).filter(|v| !v.delta);
            let here = w * before.map_or(1.0, |v| self.rest(z, v));
            if here > 0.0 && z.connects() {
                self.scatter(i, z, here, virtual_lights, &mut found, stats);
            }
            w = if z.delta { w } else { here };
            if w == 0.0 {
                break;
            }
        }
        if let Some(escape) = escape.filter(|_| w > 0.0 && self.shows(eye.len())) {
            self.direct.escaped(eye, &escape, |l, id| {
                found.add(l * w, &escape.lambda, &Closing::Found(eye.len(), id), stats);
            });
        }
        PixelRecord { rgb: frame.clamp(found.rgb), weight: film.weight, ..record }
    }

    /// The brackets of (1) at the eye path's vertex `i`, times `w`.
    fn scatter(
        &self,
        i: usize,
        z: &Vertex,
        w: f32,
        virtual_lights: &[VirtualLight],
        found: &mut Found,
        stats: &mut PassStats,
    ) {
        if self.counts(i + 1)
            && let Some((l, wi, id)) = self.direct.asked(z, stats)
        {
            found.add(l * w, &z.lambda, &Closing::NextEvent(i, z, wi, id), stats);
        }
        if !self.takes_part(z) {
            return;
        }
        let w = w / self.params.paths as f32;
        for light in virtual_lights.iter().filter(|l| self.counts(i + l.depth + 2)) {
            let Some(c) = path_space::join(&light.y, z) else { continue };
            let lambda = &c.end.lambda;
            let passage = path_space::passage(self.scene, z, &c.segment, false, lambda, stats);
            if let Some(passage) = passage {
                let l = c.value * passage.value * (w * self.bounded(&light.y, z));
                found.add_joined(light, (i, z), l, lambda, stats);
            }
        }
    }

    /// True if a vertex can be a virtual light, and be lit by one.
    fn takes_part(&self, v: &Vertex) -> bool {
        v.inside.is_some() || (v.connects() && v.bsdf.roughness() >= self.params.roughness)
    }

    /// (2)
    fn bounded(&self, y: &Vertex, z: &Vertex) -> f32 {
        let d = z.surface.p - y.surface.p;
        let d2 = d.length_squared();
        let cos = |v: &Vertex| if v.inside.is_some() { 1.0 } else { v.surface.ng.abs_dot(d) };
        let on_surfaces = [y, z].iter().filter(|v| v.inside.is_none()).count() as i32;
        // The cosines are still times d.
        let g = cos(y) * cos(z) / (d2 * d2.sqrt().powi(on_surfaces));
        if g > self.bound { self.bound / g } else { 1.0 }
    }

    /// What is left for paths that go on from `z` to `y`.
    fn rest(&self, y: &Vertex, z: &Vertex) -> f32 {
        match self.takes_part(y) && self.takes_part(z) {
            false => 1.0,
            true if self.params.compensate => 1.0 - self.bounded(y, z),
            true => 0.0,
        }
    }

    /// True if paths of this many bounces are wanted.
    fn counts(&self, depth: usize) -> bool {
        depth <= self.max_depth && self.only_depth.is_none_or(|d| d == depth)
    }

    /// True if lights found after as many bounces are.
    fn shows(&self, depth: usize) -> bool {
        self.counts(depth) && !(depth == 0 && self.params.hide_emitters)
    }
}

/// What a pixel's sample has found.
struct Found<'r, 'f> {
    frame: &'r Frame,
    rgb: [f32; 3],
    tracks: &'r mut Option<Tracks<'f>>,
}

impl Found<'_, '_> {
    fn add(&mut self, l: Spectrum, lambda: &Wavelengths, how: &Closing, stats: &mut PassStats) {
        self.add_to_picture(l, lambda, stats);
        if let Some(tracks) = self.tracks {
            tracks.add(how, l, lambda, &self.frame.sensor);
        }
    }

    fn add_joined(
        &mut self,
        light: &VirtualLight,
        eye: (usize, &Vertex),
        l: Spectrum,
        lambda: &Wavelengths,
        stats: &mut PassStats,
    ) {
        self.add_to_picture(l, lambda, stats);
        if let Some(tracks) = self.tracks {
            tracks.add_joined((&light.y, &light.classes), eye, l, lambda, &self.frame.sensor);
        }
    }

    fn add_to_picture(&mut self, l: Spectrum, lambda: &Wavelengths, stats: &mut PassStats) {
        self.frame.add(&mut self.rgb, l, lambda, stats);
    }
}
