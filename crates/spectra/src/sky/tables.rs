//! The tables of `data/hosek_wilkie.bin`; their source, shapes and licence stand beside it.

use std::sync::LazyLock;

/// Spectral channels: 320, 360, ..., 720 nm.
pub(super) const CHANNELS: usize = 11;
/// Points of the Bézier curves over the sun's elevation.
pub(super) const POINTS: usize = 6;
/// Coefficients A..I of a channel of the sky.
pub(super) const COEFFICIENTS: usize = 9;
/// Segments of elevation of the sun's polynomials, and their coefficients.
pub(super) const SEGMENTS: usize = 45;
pub(super) const CUBIC: usize = 4;
/// Coefficients of the limb darkening.
pub(super) const LIMB: usize = 6;
/// Turbidities 1..10 times albedos 0 and 1.
const SKIES: usize = 10 * 2;

/// Coefficients and mean radiances of skies, of `channels` channels.
pub(super) struct SkyTable {
    pub channels: usize,
    coefficients: Vec<f32>,
    radiances: Vec<f32>,
}

impl SkyTable {
    /// Coefficients and mean radiance of a channel: turbidity 1 + `turbidity`, albedo 0 or 1.
    pub fn at(
        &self,
        [turbidity, albedo, point, channel]: [usize; 4],
    ) -> ([f64; COEFFICIENTS], f64) {
        let i = ((turbidity * 2 + albedo) * POINTS + point) * self.channels + channel;
        let coefficient = |k: usize| f64::from(self.coefficients[i * COEFFICIENTS + k]);
        (std::array::from_fn(coefficient), f64::from(self.radiances[i]))
    }
}

pub(super) struct Tables {
    pub spectral: SkyTable,
    pub rgb: SkyTable,
    sun: Vec<f32>,
    limb: Vec<f32>,
}

impl Tables {
    /// The cubic of a segment of elevation.
    pub fn sun(&self, turbidity: usize, segment: usize, channel: usize) -> [f64; CUBIC] {
        let i = ((turbidity * SEGMENTS + segment) * CHANNELS + channel) * CUBIC;
        std::array::from_fn(|k| f64::from(self.sun[i + k]))
    }

    /// The limb darkening of a channel, in powers of cos ψ.
    pub fn limb(&self, channel: usize) -> [f64; LIMB] {
        std::array::from_fn(|k| f64::from(self.limb[channel * LIMB + k]))
    }
}

pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let bytes = include_bytes!("../../data/hosek_wilkie.bin");
    let mut floats = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let mut take = |n: usize| -> Vec<f32> { floats.by_ref().take(n).collect() };
    let mut sky = |channels: usize| {
        let count = SKIES * POINTS * channels;
        SkyTable { channels, coefficients: take(count * COEFFICIENTS), radiances: take(count) }
    };
    let (spectral, rgb) = (sky(CHANNELS), sky(3));
    let sun = take(10 * SEGMENTS * CHANNELS * CUBIC);
    Tables { spectral, rgb, sun, limb: take(CHANNELS * LIMB) }
});
