//! The picture in tiles: what is said of many pixels at once.

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// Tiles of 16 x 16 pixels, those at the right and bottom edges what is left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tiles {
    size: [u32; 2],
}

impl Tiles {
    /// Of a picture of this size.
    pub fn new(size: [u32; 2]) -> Tiles {
        Tiles { size }
    }

    fn columns(&self) -> usize {
        self.size[0].div_ceil(SIDE) as usize
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.columns() * self.size[1].div_ceil(SIDE) as usize
    }

    /// The tile of a pixel.
    pub fn of(&self, x: u32, y: u32) -> usize {
        (y / SIDE) as usize * self.columns() + (x / SIDE) as usize
    }

    /// The tile of each pixel, row by row.
    pub fn of_all(&self) -> impl Iterator<Item = usize> {
        let [w, h] = self.size;
        (0..h).flat_map(move |y| (0..w).map(move |x| self.of(x, y)))
    }

    /// Pixels in each.
    pub fn pixels(&self) -> Vec<f64> {
        let mut pixels = vec![0.0; self.count()];
        self.of_all().for_each(|t| pixels[t] += 1.0);
        pixels
    }

    /// A number of each tile as one of each of its pixels.
    pub fn spread(&self, of_tile: &[f64]) -> Vec<f32> {
        self.of_all().map(|t| of_tile[t] as f32).collect()
    }
}
