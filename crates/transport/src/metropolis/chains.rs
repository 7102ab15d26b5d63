//! The chains of a picture, and what is known of them.

use super::seeds::Seeds;
use super::tally::Tally;
use crate::saved::Saved;
use std::io::{self, Read, Write};

/// Chains whose states are `W`.
#[derive(Debug)]
pub struct Chains<W> {
    /// b: the picture's brightness, summed over pixels, without what is rendered separately.
    pub brightness: f64,
    /// Its standard error.
    pub error: f64,
    /// The chains.
    pub walks: Vec<W>,
    tally: Tally,
}

impl<W> Default for Chains<W> {
    fn default() -> Self {
        Chains { brightness: 0.0, error: 0.0, walks: Vec::new(), tally: Tally::default() }
    }
}

impl<W: Saved> Chains<W> {
    /// That start at some of `seeds`.
    pub fn new(seeds: &Seeds, walks: Vec<W>) -> Chains<W> {
        let Seeds { brightness, error, .. } = *seeds;
        Chains { brightness, error, walks, tally: Tally::default() }
    }

    /// They have moved on, and counted.
    pub fn moved(&mut self, (walks, tally): (Vec<W>, Tally)) {
        self.walks = walks;
        self.tally.add(&tally);
    }

    /// See [`Method::report`](crate::Method::report); the strategies by name.
    pub fn report(&self, strategies: &[&str]) -> Vec<(String, f64)> {
        let mut report = vec![
            ("brightness".into(), self.brightness),
            ("brightness_error".into(), self.error),
            ("chains".into(), self.walks.len() as f64),
        ];
        report.extend(self.tally.report(strategies));
        report
    }

    /// Writes where they are.
    pub fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.walks.save(out)?;
        self.tally.save(out)
    }

    /// Reads it back; as many chains must have been started.
    pub fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        let walks = Vec::<W>::load(from)?;
        if walks.len() != self.walks.len() {
            return Err(io::Error::other("the number of chains differs"));
        }
        self.walks = walks;
        self.tally = Tally::load(from)?;
        Ok(())
    }
}
