//! Samples on a grid, with what is between and beyond them.

use crate::description::{GridDesc, GridFilter, GridLayout};
use crate::texture::uplift;
use kaustika_math::{Bounds3, Vec3, lerp};
use kaustika_spectra::{ColorMode, Spectrum, SpectrumRole, Wavelengths};
use std::sync::Arc;

/// A grid that can be asked at any point of the world.
#[derive(Debug)]
pub struct Grid(Arc<GridDesc>);

impl Grid {
    /// Prepares a description.
    pub fn new(desc: &Arc<GridDesc>) -> Grid {
        Grid(desc.clone())
    }

    /// What it was made of.
    pub fn desc(&self) -> &GridDesc {
        &self.0
    }

    /// The value at a point of the world, the same number three times if it has one channel.
    #[inline]
    pub fn rgb(&self, p: Vec3) -> [f32; 3] {
        match self.0.channels {
            1 => [self.channel(p, 0); 3],
            _ => [0, 1, 2].map(|c| self.channel(p, c)),
        }
    }

    /// The value at a point of the world; of colours the first channel.
    #[inline]
    pub fn number(&self, p: Vec3) -> f32 {
        self.channel(p, 0)
    }

    /// The value at a point of the world as a spectrum: a number, or a colour of this role.
    pub fn spectrum(&self, p: Vec3, role: SpectrumRole, lambda: &Wavelengths) -> Spectrum {
        match (self.0.channels, lambda.mode) {
            (3, _) => uplift(role, self.rgb(p), lambda),
            (_, ColorMode::Rgb) => Spectrum::from_rgb([self.number(p); 3]),
            (_, ColorMode::Spectral) => Spectrum::splat(self.number(p)),
        }
    }

    /// Coordinates in units of samples along one axis.
    #[inline]
    fn coordinate(&self, axis: usize, unit: f32) -> f32 {
        let n = self.0.resolution[axis] as f32;
        match self.0.layout {
            GridLayout::CellsClamped => (unit * n - 0.5).clamp(0.0, n - 1.0),
            GridLayout::CellsRepeated => unit.rem_euclid(1.0) * n - 0.5,
            GridLayout::CellsMirrored => unit.rem_euclid(2.0) * n - 0.5,
            GridLayout::CellsFading => (unit * n - 0.5).clamp(-1.0, n),
            GridLayout::Corners => (unit * (n - 1.0)).clamp(0.0, n - 1.0),
        }
    }

    /// One channel's value at a point of the world.
    pub(super) fn channel(&self, p: Vec3, c: u32) -> f32 {
        let unit = self.0.to_world.inverse().point(p);
        let at: [f32; 3] = std::array::from_fn(|axis| self.coordinate(axis, unit[axis]));
        if self.0.filter == GridFilter::Nearest {
            return self.sample(at.map(|v| (v + 0.5).floor() as i32), c);
        }
        let low = at.map(f32::floor);
        let t: [f32; 3] = std::array::from_fn(|axis| at[axis] - low[axis]);
        let low = low.map(|v| v as i32);
        let value = |dx, dy, dz| self.sample([low[0] + dx, low[1] + dy, low[2] + dz], c);
        let row = |dy, dz| lerp(t[0], value(0, dy, dz), value(1, dy, dz));
        let sheet = |dz| lerp(t[1], row(0, dz), row(1, dz));
        lerp(t[2], sheet(0), sheet(1))
    }

    /// A sample; beyond the outermost what the layout says.
    #[inline]
    fn sample(&self, at: [i32; 3], c: u32) -> f32 {
        let n = self.0.resolution.map(|n| n as i32);
        let inside = (0..3).all(|axis| (0..n[axis]).contains(&at[axis]));
        if !inside && self.0.layout == GridLayout::CellsFading {
            return 0.0;
        }
        let [x, y, z] = std::array::from_fn(|axis| {
            let (i, n) = (at[axis], n[axis]);
            (match self.0.layout {
                GridLayout::CellsRepeated => i.rem_euclid(n),
                GridLayout::CellsMirrored => {
                    i.rem_euclid(2 * n).min(2 * n - 1 - i.rem_euclid(2 * n))
                }
                _ => i.clamp(0, n - 1),
            }) as usize
        });
        let index = (z * n[1] as usize + y) * n[0] as usize + x;
        self.0.values.get(index * self.0.channels as usize + c as usize).copied().unwrap_or(0.0)
    }

    /// No less than any value, of any channel, at the points of a box of the world.
    pub fn bound(&self, corners: impl Iterator<Item = Vec3>) -> f32 {
        if matches!(self.0.layout, GridLayout::CellsRepeated | GridLayout::CellsMirrored) {
            return self.0.values.iter().copied().fold(0.0, f32::max);
        }
        let to_unit = self.0.to_world.inverse();
        let unit = Bounds3::of_points(corners.map(|p| to_unit.point(p)));
        // A little more, for what rounding does to points.
        let range = |axis: usize| {
            let low = self.coordinate(axis, unit.min[axis]) - 1e-3;
            let high = self.coordinate(axis, unit.max[axis]) + 1e-3;
            let last = self.0.resolution[axis] as i32 - 1;
            (low.floor() as i32).clamp(0, last)..=(high.ceil() as i32).clamp(0, last)
        };
        let mut most = 0.0f32;
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    for c in 0..self.0.channels {
                        most = most.max(self.sample([x, y, z], c));
                    }
                }
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Transform;

