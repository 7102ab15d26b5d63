//! Where light is measured: pictures of named channels, reconstruction filters, image files in
//!
//! Conventions: row 0 is the top row; pixel values are linear unless a type says otherwise;
//! RGB has the sRGB / Rec. 709 primaries.

mod error;
pub mod files;
pub mod filter;
pub mod picture;
mod srgb;

pub use error::ImageError;
pub use files::{WriteOptions, read_bitmap, read_picture, write_picture};
pub use filter::{FilterDesc, FilterSample, FilterSampler};
pub use picture::{Channel, ChannelKind, MetaValue, Picture, RgbView};
