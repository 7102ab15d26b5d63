//! The fields that can be asked for.

use super::{
    Cell, Expected, Field, Guide, LightRecord, LocalDirections, LocalMixture, Mixture, Nothing,
    Quadtree, ReflectedRecord, Tree,
};
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
    Quadtree,
    /// Mixtures of von Mises-Fisher lobes in a tree over space (Ruppert et al. 2020).
    #[default]
    Mixture,
}

/// A field of one kind.
#[derive(Clone, Debug)]
pub enum AnyField {
    /// [`FieldKind::None`].
    None(Field<Nothing>),
    /// [`FieldKind::Quadtree`].
    Quadtree(Field<Quadtree>),
    /// [`FieldKind::Mixture`].
    Mixture(Field<Mixture>),
}

/// What it says of directions at a point.
#[expect(
    clippy::large_enum_variant,
    reason = "made at each vertex: a box would be memory each time"
)]
#[derive(Clone, Copy, Debug)]
pub enum AnyLocal<'a> {
    /// Of [`AnyField::Quadtree`].
    Quadtree(&'a Tree),
    /// Of [`AnyField::Mixture`].
    Mixture(LocalMixture<'a>),
}

/// What is known of it in a cell of space.
#[derive(Clone, Copy, Debug)]
pub enum AnyCell<'a> {
    /// Of [`AnyField::None`].
    None(&'a Cell<Nothing>),
    /// Of [`AnyField::Quadtree`].
    Quadtree(&'a Cell<Quadtree>),
    /// Of [`AnyField::Mixture`].
    Mixture(&'a Cell<Mixture>),
}

impl<'a> AnyCell<'a> {
    /// See [`Cell::guide`].
    #[inline]
    pub fn guide(self, p: Vec3, matte: Option<Vec3>) -> Option<Guide<AnyLocal<'a>>> {
        match self {
            AnyCell::None(_) => None,
            AnyCell::Quadtree(cell) => {
                let Guide { directions, alpha } = cell.guide(p, matte)?;
                Some(Guide { directions: AnyLocal::Quadtree(directions), alpha })
            }
            AnyCell::Mixture(cell) => {
                let Guide { directions, alpha } = cell.guide(p, matte)?;
                Some(Guide { directions: AnyLocal::Mixture(directions), alpha })
            }
        }
    }

    /// See [`Cell::expected`].
    #[inline]
    pub fn expected(self, wo: Vec3, albedo: f32) -> Option<Expected> {
        match self {
            AnyCell::None(cell) => cell.expected(wo, albedo),
            AnyCell::Quadtree(cell) => cell.expected(wo, albedo),
            AnyCell::Mixture(cell) => cell.expected(wo, albedo),
        }
    }
}

impl AnyField {
    /// An empty one.
    pub fn new(kind: FieldKind) -> AnyField {
        match kind {
            FieldKind::None => AnyField::None(Field::default()),
            FieldKind::Quadtree => AnyField::Quadtree(Field::default()),
            FieldKind::Mixture => AnyField::Mixture(Field::default()),
        }
    }

    /// What is known around `p`.
    #[inline]
    pub fn at(&self, p: Vec3) -> AnyCell<'_> {
        match self {
            AnyField::None(field) => AnyCell::None(field.at(p)),
            AnyField::Quadtree(field) => AnyCell::Quadtree(field.at(p)),
            AnyField::Mixture(field) => AnyCell::Mixture(field.at(p)),
        }
    }

    /// See [`Field::learn`].
    pub fn learn(
        &mut self,
        light: &[LightRecord],
        reflected: &[ReflectedRecord],
        end: Option<f64>,
    ) {
        match self {
            AnyField::None(f) => f.learn(light, reflected, end),
            AnyField::Quadtree(f) => f.learn(light, reflected, end),
            AnyField::Mixture(f) => f.learn(light, reflected, end),
        }
    }
}

impl Saved for AnyField {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            AnyField::None(f) => 0u8.save(out).and_then(|()| f.save(out)),
            AnyField::Quadtree(f) => 1u8.save(out).and_then(|()| f.save(out)),
            AnyField::Mixture(f) => 2u8.save(out).and_then(|()| f.save(out)),
        }
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        match u8::load(from)? {
            0 => Ok(AnyField::None(Field::load(from)?)),
            1 => Ok(AnyField::Quadtree(Field::load(from)?)),
            2 => Ok(AnyField::Mixture(Field::load(from)?)),
            _ => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

impl LocalDirections for AnyLocal<'_> {
    #[inline]
    fn sample(&self, u: Vec2) -> (Vec3, f32) {
        match self {
            AnyLocal::Quadtree(q) => q.sample(u),
            AnyLocal::Mixture(m) => m.sample(u),
        }
    }

    #[inline]
    fn pdf(&self, w: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.pdf(w),
            AnyLocal::Mixture(m) => m.pdf(w),
        }
    }

    fn radiance(&self, w: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.radiance(w),
            AnyLocal::Mixture(m) => m.radiance(w),
        }
    }

    fn irradiance(&self, n: Vec3) -> f32 {
        match self {
            AnyLocal::Quadtree(q) => q.irradiance(n),
            AnyLocal::Mixture(m) => m.irradiance(n),
        }
    }
}
