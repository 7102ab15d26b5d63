//! Photons in a hash grid: those within a radius of a point.

use kaustika_math::Vec3;
use kaustika_sampling::hash::combine;

/// Points sorted by the cell they lie in; cells are named by a hash of their coordinates.
#[derive(Clone, Debug, Default)]
pub struct HashGrid {
    /// Where the points of each hash value begin, and one more.
    starts: Vec<u32>,
    /// Indices of points, sorted by hash value.
    points: Vec<u32>,
    cell: f32,
}

impl HashGrid {
    /// Over `count` points; cells are as wide as the `radius` of the queries, twice.
    pub fn new(count: usize, radius: f32, at: impl Fn(usize) -> Vec3) -> HashGrid {
        let slots = count.next_power_of_two().max(1);
        let cell = 2.0 * radius;
        let mut grid = HashGrid { starts: vec![0; slots + 1], points: vec![0; count], cell };
        let names: Vec<u32> = (0..count).map(|i| grid.slot(grid.coordinates(at(i)))).collect();
        for &name in &names {
            grid.starts[name as usize + 1] += 1;
        }
        for i in 0..slots {
            grid.starts[i + 1] += grid.starts[i];
        }
        // Back to front, so that points of a slot stay in order.
        let mut ends: Vec<u32> = grid.starts[1..].to_vec();
        for (i, &name) in names.iter().enumerate().rev() {
            ends[name as usize] -= 1;
            grid.points[ends[name as usize] as usize] = i as u32;
        }
        grid
    }

    fn coordinates(&self, p: Vec3) -> [i32; 3] {
        [p.x, p.y, p.z].map(|v| (v / self.cell).floor() as i32)
    }

    fn slot(&self, c: [i32; 3]) -> u32 {
        let [x, y, z] = c.map(|v| u64::from(v as u32));
        let slots = self.starts.len() as u64 - 1;
        (combine(combine(x, y), z) & (slots - 1)) as u32
    }

    /// Calls `each` with every point that may lie within the radius of `p`, and others that
    /// share a hash value with them; none twice.
    #[inline]
    pub fn near(&self, p: Vec3, mut each: impl FnMut(u32)) {
        if self.points.is_empty() {
            return;
        }
        // The radius is half a cell: the ball meets two cells along each axis.
        let base = [p.x, p.y, p.z].map(|v| (v / self.cell - 0.5).floor() as i32);
        let mut slots = [0; 8];
        for i in 0..8 {
            let slot = self.slot([base[0] + (i & 1), base[1] + (i >> 1 & 1), base[2] + (i >> 2)]);
            let k = i as usize;
            slots[k] = slot;
            if slots[..k].contains(&slot) {
                continue;
            }
            let range = self.starts[slot as usize]..self.starts[slot as usize + 1];
            self.points[range.start as usize..range.end as usize].iter().for_each(|&j| each(j));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_points_within_the_radius_are_found_once() {
        let number = |i: usize, k: u64| {
            (combine(i as u64, k) >> 40) as f32 / (1u64 << 24) as f32 * 2.0 - 1.0
        };
        let points: Vec<Vec3> =
            (0..3000).map(|i| Vec3::new(number(i, 1), number(i, 2), number(i, 3))).collect();
        let radius = 0.13;
        let grid = HashGrid::new(points.len(), radius, |i| points[i]);
        for i in 0..200 {
            let p = Vec3::new(number(i, 4), number(i, 5), number(i, 6));
            let inside = |j: &u32| (points[*j as usize] - p).length() < radius;
            let mut found = Vec::new();
            grid.near(p, |j| found.push(j));
            found.sort_unstable();
            let count = found.len();
            found.dedup();
            assert_eq!(count, found.len(), "none twice");
            let near: Vec<u32> = found.into_iter().filter(inside).collect();
            let truth: Vec<u32> = (0..points.len() as u32).filter(inside).collect();
            assert_eq!(near, truth);
        }
    }
}
