//! Cameras: where a point of the film looks, and what a point of the scene shows on the film.
//!
//! Film positions are in pixels, x right, y down, the top left corner of the picture at (0, 0);
//! cropping does not move them. A camera is the twin of a light: [`Camera::sample_we`] starts a
//! path, [`Camera::sample_wi`] connects a point to the lens. Importance is normalised so that a
//! pixel's value is the mean radiance over its area (and filter, and lens): the cos⁴ of a real
//! film is left out, as in pbrt and Mitsuba. Behind a lens of many surfaces ([`Realistic`]) it is the
//! film's irradiance.

mod aperture;
mod meter;
mod moving;
mod projective;
mod realistic;
mod spherical;

pub use meter::Meter;
pub use moving::Moving;
pub use projective::{FlatView, Projective};
pub use realistic::Realistic;
pub use spherical::Spherical;

use crate::description::{CameraDesc, CameraKind, ShapeDesc};
use crate::error::BuildError;
use crate::geometry::Geometry;
use crate::moving::Placement;
use crate::shape::ShapeSample;
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
    /// What the radiance found along it is multiplied by: 1 for a camera without a lens's surfaces.
    pub weight: f32,
    /// The point of a surface that receives it, if directions are drawn by the cosine there: lights
    /// may be sampled from it, as from a matte surface.
    pub receiver: Option<ShapeSample>,
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

/// A light path at the lens.
#[derive(Clone, Copy, Debug)]
pub struct LensHit {
    /// The point on the lens.
    pub p: Vec3,
    /// Where the path enters the near plane.
    pub p_near: Vec3,
    /// Where it shows on the film.
    pub film: Vec2,
    /// Importance of the ray, per pixel of the film.
    pub we: f32,
}

/// The closed set of cameras.
#[derive(Clone, Debug)]
pub enum Camera {
    /// Perspective or orthographic, pinhole or thin lens.
    Projective(Projective),
    /// All directions.
    Spherical(Spherical),
    /// A film behind a lens of many surfaces.
    Realistic(Realistic),
    /// Not a camera: radiance, irradiance, flux.
    Meter(Meter),
    /// Several side by side, each with so many columns of the film.
    Batch(Vec<Camera>, f32),
    /// One of the others that moves.
    Moving(Moving),
}

impl Camera {
    /// From a description, at a resolution (which may differ from the file's), in a scene.
    ///
    /// # Errors
    /// If it measures at a shape that is not there or has no area.
    pub fn new(
        desc: &CameraDesc,
        resolution: [u32; 2],
        shapes: &[ShapeDesc],
        geometry: &Geometry,
    ) -> Result<Camera, BuildError> {
        if !desc.motion.is_empty() {
            let mut still = CameraDesc { motion: Vec::new(), ..desc.clone() };
            let motion = match Placement::new(&desc.transform, &desc.motion, desc.shutter) {
                Placement::Still(transform) => {
                    still.transform = transform;
                    None
                }
                Placement::Moving(motion) => {
                    still.transform = moving::AT_REST;
                    Some(motion)
                }
            };
            let at_rest = Camera::new(&still, resolution, shapes, geometry)?;
            return Ok(match motion {
                Some(motion) => Camera::Moving(Moving::new(at_rest, motion)),
                None => at_rest,
            });
        }
        let meter = |meter: Option<Meter>| {
            let message = "what this sensor measures at has no area";
            meter.map(Camera::Meter).ok_or_else(|| BuildError::new(desc.span, message))
        };
        Ok(match &desc.kind {
            CameraKind::Spherical { equal_area } => {
                Camera::Spherical(Spherical::new(desc, *equal_area, resolution))
            }
            CameraKind::Realistic(lens) => {
                Camera::Realistic(Realistic::new(lens, desc.transform, resolution, desc.span)?)
            }
            CameraKind::Radiance => Camera::Meter(Meter::radiance(&desc.transform, resolution)),
            CameraKind::Irradiance { shape, flux } => {
                let at = shapes.get(*shape).map(|s| (*shape as u32, s));
                let made = at.and_then(|at| Meter::irradiance(at, *flux, geometry, resolution));
                return meter(made);
            }
            CameraKind::Distant { target } => {
                return meter(Meter::distant(&desc.transform, target, geometry, resolution));
            }
            CameraKind::Batch { cameras } => {
                let columns = resolution[0] / cameras.len().max(1) as u32;
                let part = [columns.max(1), resolution[1]];
                let one = |c: &CameraDesc| Camera::new(c, part, shapes, geometry);
                let made = cameras.iter().map(one).collect::<Result<Vec<_>, _>>()?;
                if made.is_empty() {
                    return Err(BuildError::new(desc.span, "a batch without sensors"));
                }
                Camera::Batch(made, part[0] as f32)
            }
            _ => Camera::Projective(Projective::new(desc, resolution)),
        })
    }

