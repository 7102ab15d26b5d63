//! Piecewise constant densities on large grids, sampled within a few cache lines.

use super::InvalidWeights;
use super::shares::{choose, fill_starts, share};
use super::weights::check;
use kaustika_math::Vec2;

/// Cells along a side of a tile.
const SIDE: usize = 8;
/// Units that the probabilities within a tile are counted in.
const TILE_UNITS: u32 = 1 << 15;
/// Units of the probabilities of tiles and regions: uniform numbers have as many values.
const UNITS: u32 = 1 << 24;

/// A density that is constant on each cell of a width × height grid: first a *region* is
/// chosen, then a tile of 8 × 8 cells within it, then a cell; each time the row by the second
/// number and the column by what the first says of that row.
///
/// A table over all cells of an environment map lies outside of the caches, and a search in it
/// waits for memory at each step. Here all that is searched outside the tile is a few pages
/// that stay in the cache, and a tile is three lines. Equal shares of the numbers stay
/// together: neighbouring numbers give neighbouring places, but at borders of regions and tiles.
///
/// Probabilities are whole numbers of units, so that those of samples and `pmf` are the same to
/// the bit; a cell with any weight has at least one unit. Regions can also be sampled alone.
#[derive(Clone, Debug)]
pub struct Tiled2D {
    /// Cells along a side of a region.
    region_size: [usize; 2],
    /// Regions along each side.
    regions: [usize; 2],
    /// Tiles of a region along each side.
    tiles: [usize; 2],
    /// Of the regions: a single one.
    outer: Tables,
    /// Of the tiles in each region.
    inner: Tables,
    /// Region by region.
    cells: Vec<Tile>,
}

/// A cell that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiledSample {
    /// Column and row of the cell.
    pub cell: [usize; 2],
    /// Its probability.
    pub pmf: f32,
    /// What is left of the two numbers: uniform in [0, 1)², independent of the cell.
    pub u: Vec2,
}

/// A tile that was chosen.
#[derive(Clone, Copy, Debug)]
pub struct TileChoice {
    tile: usize,
    /// Its first cell.
    corner: [usize; 2],
    /// Probability of its region, 1 if that was given, and its own in the region.
    pmf_region: f32,
    pmf_tile: f32,
    /// What is left of the two numbers.
    u: Vec2,
}

/// Grids of the same size. Of each is known where its rows, then the columns of each row, begin:
/// the sum of the probabilities before them, in units.
#[derive(Clone, Debug)]
struct Tables {
    width: usize,
    height: usize,
    starts: Vec<u32>,
}

/// As one of [`Tables`], of 8 × 8 cells in 3 cache lines at most.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
struct Tile {
    rows: [u16; SIDE],
    columns: [[u16; SIDE]; SIDE],
}

impl Tiled2D {
    /// With probabilities proportional to `weights`, given row by row, and at most
    /// `most_regions` regions along each side.
    ///
    /// # Errors
    /// If there are not width × height > 0 weights, an invalid one or no positive one.
    pub fn new(
        weights: &[f32],
        [width, height]: [usize; 2],
        most_regions: [usize; 2],
    ) -> Result<Tiled2D, InvalidWeights> {
        let expected = width.saturating_mul(height);
        if expected == 0 || weights.len() != expected {
            return Err(InvalidWeights::Shape { expected: expected.max(1), found: weights.len() });
        }
        check(weights)?;
        // Regions of more than one tile are made of whole ones.
        let region_side = |n: usize, most: usize| {
            let side = n.div_ceil(most.max(1));
            if side > SIDE { side.next_multiple_of(SIDE) } else { side }
        };
        let region_size =
            [region_side(width, most_regions[0]), region_side(height, most_regions[1])];
        let regions = [width.div_ceil(region_size[0]), height.div_ceil(region_size[1])];
        let tiles = region_size.map(|n| n.div_ceil(SIDE));
        let mut inner = Tables::new(tiles);
        let (mut cells, mut region_weights) = (Vec::new(), Vec::new());
        for region in 0..regions[0] * regions[1] {
            let x0 = region % regions[0] * region_size[0];
            let y0 = region / regions[0] * region_size[1];
            let mut tile_weights = Vec::new();
            for tile in 0..tiles[0] * tiles[1] {
                let (dx, dy) = (tile % tiles[0] * SIDE, tile / tiles[0] * SIDE);
                let weight = |i: usize, j: usize| {
                    let (i, j) = (dx + i, dy + j);
                    let (x, y) = (x0 + i, y0 + j);
                    let inside = i < region_size[0] && j < region_size[1];
                    match inside && x < width && y < height {
                        true => f64::from(weights[y * width + x]),
                        false => 0.0,
                    }
                };
                let (tile, sum) = Tile::new(weight);
                cells.push(tile);
                tile_weights.push(sum);
            }
            inner.push(&tile_weights);
            region_weights.push(tile_weights.iter().sum());
        }
        let mut outer = Tables::new(regions);
        outer.push(&region_weights);
        Ok(Tiled2D { region_size, regions, tiles, outer, inner, cells })
    }

