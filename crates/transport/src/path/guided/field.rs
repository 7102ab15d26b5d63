//! The fields that can be asked for.

use crate::guiding::{Field, Guide, LightRecord, LocalDirections, Quadtree};
use crate::saved::Saved;
use kaustika_math::{Vec2, Vec3};
use serde::Deserialize;
use std::io::{self, Read, Write};

/// How incident light is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FieldKind {
    /// Not at all: directions are drawn by the BSDF.
    None,
    /// Quadtrees over the sphere in a tree over space (Müller et al. 2017).
    #[default]
    Quadtree,
}

/// A field of one kind.
#[derive(Clone, Debug)]
pub(super) enum AnyField {
    Quadtree(Field<Quadtree>),
}

/// What it says of a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum AnyLocal<'a> {
    Quadtree(&'a Quadtree),
}

impl AnyField {
    /// An empty one; `None` for none.
    pub(super) fn new(kind: FieldKind) -> Option<AnyField> {
        match kind {
            FieldKind::None => None,
            FieldKind::Quadtree => Some(AnyField::Quadtree(Field::default())),
        }
    }

    /// See [`Field::at`].
    #[inline]
    pub(super) fn at(&self, p: Vec3) -> Option<Guide<AnyLocal<'_>>> {
        match self {
            AnyField::Quadtree(f) => {
                let Guide { directions, alpha } = f.at(p)?;
                Some(Guide { directions: AnyLocal::Quadtree(directions), alpha })
            }
        }
    }

    /// See [`Field::learn`].
    pub(super) fn learn(&mut self, records: &[LightRecord], end: Option<f64>) {
        match self {
            AnyField::Quadtree(f) => f.learn(records, end),
        }
    }
}

impl Saved for AnyField {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            AnyField::Quadtree(f) => {
                0u8.save(out)?;
                f.save(out)
            }
        }
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        match u8::load(from)? {
            0 => Ok(AnyField::Quadtree(Field::load(from)?)),
            _ => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

impl LocalDirections for AnyLocal<'_> {
    #[inline]
    fn sample(&self, u: Vec2) -> (Vec3, f32) {
        match self {
            AnyLocal::Quadtree(q) => q.sample(u),
        }
    }

    #[inline]
    fn pdf(&self, w: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.pdf(w),
        }
    }

    fn radiance(&self, w: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.radiance(w),
        }
    }

    fn irradiance(&self, n: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.irradiance(n),
        }
    }
}
