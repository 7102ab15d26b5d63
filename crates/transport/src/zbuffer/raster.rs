//! The z-buffer (Straßer 1974, Catmull 1974), tile by tile.
//!
//! Triangles are culled, set up and sorted by tiles in chunks, then tiles are filled, both by all threads.
//! A tile takes its triangles in the order of their numbers, and of two equally near ones keeps the
//! first: what is drawn depends on nothing else.
//!
//! Within a tile functions of x and y are in single precision from its corner: over 64 pixels an edge is
//! off by some 10⁻⁵ of a pixel.

use super::mesh::{CHUNK, Meshes};
use super::setup::{Triangle, at, outside};
use super::view::View;
use kaustika_math::Vec3;
use kaustika_math::lanes::{LANES, Lanes};
use rayon::prelude::*;

/// Width and height of a tile, in pixels.
pub const TILE: usize = 64;
/// Pixels of a tile.
pub const AREA: usize = TILE * TILE;
/// Where there is no triangle.
pub const EMPTY: u32 = u32::MAX;

/// Which parts of surfaces are cut out.
#[derive(Clone, Copy)]
pub struct Holes<'a> {
    /// Of each shape whether it has any.
    pub shapes: &'a [bool],
    /// True where a triangle is open, at barycentric weights.
    pub open: &'a (dyn Fn(u32, [f32; 3]) -> bool + Sync),
}

/// A chunk of the triangles that show, by tiles.
#[derive(Debug, Default)]
struct Sorted {
    triangles: Vec<Triangle>,
    /// Where each tile's entries begin, and the end of the last.
    starts: Vec<u32>,
    /// Places in `triangles`.
    entries: Vec<u16>,
}

/// Buffers of a picture, tile after tile, row after row in each.
#[derive(Debug, Default)]
pub struct Raster {
    size: [u32; 2],
    tiles: [usize; 2],
    chunks: Vec<Sorted>,
    /// κ of what is seen.
    nearness: Vec<f32>,
    /// What is seen, as [`Raster::triangle`] takes it.
    slots: Vec<u32>,
}

/// A tile that has been filled.
#[derive(Clone, Copy)]
pub struct Tile<'a> {
    /// Its first column and row.
    pub origin: [usize; 2],
    /// Its columns and rows within the picture.
    pub size: [usize; 2],
    /// κ of what is seen; rows of [`TILE`].
    pub nearness: &'a [f32],
    /// What is seen; [`EMPTY`] where nothing is.
    pub slots: &'a [u32],
    chunks: &'a [Sorted],
}

impl Tile<'_> {
    /// The triangle in a slot.
    #[inline]
    pub fn triangle(&self, slot: u32) -> &Triangle {
        &self.chunks[slot as usize / CHUNK].triangles[slot as usize % CHUNK]
    }
}

impl Raster {
    /// Makes triangles ready for a picture.
    pub fn sort(&mut self, meshes: &Meshes, view: &View) {
        self.size = view.size;
        self.tiles = view.size.map(|n| (n as usize).div_ceil(TILE));
        let tiles = self.tiles;
        self.chunks.resize_with(meshes.indices.len().div_ceil(CHUNK), Sorted::default);
        self.chunks.par_iter_mut().enumerate().for_each(|(i, chunk)| {
            chunk.triangles.clear();
            let b = &meshes.bounds[i];
            let corners: [_; 8] = std::array::from_fn(|k| {
                let side = |axis: usize| if k >> axis & 1 == 0 { b.min[axis] } else { b.max[axis] };
                view.project(Vec3::new(side(0), side(1), side(2)))
            });
            if outside(&corners, view) {
                return;
            }
            let first = i * CHUNK;
            for id in first..meshes.indices.len().min(first + CHUNK) {
                let corners = meshes.corners(id as u32);
                if meshes.one_sided && view.toward_eye(corners[0]).dot(meshes.facets[id]) <= 0.0 {
                    continue;
                }
                let corners = corners.map(|p| view.project(p));
                if !outside(&corners, view) {
                    chunk.triangles.extend(Triangle::new(corners, view, id as u32));
                }
            }
            chunk.sort(tiles);
        });
    }

    /// Fills the buffers, and has `shade` work on each tile, whose pixels' part of `out` it gets.
    pub fn fill<T: Send>(
        &mut self,
        meshes: &Meshes,
        view: &View,
        holes: &Holes,
        out: &mut Vec<T>,
        blank: impl Fn() -> T,
        shade: impl Fn(&Tile, &mut [T]) + Sync,
    ) {
        let count = self.tiles[0] * self.tiles[1];
        self.nearness.resize(count * AREA, 0.0);
        self.slots.resize(count * AREA, EMPTY);
        out.resize_with(count * AREA, blank);
        let (tiles, size, chunks) = (self.tiles, self.size, &self.chunks[..]);
        let nearness = self.nearness.par_chunks_mut(AREA);
        let slots = self.slots.par_chunks_mut(AREA);
        let all = nearness.zip(slots).zip(out.par_chunks_mut(AREA)).with_max_len(1).enumerate();
        all.for_each(|(number, ((nearness, slots), out))| {
            let origin = [number % tiles[0] * TILE, number / tiles[0] * TILE];
            let size = [0, 1].map(|k| (size[k] as usize - origin[k]).min(TILE));
            nearness.fill(view.nearness[0] as f32);
            slots.fill(EMPTY);
            for (c, chunk) in chunks.iter().enumerate() {
                for &k in chunk.of_tile(number) {
                    let triangle = &chunk.triangles[usize::from(k)];
                    let slot = (c * CHUNK + usize::from(k)) as u32;
                    let shape = meshes.sources[triangle.id as usize].shape as usize;
                    let open = holes.shapes[shape].then_some(holes.open);
                    draw(triangle, slot, origin, view.nearness[1], open, nearness, slots);
                }
            }
            shade(&Tile { origin, size, nearness, slots, chunks }, out);
        });
    }

