//! A camera that moves while the shutter is open: one at rest, and the motion of its space.

use super::{Camera, CameraConnection, CameraRay, FlatView};
use kaustika_math::{Bounds3, Motion, Ray, Transform, Vec2, Vec3};

/// A moving camera.
#[derive(Clone, Debug)]
pub struct Moving {
    /// In its own space.
    at_rest: Box<Camera>,
    motion: Motion,
}

impl Moving {
    /// `at_rest` stands in its own space.
    pub fn new(at_rest: Camera, motion: Motion) -> Moving {
        Moving { at_rest: Box::new(at_rest), motion }
    }

    /// See [`Camera::flat`].
    pub fn flat(&self, time: f32) -> Option<FlatView> {
        let own = self.at_rest.flat(time)?;
        Some(FlatView { to_world: self.motion.at(time).then_after(&own.to_world), ..own })
    }

    /// The ray through a film position and a lens sample.
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let own = self.at_rest.sample_we(film, lens, time);
        let r = self.motion.at(time).ray(&own.ray);
        let scale = r.d.length();
        CameraRay {
            ray: Ray { d: r.d / scale, ..r },
            t_max: own.t_max * scale,
            spread: own.spread,
            width: own.width * scale,
            ..own
        }
    }

    /// Connects the scene point `p` to the lens.
    pub fn sample_wi(&self, p: Vec3, lens: Vec2, time: f32) -> Option<CameraConnection> {
        let to_world = self.motion.at(time);
        let own = self.at_rest.sample_wi(to_world.inverse().point(p), lens, time)?;
        let wi = to_world.vector(own.wi);
        let scale = wi.length();
        Some(CameraConnection {
            wi: wi / scale,
            p_lens: to_world.point(own.p_lens),
            p_near: to_world.point(own.p_near),
            we: own.we / (scale * scale),
            ..own
        })
    }

    /// Densities over the whole film: (per lens area, per solid angle).
    pub fn pdf_we(&self, ray: &Ray) -> (f32, f32) {
        let r = self.motion.at(ray.time).inverse().ray(ray);
        let scale = r.d.length();
        let (pdf_a, pdf_w) = self.at_rest.pdf_we(&Ray { d: r.d / scale, ..r });
        // A lens that is a point has no area to be scaled: its density is 1.
        (if pdf_a == 1.0 { 1.0 } else { pdf_a * scale * scale }, pdf_w)
    }

    /// The point of the lens that a camera ray comes through.
    pub fn lens_point(&self, ray: &Ray) -> Vec3 {
        let to_world = self.motion.at(ray.time);
        to_world.point(self.at_rest.lens_point(&to_world.inverse().ray(ray)))
    }

    /// The axis of a parallel projection at a time.
    pub fn parallel(&self, time: f32) -> Option<Vec3> {
        let axis = self.at_rest.parallel(time)?;
        self.motion.at(time).vector(axis).try_normalize()
    }

    /// See [`Camera::up`].
    pub fn up(&self, film: Vec2, time: f32) -> Vec3 {
        self.motion.at(time).vector(self.at_rest.up(film, time))
    }

    /// Where the camera stands at a time.
    pub fn position(&self, time: f32) -> Vec3 {
        self.motion.at(time).point(self.at_rest.position(time))
    }

    /// A box around the places where it stands.
    pub(super) fn bounds(&self) -> Bounds3 {
        self.motion.bounds(&Bounds3::of_points([self.at_rest.position(0.0)]))
    }
}

/// Own space: no transform.
pub(super) const AT_REST: Transform = Transform::IDENTITY;
