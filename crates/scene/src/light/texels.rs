//! Texels of an environment in the order in which a lookup finds its neighbours close by.

use crate::texture::ImageMap;

/// Texels along a side of a page of 4 KiB.
const PAGE: usize = 16;

/// Texels of 16 bytes, four of a square in each cache line, 16 × 16 in each page of memory: a
/// bilinear lookup of a map beyond the caches waits for two lines and one page, not for four
/// rows far from each other.
#[derive(Debug)]
pub(super) struct Texels {
    size: [usize; 2],
    pages: usize,
    quads: Vec<Quad>,
}

/// Texels (0, 0), (1, 0), (0, 1), (1, 1) of a square.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Quad([[f32; 4]; 4]);

impl Texels {
    /// The texels of an image, each with a fourth number of its own, told by column, row and
    /// colour.
    pub fn new(image: &ImageMap, fourth: impl Fn(u32, u32, [f32; 3]) -> f32) -> Texels {
        let size = [image.width as usize, image.height as usize];
        let pages = size.map(|n| n.div_ceil(PAGE));
        let count = pages[0] * pages[1] * PAGE * PAGE / 4;
        let mut texels = Texels { size, pages: pages[0], quads: vec![Quad([[0.0; 4]; 4]); count] };
        for y in 0..image.height {
            for x in 0..image.width {
                let rgb @ [r, g, b] = image.texel(x, y);
                let (quad, i) = texels.place(x as usize, y as usize);
                texels.quads[quad].0[i] = [r, g, b, fourth(x, y, rgb)];
            }
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
        let (quad, i) = self.place(x, y);
        self.quads[quad].0[i]
    }

    #[inline]
    fn place(&self, x: usize, y: usize) -> (usize, usize) {
        let page = y / PAGE * self.pages + x / PAGE;
        let (i, j) = (x % PAGE, y % PAGE);
        (page * (PAGE * PAGE / 4) + j / 2 * (PAGE / 2) + i / 2, j % 2 * 2 + i % 2)
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
        let stored = Texels::new(&image, |x, y, rgb| rgb[0] + (x + 1000 * y) as f32);
        assert_eq!(stored.size(), [37, 18]);
        for y in 0..18 {
            for x in 0..37 {
                let k = (37 * y + x) as f32;
                assert_eq!(stored.get(x, y), [k, 1.0, 2.0, k + (x + 1000 * y) as f32]);
            }
        }
    }
}
