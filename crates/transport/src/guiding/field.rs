//! What is known of light, everywhere in space.

use super::choice::{Choice, Guide};
use super::reflected::{Expected, Reflected, ReflectedRecord};
use super::space::SpaceTree;
use super::{Directions, LightRecord, LocalDirections};
use crate::saved::{Saved, saved};
use kaustika_math::{Vec2, Vec3};
use rayon::prelude::*;
use std::io::{self, Read, Write};

/// Light as learned, a [`Cell`] here and a cell there.
#[derive(Clone, Debug, Default)]
pub struct Field<D> {
    tree: SpaceTree<Cell<D>>,
    /// Records taken in since cells were divided last.
    records: u64,
}

/// What is known in a cell: where light comes from, how far to rely on that, and what is
/// reflected.
#[derive(Clone, Debug, Default)]
pub struct Cell<D> {
    directions: D,
    choice: Choice,
    reflected: Reflected,
}

saved!(Field<D> { tree, records });
saved!(Cell<D> { directions, choice, reflected });

impl<D: Directions> Cell<D> {
    /// Where light comes from at `p`, if anything is known; for a matte surface there, times the
    /// cosine about its normal ([`LocalDirections::towards`]).
    #[inline]
    pub fn guide(&self, p: Vec3, matte: Option<Vec3>) -> Option<Guide<D::Local<'_>>> {
        let directions = match matte {
            Some(n) => self.directions.towards(p, n),
            None => self.directions.at(p),
        };
        Some(Guide { directions: directions?, alpha: self.choice.alpha() })
    }

    /// See [`Reflected::expected`].
    #[inline]
    pub fn expected(&self, wo: Vec3, albedo: f32) -> Option<Expected> {
        self.reflected.expected(wo, albedo)
    }
}

impl<D: Directions> Field<D> {
    /// What is known around `p`.
    #[inline]
    pub fn at(&self, p: Vec3) -> &Cell<D> {
        self.tree.cell(p)
    }

    /// Takes in the records of a pass. At the end of an iteration what was learned becomes what
    /// [`Field::at`] says, and cells with more than `most` records of directions are divided.
    pub fn learn(
        &mut self,
        light: &[LightRecord],
        reflected: &[ReflectedRecord],
        end: Option<f64>,
    ) {
        let mut grouped = self.tree.group(light);
        self.records += light.len() as u64;
        self.tree.teach(&grouped, |cell, records| {
            cell.directions.learn(records);
            cell.choice.learn(records);
        });
        let of_reflected = self.tree.group(reflected);
        self.tree.teach(&of_reflected, |cell, records| cell.reflected.learn(records));
        let Some(most) = end else { return };
        // Refined before they are divided: children then begin with the parent's knowledge, and
        // learn on its structure.
        self.tree.cells_mut().par_iter_mut().for_each(|cell| {
            cell.directions.refine();
            cell.reflected.refine();
        });
        if !light.is_empty() {
            let times = self.records as f64 / light.len() as f64;
            self.tree.divide(&mut grouped, (times, most), |cell| {
                cell.directions.halve();
                cell.reflected.halve();
            });
        }
        self.records = 0;
    }
}

/// Nothing known of directions, for those who ask for reflected light alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nothing;

/// Nobody is ever given one.
#[derive(Clone, Copy, Debug)]
pub enum Never {}

impl Directions for Nothing {
    type Local<'a> = Never;

    fn at(&self, _: Vec3) -> Option<Never> {
        None
    }

    fn learn(&mut self, _: &[LightRecord]) {}

    fn refine(&mut self) {}
}

impl LocalDirections for Never {
    fn sample(&self, _: Vec2) -> (Vec3, f32) {
        match *self {}
    }

    fn pdf(&self, _: Vec3) -> f32 {
        match *self {}
    }

    fn radiance(&self, _: Vec3) -> f32 {
        match *self {}
    }

    fn irradiance(&self, _: Vec3) -> f32 {
        match *self {}
    }
}

impl Saved for Nothing {
    fn save(&self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }

    fn load(_: &mut dyn Read) -> io::Result<Self> {
        Ok(Nothing)
    }
}