    /// What the pixel at column `x` and row `y` shows, and its κ.
    #[inline]
    pub fn seen(&self, x: u32, y: u32) -> Option<(&Triangle, f32)> {
        let at = self.place(x, y);
        let slot = self.slots[at];
        (slot != EMPTY).then(|| (self.triangle(slot), self.nearness[at]))
    }

    /// Where a pixel is in buffers that lie tile after tile.
    #[inline]
    pub fn place(&self, x: u32, y: u32) -> usize {
        let (x, y) = (x as usize, y as usize);
        let tile = y / TILE * self.tiles[0] + x / TILE;
        tile * AREA + y % TILE * TILE + x % TILE
    }

    fn triangle(&self, slot: u32) -> &Triangle {
        &self.chunks[slot as usize / CHUNK].triangles[slot as usize % CHUNK]
    }
}

impl Sorted {
    /// Sorts the triangles by the tiles that they touch.
    fn sort(&mut self, tiles: [usize; 2]) {
        let count = tiles[0] * tiles[1];
        let touched = |t: &Triangle| {
            let [x0, y0, x1, y1] = t.bounds.map(usize::from);
            let columns = x0 / TILE..(x1 - 1) / TILE + 1;
            let rows = y0 / TILE..(y1 - 1) / TILE + 1;
            rows.flat_map(move |y| columns.clone().map(move |x| y * tiles[0] + x))
        };
        self.starts.clear();
        self.starts.resize(count + 1, 0);
        for tile in self.triangles.iter().flat_map(touched) {
            self.starts[tile + 1] += 1;
        }
        (0..count).for_each(|i| self.starts[i + 1] += self.starts[i]);
        self.entries.clear();
        self.entries.resize(self.starts[count] as usize, 0);
        let mut next = self.starts.clone();
        for (k, t) in self.triangles.iter().enumerate() {
            for tile in touched(t) {
                self.entries[next[tile] as usize] = k as u16;
                next[tile] += 1;
            }
        }
    }

    fn of_tile(&self, tile: usize) -> &[u16] {
        if self.triangles.is_empty() {
            return &[];
        }
        &self.entries[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }
}

/// Draws one triangle into a tile, sixteen pixels of a row at a time.
#[inline]
fn draw(
    t: &Triangle,
    slot: u32,
    origin: [usize; 2],
    nearest: f64,
    open: Option<&(dyn Fn(u32, [f32; 3]) -> bool + Sync)>,
    nearness: &mut [f32],
    slots: &mut [u32],
) {
    let [x0, y0, x1, y1] = t.bounds.map(usize::from);
    let columns = x0.max(origin[0]) - origin[0]..x1.min(origin[0] + TILE) - origin[0];
    let rows = y0.max(origin[1]) - origin[1]..y1.min(origin[1] + TILE) - origin[1];
    let corner = origin.map(|v| v as f64);
    // Functions of x and y from the tile's corner on.
    let local = |f: &[f64; 3]| [f[0] as f32, f[1] as f32, at(f, corner[0], corner[1]) as f32];
    let [e0, e1, e2] = [local(&t.edges[0]), local(&t.edges[1]), local(&t.edges[2])];
    let kappa = local(&t.nearness);
    let nearest = Lanes::splat(nearest as f32);
    let zero = Lanes::splat(0.0);
    let steps = Lanes::new(std::array::from_fn(|i| i as f32));
    let blocks = columns.start / LANES..(columns.end - 1) / LANES + 1;
    for y in rows {
        let row = |f: &[f32; 3]| Lanes::splat(f[1].mul_add(y as f32, f[2]));
        let (r0, r1, r2, rk) = (row(&e0), row(&e1), row(&e2), row(&kappa));
        for block in blocks.clone() {
            let x = steps + Lanes::splat((block * LANES) as f32);
            let value = |f: &[f32; 3], row: Lanes| x.mul_add(Lanes::splat(f[0]), row);
            let least = value(&e0, r0).fast_min(value(&e1, r1)).fast_min(value(&e2, r2));
            let inside = least.simd_ge(zero);
            if !inside.any() {
                continue;
            }
            let from = y * TILE + block * LANES;
            let Some(kept) = nearness[from..].first_chunk_mut::<LANES>() else { continue };
            let old = Lanes::new(*kept);
            let new = value(&kappa, rk);
            let mut mask = inside & new.simd_gt(old) & new.simd_le(nearest);
            let mut bits = mask.to_bitmask();
            if let (Some(open), true) = (open, bits != 0) {
                let covered = bits;
                for i in (0..LANES).filter(|i| covered >> i & 1 != 0) {
                    let x = corner[0] + (block * LANES + i) as f64;
                    if open(t.id, t.barycentric(x, corner[1] + y as f64)) {
                        bits &= !(1 << i);
                    }
                }
                mask = kaustika_math::lanes::mask_of(bits);
            }
            if bits == 0 {
                continue;
            }
            *kept = mask.select(new, old).to_array();
            if bits == 0xffff {
                slots[from..from + LANES].fill(slot);
            } else {
                while bits != 0 {
                    slots[from + bits.trailing_zeros() as usize] = slot;
                    bits &= bits - 1;
                }
            }
        }
    }
}
