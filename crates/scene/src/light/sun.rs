//! A disc at infinity: the sun.
//!
//! ```text
//! p_ω = 1 / (2π (1 - cos r)) within the disc of angular radius r                           (1)
//! ```

use kaustika_math::{Frame, Vec2, Vec3, warp};
use kaustika_spectra::CompiledSpectrum;

/// The same radiance from all of a disc of the sphere.
#[derive(Debug)]
pub(super) struct Sun {
    /// The normal points to the centre.
    frame: Frame,
    one_minus_cos: f32,
    pub radiance: CompiledSpectrum,
}

impl Sun {
    /// About the direction `center`, `radius` radians wide on each side.
    pub fn new(center: Vec3, radius: f32, radiance: CompiledSpectrum) -> Sun {
        // 1 - cos r without cancellation.
        let half = (0.5 * radius).sin();
        Sun { frame: Frame::from_normal(center), one_minus_cos: 2.0 * half * half, radiance }
    }

    /// A direction of the disc, uniform over it, and (1).
    pub fn sample(&self, u: Vec2) -> (Vec3, f32) {
        let local = warp::uniform_cone(u, self.one_minus_cos);
        (self.frame.to_world(local), warp::uniform_cone_pdf_w(self.one_minus_cos))
    }

    /// (1), if the disc is met in this direction.
    #[inline]
    pub fn pdf_w(&self, wi: Vec3) -> Option<f32> {
        // |wi - n|² = 2 (1 - cos): small angles keep their digits.
        let within = 0.5 * (wi - self.frame.n).length_squared() <= self.one_minus_cos;
        within.then(|| warp::uniform_cone_pdf_w(self.one_minus_cos))
    }

    /// The part of the sphere that it fills.
    pub fn share(&self) -> f32 {
        0.5 * self.one_minus_cos
    }
}
