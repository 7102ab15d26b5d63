//! The sRGB transfer curve (IEC 61966-2-1:1999).

use std::sync::LazyLock;

/// Stored value in [0, 1] to linear; negative values are mirrored, values above 1 extrapolated.
pub fn srgb_to_linear(v: f32) -> f32 {
    let a = v.abs();
    let l = if a <= 0.04045 { a / 12.92 } else { ((a + 0.055) / 1.055).powf(2.4) };
    l.copysign(v)
}

/// Linear value to the stored one; negative values are mirrored, values above 1 extrapolated.
pub fn linear_to_srgb(v: f32) -> f32 {
    let a = v.abs();
    let s = if a <= 0.003_130_8 { 12.92 * a } else { 1.055 * a.powf(1.0 / 2.4) - 0.055 };
    s.copysign(v)
}

/// An 8-bit stored value to linear, by table.
#[inline]
pub fn srgb8_to_linear(v: u8) -> f32 {
    static LINEAR: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));
    LINEAR[v as usize]
}

/// A linear value to the nearest 8-bit stored one; clamped to [0, 1], NaN becomes 0.
#[inline]
pub fn linear_to_srgb8(v: f32) -> u8 {
    // The cast saturates and sends NaN to 0.
    (linear_to_srgb(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trips() {
        for i in 0..=255u8 {
            assert_eq!(linear_to_srgb8(srgb8_to_linear(i)), i);
        }
        for i in -100..=300 {
            let v = i as f32 / 100.0;
            assert!((srgb_to_linear(linear_to_srgb(v)) - v).abs() < 1e-5, "{v}");
        }
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1e-6);
        assert_eq!([f32::NAN, -1.0, 2.0].map(linear_to_srgb8), [0, 0, 255]);
    }
}
