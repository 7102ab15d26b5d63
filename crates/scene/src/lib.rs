//! What is there: shapes, textures, materials, lights, cameras; answers queries.

pub mod description;
