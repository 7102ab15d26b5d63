//! Light paths are shown to the lens wherever they arrive.
//!
//! ```text
//! Φ ≈ β f(ωₒ,ω_c)|cos θ_c| V Wₑ / p_C     added to the pixel where it shows                      (1)
//! x = Φ/(β I_px)                          what is learned: importance, over the pixel's value    (2)
//! ```
//!
//! A vertex is shown once, before its copies: through a pinhole all would be shown alike.

use crate::frame::Frame;
use crate::method::PassStats;
use crate::particle::light_trees::{Arriving, Onward, Receiver};
use crate::path_space::{Splat, Vertex, leave, to_lens};
use crate::trees::{Node, hero_for_all};
use kaustika_math::Vec2;
use kaustika_scene::bsdf::Lobes;
use kaustika_scene::{RayBatch, Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// How the picture sees light.
#[derive(Clone, Copy)]
pub(super) struct View<'a, 'f> {
    pub scene: &'a Scene,
    pub frame: &'a Frame,
    /// I_px, row by row; empty while nothing is known, and then all count alike.
    pub pixels: &'f [f32],
    pub only_depth: Option<usize>,
    /// One over the paths of a pass.
    pub scale: f32,
}

impl View<'_, '_> {
    /// 1/I_px where a connection shows; `None` if it shows nowhere.
    fn importance(&self, film: Vec2) -> Option<f32> {
        let [x0, y0, x1, y1] = self.frame.region;
        let radius = self.frame.filter_desc.radius();
        let place = |at: f32, radius: f32, from: u32, to: u32| {
            let reached = at + radius >= from as f32 && at - radius <= to as f32;
            reached.then(|| (at.max(0.0) as u32).clamp(from, to - 1) - from)
        };
        let (x, y) = (place(film.x, radius.x, x0, x1)?, place(film.y, radius.y, y0, y1)?);
        let of_pixel = self.pixels.get(y as usize * (x1 - x0) as usize + x as usize);
        Some(of_pixel.map_or(1.0, |i| 1.0 / i))
    }
}

/// A vertex that waits to be shown to the lens.
struct Shown {
    node: u32,
    /// Of one path for each picture, for a unit of arriving flux.
    value: Spectrum,
    beta: Spectrum,
    importance: f32,
    dispersed: bool,
    film: Vec2,
    lambda: Wavelengths,
}

/// Room for a generation of them.
#[derive(Default)]
pub(super) struct Waiting {
    shown: Vec<Shown>,
    shadow_rays: Vec<Segment>,
    batch: RayBatch,
}

/// The lens.
pub(super) struct Lens<'a, 'f> {
    pub view: View<'a, 'f>,
    pub waiting: &'f mut Waiting,
    pub splats: &'f mut Vec<Splat>,
}

impl<'a> Receiver<'a> for Lens<'a, '_> {
    /// (1), but for what may be in the way.
    fn arrive(&mut self, at: &Vertex<'a>, light: &Arriving, node: &mut Node) -> Onward {
        let on = Onward { lobes: Lobes::ALL, matte: false };
        if self.view.only_depth.is_some_and(|d| d != light.depth) || !at.connects() {
            return on;
        }
        let Some(c) = to_lens(self.view.scene, at) else { return on };
        let film = c.end.film;
        let Some(importance) = self.view.importance(film) else { return on };
        node.asked = true;
        self.waiting.shadow_rays.push(c.segment);
        self.waiting.shown.push(Shown {
            node: light.node,
            value: c.value,
            beta: light.beta,
            importance,
            dispersed: light.dispersed,
            film,
            lambda: at.lambda,
        });
        on
    }

    fn settle(&mut self, scene: &Scene, nodes: &mut [Node], stats: &mut PassStats) {
        let Waiting { shown, shadow_rays, batch } = &mut *self.waiting;
        stats.shadow_rays += shadow_rays.len() as u64;
        scene.occluded_all(shadow_rays, batch);
        for (s, _) in shown.iter().zip(&batch.occluded).filter(|&(_, &occluded)| !occluded) {
            let value = s.value * self.view.scale;
            let found = value * s.importance; // (2)
            nodes[s.node as usize].found = if s.dispersed { hero_for_all(found) } else { found };
            let frame = self.view.frame;
            let sound = leave(frame, None, s.beta * value, s.film, &s.lambda, self.splats);
            stats.bad_samples += u64::from(!sound);
        }
        shown.clear();
        shadow_rays.clear();
    }
}
