//! The sRGB transfer curve (IEC 61966-2-1).
// To be replaced by kaustika_spectra's when that crate has it.

/// Linear value in [0, 1] to sRGB code in [0, 1].
pub(crate) fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB code in [0, 1] to linear value in [0, 1].
pub(crate) fn decode(code: f32) -> f32 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_directions_are_inverse_at_all_eight_bit_codes() {
        for code in 0..=255u8 {
            let back = encode(decode(code as f32 / 255.0)) * 255.0;
            assert!((back - code as f32).abs() < 1e-3, "{code}: {back}");
        }
        assert!((decode(0.5) - 0.214_041).abs() < 1e-6);
    }
}
