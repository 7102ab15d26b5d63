//! Readers of scenes.

pub mod resources;
