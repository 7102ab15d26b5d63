//! An image around the scene that shines in through one rectangle only (Bitterli, Novák and Jarosz,
//! "Portal-Masked Environment Map Sampling", 2015).
//!
//! In the rectified image of directions, with z across the portal,
//!
//! ```text
//! α = atan(x / z), β = atan(y / z),  dω = (1 - x²)(1 - y²) / z dα dβ                        (1)
//! ```
//!
//! a rectangle seen from anywhere is a rectangle, whose corners are those of the portal. So the part
//! of the image that a point sees is sampled exactly, from sums over rectangles:
//!
//! ```text
//! p_αβ = L̄(α, β) / ∫ over the window L̄                                                     (2)
//! ```
//!
//! L̄ is the image's luminance by cells of the rectified image, the radiance the image itself.

use super::sky::Sky;
use kaustika_math::{Frame, Vec2, Vec3};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// Cells along each side of the rectified image.
const CELLS: usize = 512;
/// Lookups along each side of a cell, and what each cell has of the mean at least: interpolated
/// radiance may be brighter than all of them.
const LOOKUPS: usize = 2;
const LEAST: f64 = 0.01;

/// The light, and the rectangle it comes through.
#[derive(Debug)]
pub(super) struct Portal {
    sky: Sky,
    /// Normal outward, tangents along the sides.
    frame: Frame,
    /// Two opposite corners in the frame; of the same z.
    low: Vec3,
    high: Vec3,
    /// Σ of cells before column i and row j, at (CELLS + 1) j + i.
    sums: Vec<f64>,
}

/// A rectangle of the rectified image, in cells.
#[derive(Clone, Copy, Debug)]
struct Window {
    x: [f64; 2],
    y: [f64; 2],
}

impl Portal {
    /// `corners` in order around the rectangle, in world space; the light comes from where the cross
    /// product of the sides from the first to the fourth and to the second points. `None` if they
    /// span no area.
    pub fn new(sky: Sky, corners: [Vec3; 4]) -> Option<Portal> {
        let [a, b, c, d] = corners;
        let s = (d - a).try_normalize()?;
        let n = s.cross(b - a).try_normalize()?;
        let frame = Frame { s, t: n.cross(s), n };
        let local = [a, b, c, d].map(|p| frame.to_local(p));
        let low = local.into_iter().fold(local[0], Vec3::min);
        let high = local.into_iter().fold(local[0], Vec3::max);
        let middle = 0.25 * (local[0].z + local[1].z + local[2].z + local[3].z);
        let flat = |p: Vec3| Vec3::new(p.x, p.y, middle);
        let mut portal = Portal { sky, frame, low: flat(low), high: flat(high), sums: Vec::new() };
        portal.sums = portal.tabulate();
        Some(portal)
    }

    /// Sums over the cells' luminance.
    fn tabulate(&self) -> Vec<f64> {
        let lambda = Wavelengths::rgb();
        let cell = |i: usize, j: usize| -> f64 {
            let n = LOOKUPS * LOOKUPS;
            let at = |k: usize| {
                let offset = |k: usize| (k as f64 + 0.5) / LOOKUPS as f64;
                [i as f64 + offset(k % LOOKUPS), j as f64 + offset(k / LOOKUPS)]
            };
            let rgb = |k| self.sky.escaped(self.direction(at(k)).0).0;
            let y = |k| f64::from(Spectrum::from_rgb(rgb(k)).luminance(&lambda));
            (0..n).map(y).sum::<f64>() / n as f64
        };
        let cells: Vec<f64> = (0..CELLS * CELLS).map(|k| cell(k % CELLS, k / CELLS)).collect();
        let mean = cells.iter().sum::<f64>() / cells.len() as f64;
        let least = if mean > 0.0 { LEAST * mean } else { 1.0 };
        let row = CELLS + 1;
        let mut sums = vec![0.0; row * row];
        for j in 0..CELLS {
            let mut along = 0.0;
            for i in 0..CELLS {
                along += cells[CELLS * j + i] + least;
                sums[row * (j + 1) + i + 1] = sums[row * j + i + 1] + along;
            }
        }
        sums
    }

