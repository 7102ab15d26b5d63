//! Random numbers for light transport: samplers, distributions and the small Monte Carlo tools
//! that every method shares.
//!
//! - [`SamplerPlan`] deals out one [`Sampler`] for each (pixel, sample index). Every number is a
//!   function of (seed, pixel, index, order of the draw): a sample can be replayed alone and the
//!   number of threads cannot change an image.
//! - [`distribution`] turns uniform numbers into samples of tabulated densities.
//! - [`estimator`], [`heuristics`], [`strata`] and [`walk`] are the estimators of Monte Carlo
//!   quadrature: means with error bars, multiple importance sampling, stratification, random
//!   walks with Russian roulette.
//!
//! ```
//! use kaustika_sampling::{SamplerConfig, SamplerKind, SamplerPlan};
//!
//! let plan = SamplerPlan::new(SamplerConfig {
//!     kind: SamplerKind::Sobol,
//!     seed: 0,
//!     spp: 64,
//!     resolution: [640, 480],
//! });
//! // ∫∫ x y over the unit square is 1/4.
//! let sum: f32 = (0..64)
//!     .map(|pass| {
//!         let u = plan.start([10, 20], pass).get_2d();
//!         u.x * u.y
//!     })
//!     .sum();
//! assert!((sum / 64.0 - 0.25).abs() < 0.01);
//! ```

pub mod distribution;
pub mod estimator;
pub mod hash;
pub mod heuristics;
pub mod sampler;
pub mod strata;
pub mod walk;

pub use heuristics::{Heuristic, MisHeuristic};
pub use sampler::{PrimarySample, Sampler, SamplerConfig, SamplerKind, SamplerPlan};