    /// The ray through a film position and a lens sample.
    #[inline]
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        match self {
            Camera::Projective(c) => c.sample_we(film, lens, time),
            Camera::Spherical(c) => c.sample_we(film, time),
            Camera::Realistic(c) => c.sample_we(film, lens, time),
            Camera::Meter(c) => c.sample_we(film, lens, time),
            Camera::Batch(cameras, columns) => {
                let i = ((film.x / columns).max(0.0) as usize).min(cameras.len() - 1);
                let film = Vec2::new(film.x - columns * i as f32, film.y);
                cameras[i].sample_we(film, lens, time)
            }
            Camera::Moving(c) => c.sample_we(film, lens, time),
        }
    }

    /// The rays through sixteen film positions and lens samples; `None` for cameras that make
    /// them one by one.
    #[inline(always)]
    pub fn sample_we_lanes(&self, film: [Lanes; 2], lens: [Lanes; 2]) -> Option<CameraRays> {
        match self {
            Camera::Projective(c) => c.sample_we_lanes(film, lens),
            _ => None,
        }
    }

    /// Connects the scene point `p` to the lens at a time; `None` if it is not in the picture,
    /// and for real lenses, meters and batches, which nothing is connected to.
    pub fn sample_wi(&self, p: Vec3, lens: Vec2, time: f32) -> Option<CameraConnection> {
        match self {
            Camera::Projective(c) => c.sample_wi(p, lens),
            Camera::Spherical(c) => c.sample_wi(p),
            Camera::Realistic(_) | Camera::Meter(_) | Camera::Batch(..) => None,
            Camera::Moving(c) => c.sample_wi(p, lens, time),
        }
    }

    /// Densities of [`Camera::sample_we`] choosing the ray, over the whole film: (per area of
    /// the lens, per solid angle); (0, 0) outside the picture, and of real lenses, meters
    /// and batches.
    pub fn pdf_we(&self, ray: &Ray) -> (f32, f32) {
        match self {
            Camera::Projective(c) => c.pdf_we(ray),
            Camera::Spherical(c) => c.pdf_we(ray),
            Camera::Realistic(_) | Camera::Meter(_) | Camera::Batch(..) => (0.0, 0.0),
            Camera::Moving(c) => c.pdf_we(ray),
        }
    }

    /// Where a light path meets the lens, if it does: only a lens with an area can be met, and
    /// none that moves.
    pub fn meet_lens(&self, ray: &Ray) -> Option<LensHit> {
        match self {
            Camera::Projective(c) => c.meet_lens(ray),
            _ => None,
        }
    }

    /// The point of the lens that a camera ray, which starts at the near plane, comes through.
    pub fn lens_point(&self, ray: &Ray) -> Vec3 {
        match self {
            Camera::Projective(c) => c.lens_point(ray),
            Camera::Moving(c) => c.lens_point(ray),
            _ => self.position(ray.time),
        }
    }

    /// The axis of a parallel projection at a time.
    pub fn parallel(&self, time: f32) -> Option<Vec3> {
        match self {
            Camera::Projective(c) => c.parallel(),
            Camera::Moving(c) => c.parallel(time),
            _ => None,
        }
    }

    /// The normal of a lens that light paths can meet.
    pub fn aperture(&self) -> Option<Vec3> {
        match self {
            Camera::Projective(c) => c.aperture(),
            _ => None,
        }
    }

    /// True if light paths can be connected to it: not to real lenses, meters and batches.
    pub fn connects(&self) -> bool {
        !matches!(self, Camera::Realistic(_) | Camera::Meter(_) | Camera::Batch(..))
    }

    /// As a pinhole camera with a flat film at a time, if it is perspective or parallel.
    pub fn flat(&self, time: f32) -> Option<FlatView> {
        match self {
            Camera::Projective(c) => Some(c.flat()),
            Camera::Moving(c) => c.flat(time),
            _ => None,
        }
    }

    /// What is up in the picture at a film position and a time, in world space and not unit; zero
    /// where there is no such direction, as of an irradiance meter.
    pub fn up(&self, film: Vec2, time: f32) -> Vec3 {
        match self {
            Camera::Projective(c) => c.up(),
            Camera::Spherical(c) => c.up(),
            Camera::Realistic(c) => c.up(),
            Camera::Meter(c) => c.up(),
            Camera::Batch(cameras, columns) => {
                let i = ((film.x / columns).max(0.0) as usize).min(cameras.len() - 1);
                cameras[i].up(film, time)
            }
            Camera::Moving(c) => c.up(film, time),
        }
    }

    /// Where the camera stands at a time.
    pub fn position(&self, time: f32) -> Vec3 {
        match self {
            Camera::Projective(c) => c.position(),
            Camera::Spherical(c) => c.position(),
            Camera::Realistic(c) => c.position(),
            Camera::Meter(c) => c.position(),
            Camera::Batch(cameras, _) => {
                cameras.first().map_or(Vec3::ZERO, |camera| camera.position(time))
            }
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
