//! Proofs of the sampling floor: point sets, distributions, heuristics and estimators against
//! what is known of them.

mod distributions;
mod measure;
mod mis;
mod monte_carlo;
mod samplers;
mod stratification;
mod support;
