//! Readers of scene files: what others wrote, turned into
//! [`kaustika_scene::description`].

mod curve_file;
pub mod gltf;
mod half_space;
pub mod measured;
pub mod mesh;
pub mod mitsuba;
mod nanovdb;
pub mod pbrt;
mod presets;
pub mod resources;
mod vol;