    fn grid(layout: GridLayout) -> Grid {
        // 4 x 2 x 1: x + 10 y, in a cube twice as large that begins at 1.
        let values = (0..8).map(|i| (i % 4) as f32 + 10.0 * (i / 4) as f32).collect();
        let to_world = Transform::translate(Vec3::splat(1.0))
            .then_after(&Transform::scale(Vec3::splat(2.0)).expect("not singular"));
        Grid::new(&Arc::new(GridDesc {
            resolution: [4, 2, 1],
            channels: 1,
            values,
            to_world,
            layout,
            filter: GridFilter::Trilinear,
        }))
    }

    #[test]
    fn samples_lie_where_the_formats_have_them() {
        // The unit cube's x at the sample's centre, between two, at a face, and beyond it.
        let cases = [
            (GridLayout::CellsClamped, [0.375, 0.5, 0.0, -1.0], [1.0, 1.5, 0.0, 0.0]),
            (GridLayout::CellsClamped, [0.625, 0.75, 1.0, 2.0], [2.0, 2.5, 3.0, 3.0]),
            (GridLayout::CellsFading, [0.375, 0.5, 1.0, 1.2], [1.0, 1.5, 1.5, 0.0]),
            (GridLayout::Corners, [1.0 / 3.0, 0.5, 0.0, 1.0], [1.0, 1.5, 0.0, 3.0]),
        ];
        for (layout, xs, expected) in cases {
            let grid = grid(layout);
            // In the middle of the lower row, where the fading one has all of it.
            let y = if layout == GridLayout::Corners { 0.0 } else { 0.25 };
            for (x, e) in xs.into_iter().zip(expected) {
                let v = grid.number(Vec3::splat(1.0) + Vec3::new(x, y, 0.5) * 2.0);
                assert!((v - e).abs() < 1e-5, "{layout:?} {x}: {v}, expected {e}");
            }
        }
    }

    /// As Mitsuba 3.9.1 has it of a texture `volume` with five samples along x.
    #[test]
    fn repeated_mirrored_and_nearest() {
        let values = vec![0.158555, 0.952029, 0.154354, 0.510303, 0.144003];
        let desc = |layout, filter| GridDesc {
            resolution: [5, 1, 1],
            channels: 1,
            values: values.clone(),
            to_world: Transform::IDENTITY,
            layout,
            filter,
        };
        use {GridFilter::*, GridLayout::*};
        let cases = [
            (CellsClamped, Nearest, [0.158555, 0.158555, 0.952029, 0.154354, 0.144003, 0.144003]),
            (CellsRepeated, Nearest, [0.510303, 0.158555, 0.952029, 0.154354, 0.144003, 0.952029]),
            (CellsMirrored, Nearest, [0.952029, 0.158555, 0.952029, 0.154354, 0.144003, 0.510303]),
        ];
        for (layout, filter, expected) in cases {
            let grid = Grid::new(&Arc::new(desc(layout, filter)));
            for (x, e) in [-0.25, 0.02, 0.3, 0.41, 0.97, 1.25].into_iter().zip(expected) {
                assert_eq!(grid.number(Vec3::new(x, 0.5, 0.5)), e, "{layout:?} {x}");
            }
        }
        // Linear across the border: half a cell beyond the last sample it is the mean of both.
        let at = |layout, x| {
            Grid::new(&Arc::new(desc(layout, Trilinear))).number(Vec3::new(x, 0.0, 0.0))
        };
        assert!((at(CellsRepeated, 1.0) - 0.5 * (0.158555 + 0.144003)).abs() < 1e-5);
        assert!((at(CellsMirrored, 1.0) - 0.144003).abs() < 1e-5);
        assert!((at(CellsMirrored, 1.2) - 0.5 * (0.144003 + 0.510303)).abs() < 1e-5);
        assert!((at(CellsMirrored, -0.2) - 0.5 * (0.158555 + 0.952029)).abs() < 1e-5);
    }

    #[test]
    fn bounds_hold_every_value() {
        use GridLayout::*;
        for layout in [CellsClamped, CellsRepeated, CellsMirrored, CellsFading, Corners] {
            let grid = grid(layout);
            for i in 0..200u64 {
                let unit = |k: u64| {
                    (kaustika_math::mix_bits(8 * i + k) >> 40) as f32 / (1 << 24) as f32 * 2.4 + 0.8
                };
                let b = Bounds3::new(
                    Vec3::new(unit(1), unit(2), unit(3)),
                    Vec3::new(unit(4), unit(5), unit(6)),
                );
                let bound = grid.bound((0..8).map(|k| b.corner(k)));
                for k in 0..27 {
                    let t = |k: u32| (k % 3) as f32 * 0.5;
                    let d = b.diagonal();
                    let p = b.min + Vec3::new(d.x * t(k), d.y * t(k / 3), d.z * t(k / 9));
                    assert!(grid.number(p) <= bound + 1e-5, "{layout:?} {b:?}");
                }
            }
        }
    }
}
