//! How much of what surrounds a scene arrives where the camera looks.
//!
//! ```text
//! s = mean of Lₑ over rays that leave the scene (0 over the others),   o their part           (1)
//! I_a = s + (1 - o) ρ̄ I_a   =>   I_a = s / (1 - (1 - o) ρ̄)                                (2)
//! ```
//!
//! Phong's ambient light stands for all light that has no direction. A room gets of its sky what comes
//! through its windows, not the whole: (1) follows cosine-distributed rays from places that the camera
//! sees, straight through what is clear, and (2) lets the rest be as bright as the mean, reflected by a
//! mean ρ̄ of what was met.

use super::looks::Look;
use kaustika_math::{Frame, Ray, Vec2, Vec3, warp};
use kaustika_sampling::hash::{combine, halves, unit};
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};
use rayon::prelude::*;

/// Places that the camera sees, along either side of the picture, and rays of each.
const PLACES: u32 = 24;
const RAYS: u32 = 16;
/// Clear surfaces that a ray goes through at most.
const MOST_CLEAR: u32 = 32;

/// What rays from one place found, summed.
#[derive(Clone, Copy, Default)]
struct Found {
    rays: f32,
    sky: Spectrum,
    open: f32,
    albedo: Spectrum,
}

impl Found {
    fn and(self, o: Found) -> Found {
        Found {
            rays: self.rays + o.rays,
            sky: self.sky + o.sky,
            open: self.open + o.open,
            albedo: self.albedo + o.albedo,
        }
    }
}

/// (2), linear RGB; black without anything around the scene, or if the camera sees nothing.
pub fn ambient(scene: &Scene, looks: &[Look]) -> [f32; 3] {
    let flat = scene.camera.flat(0.0).filter(|_| !scene.environments.is_empty());
    let Some(flat) = flat else { return [0.0; 3] };
    let at = |i: u32| {
        let [x, y] = [i % PLACES, i / PLACES].map(|k| (k as f32 + 0.5) / PLACES as f32);
        let film = Vec2::new(x * flat.resolution[0], y * flat.resolution[1]);
        let ray = scene.camera.sample_we(film, Vec2::splat(0.5), 0.0).ray;
        solid(scene, looks, ray).map(|(s, d)| around(scene, looks, &s, d, u64::from(i)))
    };
    // In the order of the places, whatever the threads.
    let found: Vec<Found> = (0..PLACES * PLACES).into_par_iter().filter_map(at).collect();
    let all = found.into_iter().fold(Found::default(), Found::and);
    if all.rays == 0.0 {
        return [0.0; 3];
    }
    let hits = all.rays - all.open;
    let albedo = if hits > 0.0 { all.albedo / hits } else { Spectrum::ZERO };
    let closed = hits / all.rays;
    let left = (Spectrum::ONE - albedo.clamp(0.0, 0.95) * closed).clamp(0.05, 1.0);
    Sensor::default().rgb((all.sky / all.rays).safe_div(left), &Wavelengths::rgb())
}

/// (1) from one place, on the side from which a ray along `d` came.
fn around(scene: &Scene, looks: &[Look], s: &Surface, d: Vec3, key: u64) -> Found {
    let frame = Frame::from_normal(s.facing(-d));
    let mut found = Found { rays: RAYS as f32, ..Found::default() };
    for k in 0..RAYS {
        let (a, b) = halves(combine(key, u64::from(k)));
        // Strata of the square, four by four.
        let u = Vec2::new((k % 4) as f32 + unit(a), (k / 4) as f32 + unit(b)) * 0.25;
        let ray = s.spawn(frame.to_world(warp::cosine_hemisphere(u)));
        match solid(scene, looks, ray) {
            Some((met, d)) => found.albedo += albedo(scene, &met, -d),
            None => {
                found.open += 1.0;
                let lambda = Wavelengths::rgb();
                for &id in &scene.environments {
                    found.sky += scene.light(id).escaped(ray.o, ray.d, &lambda).le;
                }
            }
        }
    }
    found
}

/// The first surface along a ray that is not clear, and the ray's direction.
fn solid(scene: &Scene, looks: &[Look], mut ray: Ray) -> Option<(Surface, Vec3)> {
    for _ in 0..MOST_CLEAR {
        let s = scene.intersect(&ray, f32::INFINITY)?;
        if looks[s.shape as usize].opaque {
            return Some((s, ray.d));
        }
        ray = s.spawn(ray.d);
    }
    None
}

/// The diffuse part of a material, lit and seen along its normal.
fn albedo(scene: &Scene, s: &Surface, wo: Vec3) -> Spectrum {
    let Some(bsdf) = scene.bsdf(s, wo, &mut Wavelengths::rgb()) else { return Spectrum::ZERO };
    let n = bsdf.shading_normal().face_forward(s.facing(wo));
    bsdf.eval(n, n, Mode::Radiance, Lobes::DIFFUSE) * std::f32::consts::PI
}
