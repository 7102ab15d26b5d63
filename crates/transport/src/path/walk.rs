//! A path on its way: what must be kept from one vertex to the next.

use kaustika_math::Vec3;
use kaustika_scene::Segment;
use kaustika_spectra::{Spectrum, Wavelengths};

/// The previous vertex, as the next emitter hit needs it for its weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Previous {
    pub(super) p: Vec3,
    pub(super) n: Vec3,
    /// Density per solid angle of the direction taken.
    pub(super) pdf_w: f32,
    /// True if only BSDF sampling could have taken it.
    pub(super) delta: bool,
}

/// A path between two vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    /// The ray to be traced next.
    pub(super) segment: Segment,
    /// Found so far, at the path's wavelengths.
    pub(super) radiance: Spectrum,
    /// Throughput.
    pub(super) beta: Spectrum,
    /// Product of squared relative indices of refraction.
    pub(super) eta_scale: f32,
    /// Bounces.
    pub(super) depth: u32,
    /// Interfaces passed.
    pub(super) passages: u32,
    /// Width of the pixel's beam here, and its growth with distance.
    pub(super) footprint: f32,
    pub(super) spread: f32,
    pub(super) previous: Previous,
    /// The secondary ones ended if the path was dispersed.
    pub(super) lambda: Wavelengths,
    /// Weight of the sample on the film.
    pub(super) film_weight: f32,
}
