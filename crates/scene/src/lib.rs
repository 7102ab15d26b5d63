//! What is there: shapes, textures, materials, lights, cameras; answers queries.

pub mod bsdf;
pub mod description;
