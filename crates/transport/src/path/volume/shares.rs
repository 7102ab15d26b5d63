//! How the lanes of a spectrum share a path: s and ℓ of (4).

use super::super::walk::{Previous, Walk};
use kaustika_sampling::hash::{combine, nth, unit};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// The shares of the lanes in a path's density.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    /// s: each lane's density of the path so far over their mean.
    pub(super) camera: Spectrum,
    /// ℓ: that of making the way since the last vertex by light sampling.
    pub(super) light: Spectrum,
    /// The lane that chooses.
    pub(super) hero: usize,
    live: Live,
    /// What lane 0 has found, had it been alone from the start.
    alone: f32,
}

/// Which lanes count.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Live {
    /// r, g, b.
    Rgb,
    /// Four wavelengths.
    Four,
    /// The first, since the path was dispersed.
    One,
}

impl Shares {
    /// Of a path that begins; `u` in [0, 1) chooses the hero.
    pub(super) fn new(lambda: &Wavelengths, u: f32) -> Shares {
        // Wavelengths are drawn so that each lane is as likely to be any of them.
        let (hero, live) = match lambda.mode {
            ColorMode::Rgb => (((3.0 * u) as usize).min(2), Live::Rgb),
            ColorMode::Spectral => (0, Live::Four),
        };
        Shares { camera: Spectrum::ONE, light: Spectrum::ONE, hero, live, alone: 0.0 }
    }

    /// ⟨v⟩.
    #[inline]
    pub(super) fn mean(&self, v: Spectrum) -> f32 {
        match self.live {
            Live::Rgb => (v[0] + v[1] + v[2]) * (1.0 / 3.0),
            Live::Four => v.average(),
            Live::One => v[0],
        }
    }

    /// An event of density `p` and value `f`, which shadow rays have with density `q`.
    #[inline]
    pub(super) fn event(&mut self, beta: &mut Spectrum, f: Spectrum, p: Spectrum, q: Spectrum) {
        let mean = self.mean(self.camera * p);
        let k = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        *beta *= f * k; // (4)
        self.camera *= p * k;
        self.light *= q * k;
    }

    /// A choice of probability `p` that shadow rays need not make; β knows of it already.
    pub(super) fn pass_with(&mut self, p: f32) {
        self.light *= 1.0 / p;
    }

    /// A vertex: light sampling begins anew.
    pub(super) fn turn(&mut self) {
        self.light = self.camera;
    }

    /// The previous vertex with the density that gives (5).
    pub(super) fn seen_from(&self, previous: &Previous) -> Previous {
        Previous { pdf_w: previous.pdf_w / self.mean(self.light), ..*previous }
    }

    /// Adds what a path has found.
    #[inline]
    pub(super) fn add(&mut self, walk: &mut Walk, found: Spectrum) {
        self.add_by(walk, found, self.camera);
    }

    /// Adds what was found in another way, in which the lanes have these shares.
    #[inline]
    pub(super) fn add_by(&mut self, walk: &mut Walk, found: Spectrum, shares: Spectrum) {
        walk.radiance += found;
        if found[0] > 0.0 && shares[0] > 0.0 {
            self.alone += found[0] / shares[0];
        }
    }

    /// After a surface: if it has ended the secondary wavelengths, lane 0 is alone from now on.
    /// The other lanes can't make up any more for the share that they took.
    #[inline]
    pub(super) fn follow(&mut self, walk: &mut Walk) {
        if self.live == Live::Four && walk.lambda.secondary_terminated() {
            let k = 1.0 / self.camera[0];
            walk.beta *= k;
            self.light *= k;
            self.camera = Spectrum::ONE;
            self.live = Live::One;
        }
    }

    /// At the path's end.
    pub(super) fn settle(&self, walk: &mut Walk) {
        if self.live == Live::One {
            walk.radiance = Spectrum([self.alone, 0.0, 0.0, 0.0]);
        }
    }
}

/// Numbers in [0, 1) that depend on a few others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stream {
    key: u64,
    drawn: u32,
}

impl Stream {
    /// The stream that belongs to these numbers.
    pub(super) fn new(numbers: &[f32]) -> Stream {
        let key = numbers.iter().fold(0, |key, u| combine(key, u64::from(u.to_bits())));
        Stream { key, drawn: 0 }
    }

    /// The next.
    #[inline]
    pub(super) fn next(&mut self) -> f32 {
        self.drawn = self.drawn.wrapping_add(1);
        unit((nth(self.key, self.drawn) >> 32) as u32)
    }

    /// An optical distance with density e⁻ˣ.
    #[inline]
    pub(super) fn distance(&mut self) -> f32 {
        optical_distance(self.next())
    }
}

/// The optical distance that `u` stands for, with density e⁻ˣ.
#[inline]
pub(super) fn optical_distance(u: f32) -> f32 {
    -(-u).ln_1p()
}
