//! A distribution of directions everywhere in space.

use super::choice::{Choice, Guide};
use super::space::SpaceTree;
use super::{Directions, LightRecord};
use crate::saved::saved;
use kaustika_math::Vec3;
use rayon::prelude::*;

/// Incident radiance as learned: a [`Directions`] and a [`Choice`] in each cell of space.
#[derive(Clone, Debug, Default)]
pub struct Field<D> {
    tree: SpaceTree<Cell<D>>,
    /// Records taken in since cells were divided last.
    records: u64,
}

#[derive(Clone, Debug, Default)]
struct Cell<D> {
    directions: D,
    choice: Choice,
}

saved!(Field<D> { tree, records });
saved!(Cell<D> { directions, choice });

impl<D: Directions> Field<D> {
    /// The guide at `p`; `None` where nothing is known.
    #[inline]
    pub fn at(&self, p: Vec3) -> Option<Guide<D::Local<'_>>> {
        let cell = self.tree.cell(p);
        let directions = cell.directions.at(p)?;
        Some(Guide { directions, alpha: cell.choice.alpha() })
    }

    /// Takes in the records of a pass. At the end of an iteration what was learned becomes what
    /// [`Field::at`] says, and cells with more than `most` records are divided.
    pub fn learn(&mut self, records: &[LightRecord], end: Option<f64>) {
        let mut grouped = self.tree.group(records);
        self.records += records.len() as u64;
        self.tree.teach(&grouped, |cell, records| {
            cell.directions.learn(records);
            cell.choice.learn(records);
        });
        let Some(most) = end else { return };
        // Refined before they are divided: children then begin with the parent's knowledge, and
        // learn on its structure.
        self.tree.cells_mut().par_iter_mut().for_each(|cell| cell.directions.refine());
        if !records.is_empty() {
            let times = self.records as f64 / records.len() as f64;
            self.tree.divide(&mut grouped, (times, most), |cell| cell.directions.halve());
        }
        self.records = 0;
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.tree.cells().len()
    }
}
