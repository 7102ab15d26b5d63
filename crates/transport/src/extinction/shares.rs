//! How the lanes of a spectrum share a path: s and ℓ of (4).

use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// The shares of the lanes in a path's density.
#[derive(Clone, Copy, Debug)]
pub struct Shares {
    /// s: each lane's density of the path so far over their mean.
    pub path: Spectrum,
    /// ℓ: that of making the way since the last vertex by the other technique.
    pub other: Spectrum,
    /// The lane that chooses.
    pub hero: usize,
    live: Live,
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
    /// Of a path that begins; `u` in [0, 1) chooses the hero among r, g, b. Of four wavelengths
    /// it is the first: they are drawn so that each lane is as likely to be any of them.
    pub fn new(lambda: &Wavelengths, u: f32) -> Shares {
        match lambda.mode {
            ColorMode::Rgb => Shares::with(((3.0 * u) as usize).min(2), Live::Rgb),
            ColorMode::Spectral => Shares::with(0, Live::Four),
        }
    }

    /// Of a part of a path whose other parts have heroes of their own, at wavelengths that may
    /// have been ended before.
    pub fn independent(lambda: &Wavelengths, u: f32) -> Shares {
        match lambda.mode {
            ColorMode::Rgb => Shares::new(lambda, u),
            ColorMode::Spectral if lambda.secondary_terminated() => Shares::with(0, Live::One),
            ColorMode::Spectral => Shares::with(((4.0 * u) as usize).min(3), Live::Four),
        }
    }

    fn with(hero: usize, live: Live) -> Shares {
        Shares { path: Spectrum::ONE, other: Spectrum::ONE, hero, live }
    }

    /// ⟨v⟩.
    #[inline]
    pub fn mean(&self, v: Spectrum) -> f32 {
        match self.live {
            Live::Rgb => (v[0] + v[1] + v[2]) * (1.0 / 3.0),
            Live::Four => v.average(),
            Live::One => v[0],
        }
    }

    /// An event of density `p` and value `f`, which the other technique has with density `q`.
    #[inline]
    pub fn event(&mut self, beta: &mut Spectrum, f: Spectrum, p: Spectrum, q: Spectrum) {
        let mean = self.mean(self.path * p);
        let k = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        *beta *= f * k; // (4)
        self.path *= p * k;
        self.other *= q * k;
    }

    /// A vertex: the other technique begins anew.
    pub fn turn(&mut self) {
        self.other = self.path;
    }

    /// True if the secondary wavelengths were ended, `lambda` says, and count here no more from
    /// now on: what the shares were is the caller's to make up for.
    #[inline]
    pub fn end_secondary(&mut self, lambda: &Wavelengths) -> bool {
        let ends = self.live == Live::Four && lambda.secondary_terminated();
        if ends {
            self.path = Spectrum::ONE;
            self.live = Live::One;
            self.hero = 0;
        }
        ends
    }

    /// True if only the first of four wavelengths counts.
    #[inline]
    pub fn alone(&self) -> bool {
        self.live == Live::One
    }
}