    /// The world direction of a place of the rectified image, and cells per solid angle there; (1).
    fn direction(&self, [x, y]: [f64; 2]) -> (Vec3, f32) {
        let angle = |v: f64| ((v / CELLS as f64 - 0.5) * std::f64::consts::PI).tan() as f32;
        let local = Vec3::new(angle(x), angle(y), 1.0).normalize();
        (self.frame.to_world(local), cells_per_w(local))
    }

    /// The place of a direction in the frame that goes outward.
    fn place(local: Vec3) -> [f64; 2] {
        [local.x, local.y].map(|v| (f64::from(v.atan2(local.z) / PI) + 0.5) * CELLS as f64)
    }

    /// What a point sees through the portal; nothing from outside.
    fn window(&self, from: Vec3) -> Option<Window> {
        let p = self.frame.to_local(from);
        let (low, high) = (self.low - p, self.high - p);
        if low.z <= 0.0 {
            return None;
        }
        let [[x0, y0], [x1, y1]] = [Portal::place(low), Portal::place(high)];
        (x1 > x0 && y1 > y0).then_some(Window { x: [x0, x1], y: [y0, y1] })
    }

    /// Sum of the cells before (x, y), parts of them counted.
    fn sum(&self, x: f64, y: f64) -> f64 {
        let split = |v: f64| {
            let i = (v.max(0.0) as usize).min(CELLS - 1);
            (i, v - i as f64)
        };
        let ((i, fx), (j, fy)) = (split(x), split(y));
        let at = |i: usize, j: usize| self.sums[(CELLS + 1) * j + i];
        let row = |j: usize| at(i, j) + fx * (at(i + 1, j) - at(i, j));
        row(j) + fy * (row(j + 1) - row(j))
    }

    fn within(&self, w: &Window) -> f64 {
        self.sum(w.x[1], w.y[1]) - self.sum(w.x[0], w.y[1]) - self.sum(w.x[1], w.y[0])
            + self.sum(w.x[0], w.y[0])
    }

    /// (2)
    fn density(&self, [x, y]: [f64; 2], window: &Window) -> f64 {
        let cell = |v: f64| v.max(0.0).floor().min((CELLS - 1) as f64);
        let (i, j) = (cell(x), cell(y));
        let one = Window { x: [i, i + 1.0], y: [j, j + 1.0] };
        let all = self.within(window);
        if all > 0.0 { self.within(&one) / all } else { 0.0 }
    }

    /// A direction that leads out of the portal from a point, its density per solid angle, and the
    /// RGB from there.
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<(Vec3, f32, [f32; 3])> {
        let window = self.window(from)?;
        let all = self.within(&window);
        let share = f64::from(u.x) * all;
        let x = invert(window.x, share, |x| self.within(&Window { x: [window.x[0], x], ..window }));
        // Within the column of cells that x is in.
        let i = x.floor().min((CELLS - 1) as f64);
        let column = |y: f64| self.within(&Window { x: [i, i + 1.0], y: [window.y[0], y] });
        let share = f64::from(u.y) * column(window.y[1]);
        let y = invert(window.y, share, column);
        let (wi, per_w) = self.direction([x, y]);
        let pdf_w = self.density([x, y], &window) as f32 * per_w;
        (pdf_w > 0.0 && pdf_w.is_finite()).then(|| (wi, pdf_w, self.sky.escaped(wi).0))
    }

    /// RGB along a ray that left the scene, and the density of [`Portal::sample`] choosing its
    /// direction from its beginning; `None` if it did not pass the portal.
    pub fn escaped(&self, from: Vec3, wi: Vec3) -> Option<([f32; 3], f32)> {
        let local = self.frame.to_local(wi);
        if local.z <= 0.0 {
            return None;
        }
        let window = self.window(from)?;
        let place @ [x, y] = Portal::place(local);
        let inside =
            (window.x[0]..=window.x[1]).contains(&x) && (window.y[0]..=window.y[1]).contains(&y);
        inside.then(|| {
            let pdf_w = self.density(place, &window) as f32 * cells_per_w(local);
            (self.sky.escaped(wi).0, pdf_w)
        })
    }

