//! Readers of scene files: what others wrote, turned into
//! [`kaustika_scene::description`].

pub mod gltf;
pub mod mesh;
pub mod mitsuba;
pub mod pbrt;
mod presets;
pub mod resources;
mod vol;