    /// Columns and rows of regions, which are numbered row by row.
    pub fn regions(&self) -> [usize; 2] {
        self.regions
    }

    /// The region that a cell lies in.
    #[inline]
    pub fn region_of(&self, [column, row]: [usize; 2]) -> usize {
        row / self.region_size[1] * self.regions[0] + column / self.region_size[0]
    }

    /// Probability of a region.
    pub fn region_pmf(&self, region: usize) -> f32 {
        self.outer.pmf(0, [region % self.regions[0], region / self.regions[0]])
    }

    /// A tile, of a region that has a positive probability if one is given; `u` in [0, 1)². All
    /// that is read is in the cache.
    #[inline]
    pub fn choose_tile(&self, region: Option<usize>, u: Vec2) -> TileChoice {
        let (region, u, pmf_region) = match region {
            Some(region) => (region, u, 1.0),
            None => {
                let ([x, y], u, pmf) = self.outer.sample(0, u);
                (y * self.regions[0] + x, u, pmf)
            }
        };
        let ([tx, ty], u, pmf_tile) = self.inner.sample(region, u);
        let x = region % self.regions[0] * self.region_size[0] + tx * SIDE;
        let y = region / self.regions[0] * self.region_size[1] + ty * SIDE;
        let tile = (region * self.tiles[1] + ty) * self.tiles[0] + tx;
        TileChoice { tile, corner: [x, y], pmf_region, pmf_tile, u }
    }

    /// Reads what [`Tiled2D::sample_tile`] will need. Whoever draws several samples lets the
    /// memory work on all of them at once.
    #[inline(always)]
    pub fn touch(&self, choice: &TileChoice) {
        let tile = &self.cells[choice.tile];
        std::hint::black_box((tile.rows[0], tile.columns[SIDE / 2][0], tile.columns[SIDE - 1][0]));
    }

    /// A cell of a tile that was chosen; its probability is among those of the region, if that
    /// was given.
    #[inline]
    pub fn sample_tile(&self, choice: &TileChoice) -> TiledSample {
        let TileChoice { tile, corner: [x, y], pmf_region, pmf_tile, u } = *choice;
        let tile = &self.cells[tile];
        let (row, v, pmf_row) = choose(&tile.rows, TILE_UNITS, u.y);
        let (column, u, pmf_column) = choose(&tile.columns[row], TILE_UNITS, u.x);
        let pmf = pmf_region * (pmf_tile * (pmf_row * pmf_column));
        TiledSample { cell: [x + column, y + row], pmf, u: Vec2::new(u, v) }
    }

    /// Probability of a cell of the grid.
    #[inline]
    pub fn pmf(&self, cell: [usize; 2]) -> f32 {
        self.region_pmf(self.region_of(cell)) * self.pmf_in(cell)
    }

