//! Texels of an environment in the order in which a lookup finds its neighbours close by.

use crate::texture::ImageMap;

/// Texels along a side of a page of 4 KiB: 32 × 16.
const PAGE: [usize; 2] = [32, 16];
/// Texels of a cache line along each side.
const LINE: [usize; 2] = [4, 2];

/// Texels of four half floats, eight neighbours in each cache line, 32 × 16 in each page of
/// memory: a bilinear lookup of a map beyond the caches waits for two lines and one page, not
/// for four rows far from each other.
///
/// A half has 11 bits, as most files of environments have; here the brightest texel has the
/// greatest exponent, so that the darkest that keeps them is 2²⁸ times darker.
#[derive(Debug)]
pub(super) struct Texels {
    size: [usize; 2],
    pages: usize,
    lines: Vec<Line>,
    /// What halves are multiplied by: for colours, and for the fourth number.
    scale: [f32; 2],
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Line([[u16; 4]; 8]);

/// 2¹¹², between the exponents of floats and of halves.
const BIAS: f32 = f32::from_bits((112 + 127) << 23);

/// The value of a half that is not negative.
#[inline]
fn float(half: u16) -> f32 {
    f32::from_bits(u32::from(half) << 13) * BIAS
}

/// The half nearest to a number in [0, 2¹⁵].
fn half(float: f32) -> u16 {
    (((float / BIAS).to_bits() + (1 << 12)) >> 13) as u16
}

/// The power of two by which `most` is divided to lie in [2¹⁴, 2¹⁵).
fn scale_for(most: f32) -> f32 {
    if most > 0.0 { (most.log2().floor() - 14.0).clamp(-126.0, 127.0).exp2() } else { 1.0 }
}

impl Texels {
    /// The texels of an image, each with a fourth number of its own, told by column, row and
    /// colour; none is negative.
    pub fn new(image: &ImageMap, fourth: impl Fn(u32, u32, [f32; 3]) -> f32) -> Texels {
        let size = [image.width as usize, image.height as usize];
        let pages = [0, 1].map(|k| size[k].div_ceil(PAGE[k]));
        let count = pages[0] * pages[1] * PAGE[0] * PAGE[1] / 8;
        let lines = vec![Line([[0; 4]; 8]); count];
        let all = || {
            (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y))).map(|(x, y)| {
                let rgb = image.texel(x, y);
                (x, y, rgb, fourth(x, y, rgb))
            })
        };
        let most = all()
            .fold([0.0f32; 2], |[a, b], (_, _, [r, g, c], f)| [a.max(r).max(g).max(c), b.max(f)]);
        let scale = most.map(scale_for);
        let mut texels = Texels { size, pages: pages[0], lines, scale };
        for (x, y, [r, g, b], f) in all() {
            let (line, i) = texels.place(x as usize, y as usize);
            let [k, of_fourth] = scale;
            texels.lines[line].0[i] = [half(r / k), half(g / k), half(b / k), half(f / of_fourth)];
        }
        texels
    }

    /// Columns and rows.
    #[inline]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// R, G, B and the fourth number of a texel within the image.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> [f32; 4] {
        let (line, i) = self.place(x, y);
        let [k, of_fourth] = self.scale;
        let [r, g, b, f] = self.lines[line].0[i].map(float);
        [r * k, g * k, b * k, f * of_fourth]
    }

    #[inline]
    fn place(&self, x: usize, y: usize) -> (usize, usize) {
        let page = y / PAGE[1] * self.pages + x / PAGE[0];
        let (i, j) = (x % PAGE[0], y % PAGE[1]);
        let line = j / LINE[1] * (PAGE[0] / LINE[0]) + i / LINE[0];
        (page * (PAGE[0] * PAGE[1] / 8) + line, j % LINE[1] * LINE[0] + i % LINE[0])
    }
}

/// Bilinear blend of the corners (0, 0), (1, 0), (0, 1), (1, 1), the first three numbers.
#[inline]
pub(super) fn blend(c: &[[f32; 4]; 4], fx: f32, fy: f32) -> [f32; 3] {
    std::array::from_fn(|i| {
        (c[0][i] * (1.0 - fx) + c[1][i] * fx) * (1.0 - fy)
            + (c[2][i] * (1.0 - fx) + c[3][i] * fx) * fy
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_texel_is_where_it_is_looked_for() {
        let (width, height) = (37, 18);
        let texels = (0..width * height).map(|k| [k as f32, 1.0, 2.0]).collect();
        let image = ImageMap { width, height, texels };
        let stored = Texels::new(&image, |x, y, _| (x + 64 * y) as f32);
        assert_eq!(stored.size(), [37, 18]);
        for y in 0..18 {
            for x in 0..37 {
                // Whole numbers up to 2048 are halves.
                let (k, fourth) = ((37 * y + x) as f32, (x + 64 * y) as f32);
                assert_eq!(stored.get(x, y), [k, 1.0, 2.0, fourth]);
            }
        }
    }

    #[test]
    fn halves_keep_11_bits_of_bright_and_dark() {
        for most in [1e-20f32, 0.3, 1.0, 65504.0, 1e6, 1e20] {
            let texels = (0..38).map(|k| [most * 0.6f32.powi(k), 0.0, 0.0]).collect();
            let image = ImageMap { width: 38, height: 1, texels };
            let stored = Texels::new(&image, |_, _, _| 0.0);
            for k in 0..38 {
                let (found, given) = (stored.get(k, 0)[0], image.texel(k as u32, 0)[0]);
                assert!((found / given - 1.0).abs() <= 1.0 / 2048.0, "{found} {given}");
            }
        }
    }
}
