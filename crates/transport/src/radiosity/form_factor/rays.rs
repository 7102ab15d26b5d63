//! Form factors by cosine-distributed rays from points of the patch (Malley 1988).
//!
//! ```text
//! F_ij ≈ share of the rays that meet patch j first                                  (1)
//! F_ij += 1/n Πₖ f_S,k |cos| / p_k    over rays by way of mirrors and glass          (2)
//! ```
//!
//! Nothing is lost or counted twice: rows sum to 1 in a closed scene. (2) are the extended form
//! factors of Sillion & Puech 1989 (mirrors alone: Wallace, Cohen & Greenberg 1987), for all that
//! scatters otherwise than diffusely: D S* D.

use super::{FormFactors, Row};
use crate::path_space::Chain;
use crate::radiosity::points::{r2, rotated};
use kaustika_math::{Frame, Vec2, Vec3, mix_bits, warp};
use kaustika_sampling::hash::{combine, halves, permute, unit};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{RayBatch, Segment, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::collections::BTreeMap;

/// Surfaces on the way between two patches at most.
const MOST_MIRRORS: u32 = 16;

impl FormFactors<'_> {
    /// (1) and (2).
    pub(super) fn by_rays(&self, i: usize) -> Row {
        let (scene, mesh) = (self.scene, self.mesh);
        let e = self.patches[i];
        let key = mix_bits(u64::from(e));
        let n = self.samples;
        let segments: Vec<Segment> = (0..n)
            .map(|k| {
                // Places and directions are one stratified set each, paired by chance.
                let point = mesh.sample(scene, e, rotated(r2(k), combine(key, 1)));
                let k = permute(k, n, combine(key, 2));
                let local = warp::cosine_hemisphere(rotated(r2(k), combine(key, 3)));
                let d = Frame::from_normal(point.n).to_world(local);
                Segment { ray: point.ray(d), t_max: f32::INFINITY }
            })
            .collect();
        let mut batch = RayBatch::default();
        scene.hit_all(&segments, &mut batch);

        let (mut seen, mut mirrored) = (BTreeMap::<u32, u32>::new(), BTreeMap::new());
        for (k, segment) in segments.iter().enumerate() {
            let Some(hit) = batch.hit(k) else { continue };
            let s = scene.geometry.surface(&hit, &segment.ray);
            if let Some(j) = self.patch_at(&s, -segment.ray.d) {
                *seen.entry(j).or_default() += 1; // (1)
            }
            if self.chain != Chain::NONE {
                self.follow(s, segment.ray.d, combine(key, 8 + k as u64), &mut |j, weight| {
                    *mirrored.entry(j).or_insert(Spectrum::ZERO) += weight / n as f32; // (2)
                });
            }
        }
        let share = 1.0 / n as f32;
        Row {
            seen: seen.into_iter().map(|(j, count)| (j, count as f32 * share)).collect(),
            mirrored: mirrored.into_iter().collect(),
        }
    }

    /// The patch at a surface on the side of `w`.
    fn patch_at(&self, s: &Surface, w: Vec3) -> Option<u32> {
        self.mesh.locate(self.scene, s, w).map(|(e, _)| self.number[e as usize])
    }

    /// (2): takes a ray along `d` on from a surface as long as something mirrors it.
    fn follow(&self, mut s: Surface, mut d: Vec3, key: u64, found: &mut impl FnMut(u32, Spectrum)) {
        let scene = self.scene;
        let mut lambda = Wavelengths::rgb();
        let mut bsdf = Bsdf::default();
        let (mut weight, mut mirrors) = (Spectrum::ONE, 0);
        for bounce in 0..MOST_MIRRORS {
            let lobes = self.chain.after(mirrors);
            if !scene.bsdf_into(&s, -d, &mut lambda, &mut bsdf) {
                bsdf = Bsdf::default();
            } else if !bsdf.lobes().has(lobes) {
                return;
            } else {
                let h = combine(key, 2 * u64::from(bounce));
                let (a, b) = halves(combine(key, 2 * u64::from(bounce) + 1));
                let u2 = Vec2::new(unit(a), unit(b));
                let sample = bsdf.sample(-d, unit(halves(h).0), u2, Mode::Radiance, lobes);
                let Some(sample) = sample.filter(|s| !s.weight.is_black()) else { return };
                weight *= sample.weight;
                mirrors += u32::from(!sample.lobe.has(Lobes::NULL));
                d = sample.wi;
            }
            let ray = s.spawn(d);
            let Some(next) = scene.intersect(&ray, f32::INFINITY) else { return };
            s = next;
            if let Some(j) = self.patch_at(&s, -d) {
                found(j, weight);
            }
        }
    }
}
