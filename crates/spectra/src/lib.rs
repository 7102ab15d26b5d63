//! Colour.

mod desc;
mod spectrum;

pub use desc::{ColorSpace, SpectrumDesc};
pub use spectrum::Spectrum;