    /// Probability of a cell among those of its region.
    #[inline]
    fn pmf_in(&self, [column, row]: [usize; 2]) -> f32 {
        let region = self.region_of([column, row]);
        let (i, j) = (column % self.region_size[0], row % self.region_size[1]);
        let (tx, ty) = (i / SIDE, j / SIDE);
        let tile = &self.cells[(region * self.tiles[1] + ty) * self.tiles[0] + tx];
        let (i, j) = (i % SIDE, j % SIDE);
        let pmf_row = share(&tile.rows, TILE_UNITS, j);
        let pmf_column = share(&tile.columns[j], TILE_UNITS, i);
        self.inner.pmf(region, [tx, ty]) * (pmf_row * pmf_column)
    }
}

impl Tables {
    /// None yet, of this width and height.
    fn new([width, height]: [usize; 2]) -> Tables {
        Tables { width, height, starts: Vec::new() }
    }

    /// One more, of weights given row by row.
    fn push(&mut self, weights: &[f64]) {
        let rows = weights.chunks_exact(self.width);
        let sums: Vec<f64> = rows.clone().map(|row| row.iter().sum()).collect();
        for part in std::iter::once(&sums[..]).chain(rows) {
            fill_starts(part, UNITS, |_, start| self.starts.push(start));
        }
    }

    /// Where the rows begin, and where the columns.
    #[inline]
    fn table(&self, number: usize) -> (&[u32], &[u32]) {
        let size = self.height * (self.width + 1);
        self.starts[number * size..(number + 1) * size].split_at(self.height)
    }

    /// Column and row, what is left of `u`, and their probability.
    #[inline]
    fn sample(&self, number: usize, u: Vec2) -> ([usize; 2], Vec2, f32) {
        let (rows, columns) = self.table(number);
        let (row, v, pmf_row) = choose(rows, UNITS, u.y);
        let columns = &columns[row * self.width..(row + 1) * self.width];
        let (column, u, pmf_column) = choose(columns, UNITS, u.x);
        ([column, row], Vec2::new(u, v), pmf_row * pmf_column)
    }

    #[inline]
    fn pmf(&self, number: usize, [column, row]: [usize; 2]) -> f32 {
        let (rows, columns) = self.table(number);
        let columns = &columns[row * self.width..(row + 1) * self.width];
        share(rows, UNITS, row) * share(columns, UNITS, column)
    }
}

