//! Illumination maps (Arvo 1986): the light that arrived on a surface, by place.
//!
//! ```text
//! E(x) = Φ_T / A_T,   x in the texel T                                              (1)
//! ```
//!
//! Φ_T is the flux that arrived in the texel, A_T its area. Maps lie on the charts of the surfaces
//! ([`kaustika_scene::ChartPoint`]): a triangle is cut into n² equal triangles, a quadric into rows
//! and columns of equal area. Both sides of a surface have theirs. Only texels that light reached
//! take memory.

use kaustika_scene::{ChartPoint, Scene, Surface};
use kaustika_spectra::Spectrum;
use std::collections::HashMap;

/// Rows and columns of a map at most: beyond, single precision cannot tell places apart.
const MOST: f32 = 65_536.0;

/// A texel: which surface, where on it, on which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Texel {
    instance: Option<u32>,
    /// Of a triangle or an analytic shape, the other being `u32::MAX`.
    primitive: [u32; 2],
    /// Column and row; of the two triangles in a cell of a triangle the upper has `upper` set.
    cell: [u32; 2],
    upper: bool,
    front: bool,
}

/// Flux in a texel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light {
    /// With all its wavelengths.
    pub all: Spectrum,
    /// With the hero wavelength alone: it was dispersed.
    pub hero: Spectrum,
}

/// The illumination maps of all surfaces.
#[derive(Debug)]
pub struct Maps {
    /// Width of a texel, in units of the world.
    width: f32,
    texels: HashMap<Texel, Light>,
}

impl Maps {
    /// Empty ones, of texels about `width` wide.
    pub fn new(width: f32) -> Maps {
        Maps { width, texels: HashMap::new() }
    }

    /// Adds light that arrived at a surface, on its front or its back; `hero` says that it was
    /// dispersed.
    pub fn add(&mut self, scene: &Scene, s: &Surface, front: bool, flux: Spectrum, hero: bool) {
        let Some((texel, _)) = self.texel(scene, s, front) else { return };
        let light = self.texels.entry(texel).or_default();
        *(if hero { &mut light.hero } else { &mut light.all }) += flux;
    }

    /// (1): the irradiance of a surface, from its front or its back.
    pub fn irradiance(&self, scene: &Scene, s: &Surface, front: bool) -> Light {
        let Some((texel, area)) = self.texel(scene, s, front) else { return Light::default() };
        let Some(light) = self.texels.get(&texel) else { return Light::default() };
        let per_area = 1.0 / area.max(f32::MIN_POSITIVE);
        Light { all: light.all * per_area, hero: light.hero * per_area }
    }

    /// The flux in all of them.
    pub fn flux(&self) -> Spectrum {
        self.texels.values().fold(Spectrum::ZERO, |sum, l| sum + l.all + l.hero)
    }

    /// The texel of a place, and its area there; curves have none.
    fn texel(&self, scene: &Scene, s: &Surface, front: bool) -> Option<(Texel, f32)> {
        let chart = scene.geometry.chart(s)?;
        let (cell, upper, count) = self.cell(&chart);
        let (instance, primitive) = (s.instance, [s.triangle, s.analytic]);
        Some((Texel { instance, primitive, cell, upper, front }, chart.area / count))
    }

    /// The cell of a place, whether it is in the upper half of it, and how many texels there are.
    fn cell(&self, chart: &ChartPoint) -> ([u32; 2], bool, f32) {
        let cells = |width: f32| (width / self.width).ceil().clamp(1.0, MOST);
        if chart.triangle {
            let n = cells(chart.size.sqrt());
            let (x, y) = (chart.at.x * n, chart.at.y * n);
            let column = x.floor().clamp(0.0, n - 1.0);
            let row = y.floor().clamp(0.0, n - 1.0 - column);
            // The last cell of a row is cut by the triangle's long side.
            let upper = (x - column) + (y - row) > 1.0 && column + row < n - 1.0;
            return ([column as u32, row as u32], upper, n * n);
        }
        let columns = cells((chart.size * chart.aspect).sqrt());
        let rows = cells((chart.size / chart.aspect).sqrt());
        let cell = |x: f32, n: f32| (x * n).min(n - 1.0) as u32;
        ([cell(chart.at.x, columns), cell(chart.at.y, rows)], false, columns * rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Vec2;

    #[test]
    fn texels_of_a_triangle_have_equal_areas() {
        // 5² texels of a triangle; a grid of points that is uniform over it.
        let maps = Maps::new(0.2);
        let mut counts = HashMap::new();
        const N: usize = 600;
        for i in 0..N * N {
            let at = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.25) / N as f32;
            if at.x + at.y < 1.0 {
                let chart = ChartPoint { at, triangle: true, area: 1.0, size: 0.999, aspect: 1.0 };
                let (cell, upper, count) = maps.cell(&chart);
                assert_eq!(count, 25.0);
                *counts.entry((cell, upper)).or_insert(0) += 1;
            }
        }
        assert_eq!(counts.len(), 25);
        let expected = (N * N / 50) as i32;
        assert!(counts.values().all(|n: &i32| (n - expected).abs() < expected / 50), "{counts:?}");
    }
}
