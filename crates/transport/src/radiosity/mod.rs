//! Radiosity (Goral, Torrance, Greenberg & Battaile 1984): diffuse light in equilibrium between
//! patches, independent of the view.

pub mod form_factor;
pub mod mesh;
mod points;
pub mod solve;
