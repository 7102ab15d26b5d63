//! A flight around what a picture shows.

use super::rasterizer::Rasterizer;
use super::view::View;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::{FlatView, Scene};

/// The camera swings about an upright axis, from its place to one side, to the other, and back.
#[derive(Clone, Debug)]
pub struct Flight {
    start: FlatView,
    pivot: Vec3,
    axis: Vec3,
    /// Greatest angle, degrees.
    swing: f32,
}

impl Flight {
    /// Around the point in the middle of the picture that a view shows; the scene's middle if it shows
    /// nothing there.
    pub fn new(
        scene: &Scene,
        rasterizer: &mut Rasterizer,
        (camera, view): (&FlatView, &View),
        swing: f32,
    ) -> Flight {
        rasterizer.draw(scene, view);
        let [w, h] = view.size;
        let pivot = rasterizer.seen(view, w / 2, h / 2).map_or(scene.center, |seen| seen.p);
        let axis = camera.to_world.vector(Vec3::Y).normalize();
        Flight { start: *camera, pivot, axis, swing }
    }

    /// The camera when a part of the flight from 0 to 1 has passed.
    pub fn camera(&self, part: f32) -> FlatView {
        let angle = self.swing * (std::f32::consts::TAU * part).sin();
        let (there, back) = (Transform::translate(self.pivot), Transform::translate(-self.pivot));
        let turn = Transform::rotate(angle, self.axis).unwrap_or(Transform::IDENTITY);
        let moved = there.then_after(&turn).then_after(&back);
        FlatView { to_world: moved.then_after(&self.start.to_world), ..self.start }
    }
}
