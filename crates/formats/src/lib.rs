//! Readers of scenes.

pub mod mitsuba;
pub mod resources;
