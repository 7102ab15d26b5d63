//! The tree of a grid, made dense.
//!
//! ```text
//! grid  = GridData (672 bytes)  TreeData (64)  nodes
//! root  = box (24)  tiles (4)  background (4) ... to 64;  tile = key (8)  child (8)  state (4)  value (4) ... to 32
//! upper, lower node = box (24)  flags (8)  value mask  child mask  statistics (16) ... to 32;  values or children, 8 each
//! leaf  = place (12)  sizes (3)  flags (1)  mask (64)  statistics (16);  512 values
//! ```
//!
//! Children are found by their distance in bytes from their parent. A node of side n numbers what
//! it holds by (x n + y) n + z. From `GridData`, `TreeData`, `RootData`, `InternalData` and
//! `LeafData` in NanoVDB.h.

use super::{u32_at, u64_at};
use kaustika_math::{Transform, Vec3};

/// Samples are kept up to this many, 1 GiB.
const MOST_SAMPLES: u64 = 1 << 28;

const GRID_DATA: usize = 672;
const TREE_DATA: usize = 64;
const TILE: usize = 32;

/// A level of inner nodes.
struct Level {
    /// log₂ of how many children lie along an axis.
    log2: u32,
    /// log₂ of a child's side in voxels.
    child_log2: u32,
    child_mask: usize,
    table: usize,
}

const UPPER: Level = Level { log2: 5, child_log2: 7, child_mask: 32 + 4096, table: 8256 };
const LOWER: Level = Level { log2: 4, child_log2: 3, child_mask: 32 + 512, table: 1088 };
const LEAF_VALUES: usize = 96;
const LEAF_SIDE: u32 = 8;

/// All samples in a grid's box of indices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DenseGrid {
    /// Index of the first sample.
    pub(crate) min: [i32; 3],
    pub(crate) resolution: [u32; 3],
    /// x fastest.
    pub(crate) values: Vec<f32>,
    /// Indices, at which samples lie, to the space of the grid.
    pub(crate) to_world: Transform,
}

impl DenseGrid {
    /// Indices from the first sample to one beyond the last, where the grid is.
    pub(crate) fn index_box(&self) -> [Vec3; 2] {
        let min: [f32; 3] = self.min.map(|v| v as f32);
        let size: [f32; 3] = self.resolution.map(|n| n as f32);
        [Vec3::from(min), Vec3::from(min) + Vec3::from(size)]
    }
}

/// The samples of a grid's bytes.
pub(super) fn dense(bytes: &[u8]) -> Result<DenseGrid, String> {
    let bytes = Bytes(bytes);
    bytes.slice(0, GRID_DATA + TREE_DATA)?;
    let offset = bytes.i64(GRID_DATA + 24)?;
    let root = bytes.child(GRID_DATA, offset)?;
    let corner = |at: usize| -> Result<[i32; 3], String> {
        Ok([bytes.i32(at)?, bytes.i32(at + 4)?, bytes.i32(at + 8)?])
    };
    let (min, max) = (corner(root)?, corner(root + 12)?);
    if (0..3).any(|k| max[k] < min[k]) {
        return Err("it has no samples".into());
    }
    let size = [0, 1, 2].map(|k| (i64::from(max[k]) - i64::from(min[k]) + 1) as u64);
    let count = size.iter().fold(1, |n: u64, s| n.saturating_mul(*s));
    if count > MOST_SAMPLES {
        let [x, y, z] = size;
        return Err(format!(
            "its box of {x} x {y} x {z} samples is too large, at most 2^28 are kept: resample it"
        ));
    }
    let resolution = size.map(|s| s as u32);
    let background = bytes.f32(root + 28)?;
    let values = vec![background; count as usize];
    let grid = DenseGrid { min, resolution, values, to_world: bytes.map()? };
    let mut fill = Fill { bytes, grid };
    for i in 0..bytes.u32(root + 24)? as usize {
        fill.tile(root, root + 64 + i * TILE)?;
    }
    if let Some(v) = fill.grid.values.iter().find(|v| !v.is_finite()) {
        return Err(format!("a sample is {v}"));
    }
    Ok(fill.grid)
}

