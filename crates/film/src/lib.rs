//! Where light is measured: pictures of named channels, reconstruction filters, image files in
//! and out, light path expressions, error metrics against a reference, and the wire to an image viewer.
//!
//! Conventions: row 0 is the top row; pixel values are linear unless a type says otherwise;
//! RGB has the sRGB / Rec. 709 primaries.

pub mod accumulate;
pub mod denoise;
mod error;
pub mod files;
pub mod filter;
pub mod metrics;
pub mod path_expression;
pub mod picture;
mod srgb;
pub mod tev;

pub use error::ImageError;
pub use files::{WriteOptions, read_bitmap, read_picture, write_picture};
pub use filter::{FilterDesc, FilterSample, FilterSampler};
pub use picture::{Channel, ChannelKind, MetaValue, Picture, RgbView};
pub use tev::TevClient;
