//! The names of the samplers.

use std::fmt;
use std::str::FromStr;

/// Which point set the numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Pseudo-random numbers (xoroshiro128++): the baseline, error N^(-1/2) always.
    Independent,
    /// Multi-jittered cells (Chiu et al. 1994) over the planned number of samples.
    Stratified,
    /// Halton's sequence with random digit permutations, rotated per pixel (Halton 1960,
    /// Braaten & Weller 1979, Cranley & Patterson 1976); random beyond 64 dimensions.
    Halton,
    /// Owen-scrambled Sobol points in shuffled groups of four dimensions (Burley 2020).
    #[default]
    Sobol,
    /// Owen-scrambled Sobol points along a shuffled Z-order curve through the pixels (Ahmed &
    /// Wonka 2020): as good as `Sobol` in each pixel, and the error looks like blue noise.
    ZSobol,
    /// Tables of progressive multi-jittered (0,2) points (Christensen et al. 2018), each pixel
    /// and dimension with a digital shift and shuffle of its own. See `pmj02.rs` for what the
    /// tables are; they carry no blue noise, which pbrt's `pmj02bn` does.
    Pmj02,
}

impl SamplerKind {
    /// All kinds, in the order of the documentation.
    pub const ALL: [SamplerKind; 6] = [
        SamplerKind::Independent,
        SamplerKind::Stratified,
        SamplerKind::Halton,
        SamplerKind::Sobol,
        SamplerKind::ZSobol,
        SamplerKind::Pmj02,
    ];

    /// The name in scene files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            SamplerKind::Independent => "independent",
            SamplerKind::Stratified => "stratified",
            SamplerKind::Halton => "halton",
            SamplerKind::Sobol => "sobol",
            SamplerKind::ZSobol => "zsobol",
            SamplerKind::Pmj02 => "pmj02",
        }
    }
}

impl fmt::Display for SamplerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no sampler's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownSampler(pub String);

impl fmt::Display for UnknownSampler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown sampler \"{}\"; known are ", self.0)?;
        for (i, kind) in SamplerKind::ALL.iter().enumerate() {
            write!(f, "{}{kind}", if i > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for UnknownSampler {}

impl FromStr for SamplerKind {
    type Err = UnknownSampler;

    /// Names as [`SamplerKind::name`] gives them; pbrt's `pmj02bn` is taken for `pmj02`.
    fn from_str(s: &str) -> Result<Self, UnknownSampler> {
        if s == "pmj02bn" {
            return Ok(SamplerKind::Pmj02);
        }
        SamplerKind::ALL
            .into_iter()
            .find(|kind| kind.name() == s)
            .ok_or_else(|| UnknownSampler(s.to_owned()))
    }
}
