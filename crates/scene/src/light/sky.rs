//! An image around the scene, kept in half floats (see [`Texels`]).
//!
//! Latitude-longitude images are interpolated between columns periodically and between rows
//! that span pole to pole (row 0 at +y, the last at -y), as Mitsuba does; octahedral ones
//! between texel centres with their borders folded, as pbrt-v4 does.
//!
//! ```text
//! latitude-longitude: p_ω = P(cell) w (h - 1) b(x, y) / (2π² sin θ)                        (1)
//! octahedral:         p_ω = P(cell) w h / 4π                                              (2)
//! ```
//!
//! A latitude-longitude map's cells lie between four texel centres. Their probabilities P are
//! those of the mean of luminance times sin θ, and b is the density within a cell that
//! interpolates it between the corners, so that the product follows the interpolated luminance
//! (Mitsuba's continuous distributions do so too). An octahedral map's cells are its texels, by their mean luminance.

use super::texels::{Texels, blend};
use crate::description::EnvironmentLayout;
use crate::texture::ImageMap;
use kaustika_math::{INV_PI, Transform, Vec2, Vec3, safe_acos, warp};
use kaustika_sampling::distribution::{
    TileChoice, Tiled2D, TiledSample, bilinear_pdf, sample_bilinear,
};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// Regions along each side at most: about 11° of longitude and of latitude.
const MOST_REGIONS: [usize; 2] = [32, 16];

/// Radiance from an image.
#[derive(Debug)]
pub(super) struct Sky {
    /// The fourth number of a latitude-longitude texel is its luminance times sin θ.
    texels: Texels,
    layout: EnvironmentLayout,
    to_world: Transform,
    from_world: Transform,
    /// Mean RGB over the sphere.
    mean: [f32; 3],
    /// Probabilities of the cells; `None` where all are black or there are none: directions are
    /// then uniform over the sphere.
    cells: Option<Tiled2D>,
}

/// A direction, its density per solid angle and the RGB from there.
pub(super) type SkySample = (Vec3, f32, [f32; 3]);

/// A place of the image: a cell, and where in it.
#[derive(Clone, Copy, Debug)]
struct Place {
    cell: [usize; 2],
    t: Vec2,
}

impl Sky {
    /// Around the scene; only the rotation of `to_world` matters.
    pub fn new(image: &ImageMap, layout: EnvironmentLayout, to_world: Transform) -> Sky {
        let height = image.height as usize;
        let texels = Texels::new(image, |_, y, rgb| {
            let theta = PI * y as f32 / (height.max(2) - 1) as f32;
            theta.sin().max(0.0) * luminance(rgb)
        });
        let from_world = to_world.inverse();
        let mean = mean(image, layout);
        let mut sky = Sky { texels, layout, to_world, from_world, mean, cells: None };
        let size @ [w, h] = sky.size();
        let weights: Vec<f32> = (0..w * h).map(|k| sky.weight([k % w, k / w])).collect();
        sky.cells = Tiled2D::new(&weights, size, MOST_REGIONS).ok();
        sky
    }

    /// Columns and rows of cells.
    fn size(&self) -> [usize; 2] {
        let [w, h] = self.texels.size();
        match self.layout {
            EnvironmentLayout::LatLong => [w, h - 1],
            EnvironmentLayout::EqualArea => [w, h],
        }
    }

    /// What a cell's probability is proportional to.
    fn weight(&self, cell @ [i, j]: [usize; 2]) -> f32 {
        match self.layout {
            EnvironmentLayout::LatLong => {
                self.corners(cell).iter().map(|texel| 0.25 * texel[3]).sum()
            }
            EnvironmentLayout::EqualArea => {
                // A bilinear function's mean over a texel: weights 1/8, 3/4, 1/8 each way.
                let mut sum = 0.0;
                for (dy, wy) in [(-1i64, 0.125), (0, 0.75), (1, 0.125)] {
                    for (dx, wx) in [(-1i64, 0.125), (0, 0.75), (1, 0.125)] {
                        let [r, g, b, _] = self.folded(i as i64 + dx, j as i64 + dy);
                        sum += wx * wy * luminance([r, g, b]);
                    }
                }
                sum
            }
        }
    }

    /// Mean RGB over the sphere, to which every texel counts, however small a sun it is.
    pub fn mean(&self) -> [f32; 3] {
        self.mean
    }

    /// RGB from the light-space direction `d`, unit.
    pub fn radiance(&self, d: Vec3) -> [f32; 3] {
        self.look(self.place(d)).0
    }

