//! Images that textures and environment lights look up.

/// Rows of texels, row 0 at the top, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// 1 (grey), 2 (grey, alpha), 3 (r, g, b) or 4 (r, g, b, alpha).
    pub channels: u32,
    /// `width * height * channels` numbers.
    pub texels: Texels,
    /// How the stored numbers relate to linear values. Alpha is always linear.
    pub encoding: Encoding,
}

/// Texels as the file stores them: 8-bit images stay 8-bit in memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 0..=255 stands for 0..=1.
    U8(Vec<u8>),
    /// 0..=65535 stands for 0..=1.
    U16(Vec<u16>),
    /// Values as they are.
    F32(Vec<f32>),
}

/// Transfer curve of stored texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// Stored numbers are the values.
    Linear,
    /// The sRGB curve.
    Srgb,
    /// value = stored^gamma.
    Gamma(f32),
}
