//! Mixtures in checkpoints.

use super::Mixture;
use super::expectation::{Misfit, Sums};
use super::lobes::{Known, Lobe, MOST};
use super::split::Component;
use crate::saved::{Saved, saved};
use std::io::{self, Read, Write};

saved!(Lobe { mean, kappa, weight, nearness });
saved!(Sums { energy, direction, squares, nearness });
saved!(Misfit { energy, moments, squares });
saved!(Component { lobe, sums, misfit });

/// A list of what there are at most [`MOST`] of.
fn few<T: Saved>(from: &mut dyn Read) -> io::Result<Vec<T>> {
    let list = Vec::load(from)?;
    if list.len() > MOST {
        return Err(io::ErrorKind::InvalidData.into());
    }
    Ok(list)
}

impl Saved for Known {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.lobes().save(out)?;
        self.pivot().save(out)?;
        self.fluence().save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok(Known::new(&few(from)?, Saved::load(from)?, Saved::load(from)?))
    }
}

impl Saved for Mixture {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.known.save(out)?;
        self.components.save(out)?;
        [self.records, self.energy, self.squares, self.since_split].save(out)?;
        self.pivot.save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let (known, components) = (Saved::load(from)?, few(from)?);
        let [records, energy, squares, since_split] = Saved::load(from)?;
        let pivot = Saved::load(from)?;
        Ok(Mixture { known, components, records, energy, squares, since_split, pivot })
    }
}
