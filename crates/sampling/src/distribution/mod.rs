//! Sampling of given densities by inversion, alias tables, rejection and reservoirs.
//!
//! A `sample` takes uniform numbers in [0, 1) and returns what was sampled with its density, a
//! `pdf` the density of any point, an `invert` the uniform numbers that `sample` would have
//! needed. Tabulated densities live on [0, 1) or [0, 1)² and integrate to 1 there; the caller
//! rescales. In all of them `sample` returns the very number that `pdf` gives for its result.

mod constant;
mod constant_2d;
mod discrete;
mod inversion;
mod linear;
mod rejection;
mod reservoir;
pub mod shares;
mod tiled;
mod weights;

pub use constant::PiecewiseConstant1D;
pub use constant_2d::PiecewiseConstant2D;
pub use discrete::{Discrete, DiscreteSample};
pub use inversion::{
    bilinear_inverse, bilinear_pdf, exponential_inverse, exponential_pdf, linear_inverse,
    linear_pdf, sample_bilinear, sample_exponential, sample_linear,
};
pub use linear::PiecewiseLinear1D;
pub use rejection::{Rejection, rejection};
pub use reservoir::WeightedReservoir;
pub use tiled::{TileChoice, Tiled2D, TiledSample};
pub use weights::InvalidWeights;
