//! How alike two pixels are.

use super::plane::Plane;
use super::prepare::Prepared;
use wide::f32x8;

/// Pixels of a window to either side of its centre.
pub const RADIUS: isize = 11;

/// Side of a window.
pub const SIDE: usize = 2 * RADIUS as usize + 1;

/// Lanes of a window's row, 8 at a time.
pub const ROW: usize = SIDE.next_multiple_of(8);

/// Pixels of a patch to either side of its centre.
const PATCH: isize = 2;

/// k² of (1).
const K2: f32 = 0.36;

/// Scales of (2): normal, depth, albedo.
const NORMAL: f32 = 0.3;
const DEPTH: f32 = 0.05;
const ALBEDO: f32 = 0.3;

/// Weights (1), (2) of a window's pixels, row after row; 0 outside of the picture.
pub type Window = [[f32; ROW]; SIDE];

/// Fills in the weights of the window around a pixel.
pub fn weigh<const C: usize>(p: &Prepared<C>, x: isize, y: isize, out: &mut Window) {
    let (width, height) = (p.size.0 as isize, p.size.1 as isize);
    let [_, _, nx, ny, nz, depth, albedo] = &p.features;
    let centre = p.grey.at(x, y);
    let here = |plane: &Plane| f32x8::splat(plane.get(centre));
    let normal = [nx, ny, nz].map(here);
    let (z, a) = (here(depth), here(albedo));
    let slope = f32x8::splat(1.5 * change(&[depth], centre).sqrt());
    let allowed = |planes: &[&Plane], k: f32| f32x8::splat(1.0 / change(planes, centre).max(k * k));
    let (bend, stain) = (allowed(&[nx, ny, nz], NORMAL), allowed(&[albedo], ALBEDO));
    let lanes = f32x8::new(std::array::from_fn(|i| i as f32));
    for (j, row) in out.iter_mut().enumerate() {
        let dy = j as isize - RADIUS;
        if y + dy < 0 || y + dy >= height {
            *row = [0.0; ROW];
            continue;
        }
        for (k, eight) in row.chunks_exact_mut(8).enumerate() {
            let dx = 8 * k as isize - RADIUS;
            let at = p.grey.at(x + dx, y + dy);
            let load = |plane: &Plane| f32x8::new(plane.eight(at));
            // (2)
            let square = |v: f32x8| v * v;
            let turned = square(load(nx) - normal[0])
                + square(load(ny) - normal[1])
                + square(load(nz) - normal[2]);
            let column = lanes + f32x8::splat(dx as f32);
            let steps = column.abs() + f32x8::splat(dy.abs() as f32);
            let off = (load(depth) - z).abs() - slope * steps;
            let features = (turned * bend)
                .max(square(off.max(f32x8::splat(0.0))) * f32x8::splat(1.0 / (DEPTH * DEPTH)))
                .max(square(load(albedo) - a) * stain);
            let d = features.max(patches(p, centre, at));
            // (1 - d/8)⁸ is e⁻ᵈ with an end.
            let w = (f32x8::splat(1.0) - d * f32x8::splat(0.125)).max(f32x8::splat(0.0));
            let w = square(square(square(w)));
            let (first, last) = ((-x) as f32, (width - 1 - x).min(RADIUS) as f32);
            let inside = column.simd_ge(f32x8::splat(first)) & column.simd_le(f32x8::splat(last));
            eight.copy_from_slice(&(w & inside).to_array());
        }
    }
}

/// (1): the distance of the patch around `centre` from those around eight pixels at `other`.
#[inline(always)]
fn patches<const C: usize>(p: &Prepared<C>, centre: usize, other: usize) -> f32x8 {
    let stride = p.grey.stride() as isize;
    let mut sum = f32x8::splat(0.0);
    for dy in -PATCH..=PATCH {
        for dx in -PATCH..=PATCH {
            let shift = dy * stride + dx;
            let (here, there) =
                ((centre as isize + shift) as usize, (other as isize + shift) as usize);
            let off = f32x8::new(p.grey.eight(there)) - f32x8::splat(p.grey.get(here));
            let own = f32x8::splat(p.variance.get(here));
            let theirs = f32x8::new(p.variance.eight(there));
            let above = off * off - (own + own.min(theirs));
            sum += above / ((own + theirs) * f32x8::splat(K2));
        }
    }
    let taps = ((2 * PATCH + 1) * (2 * PATCH + 1)) as f32;
    (sum * f32x8::splat(1.0 / taps)).max(f32x8::splat(0.0))
}

/// How much a pixel's feature differs, squared, from that of its neighbours, of two opposite ones
/// the nearer: what lies between two surfaces is like neither and takes from both.
fn change(planes: &[&Plane], centre: usize) -> f32 {
    let off = |at: usize| planes.iter().map(|p| (p.get(at) - p.get(centre)).powi(2)).sum::<f32>();
    let stride = planes[0].stride();
    let along = |step: usize| off(centre - step).min(off(centre + step));
    along(1).max(along(stride))
}
