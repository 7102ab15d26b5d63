//! Tone curves: from scene-referred linear sRGB to what a display shows.

use crate::photometry::rec709_luminance;
use crate::{linear_to_srgb, linear_to_srgb8};

/// A curve from linear sRGB in [0, ∞) to display-linear sRGB in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tonemap {
    /// Values above 1 are cut off.
    #[default]
    Clamp,
    /// c / (1 + Y) with the colour's luminance Y (Reinhard et al. 2002, "Photographic Tone
    /// Reproduction for Digital Images", eq. 3), then cut off at 1.
    Reinhard,
    /// Stephen Hill's fit of the ACES 1.0 reference rendering and output transforms (2016, the
    /// BakingLab sources), desaturating highlights as ACES does.
    AcesHill,
    /// Krzysztof Narkowicz's fit of the ACES curve, each component on its own (2016, "ACES Filmic
    /// Tone Mapping Curve"), with his exposure of 0.6.
    AcesNarkowicz,
    /// AgX (Troy Sobotka 2022), in Benjamin Wrensch's polynomial fit of the base look (2023,
    /// "Minimal AgX Implementation").
    Agx,
    /// John Hable's curve for Uncharted 2 (2010, "Filmic Tonemapping Operators"), white at 11.2.
    Filmic,
}

impl Tonemap {
    /// All names that [`Tonemap::by_name`] knows, each with its curve.
    pub const NAMES: [(&'static str, Tonemap); 9] = [
        ("none", Tonemap::Clamp),
        ("clamp", Tonemap::Clamp),
        ("reinhard", Tonemap::Reinhard),
        ("aces", Tonemap::AcesHill),
        ("aces-hill", Tonemap::AcesHill),
        ("aces-narkowicz", Tonemap::AcesNarkowicz),
        ("agx", Tonemap::Agx),
        ("filmic", Tonemap::Filmic),
        ("hable", Tonemap::Filmic),
    ];

    /// The curve of this name, case ignored.
    pub fn by_name(name: &str) -> Option<Tonemap> {
        Tonemap::NAMES.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, t)| t)
    }

    /// Display-linear sRGB in [0, 1] of a linear sRGB colour multiplied by 2^`exposure`. Negative
    /// components and NaN count as 0, infinite ones as very bright.
    pub fn apply(self, rgb: [f32; 3], exposure: f32) -> [f32; 3] {
        // Beyond 1e6 all curves are flat; the bound keeps their polynomials finite.
        let scale = exposure.exp2();
        let rgb = rgb.map(|v| if v > 0.0 { (v * scale).min(1e6) } else { 0.0 });
        let out = match self {
            Tonemap::Clamp => rgb,
            Tonemap::Reinhard => {
                let y = rec709_luminance(rgb);
                rgb.map(|v| v / (1.0 + y))
            }
            Tonemap::AcesHill => aces_hill(rgb),
            Tonemap::AcesNarkowicz => rgb.map(|v| aces_narkowicz(0.6 * v)),
            Tonemap::Agx => agx(rgb),
            Tonemap::Filmic => rgb.map(|v| hable(2.0 * v) / hable(11.2)),
        };
        out.map(|v| v.clamp(0.0, 1.0))
    }

    /// `apply`, then the sRGB curve: values in [0, 1] to store.
    pub fn encode(self, rgb: [f32; 3], exposure: f32) -> [f32; 3] {
        self.apply(rgb, exposure).map(linear_to_srgb)
    }

    /// `apply`, then the sRGB curve in 8 bits.
    pub fn encode8(self, rgb: [f32; 3], exposure: f32) -> [u8; 3] {
        self.apply(rgb, exposure).map(linear_to_srgb8)
    }
}