    /// RGB along a ray that left the scene along `wi`, the density of [`Sky::sample`] choosing
    /// it, and its region.
    #[inline]
    pub fn escaped(&self, wi: Vec3) -> ([f32; 3], f32, u32) {
        let d = self.from_world.vector(wi).normalize();
        let place = self.place(d);
        let (rgb, within) = self.look(place);
        let Some(cells) = &self.cells else { return (rgb, warp::UNIFORM_SPHERE_PDF_W, 0) };
        let pdf_w = cells.pmf(place.cell) * within * self.cells_per_w(d);
        (rgb, pdf_w, cells.region_of(place.cell) as u32)
    }

    /// Columns and rows of regions.
    pub fn regions(&self) -> [usize; 2] {
        self.cells.as_ref().map_or([1, 1], Tiled2D::regions)
    }

    /// Probability that [`Sky::sample`] chooses a direction of a region.
    #[inline]
    pub fn region_pmf(&self, region: u32) -> f32 {
        self.cells.as_ref().map_or(1.0, |cells| cells.region_pmf(region as usize))
    }

    /// A direction, of one region if that is given; then its density is that within the region.
    /// A place of the image is looked up as it was chosen, not by way of its direction.
    #[inline]
    pub fn sample(&self, region: Option<u32>, u: Vec2) -> Option<SkySample> {
        match self.choose(region, u) {
            Some(tile) => self.sample_cell(&self.cell(&tile)?),
            None => {
                let d = warp::uniform_sphere(u);
                Some((self.world(d), warp::UNIFORM_SPHERE_PDF_W, self.radiance(d)))
            }
        }
    }

    /// The first step of [`Sky::sample`], a tile, which is then [touched](Sky::touch_tile).
    /// `None` if directions are uniform.
    #[inline]
    pub fn choose(&self, region: Option<u32>, u: Vec2) -> Option<TileChoice> {
        Some(self.cells.as_ref()?.choose_tile(region.map(|r| r as usize), u))
    }

    /// Reads what [`Sky::cell`] will need.
    #[inline(always)]
    pub fn touch_tile(&self, tile: &TileChoice) {
        if let Some(cells) = &self.cells {
            cells.touch(tile);
        }
    }

    /// The second step of [`Sky::sample`], a cell, which is then [touched](Sky::touch).
    #[inline]
    pub fn cell(&self, tile: &TileChoice) -> Option<TiledSample> {
        Some(self.cells.as_ref()?.sample_tile(tile))
    }

    /// Reads what [`Sky::sample_cell`] will need.
    #[inline(always)]
    pub fn touch(&self, s: &TiledSample) {
        let [x, y] = s.cell;
        let [w, h] = self.texels.size();
        for (x, y) in [(x, y), ((x + 1).min(w - 1), (y + 1).min(h - 1))] {
            std::hint::black_box(self.texels.get(x, y)[3]);
        }
    }

    /// The last step of [`Sky::sample`], a direction of a cell.
    #[inline]
    pub fn sample_cell(&self, s: &TiledSample) -> Option<SkySample> {
        let t = match self.layout {
            EnvironmentLayout::LatLong => {
                sample_bilinear(s.u, self.corners(s.cell).map(|texel| texel[3]))
            }
            EnvironmentLayout::EqualArea => s.u,
        };
        let place = Place { cell: s.cell, t };
        let d = self.direction(place);
        let (rgb, within) = self.look(place);
        let pdf_w = s.pmf * within * self.cells_per_w(d);
        (pdf_w > 0.0 && pdf_w.is_finite()).then(|| (self.world(d), pdf_w, rgb))
    }

    /// World-space direction.
    #[inline]
    fn world(&self, d: Vec3) -> Vec3 {
        self.to_world.vector(d).normalize()
    }

    /// Cells per solid angle about the light-space direction `d`; (1) or (2) without P and b.
    #[inline]
    fn cells_per_w(&self, d: Vec3) -> f32 {
        let [w, h] = self.size();
        let cells = (w * h) as f32;
        match self.layout {
            EnvironmentLayout::LatLong => {
                let sin = (d.x * d.x + d.z * d.z).sqrt();
                if sin > 0.0 { cells / (2.0 * PI * PI * sin) } else { 0.0 } // (1)
            }
            EnvironmentLayout::EqualArea => cells * warp::UNIFORM_SPHERE_PDF_W, // (2)
        }
    }

    /// RGB at a place, and its density within its cell.
    #[inline]
    fn look(&self, Place { cell, t }: Place) -> ([f32; 3], f32) {
        match self.layout {
            EnvironmentLayout::LatLong => {
                let corners = self.corners(cell);
                (blend(&corners, t.x, t.y), bilinear_pdf(t, corners.map(|texel| texel[3])))
            }
            EnvironmentLayout::EqualArea => {
                let (x, y) = (t.x - 0.5, t.y - 0.5);
                let (i, j) = (cell[0] as i64 + x.floor() as i64, cell[1] as i64 + y.floor() as i64);
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let corners = corners.map(|(dx, dy)| self.folded(i + dx, j + dy));
                (blend(&corners, x - x.floor(), y - y.floor()), 1.0)
            }
        }
    }

