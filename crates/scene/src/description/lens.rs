//! A lens of many surfaces.

use super::Bitmap;
use std::sync::Arc;

/// What stands between the film and the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct LensDesc {
    /// From the scene to the film.
    pub surfaces: Vec<LensSurface>,
    /// What the film sees sharply, measured from the film, m.
    pub focus_distance: f32,
    /// The film's diagonal, m.
    pub film_diagonal: f32,
    /// The form of the stop's opening; `None`: round.
    pub aperture: Option<ApertureShape>,
}

/// A surface of a lens, or its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensSurface {
    /// Radius of curvature, m: positive where it bulges toward the scene; 0 for the stop.
    pub radius: f32,
    /// To the next surface, m.
    pub thickness: f32,
    /// Index of refraction up to the next surface.
    pub ior: f32,
    /// Radius of the part that lets light through, m.
    pub aperture_radius: f32,
}

/// What the opening of a stop lets through, over the square around it; scaled so that it lets
/// through as much as a round one.
#[derive(Clone, Debug, PartialEq)]
pub enum ApertureShape {
    /// exp(-r²) less its value at the border.
    Gaussian,
    /// Half as wide.
    Square,
    /// Regular, of 0.8 of the radius.
    Pentagon,
    /// Of five points.
    Star,
    /// The mean of the colours.
    Image(Arc<Bitmap>),
}
