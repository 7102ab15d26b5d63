//! What trees of light paths have learned of importance.
//!
//! ```text
//! I = E[x₀],   V̄ = E[x₀²]/I²,   C̄ = E[c₀]        of whole paths, x₀ = ν₀ W                  (1)
//! ```

use super::emission::{Emission, EmissionRecord};
use crate::guiding::{AnyField, FieldKind};
use crate::roulette::efficiency::Totals;
use crate::saved::{Saved, saved};
use crate::trees::Records;
use std::io::{self, Read, Write};

/// Importance: where light should leave its sources, where it should go, how much it brings.
#[derive(Debug)]
pub(in crate::particle) struct Importance {
    /// False: only what is expected is learned, for roulette and splitting.
    guiding: bool,
    /// Of the lights.
    pub emission: Emission,
    /// Everywhere in space.
    pub field: AnyField,
    learning: Sums,
    /// I.
    pub measurement: f32,
    /// V̄ and C̄.
    pub totals: Option<Totals>,
}

/// Σ over the paths of an iteration.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    paths: f64,
    contribution: f64,
    square: f64,
    cost: f64,
}

saved!(Sums { paths, contribution, square, cost });

impl Importance {
    /// Nothing known.
    pub fn new(guiding: bool) -> Importance {
        let field = if guiding { FieldKind::default() } else { FieldKind::None };
        Importance {
            guiding,
            emission: Emission::default(),
            field: AnyField::new(field),
            learning: Sums::default(),
            measurement: 1.0,
            totals: None,
        }
    }

    /// Begins in a scene with so many lights.
    pub fn begin(&mut self, lights: usize) {
        *self = Importance { emission: Emission::new(lights), ..Importance::new(self.guiding) };
    }

    /// Takes in the records of `paths` paths. Cells with more than `most` of them are divided at
    /// the end of an iteration.
    pub fn learn(
        &mut self,
        paths: f64,
        records: &Records,
        emitted: &[EmissionRecord],
        most: Option<f64>,
    ) {
        self.field.learn(&records.light, &records.reflected, most);
        if self.guiding {
            self.emission.learn(emitted);
        }
        let mut sums = Sums { paths, ..Sums::default() };
        for r in emitted.iter().filter(|r| r.contribution.is_finite()) {
            let x = f64::from(r.contribution);
            sums.contribution += x;
            sums.square += x * x;
            sums.cost += f64::from(r.cost);
        }
        self.learning.paths += sums.paths;
        self.learning.contribution += sums.contribution;
        self.learning.square += sums.square;
        self.learning.cost += sums.cost;
    }

    /// Takes over what was learned.
    pub fn refine(&mut self) {
        let sums = std::mem::take(&mut self.learning);
        if sums.paths == 0.0 {
            return;
        }
        let [mean, square, cost] =
            [sums.contribution, sums.square, sums.cost].map(|s| s / sums.paths);
        self.measurement = mean as f32;
        let totals = Totals { variance: (square / (mean * mean)) as f32, cost: cost as f32 };
        self.totals = (totals.variance.is_finite() && cost > 0.0).then_some(totals);
        if self.guiding {
            self.emission.refine();
        }
    }

    /// Writes it.
    pub fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.emission.save(out)?;
        self.field.save(out)?;
        self.learning.save(out)?;
        self.measurement.save(out)?;
        self.totals.save(out)
    }

    /// Reads it back, of a scene with as many lights.
    pub fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        let lights = self.emission.count();
        self.emission = Saved::load(from)?;
        if self.emission.count() != lights {
            return Err(io::ErrorKind::InvalidData.into());
        }
        self.field = Saved::load(from)?;
        self.learning = Saved::load(from)?;
        self.measurement = Saved::load(from)?;
        self.totals = Saved::load(from)?;
        Ok(())
    }
}