/// Bytes that may be fewer than their own offsets say.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn slice(&self, at: usize, n: usize) -> Result<&'a [u8], String> {
        let slice = at.checked_add(n).and_then(|end| self.0.get(at..end));
        slice.ok_or_else(|| "it ends within its tree".to_string())
    }

    fn u32(&self, at: usize) -> Result<u32, String> {
        Ok(u32_at(self.slice(at, 4)?, 0))
    }

    fn u64(&self, at: usize) -> Result<u64, String> {
        Ok(u64_at(self.slice(at, 8)?, 0))
    }

    fn i32(&self, at: usize) -> Result<i32, String> {
        Ok(self.u32(at)? as i32)
    }

    fn i64(&self, at: usize) -> Result<i64, String> {
        Ok(self.u64(at)? as i64)
    }

    fn f32(&self, at: usize) -> Result<f32, String> {
        Ok(f32::from_bits(self.u32(at)?))
    }

    fn f64(&self, at: usize) -> Result<f64, String> {
        Ok(f64::from_bits(self.u64(at)?))
    }

    /// The place that lies `offset` beyond `parent`.
    fn child(&self, parent: usize, offset: i64) -> Result<usize, String> {
        let place = usize::try_from(offset).ok().and_then(|o| parent.checked_add(o));
        place.filter(|p| *p < self.0.len()).ok_or_else(|| "it ends within its tree".to_string())
    }

    /// Indices to world.
    fn map(&self) -> Result<Transform, String> {
        // In double precision after the same in single.
        const MATRIX: usize = 296 + 88;
        const VECTOR: usize = MATRIX + 144;
        let mut rows = [[0.0, 0.0, 0.0, 1.0]; 4];
        for (i, row) in rows.iter_mut().take(3).enumerate() {
            for (j, v) in row.iter_mut().enumerate() {
                let at = if j < 3 { MATRIX + 8 * (3 * i + j) } else { VECTOR + 8 * i };
                *v = self.f64(at)? as f32;
            }
        }
        Transform::from_rows(rows).ok_or_else(|| "its map is singular".into())
    }
}

/// Puts the values of nodes where they belong.
struct Fill<'a> {
    bytes: Bytes<'a>,
    grid: DenseGrid,
}

impl Fill<'_> {
    /// A tile of the root.
    fn tile(&mut self, root: usize, tile: usize) -> Result<(), String> {
        let key = self.bytes.u64(tile)?;
        // 21 bits an axis, x the highest, of the coordinates' upper 20 bits.
        let origin = [42, 21, 0].map(|shift| ((key >> shift) as u32 & 0x1f_ffff) << 12);
        let origin = origin.map(|v| v as i32);
        match self.bytes.i64(tile + 8)? {
            0 => {
                let value = self.bytes.f32(tile + 20)?;
                self.cube(origin, 1 << 12, value);
                Ok(())
            }
            offset => {
                let node = self.bytes.child(root, offset)?;
                self.node(&UPPER, node, origin)
            }
        }
    }

    fn node(&mut self, level: &Level, node: usize, origin: [i32; 3]) -> Result<(), String> {
        let side = 1u32 << level.log2;
        for n in 0..side * side * side {
            let place = [n >> (2 * level.log2), n >> level.log2 & (side - 1), n & (side - 1)];
            let child: [i32; 3] = std::array::from_fn(|k| {
                origin[k].wrapping_add((place[k] << level.child_log2) as i32)
            });
            let entry = node + level.table + 8 * n as usize;
            let mask = self.bytes.u64(node + level.child_mask + (n / 64) as usize * 8)?;
            if mask >> (n % 64) & 1 == 0 {
                let value = self.bytes.f32(entry)?;
                self.cube(child, 1 << level.child_log2, value);
                continue;
            }
            let below = self.bytes.child(node, self.bytes.i64(entry)?)?;
            match level.child_log2 {
                3 => self.leaf(below, child)?,
                _ => self.node(&LOWER, below, child)?,
            }
        }
        Ok(())
    }

    fn leaf(&mut self, leaf: usize, origin: [i32; 3]) -> Result<(), String> {
        let values = self.bytes.slice(leaf + LEAF_VALUES, 4 * 512)?;
        self.each(origin, LEAF_SIDE, |n| f32::from_bits(u32_at(values, 4 * n)));
        Ok(())
    }

    fn cube(&mut self, origin: [i32; 3], side: u32, value: f32) {
        self.each(origin, side, |_| value);
    }

    /// Sets the samples of a cube that lie in the box, by their numbers in the cube.
    fn each(&mut self, origin: [i32; 3], side: u32, value: impl Fn(usize) -> f32) {
        let DenseGrid { min, resolution, values, .. } = &mut self.grid;
        // From where to where in the box.
        let range = |k: usize| {
            let start = i64::from(origin[k]) - i64::from(min[k]);
            let end = (start + i64::from(side)).min(i64::from(resolution[k]));
            (start.max(0)..end, start)
        };
        let [(xs, x0), (ys, y0), (zs, z0)] = [range(0), range(1), range(2)];
        let side = i64::from(side);
        for z in zs {
            for y in ys.clone() {
                let row =
                    (z as usize * resolution[1] as usize + y as usize) * resolution[0] as usize;
                for x in xs.clone() {
                    let n = ((x - x0) * side + (y - y0)) * side + (z - z0);
                    values[row + x as usize] = value(n as usize);
                }
            }
        }
    }
}
