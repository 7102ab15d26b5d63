//! What all paths of a pass have in common, where light is shared between pixels.

use crate::frame::{Frame, pass_number};
use kaustika_sampling::hash::combine;
use kaustika_scene::Scene;
use kaustika_spectra::Wavelengths;

/// Wavelengths and shutter time of a pass, stratified over the passes.
#[derive(Clone, Copy, Debug)]
pub struct OfPass {
    /// The wavelengths.
    pub lambda: Wavelengths,
    /// The part of the shutter's interval that has passed.
    pub time: f32,
}

impl OfPass {
    /// Of pass `index`.
    pub fn new(scene: &Scene, frame: &Frame, index: u64) -> OfPass {
        let seed = frame.sampler.config().seed;
        OfPass {
            lambda: Wavelengths::sample_for(scene.mode, pass_number(index, seed)),
            time: pass_number(index, combine(seed, 1)),
        }
    }
}
