//! Daylight: the radiance of clear skies and of the sun, W/(m² sr nm).
//!
//! * [`HosekSky`]: the sky by direction; [`hosek_sun`]: the sun's disc (Hosek and Wilkie 2012, 2013).
//! * [`preetham_sun`]: the sun's disc (Preetham et al. 1999).
//!
//! In RGB mode they are divided by ∫ ȳ dλ as all light is, so both modes give the same picture.

mod hosek;
mod preetham;
mod tables;

pub use hosek::{HosekSky, hosek_sun};
pub use preetham::preetham_sun;
