//! Colour.

mod spectrum;

pub use spectrum::Spectrum;
