//! Plain linear RGB images for lights: environments, projections, goniometric diagrams.

use super::bitmap::linear_rgb;
use crate::description::Bitmap;
use kaustika_math::Vec2;
use kaustika_spectra::ColorSpace;

/// Linear sRGB texels, row 0 at the top, looked up with y running down.
#[derive(Debug)]
pub struct ImageMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Texels.
    pub texels: Vec<[f32; 3]>,
}

impl ImageMap {
    /// Decodes a bitmap with colours in `space`. Values that are negative or not finite become 0.
    pub fn new(bitmap: &Bitmap, space: ColorSpace) -> ImageMap {
        let mut texels = linear_rgb(bitmap);
        for t in &mut texels {
            *t = space.to_srgb(*t).map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 });
        }
        ImageMap { width: bitmap.width, height: bitmap.height, texels }
    }

    /// Texel by column and row, both within the image.
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 3] {
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// Bilinear between texel centres, borders clamped.
    pub fn bilinear(&self, p: Vec2) -> [f32; 3] {
        let (x, y) = (p.x * self.width as f32 - 0.5, p.y * self.height as f32 - 0.5);
        let clamp = |v: f32, n: u32| v.clamp(0.0, (n - 1) as f32);
        let at = |dx: f32, dy: f32| {
            self.texel(
                clamp(x.floor() + dx, self.width) as u32,
                clamp(y.floor() + dy, self.height) as u32,
            )
        };
        blend(
            [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)],
            x - x.floor(),
            y - y.floor(),
        )
    }

    /// Mean over texels and channels.
    pub fn mean(&self) -> f32 {
        let sum: f64 = self.texels.iter().flatten().map(|&v| v as f64).sum();
        (sum / (3 * self.texels.len()) as f64) as f32
    }
}

/// Bilinear blend of the corners (0,0), (1,0), (0,1), (1,1).
#[inline]
fn blend(c: [[f32; 3]; 4], fx: f32, fy: f32) -> [f32; 3] {
    std::array::from_fn(|i| {
        (c[0][i] * (1.0 - fx) + c[1][i] * fx) * (1.0 - fy)
            + (c[2][i] * (1.0 - fx) + c[3][i] * fx) * fy
    })
}
