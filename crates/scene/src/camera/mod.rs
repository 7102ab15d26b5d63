//! Cameras: where a point of the film looks, and what a point of the scene shows on the film.
//!
//! Film positions are in pixels, x right, y down, the top left corner of the picture at (0, 0);
//! cropping does not move them. A camera is the twin of a light: [`Camera::sample_we`] starts a
//! path, [`Camera::sample_wi`] connects a point to the lens. Importance is normalised so that a
//! pixel's value is the mean radiance over its area (and filter, and lens): the cos⁴ of a real
//! film is left out, as in pbrt and Mitsuba.

mod moving;
mod projective;
mod spherical;

pub use moving::Moving;
pub use projective::Projective;
pub use spherical::Spherical;

use crate::description::{CameraDesc, CameraKind};
use crate::moving::Placement;
use kaustika_math::lanes::{Lanes, Vec3s};
use kaustika_math::{Bounds3, Ray, Vec2, Vec3};

/// A ray from the camera into the scene.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray; its direction is unit.
    pub ray: Ray,
    /// It sees nothing beyond this distance.
    pub t_max: f32,
    /// Angle that a pixel's width fills, radians (orthographic: 0, see `width`).
    pub spread: f32,
    /// Width of a pixel's footprint at the origin, world units.
    pub width: f32,
}

/// Sixteen [`CameraRay`]s.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays {
    /// Origins.
    pub o: Vec3s,
    /// Unit directions.
    pub d: Vec3s,
    /// See [`CameraRay::t_max`].
    pub t_max: Lanes,
    /// See [`CameraRay::spread`].
    pub spread: f32,
    /// See [`CameraRay::width`].
    pub width: f32,
}

/// A connection from a scene point to the lens.
#[derive(Clone, Copy, Debug)]
pub struct CameraConnection {
    /// Unit direction from the point to the lens.
    pub wi: Vec3,
    /// The point on the lens.
    pub p_lens: Vec3,
    /// Where the connection enters the near plane: what stands between it and the lens is not
    /// seen, and does not hide anything.
    pub p_near: Vec3,
    /// Where the point shows on the film.
    pub film: Vec2,
    /// Importance emitted from the lens toward the point, per pixel of the film: the flux
    /// through a connection with weight `we / pdf_w` lands on the pixel at `film`.
    pub we: f32,
    /// Density of `wi` per solid angle at the point (1 for a pinhole, which has no area).
    pub pdf_w: f32,
    /// True if the lens is a point.
    pub delta: bool,
}

/// The closed set of cameras.
#[derive(Clone, Debug)]
pub enum Camera {
    /// Perspective or orthographic, pinhole or thin lens.
    Projective(Projective),
    /// All directions.
    Spherical(Spherical),
    /// One of the others that moves.
    Moving(Moving),
}

impl Camera {
    /// From a description, at a resolution (which may differ from the file's).
    pub fn new(desc: &CameraDesc, resolution: [u32; 2]) -> Camera {
        if !desc.motion.is_empty() {
            let mut still = CameraDesc { motion: Vec::new(), ..desc.clone() };
            match Placement::new(&desc.transform, &desc.motion, desc.shutter) {
                Placement::Still(transform) => still.transform = transform,
                Placement::Moving(motion) => {
                    still.transform = moving::AT_REST;
                    return Camera::Moving(Moving::new(Camera::new(&still, resolution), motion));
                }
            }
            return Camera::new(&still, resolution);
        }
        match &desc.kind {
            CameraKind::Spherical { equal_area } => {
                Camera::Spherical(Spherical::new(desc, *equal_area, resolution))
            }
            _ => Camera::Projective(Projective::new(desc, resolution)),
        }
    }

    /// The ray through a film position and a lens sample.
    #[inline]
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        match self {
            Camera::Projective(c) => c.sample_we(film, lens, time),
            Camera::Spherical(c) => c.sample_we(film, time),
            Camera::Moving(c) => c.sample_we(film, lens, time),
        }
    }

    /// The rays through sixteen film positions and lens samples; `None` for cameras that make
    /// them one by one.
    #[inline(always)]
    pub fn sample_we_lanes(&self, film: [Lanes; 2], lens: [Lanes; 2]) -> Option<CameraRays> {
        match self {
            Camera::Projective(c) => c.sample_we_lanes(film, lens),
            Camera::Spherical(_) | Camera::Moving(_) => None,
        }
    }

    /// Connects the scene point `p` to the lens at a time; `None` if it is not in the picture.
    pub fn sample_wi(&self, p: Vec3, lens: Vec2, time: f32) -> Option<CameraConnection> {
        match self {
            Camera::Projective(c) => c.sample_wi(p, lens),
            Camera::Spherical(c) => c.sample_wi(p),
            Camera::Moving(c) => c.sample_wi(p, lens, time),
        }
    }

    /// Densities of [`Camera::sample_we`] choosing the ray, over the whole film: (per area of
    /// the lens, per solid angle); (0, 0) outside the picture.
    pub fn pdf_we(&self, ray: &Ray) -> (f32, f32) {
        match self {
            Camera::Projective(c) => c.pdf_we(ray),
            Camera::Spherical(c) => c.pdf_we(ray),
            Camera::Moving(c) => c.pdf_we(ray),
        }
    }

    /// Where the camera stands at a time.
    pub fn position(&self, time: f32) -> Vec3 {
        match self {
            Camera::Projective(c) => c.position(),
            Camera::Spherical(c) => c.position(),
            Camera::Moving(c) => c.position(time),
        }
    }

    /// A box around the places where it stands.
    pub(crate) fn bounds(&self) -> Bounds3 {
        match self {
            Camera::Moving(c) => c.bounds(),
            _ => Bounds3::of_points([self.position(0.0)]),
        }
    }
}