impl Tile {
    /// Of the weights at (column, row), and their sum.
    fn new(weight: impl Fn(usize, usize) -> f64) -> (Tile, f64) {
        let mut tile = Tile { rows: [0; SIDE], columns: [[0; SIDE]; SIDE] };
        let mut sums = [0.0; SIDE];
        for (j, sum) in sums.iter_mut().enumerate() {
            let row: [f64; SIDE] = std::array::from_fn(|i| weight(i, j));
            *sum = row.iter().sum();
            fill_starts(&row, TILE_UNITS, |i, start| tile.columns[j][i] = start as u16);
        }
        fill_starts(&sums, TILE_UNITS, |j, start| tile.rows[j] = start as u16);
        (tile, sums.iter().sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::{ONE_MINUS_EPSILON, mix_bits};

    fn draw(d: &Tiled2D, u: Vec2) -> TiledSample {
        d.sample_tile(&d.choose_tile(None, u))
    }

    /// In [0, 1), by number.
    fn uniform(k: usize) -> f32 {
        (mix_bits(k as u64) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Noise over many magnitudes, a sun, empty rows and columns, flat parts.
    fn tables() -> Vec<([usize; 2], Vec<f32>)> {
        let mut tables = Vec::new();
        for [w, h] in [[1, 1], [2, 3], [65, 9], [257, 130], [9, 300]] {
            let noise: Vec<f32> = (0..w * h).map(|k| uniform(k + 1).powi(20)).collect();
            let mut sun = vec![1e-3; w * h];
            sun[w * h / 2] = 1e6;
            let gap = |k: usize| k / w == 1 || (k % w) * 3 / w == 1;
            let gaps = (0..w * h).map(|k| if gap(k) { 0.0 } else { 1.0 + k as f32 }).collect();
            tables.extend([noise, sun, gaps, vec![1.0; w * h]].map(|t| ([w, h], t)));
        }
        tables
    }

    #[test]
    fn probabilities_are_those_of_the_weights_and_sum_to_one() {
        for ([w, h], weights) in tables() {
            for most in [[1, 1], [4, 3], [32, 16]] {
                let d = Tiled2D::new(&weights, [w, h], most).expect("valid");
                let sum: f64 = weights.iter().map(|&v| f64::from(v)).sum();
                let cell = |k: usize| [k % w, k / w];
                let total: f64 = (0..w * h).map(|k| f64::from(d.pmf(cell(k)))).sum();
                assert!((total - 1.0).abs() < 1e-5, "{w} x {h}: {total}");
                let mut of_regions = vec![0.0; d.regions()[0] * d.regions()[1]];
                for (k, &weight) in weights.iter().enumerate() {
                    let p = f64::from(d.pmf(cell(k)));
                    let exact = f64::from(weight) / sum;
                    assert_eq!(p > 0.0, exact > 0.0);
                    // Two units in either direction.
                    assert!((p - exact).abs() < 2.5e-3 * exact + 2e-4, "{w} x {h}: {p} {exact}");
                    of_regions[d.region_of(cell(k))] += f64::from(d.pmf_in(cell(k)));
                }
                for (r, sum) in of_regions.iter().enumerate() {
                    assert!((sum - 1.0).abs() < 1e-5 || d.region_pmf(r) == 0.0, "{r}: {sum}");
                }
            }
        }
    }

    #[test]
    fn samples_have_their_probability_and_cover_the_cells_evenly() {
        for ([w, h], weights) in tables() {
            let d = Tiled2D::new(&weights, [w, h], [4, 3]).expect("valid");
            let n = 64;
            let (mut seen, mut mean) = (vec![0usize; w * h], Vec2::ZERO);
            for i in 0..n * n {
                // Stratified: a cell of probability p gets close to p n² of the points.
                let (x, y) = (i % n, i / n);
                let u = Vec2::new(x as f32 + uniform(2 * i), y as f32 + uniform(2 * i + 1));
                let s = draw(&d, u / n as f32);
                assert_eq!(s.pmf, d.pmf(s.cell));
                assert!(s.pmf > 0.0 && (0.0..1.0).contains(&s.u.x) && (0.0..1.0).contains(&s.u.y));
                seen[s.cell[1] * w + s.cell[0]] += 1;
                mean += s.u / (n * n) as f32;
            }
            for (k, &count) in seen.iter().enumerate() {
                let expected = d.pmf([k % w, k / w]) * (n * n) as f32;
                // Within the strata that a cell's border crosses.
                let slack = 6.0 * expected.max(1.0).sqrt() + 4.0;
                assert!((count as f32 - expected).abs() < slack, "{w} x {h}: {count} {expected}");
            }
            // What is left is uniform: its mean's error is at most 0.29/64.
            assert!((mean - Vec2::splat(0.5)).length() < 0.02, "{w} x {h}: {mean:?}");
            for (r, u) in (0..d.regions()[0] * d.regions()[1])
                .flat_map(|r| [(r, Vec2::ZERO), (r, Vec2::splat(0.7))])
            {
                if d.region_pmf(r) > 0.0 {
                    let s = d.sample_tile(&d.choose_tile(Some(r), u));
                    assert_eq!((d.region_of(s.cell), s.pmf), (r, d.pmf_in(s.cell)));
                }
            }
        }
    }

    #[test]
    fn the_greatest_number_is_one_too() {
        let d = Tiled2D::new(&[0.0, 3.0, 1.0, 0.0], [2, 2], [2, 2]).expect("valid");
        let s = draw(&d, Vec2::splat(ONE_MINUS_EPSILON));
        assert_eq!(s.cell, [0, 1]);
        assert_eq!(draw(&d, Vec2::ZERO).cell, [1, 0]);
        assert!(Tiled2D::new(&[0.0; 4], [2, 2], [1, 1]).is_err());
        assert!(Tiled2D::new(&[1.0; 3], [2, 2], [1, 1]).is_err());
    }
}
