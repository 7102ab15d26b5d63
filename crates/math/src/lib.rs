//! The ground everything stands on: 3-vectors, transforms and their motion, frames, rays with error bounds,
//! warps from the unit square, quadrature and a few special functions.
//!
//! Conventions: `f32` everywhere but where a comment says why not; right-handed unless a
//! transform says otherwise; directions point away from the surface; matrices act on column
//! vectors.

mod bounds;
mod float;
mod frame;
pub mod lanes;
mod motion;
pub mod quadrature;
pub mod ray;
pub mod special;
mod transform;
mod vec;
pub mod warp;

pub use bounds::Bounds3;
pub use float::{
    EPS, INV_PI, INV_TWO_PI, ONE_MINUS_EPSILON, diff_of_products, gamma, lerp, mix_bits, safe_acos,
    safe_sqrt, sqr,
};
pub use frame::Frame;
pub use motion::Motion;
pub use ray::Ray;
pub use transform::{Affine2, Transform};
pub use vec::{Vec2, Vec3};
