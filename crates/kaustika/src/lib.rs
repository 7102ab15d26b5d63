//! Kaustika: a photorealistic renderer with every light transport method.
//!
//! The way of data is one straight line: [`load`] reads a file into a description,
//! [`Setup::new`] builds the scene and the frame, a [`transport::Session`] runs passes of a
//! method, [`output`] makes pictures of them.

pub mod load;
pub mod output;
pub mod setup;

pub use kaustika_accel as accel;
pub use kaustika_film as film;
pub use kaustika_formats as formats;
pub use kaustika_math as math;
pub use kaustika_sampling as sampling;
pub use kaustika_scene as scene;
pub use kaustika_spectra as spectra;
pub use kaustika_transport as transport;

pub use load::load;
pub use setup::{RenderOptions, Setup};
