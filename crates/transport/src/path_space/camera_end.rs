//! xₖ: where a path meets the lens, and with what densities, per picture.

use super::{Departure, Start, solid_angle_to_area};
use crate::method::RenderError;
use kaustika_math::{Ray, Vec3};
use kaustika_scene::{CameraRay, Scene};
use kaustika_spectra::{Spectrum, Wavelengths};

/// The camera's end of a path.
#[derive(Clone, Copy, Debug)]
pub struct CameraEnd {
    /// The point of the lens.
    pub p: Vec3,
    /// Density of xₖ by camera rays.
    pub lens: f64,
    /// Density of xₖ if a point asks for the lens.
    pub connection: f64,
    /// How xₖ₋₁ follows by camera rays, of the whole picture.
    pub departure: Departure,
    /// True if light paths can show here: the place is in the picture.
    pub seen: bool,
    /// The lens's normal, if paths from the light can meet it.
    pub aperture: Option<Vec3>,
}

impl CameraEnd {
    /// Of the path along a camera ray.
    pub fn new(scene: &Scene, ray: &Ray) -> CameraEnd {
        let camera = &scene.camera;
        let (pdf_a, pdf_w) = camera.pdf_we(ray);
        let (pdf_a, pdf_w) = (f64::from(pdf_a), f64::from(pdf_w));
        let aperture = camera.aperture();
        let p = camera.lens_point(ray);
        if pdf_a * pdf_w == 0.0 {
            // Filters reach beyond the picture's edge; connections do not.
            let departure = Departure::Point { p, pdf_w: 1.0 };
            return CameraEnd { p, lens: 1.0, connection: 0.0, departure, seen: false, aperture };
        }
        let (lens, departure) = match camera.parallel(ray.time) {
            Some(axis) => {
                let across = pdf_a / f64::from(axis.dot(ray.d));
                (pdf_w, Departure::Parallel { d: ray.d, pdf_a: across })
            }
            None => (pdf_a, Departure::Point { p, pdf_w }),
        };
        CameraEnd { p, lens, connection: lens, departure, seen: true, aperture }
    }

    /// The first step of the subpath along a camera ray.
    pub fn start(&self, scene: &Scene, camera: &CameraRay, lambda: Wavelengths) -> Start {
        Start {
            ray: camera.ray,
            t_max: camera.t_max,
            beta: Spectrum::ONE,
            lambda,
            departure: self.departure,
            medium: scene.camera_medium,
            footprint: camera.width * scene.footprint_scale,
            spread: camera.spread * scene.footprint_scale,
        }
    }

    /// What turns a density per solid angle at `from` into one of xₖ; 0 where light cannot meet
    /// the lens.
    #[inline]
    pub fn area(&self, from: Vec3) -> f64 {
        self.aperture.map_or(0.0, |n| solid_angle_to_area(from, self.p, n))
    }
}

/// For methods that connect light paths to the lens.
///
/// # Errors
/// If nothing can be connected to the scene's camera, which is then a meter.
pub fn needs_lens(scene: &Scene) -> Result<(), RenderError> {
    match scene.camera.connects() {
        true => Ok(()),
        false => {
            let message = "paths cannot be connected to a lens of many surfaces, a meter or a batch \
                           of sensors: use the method `path`, without layers by path";
            Err(RenderError::Failed(message.into()))
        }
    }
}
