//! Irradiance caching (Ward, Rubinstein & Clear 1988): the multiple diffuse term of matte surfaces
//! is gathered at few places and interpolated between them.

mod cache;
mod overture;
mod record;

pub(super) use cache::Cache;
