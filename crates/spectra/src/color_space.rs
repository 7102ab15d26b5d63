//! RGB colour spaces.

use std::sync::OnceLock;

use crate::{DenseSpectrum, Matrix3, illuminant};

/// An RGB colour space: three primaries and a white given by an illuminant.
///
/// The matrices are computed from the primaries' chromaticities and the chromaticity that the
/// illuminant's tabulated spectrum has, not the standard's value rounded to four digits, so that
/// the illuminant itself is exactly (1, 1, 1). They differ from the printed ones by less than
/// 0.0005.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// sRGB and Rec. ITU-R BT.709, white D65.
    #[default]
    Srgb,
    /// DCI-P3 primaries with white D65 ("Display P3").
    DciP3,
    /// Rec. ITU-R BT.2020, white D65.
    Rec2020,
    /// ACES 2065-1 (SMPTE ST 2065-1, "AP0"), white D60.
    Aces2065_1,
}

struct Matrices {
    to_xyz: Matrix3,
    from_xyz: Matrix3,
    to_srgb: Matrix3,
}

impl ColorSpace {
    /// All of them.
    pub const ALL: [ColorSpace; 4] =
        [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020, ColorSpace::Aces2065_1];

    /// Chromaticities (x, y) of red, green and blue.
    pub const fn primaries(self) -> [[f32; 2]; 3] {
        match self {
            ColorSpace::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]],
            ColorSpace::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
            ColorSpace::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            ColorSpace::Aces2065_1 => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770]],
        }
    }

    /// The white's spectrum, normalised to Y = 1: D65 or D60.
    pub fn illuminant(self) -> &'static DenseSpectrum {
        match self {
            ColorSpace::Aces2065_1 => illuminant::d60(),
            _ => illuminant::d65(),
        }
    }

    /// Chromaticity (x, y) of the white.
    pub fn white(self) -> [f32; 2] {
        let [x, y, z] = self.illuminant().xyz();
        [x / (x + y + z), y / (x + y + z)]
    }

    /// XYZ from linear RGB; (1, 1, 1) has Y = 1.
    pub fn to_xyz(self) -> &'static Matrix3 {
        &self.matrices().to_xyz
    }

    /// Linear RGB from XYZ.
    pub fn from_xyz(self) -> &'static Matrix3 {
        &self.matrices().from_xyz
    }

    /// Linear sRGB of a colour of this space. Unclamped: colours outside the sRGB gamut have
    /// negative components. Whites are not adapted.
    #[inline]
    pub fn to_srgb(self, rgb: [f32; 3]) -> [f32; 3] {
        match self {
            ColorSpace::Srgb => rgb,
            _ => self.matrices().to_srgb.apply(rgb),
        }
    }

    fn matrices(self) -> &'static Matrices {
        static MATRICES: [OnceLock<Matrices>; 4] = [const { OnceLock::new() }; 4];
        MATRICES[self as usize].get_or_init(|| {
            // The columns are the primaries' XYZ, scaled so that their sum is the white.
            let p = self.primaries().map(|[x, y]| [x, y, 1.0 - x - y]);
            let unscaled = Matrix3(std::array::from_fn(|i| std::array::from_fn(|j| p[j][i])));
            let invert = |m: &Matrix3| {
                m.inverse().expect("primaries of a colour space do not lie on a line")
            };
            let scale = invert(&unscaled).apply(self.illuminant().xyz());
            let to_xyz = unscaled * Matrix3::diagonal(scale);
            let from_xyz = invert(&to_xyz);
            let to_srgb = match self {
                ColorSpace::Srgb => Matrix3::IDENTITY,
                _ => *ColorSpace::Srgb.from_xyz() * to_xyz,
            };
            Matrices { to_xyz, from_xyz, to_srgb }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f32; 3], b: [f32; 3], tolerance: f32) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn illuminants_are_white() {
        for space in ColorSpace::ALL {
            close(space.from_xyz().apply(space.illuminant().xyz()), [1.0; 3], 2e-6);
        }
        let [x, y] = ColorSpace::Srgb.white();
        assert!((x - 0.3127).abs() < 5e-5 && (y - 0.3290).abs() < 5e-5, "{x} {y}");
    }

    #[test]
    fn round_trips() {
        for space in ColorSpace::ALL {
            let rgb = [0.8, 0.3, 0.1];
            close(space.from_xyz().apply(space.to_xyz().apply(rgb)), rgb, 1e-6);
        }
    }

    #[test]
    fn printed_matrices() {
        let srgb = ColorSpace::Srgb.to_xyz().0;
        close(srgb[0], [0.4124, 0.3576, 0.1805], 3e-4);
        close(srgb[1], [0.2126, 0.7152, 0.0722], 1e-4);
        close(srgb[2], [0.0193, 0.1192, 0.9505], 5e-4);
        close(ColorSpace::Rec2020.to_xyz().0[1], [0.2627, 0.6780, 0.0593], 2e-4);
        close(ColorSpace::Aces2065_1.to_xyz().0[1], [0.3440, 0.7282, -0.0721], 3e-4);
    }

    #[test]
    fn wide_primaries_leave_srgb() {
        let g = ColorSpace::Rec2020.to_srgb([0.0, 1.0, 0.0]);
        assert!(g[0] < -0.5 && g[1] > 1.0, "{g:?}");
        close(ColorSpace::DciP3.to_srgb([1.0; 3]), [1.0; 3], 1e-5);
    }
}
