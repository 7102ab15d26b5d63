//! Gather directions where the photons came from (Jensen 1995, "Importance driven path tracing
//! using the photon map").
//!
//! ```text
//! P_cell ∝ Σ f Φ over the photons from the cell,   p(ω) = P_cell n² cos θ / π            (4)
//! ```
//!
//! The hemisphere is parted into n² cells of equal projected solid angle.

use super::estimate::Place;
use super::photon::PhotonMap;
use super::tracing::sum;
use crate::nearest::Nearest;
use kaustika_math::warp::{cosine_hemisphere, cosine_hemisphere_pdf_w, disk_inverse};
use kaustika_math::{Frame, ONE_MINUS_EPSILON, Vec2, Vec3};
use kaustika_scene::bsdf::Mode;

/// n.
const SIDE: usize = 8;
/// Photons that it is made from.
const PHOTONS: usize = 50;

/// A distribution of directions.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    frame: Frame,
    /// P of the cells, and the sum of those before.
    pmf: [f32; SIDE * SIDE],
    before: [f32; SIDE * SIDE],
}

impl Guide {
    /// From the photons near a place that are there by matte surfaces; `None` if there are none.
    pub(super) fn new(
        map: &PhotonMap,
        at: &Place,
        radius: f32,
        found: &mut Nearest,
    ) -> Option<Guide> {
        found.begin(PHOTONS, radius * radius);
        map.nearest(at.surface.p, found);
        let frame = Frame::from_normal(at.surface.facing(at.wo));
        let mut pmf = [0.0; SIDE * SIDE];
        let mut total = 0.0;
        for (i, _) in found.iter() {
            let photon = map.photon(i);
            let wi = photon.wi();
            let Some(cell) = cell(frame.to_local(wi)).filter(|_| photon.indirect()) else {
                continue;
            };
            let f = at.bsdf.eval(at.wo, wi, Mode::Radiance, at.lobes);
            let weight = sum(f * photon.power()) / frame.n.dot(wi).max(0.05);
            pmf[cell] += weight;
            total += weight;
        }
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut before = [0.0; SIDE * SIDE];
        let mut sum = 0.0;
        for (p, before) in pmf.iter_mut().zip(&mut before) {
            *before = sum;
            *p /= total;
            sum += *p;
        }
        Some(Guide { frame, pmf, before })
    }

    /// A direction; `u` chooses the cell.
    pub(super) fn sample(&self, u: f32, u2: Vec2) -> Vec3 {
        let mut cell = self.before.partition_point(|&b| b <= u).saturating_sub(1);
        while self.pmf[cell] == 0.0 && cell > 0 {
            cell -= 1;
        }
        let corner = Vec2::new((cell % SIDE) as f32, (cell / SIDE) as f32);
        let at = (corner + u2) / SIDE as f32;
        self.frame.to_world(cosine_hemisphere(at.min(Vec2::splat(ONE_MINUS_EPSILON))))
    }

    /// (4), per solid angle.
    pub(super) fn pdf_w(&self, wi: Vec3) -> f32 {
        let local = self.frame.to_local(wi);
        cell(local).map_or(0.0, |cell| {
            self.pmf[cell] * (SIDE * SIDE) as f32 * cosine_hemisphere_pdf_w(local.z)
        })
    }
}

/// The cell of a local direction above the surface.
fn cell(local: Vec3) -> Option<usize> {
    let square = disk_inverse(Vec2::new(local.x, local.y));
    let along = |v: f32| ((v * SIDE as f32) as usize).min(SIDE - 1);
    (local.z > 0.0).then(|| along(square.y) * SIDE + along(square.x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_the_density() {
        let mut pmf = [0.0; SIDE * SIDE];
        (pmf[3], pmf[20], pmf[63]) = (0.2, 0.5, 0.3);
        let mut before = [0.0; SIDE * SIDE];
        for i in 1..SIDE * SIDE {
            before[i] = before[i - 1] + pmf[i - 1];
        }
        let frame = Frame::from_normal(Vec3::new(0.3, -0.4, 0.5).normalize());
        let guide = Guide { frame, pmf, before };
        // E[1/p] over the directions with P > 0 is their solid angle; E[cos/p] their projected one.
        let n = 100;
        let mut projected = 0.0;
        for i in 0..n * n * n {
            let u = |k: usize| (k as f32 + 0.5) / n as f32;
            let wi = guide.sample(u(i % n), Vec2::new(u(i / n % n), u(i / n / n)));
            projected += f64::from(frame.n.dot(wi) / guide.pdf_w(wi));
        }
        let mean = projected / (n * n * n) as f64;
        let truth = std::f64::consts::PI * 3.0 / 64.0;
        assert!((mean / truth - 1.0).abs() < 1e-2, "{mean} instead of {truth}");
    }
}
