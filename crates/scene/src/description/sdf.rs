//! Surfaces given by distances from them.

/// A surface where a sampled signed distance is zero: negative inside.
#[derive(Clone, Debug, PartialEq)]
pub struct SdfGrid {
    /// Samples along x, y and z, each at least 2; they lie on the corners of cells, from face to
    /// face of the unit cube.
    pub resolution: [u32; 3],
    /// Signed distances of any unit, x fastest, then y, then z.
    pub values: Vec<f32>,
    /// Shading normals.
    pub normals: SdfNormals,
}

/// Shading normals of a signed distance grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SdfNormals {
    /// The gradient, which jumps from cell to cell.
    Analytic,
    /// Blended from cell to cell.
    #[default]
    Smooth,
}

impl SdfGrid {
    /// True if the surface passes the cell (x, y, z): its corners are not all of one sign.
    pub fn is_crossed(&self, cell: [u32; 3]) -> bool {
        let corners = self.corners(cell);
        !(corners.iter().all(|v| *v > 0.0) || corners.iter().all(|v| *v < 0.0))
    }

    /// The samples on the corners of a cell, x fastest.
    pub fn corners(&self, [x, y, z]: [u32; 3]) -> [f32; 8] {
        let [nx, ny, _] = self.resolution.map(|n| n as usize);
        let at = |i: usize| {
            let [dx, dy, dz] = [i & 1, i >> 1 & 1, i >> 2];
            (x as usize + dx) + nx * ((y as usize + dy) + ny * (z as usize + dz))
        };
        std::array::from_fn(|i| self.values[at(i)])
    }

    /// The cells that the surface passes.
    pub fn crossed_cells(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let [cx, cy, cz] = self.resolution.map(|n| n.saturating_sub(1));
        (0..cz)
            .flat_map(move |z| (0..cy).flat_map(move |y| (0..cx).map(move |x| [x, y, z])))
            .filter(|cell| self.is_crossed(*cell))
    }
}
