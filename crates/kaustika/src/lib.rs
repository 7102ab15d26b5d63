//! Kaustika: a photorealistic renderer with every light transport method.
//!
//! The way of data is one straight line: [`load`] reads a file into a description,
//! [`Setup::new`] builds the scene and the frame, a [`transport::Session`] runs passes of a
//! method, [`output`] makes pictures of them. Between two passes a [`checkpoint`] holds all that
//! is needed to go on, here or on another machine.

pub mod builtin;
pub mod checkpoint;
pub mod denoiser;
pub mod environment;
pub mod fingerprint;
pub mod load;
pub mod output;
pub mod plot;
pub mod pyramid;
pub mod record;
pub mod setup;
pub mod stats;

pub use kaustika_accel as accel;
pub use kaustika_film as film;
pub use kaustika_formats as formats;
pub use kaustika_math as math;
pub use kaustika_sampling as sampling;
pub use kaustika_scene as scene;
pub use kaustika_spectra as spectra;
pub use kaustika_transport as transport;

pub use checkpoint::Checkpoint;
pub use denoiser::Denoiser;
pub use environment::Environment;
pub use load::load;
pub use record::Record;
pub use setup::{Crop, RenderOptions, Setup, SetupError};