fn mul(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// (v (v + a) - b) / (v (c v + d) + e) between two matrices.
fn aces_hill(rgb: [f32; 3]) -> [f32; 3] {
    // sRGB to the renderer's space with its desaturation, and back.
    const INPUT: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUTPUT: [[f32; 3]; 3] = [
        [1.60475, -0.53108, -0.07367],
        [-0.10208, 1.10813, -0.00605],
        [-0.00327, -0.07276, 1.07602],
    ];
    let v = mul(&INPUT, rgb).map(|v| {
        (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081)
    });
    mul(&OUTPUT, v)
}

fn aces_narkowicz(v: f32) -> f32 {
    (v * (2.51 * v + 0.03)) / (v * (2.43 * v + 0.59) + 0.14)
}

/// ((x (A x + C B) + D E) / (x (A x + B) + D F)) - E/F.
fn hable(x: f32) -> f32 {
    const A: f32 = 0.15;
    const B: f32 = 0.50;
    const C: f32 = 0.10;
    const D: f32 = 0.20;
    const E: f32 = 0.02;
    const F: f32 = 0.30;
    (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F
}

/// Inset matrix, log₂ between two exposures, a sigmoid of degree 6, outset matrix, and the
/// display's 2.2 gamma undone.
fn agx(rgb: [f32; 3]) -> [f32; 3] {
    const INSET: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_142_97],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_745],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_635, -0.098_043_45, 1.151_073_7],
    ];
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    let v = mul(&INSET, rgb).map(|v| {
        let ev = v.max(1e-10).log2().clamp(MIN_EV, MAX_EV);
        let x = (ev - MIN_EV) / (MAX_EV - MIN_EV);
        let curve = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
        curve.iter().fold(0.0, |sum, c| sum * x + c)
    });
    mul(&OUTSET, v).map(|v| v.max(0.0).powf(2.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Tonemap; 6] = [
        Tonemap::Clamp,
        Tonemap::Reinhard,
        Tonemap::AcesHill,
        Tonemap::AcesNarkowicz,
        Tonemap::Agx,
        Tonemap::Filmic,
    ];

    #[test]
    fn greys_rise_from_black_to_white() {
        for t in ALL {
            let mut before = -1.0;
            for i in 0..400 {
                let v = (i as f32 * 0.05 - 14.0).exp2();
                let [r, g, b] = t.apply([v; 3], 0.0);
                assert!((r - g).abs() < 2e-3 && (g - b).abs() < 2e-3, "{t:?} {v}: {r} {g} {b}");
                assert!(g >= before - 1e-4, "{t:?} falls at {v}");
                before = g;
            }
            assert!(before > 0.95, "{t:?} {before}");
            assert!(t.apply([0.0; 3], 0.0)[0] < 1e-3, "{t:?}");
        }
    }

    #[test]
    fn strange_values_stay_in_range() {
        for t in ALL {
            for rgb in [
                [f32::NAN, 0.5, 0.5],
                [f32::INFINITY, 0.0, 0.0],
                [-5.0, 2.0, 1e30],
                [0.0, 0.0, 1e4],
                [1e-30; 3],
            ] {
                let out = t.apply(rgb, 1.0);
                assert!(out.iter().all(|v| (0.0..=1.0).contains(v)), "{t:?} {rgb:?} {out:?}");
            }
        }
    }

    #[test]
    fn known_points() {
        let g = |t: Tonemap, v: f32| t.apply([v; 3], 0.0)[1];
        assert!((g(Tonemap::Reinhard, 1.0) - 0.5).abs() < 1e-6);
        // Narkowicz at 0.6·1: (0.6·1.536)/(0.6·2.048 + 0.14).
        assert!((g(Tonemap::AcesNarkowicz, 1.0) - 0.673_260).abs() < 1e-4);
        assert!((g(Tonemap::Filmic, 5.6) - 1.0).abs() < 1e-6);
        // AgX puts middle grey near the display's middle grey.
        assert!((linear_to_srgb(g(Tonemap::Agx, 0.18)) - 0.46).abs() < 0.05);
        assert_eq!(Tonemap::Clamp.apply([0.25, 0.5, 3.0], 1.0), [0.5, 1.0, 1.0]);
        assert_eq!(Tonemap::Clamp.encode8([1.0, 0.0, 0.214_041_14], 0.0), [255, 0, 128]);
        assert_eq!(Tonemap::by_name("ACES"), Some(Tonemap::AcesHill));
        assert_eq!(Tonemap::by_name("sepia"), None);
    }
}