    /// A point of the portal, a direction that comes in through it from outside and its density per
    /// solid angle, and the RGB from there.
    pub fn sample_inward(&self, u: Vec2, v: Vec2) -> Option<(Vec3, Vec3, f32, [f32; 3])> {
        let side = self.high - self.low;
        let local = self.low + Vec3::new(side.x * u.x, side.y * u.y, 0.0);
        // All directions are seen from close before the portal.
        let whole = Window { x: [0.0, CELLS as f64], y: [0.0, CELLS as f64] };
        let x = invert(whole.x, f64::from(v.x) * self.within(&whole), |x| {
            self.within(&Window { x: [0.0, x], ..whole })
        });
        let i = x.floor().min((CELLS - 1) as f64);
        let column = |y: f64| self.within(&Window { x: [i, i + 1.0], y: [0.0, y] });
        let y = invert(whole.y, f64::from(v.y) * column(whole.y[1]), column);
        let (wi, per_w) = self.direction([x, y]);
        let pdf_w = self.density([x, y], &whole) as f32 * per_w;
        let sampled = (self.frame.to_world(local), -wi, pdf_w, self.sky.escaped(wi).0);
        (pdf_w > 0.0 && pdf_w.is_finite()).then_some(sampled)
    }

    /// Density of [`Portal::sample_inward`] choosing the direction of a ray that comes in along `w`.
    pub fn pdf_inward(&self, w: Vec3) -> f32 {
        let local = self.frame.to_local(-w);
        let whole = Window { x: [0.0, CELLS as f64], y: [0.0, CELLS as f64] };
        match local.z > 0.0 {
            true => self.density(Portal::place(local), &whole) as f32 * cells_per_w(local),
            false => 0.0,
        }
    }

    /// Its area.
    pub fn area(&self) -> f32 {
        let side = self.high - self.low;
        side.x * side.y
    }

    /// Density of a point of it per area across the direction `w`.
    pub fn pdf_across(&self, w: Vec3) -> f32 {
        1.0 / (self.area() * self.frame.n.abs_dot(w)).max(f32::MIN_POSITIVE)
    }

    /// ∫ L cos θ dω over the directions outward, RGB, by the midpoint rule.
    pub fn irradiance(&self) -> [f32; 3] {
        const N: usize = 256;
        let mut sum = [0.0; 3];
        for k in 0..N * N {
            let u = Vec2::new((k % N) as f32 + 0.5, (k / N) as f32 + 0.5) / N as f32;
            let d = self.frame.to_world(kaustika_math::warp::cosine_hemisphere(u));
            let rgb = self.sky.escaped(d).0;
            sum.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
        }
        sum.map(|v| v * PI / (N * N) as f32)
    }
}

/// (1)
fn cells_per_w(local: Vec3) -> f32 {
    let jacobian = (1.0 - local.x * local.x) * (1.0 - local.y * local.y) / local.z;
    let cells = CELLS as f32 / PI;
    if jacobian > 0.0 { cells * cells / jacobian } else { 0.0 }
}

/// Where a function that grows from the start of a range, linearly from cell to cell, reaches a
/// value.
fn invert([from, to]: [f64; 2], value: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (from.floor() as i64, to.ceil() as i64);
    let within = |i: i64| (i as f64).clamp(from, to);
    while high - low > 1 {
        let middle = (low + high) / 2;
        match f(within(middle)) <= value {
            true => low = middle,
            false => high = middle,
        }
    }
    let (a, b) = (within(low), within(high));
    let (fa, fb) = (f(a), f(b));
    let t = if fb > fa { ((value - fa) / (fb - fa)).clamp(0.0, 1.0) } else { 0.5 };
    // Before the end: the end is the next cell's.
    (a + t * (b - a)).min(b - 1e-9 * (b - a))
}
