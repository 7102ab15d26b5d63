//! The fields that can be asked for.

use super::{
    Expected, Field, Guide, LightRecord, LocalDirections, LocalMixture, Mixture, Nothing, Quadtree,
    ReflectedRecord, Tree,
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

/// What it says of a point: where light comes from, and what is reflected.
pub type Known<'a> = (Option<Guide<AnyLocal<'a>>>, Option<Expected>);

impl AnyField {
    /// An empty one.
    pub fn new(kind: FieldKind) -> AnyField {
        match kind {
            FieldKind::None => AnyField::None(Field::default()),
            FieldKind::Quadtree => AnyField::Quadtree(Field::default()),
            FieldKind::Mixture => AnyField::Mixture(Field::default()),
        }
    }

    /// What is known at `p`; of light toward `wo`, where the albedo is `albedo`.
    #[inline]
    pub fn at(&self, p: Vec3, wo: Vec3, albedo: f32) -> Known<'_> {
        match self {
            AnyField::None(f) => (None, f.at(p).expected(wo, albedo)),
            AnyField::Quadtree(f) => {
                let cell = f.at(p);
                let local = |g: Guide<_>| Guide {
                    directions: AnyLocal::Quadtree(g.directions),
                    alpha: g.alpha,
                };
                (cell.guide(p, None).map(local), cell.expected(wo, albedo))
            }
            AnyField::Mixture(f) => {
                let cell = f.at(p);
                let local = |g: Guide<_>| Guide {
                    directions: AnyLocal::Mixture(g.directions),
                    alpha: g.alpha,
                };
                (cell.guide(p, None).map(local), cell.expected(wo, albedo))
            }
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

    #[inline]
    fn towards(self, n: Vec3) -> Self {
        match self {
            AnyLocal::Quadtree(q) => AnyLocal::Quadtree(q),
            AnyLocal::Mixture(m) => AnyLocal::Mixture(m.towards(n)),
        }
    }
}