    /// The texels at the corners of a latitude-longitude map's cell.
    #[inline]
    fn corners(&self, [x0, y0]: [usize; 2]) -> [[f32; 4]; 4] {
        let [w, h] = self.texels.size();
        let x1 = if x0 + 1 < w { x0 + 1 } else { 0 };
        let y1 = (y0 + 1).min(h - 1);
        let t = &self.texels;
        [t.get(x0, y0), t.get(x1, y0), t.get(x0, y1), t.get(x1, y1)]
    }

    /// A texel of an octahedral map, also beyond its borders.
    #[inline]
    fn folded(&self, x: i64, y: i64) -> [f32; 4] {
        let [w, h] = self.texels.size();
        let [i, j] = fold(x, y, [w as i64, h as i64]);
        self.texels.get(i as usize, j as usize)
    }

    /// Where a light-space direction meets the image.
    #[inline]
    fn place(&self, d: Vec3) -> Place {
        let p = match self.layout {
            // A cell begins at the first texel's centre.
            EnvironmentLayout::LatLong => {
                let p = lat_long_square(d);
                let u = p.x - 0.5 / self.texels.size()[0] as f32;
                Vec2::new(u - u.floor(), p.y)
            }
            EnvironmentLayout::EqualArea => warp::equal_area_sphere_to_square(d),
        };
        let [w, h] = self.size();
        let (x, y) = (p.x * w as f32, p.y * h as f32);
        // A one-row map has no cell; it is looked up as one row of them.
        let cell = [(x as usize).min(w - 1), (y as usize).min(h.max(1) - 1)];
        Place { cell, t: Vec2::new(x - cell[0] as f32, y - cell[1] as f32) }
    }

    /// The light-space direction of a place.
    #[inline]
    fn direction(&self, Place { cell, t }: Place) -> Vec3 {
        let [w, h] = self.size();
        let x = (cell[0] as f32 + t.x) / w as f32;
        let y = (cell[1] as f32 + t.y) / h as f32;
        match self.layout {
            EnvironmentLayout::LatLong => {
                let phi = 2.0 * PI * (x + 0.5 / w as f32);
                let ((st, ct), (sp, cp)) = ((PI * y).sin_cos(), phi.sin_cos());
                Vec3::new(sp * st, ct, -cp * st)
            }
            EnvironmentLayout::EqualArea => warp::equal_area_square_to_sphere(Vec2::new(x, y)),
        }
    }
}

/// ∫ RGB dω / 4π of the interpolated image. A row of a latitude-longitude map, δ from its
/// neighbours, counts with
///
/// ```text
/// ∫ (1 - |x|/δ) sin(θ + x) dx / 2 = sin θ (1 - cos δ)/δ;   at a pole (1 - sin δ/δ)/2
/// ```
fn mean(image: &ImageMap, layout: EnvironmentLayout) -> [f32; 3] {
    let (w, h) = (image.width, image.height);
    let weight = |y: u32| match layout {
        EnvironmentLayout::LatLong if h > 1 => {
            let step = std::f64::consts::PI / f64::from(h - 1);
            let row = match y == 0 || y == h - 1 {
                true => 0.5 * (1.0 - step.sin() / step),
                false => (step * f64::from(y)).sin() * (1.0 - step.cos()) / step,
            };
            row / f64::from(w)
        }
        _ => 1.0 / (f64::from(w) * f64::from(h)),
    };
    let mut sum = [0.0; 3];
    for y in 0..h {
        let weight = weight(y);
        for x in 0..w {
            let rgb = image.texel(x, y);
            sum.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += weight * f64::from(v));
        }
    }
    sum.map(|v| v as f32)
}

/// (u, v) of a direction: u = atan2(x, -z)/2π in [0,1), v = acos(y)/π.
fn lat_long_square(d: Vec3) -> Vec2 {
    let u = d.x.atan2(-d.z) / (2.0 * PI);
    Vec2::new(u - u.floor(), safe_acos(d.y) * INV_PI)
}

