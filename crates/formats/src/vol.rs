//! Mitsuba's `.vol` files: samples on a grid.
//!
//! ```text
//! "VOL"  u8 version 3  i32 encoding  i32 x, y, z  i32 channels  f32 box min, max  samples
//! ```
//!
//! Little-endian; x fastest, the channels of a sample side by side. Encoding 1 is f32; 0.6 also
//! wrote 3, bytes from 0 to 1. From the documentation of the plugin `gridvolume`.

use kaustika_math::{Bounds3, Vec3};
use std::path::Path;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VolFile {
    pub(crate) resolution: [u32; 3],
    /// 1, 3 or 6.
    pub(crate) channels: u32,
    pub(crate) values: Vec<f32>,
    /// The box that the samples fill.
    pub(crate) bounds: Bounds3,
}

const HEADER: usize = 48;

/// What the samples stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Samples {
    /// Amounts of something, none negative.
    Amounts,
    /// Signed distances.
    Distances,
}

/// Reads a file. An error is a one-line cause.
pub(crate) fn read(path: &Path, samples: Samples) -> Result<VolFile, String> {
    parse(&std::fs::read(path).map_err(|e| e.to_string())?, samples)
}

fn parse(bytes: &[u8], kind: Samples) -> Result<VolFile, String> {
    if !bytes.starts_with(b"VOL") {
        return Err("not a volume: it does not begin with `VOL`".into());
    }
    if bytes.len() < HEADER {
        return Err(format!("it ends within the header, after {} bytes", bytes.len()));
    }
    if bytes[3] != 3 {
        return Err(format!("version {} of the format is not known, only 3", bytes[3]));
    }
    let word = |i: usize| -> [u8; 4] { std::array::from_fn(|k| bytes[4 + 4 * i + k]) };
    let int = |i: usize| i32::from_le_bytes(word(i));
    let float = |i: usize| f32::from_le_bytes(word(i));
    let size = match int(0) {
        1 => 4,
        3 => 1,
        other => {
            return Err(format!(
                "samples of encoding {other} are not supported, only 1 (f32) and 3 (bytes)"
            ));
        }
    };
    let resolution = [int(1), int(2), int(3)];
    if resolution.iter().any(|n| *n < 1) {
        let [x, y, z] = resolution;
        return Err(format!("a resolution of {x} x {y} x {z} is no grid"));
    }
    let resolution = resolution.map(|n| n as u32);
    let channels = int(4);
    if ![1, 3, 6].contains(&channels) {
        return Err(format!("{channels} channels are not supported, only 1, 3 and 6"));
    }
    // Three 31-bit numbers and a small one: no overflow in 128 bits.
    let count = resolution.iter().map(|n| u128::from(*n)).product::<u128>() * channels as u128;
    let (expected, found) = (count * size as u128, (bytes.len() - HEADER) as u128);
    if expected > found {
        return Err(format!("it has {found} bytes of samples where {expected} are announced"));
    }
    let samples = &bytes[HEADER..HEADER + expected as usize];
    let values: Vec<f32> = match size {
        4 => {
            samples.chunks_exact(4).map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect()
        }
        _ => samples.iter().map(|b| f32::from(*b) / 255.0).collect(),
    };
    // Microflakes have covariances among their six numbers.
    let (least, wanted) = match kind {
        Samples::Amounts if channels == 6 => (f32::MIN, "no number"),
        Samples::Amounts => (0.0, "neither zero nor a positive number"),
        Samples::Distances => (f32::MIN, "no number"),
    };
    if let Some(i) = values.iter().position(|v| !v.is_finite() || *v < least) {
        return Err(format!("sample {i} is {}: {wanted}", values[i]));
    }
    let corner = |i| Vec3::new(float(i), float(i + 1), float(i + 2));
    let bounds = Bounds3 { min: corner(5), max: corner(8) };
    if !bounds.min.is_finite() || !bounds.max.is_finite() || bounds.is_empty() {
        return Err("its box has no extent".into());
    }
    Ok(VolFile { resolution, channels: channels as u32, values, bounds })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(encoding: i32, resolution: [i32; 3], channels: i32, samples: &[u8]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for i in [encoding, resolution[0], resolution[1], resolution[2], channels] {
            bytes.extend(i.to_le_bytes());
        }
        for f in [0.0f32, 0.0, -1.0, 1.0, 2.0, 3.0] {
            bytes.extend(f.to_le_bytes());
        }
        bytes.extend(samples);
        bytes
    }

    #[test]
    fn floats_and_bytes() {
        let samples: Vec<u8> = [0.5f32, 2.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let vol = parse(&file(1, [2, 1, 1], 1, &samples), Samples::Amounts).expect("a volume");
        assert_eq!(
            (vol.resolution, vol.channels, vol.values.as_slice()),
            ([2, 1, 1], 1, &[0.5, 2.0][..])
        );
        assert_eq!(vol.bounds.max, Vec3::new(1.0, 2.0, 3.0));
        let vol = parse(&file(3, [1, 1, 1], 3, &[0, 255, 51]), Samples::Amounts).expect("a volume");
        assert_eq!(vol.values, [0.0, 1.0, 0.2]);
    }

    #[test]
    fn damaged_files_say_why() {
        let why = |bytes: &[u8]| parse(bytes, Samples::Amounts).expect_err("must be refused");
        assert_eq!(why(b"PNG"), "not a volume: it does not begin with `VOL`");
        assert_eq!(why(b"VOL\x03"), "it ends within the header, after 4 bytes");
        assert_eq!(
            why(&file(2, [1; 3], 1, &[])),
            "samples of encoding 2 are not supported, only 1 (f32) and 3 (bytes)"
        );
        assert_eq!(why(&file(1, [0, 1, 1], 1, &[])), "a resolution of 0 x 1 x 1 is no grid");
        assert_eq!(why(&file(1, [1; 3], 2, &[])), "2 channels are not supported, only 1, 3 and 6");
        let huge = [i32::MAX; 3];
        assert!(why(&file(1, huge, 3, &[])).ends_with("are announced"));
        let nan = f32::NAN.to_le_bytes();
        assert_eq!(
            why(&file(1, [1; 3], 1, &nan)),
            "sample 0 is NaN: neither zero nor a positive number"
        );
        let below = file(1, [1; 3], 1, &(-0.5f32).to_le_bytes());
        assert_eq!(why(&below), "sample 0 is -0.5: neither zero nor a positive number");
        assert_eq!(parse(&below, Samples::Distances).expect("distances").values, [-0.5]);
        // Every shorter file and every flipped byte is refused or read, without a panic.
        let whole = file(3, [2, 2, 1], 1, &[1, 2, 3, 4]);
        for end in 0..whole.len() {
            assert!(parse(&whole[..end], Samples::Amounts).is_err());
        }
        for i in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[i] ^= 0xff;
            let _ = parse(&bytes, Samples::Amounts);
        }
    }
}
