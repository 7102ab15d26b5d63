//! Pictures of what materials do: lobes of their BSDFs.

pub mod brdf;
pub mod lobes_svg;