/// Texels beyond a border of an octahedral map continue where the border is folded: mirrored
/// along the border.
fn fold(mut x: i64, mut y: i64, n: [i64; 2]) -> [i64; 2] {
    if x < 0 {
        x = -1 - x;
        y = n[1] - 1 - y;
    } else if x >= n[0] {
        x = 2 * n[0] - 1 - x;
        y = n[1] - 1 - y;
    }
    if y < 0 {
        x = n[0] - 1 - x;
        y = -1 - y;
    } else if y >= n[1] {
        x = n[0] - 1 - x;
        y = 2 * n[1] - 1 - y;
    }
    [x.clamp(0, n[0] - 1), y.clamp(0, n[1] - 1)]
}

fn luminance(rgb: [f32; 3]) -> f32 {
    Spectrum::from_rgb(rgb).luminance(&Wavelengths::rgb())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_has_the_field_s_orientation() {
        // Mitsuba: u = 1/4 looks along +x, u = 1/2 along +z, v = 0 along +y.
        assert!((lat_long_square(Vec3::X) - Vec2::new(0.25, 0.5)).length() < 1e-6);
        assert!((lat_long_square(Vec3::Z) - Vec2::new(0.5, 0.5)).length() < 1e-6);
        assert!(lat_long_square(Vec3::Y).y < 1e-6);
        // Octahedral borders fold onto themselves.
        assert_eq!(fold(-1, 2, [8, 8]), [0, 5]);
        assert_eq!(fold(3, 8, [8, 8]), [4, 7]);
        assert_eq!(fold(-1, -1, [8, 8]), [7, 7]);
    }

    /// Against a fine grid of directions; and a sun of one texel, which such a grid may miss.
    #[test]
    fn the_mean_is_that_of_all_directions() {
        for layout in [EnvironmentLayout::LatLong, EnvironmentLayout::EqualArea] {
            let value = |k: u64| 0.1 + (kaustika_math::mix_bits(k) % 1000) as f32 / 300.0;
            let mut texels: Vec<[f32; 3]> = (0..24 * 24).map(|k| [value(k), 1.0, 0.0]).collect();
            let image = ImageMap { width: 24, height: 24, texels: texels.clone() };
            let sky = Sky::new(&image, layout, Transform::IDENTITY);
            let n = 400;
            let grid = (0..n * n).map(|i| {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                f64::from(sky.radiance(warp::uniform_sphere(u))[0])
            });
            let expected = grid.sum::<f64>() / (n * n) as f64;
            let [r, g, b] = sky.mean().map(f64::from);
            assert!((r / expected - 1.0).abs() < 1e-3, "{layout:?} {r} {expected}");
            assert!((g - 1.0).abs() < 1e-5 && b == 0.0, "{layout:?} {g} {b}");
            texels.fill([0.0; 3]);
            texels[24 * 7 + 3] = [1e6; 3];
            let sun = Sky::new(&ImageMap { texels, ..image }, layout, Transform::IDENTITY);
            assert!(sun.mean()[0] > 1e6 / 1000.0, "{layout:?}");
        }
    }

    #[test]
    fn a_place_is_where_its_direction_leads() {
        for layout in [EnvironmentLayout::LatLong, EnvironmentLayout::EqualArea] {
            let texels = (0..20 * 12).map(|k| [k as f32; 3]).collect();
            let image = ImageMap { width: 20, height: 12, texels };
            let sky = Sky::new(&image, layout, Transform::IDENTITY);
            let [w, h] = sky.size();
            for k in 0..w * h {
                let cell = [k % w, k / w];
                let there = Place { cell, t: Vec2::new(0.3, 0.8) };
                let found = sky.place(sky.direction(there));
                assert_eq!(found.cell, cell, "{layout:?}");
                assert!((found.t - there.t).length() < 1e-3, "{layout:?} {found:?}");
            }
        }
    }

    #[test]
    fn lat_long_densities_follow_the_interpolated_luminance() {
        let value = |k: u64| 0.1 + (kaustika_math::mix_bits(k) % 1000) as f32;
        let texels = (0..40 * 30).map(|k| [value(k); 3]).collect();
        let image = ImageMap { width: 40, height: 30, texels };
        let sky = Sky::new(&image, EnvironmentLayout::LatLong, Transform::IDENTITY);
        let mut ratios = Vec::new();
        for i in 0..500 {
            // Between two rows of texels sin θ is interpolated, too: looked up at the rows.
            let y = ((i * 7) % 28 + 1) as f32 / 29.0;
            let phi = i as f32 * 0.4;
            let ((st, ct), (sp, cp)) = ((PI * y).sin_cos(), phi.sin_cos());
            let (rgb, pdf, _) = sky.escaped(Vec3::new(sp * st, ct, -cp * st));
            ratios.push(pdf / rgb[0]);
        }
        let mean = ratios.iter().sum::<f32>() / 500.0;
        assert!(ratios.iter().all(|r| (r / mean - 1.0).abs() < 3e-3), "{ratios:?}");
    }
}
