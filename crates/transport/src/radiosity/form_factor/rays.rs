//! Form factors by cosine-distributed rays from points of the patch (Malley 1988).
//!
//! ```text
//! F_ij ≈ share of the rays that meet patch j first                                  (1)
//! F_ij += 1/n Πₖ f_S,k |cos| / p_k    over rays by way of mirrors and glass          (2)
//! H_i += π/n Lₑ Πₖ f_S,k |cos| / p_k   over those that leave the scene                (3)
//! ```
//!
//! Nothing is lost or counted twice: rows sum to 1 in a closed scene. (2) are the extended form
//! factors of Sillion & Puech 1989 (mirrors alone: Wallace, Cohen & Greenberg 1987), for all that
//! scatters otherwise than diffusely: D S* D. (3) is what comes through windows from what surrounds the
//! scene, L S+ D.

use super::{FormFactors, Row};
use crate::path_space::Chain;
use crate::radiosity::points::{r2, rotated};
use crate::radiosity::sources::outside;
use kaustika_math::{Frame, Vec2, Vec3, mix_bits, warp};
use kaustika_sampling::hash::{combine, halves, permute, unit};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{RayBatch, Segment, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// Surfaces on the way between two patches at most.
const MOST_MIRRORS: u32 = 16;

impl FormFactors<'_> {
    /// The rays of (1) as directions and the patches that they meet, `u32::MAX` for none.
    pub fn rays_of(&self, i: usize) -> Vec<(Vec3, u32)> {
        let segments = self.segments(i);
        let mut batch = RayBatch::default();
        self.scene.hit_all(&segments, &mut batch);
        let met = |k: usize, segment: &Segment| {
            let hit = batch.hit(k)?;
            let s = self.scene.geometry.surface(&hit, &segment.ray);
            self.patch_at(&s, -segment.ray.d)
        };
        let rays = segments.iter().enumerate();
        rays.map(|(k, segment)| (segment.ray.d, met(k, segment).unwrap_or(u32::MAX))).collect()
    }

    /// Cosine-distributed rays from points of patch `i`.
    pub fn segments(&self, i: usize) -> Vec<Segment> {
        let (scene, mesh) = (self.scene, self.mesh);
        let e = self.patches[i];
        let key = mix_bits(u64::from(e));
        let n = self.samples;
        let segment = |k| {
            // Places and directions are one stratified set each, paired by chance.
            let point = mesh.sample(scene, e, rotated(r2(k), combine(key, 1)));
            let k = permute(k, n, combine(key, 2));
            let local = warp::cosine_hemisphere(rotated(r2(k), combine(key, 3)));
            let d = Frame::from_normal(point.n).to_world(local);
            Segment { ray: point.ray(d), t_max: f32::INFINITY }
        };
        (0..n).map(segment).collect()
    }

    /// (1) and (2).
    pub(super) fn by_rays(&self, i: usize) -> Row {
        let scene = self.scene;
        let key = mix_bits(u64::from(self.patches[i]));
        let n = self.samples;
        let segments = self.segments(i);
        let mut batch = RayBatch::default();
        scene.hit_all(&segments, &mut batch);

        let mut escaped = Spectrum::ZERO;
        let (mut seen, mut mirrored) = (BTreeMap::<u32, u32>::new(), BTreeMap::new());
        for (k, segment) in segments.iter().enumerate() {
            let Some(hit) = batch.hit(k) else { continue };
            let s = scene.geometry.surface(&hit, &segment.ray);
            if let Some(j) = self.patch_at(&s, -segment.ray.d) {
                *seen.entry(j).or_default() += 1; // (1)
            }
            if self.chain != Chain::NONE {
                let key = combine(key, 8 + k as u64);
                escaped += self.follow(s, segment.ray.d, key, &mut |j, weight| match weight {
                    Some(k) => *mirrored.entry(j).or_insert(Spectrum::ZERO) += k / n as f32, // (2)
                    None => *seen.entry(j).or_default() += 1,
                });
            }
        }
        let share = 1.0 / n as f32;
        Row {
            outside: escaped * (PI * share), // (3)
            seen: seen.into_iter().map(|(j, count)| (j, count as f32 * share)).collect(),
            mirrored: mirrored.into_iter().collect(),
        }
    }

    /// The patch at a surface on the side of `w`.
    pub fn patch_at(&self, s: &Surface, w: Vec3) -> Option<u32> {
        self.mesh.locate(self.scene, s, w).map(|(e, _)| self.number[e as usize])
    }

    /// (2): takes a ray along `d` on from a surface as long as something mirrors it; and the Lₑ of (3),
    /// weighted, if it leaves the scene then. What is found straight behind something clear has no weight.
    fn follow(
        &self,
        mut s: Surface,
        mut d: Vec3,
        key: u64,
        found: &mut impl FnMut(u32, Option<Spectrum>),
    ) -> Spectrum {
        let scene = self.scene;
        let mut lambda = Wavelengths::rgb();
        let mut bsdf = Bsdf::default();
        let (mut weight, mut mirrors, mut weighted) = (Spectrum::ONE, 0, false);
        for bounce in 0..MOST_MIRRORS {
            let lobes = self.chain.after(mirrors);
            if !scene.bsdf_into(&s, -d, &mut lambda, &mut bsdf) {
                bsdf = Bsdf::default();
            } else if !bsdf.lobes().has(lobes) {
                return Spectrum::ZERO;
            } else {
                let h = combine(key, 2 * u64::from(bounce));
                let (a, b) = halves(combine(key, 2 * u64::from(bounce) + 1));
                let u2 = Vec2::new(unit(a), unit(b));
                let sample = bsdf.sample(-d, unit(halves(h).0), u2, Mode::Radiance, lobes);
                let Some(sample) = sample.filter(|s| !s.weight.is_black()) else {
                    return Spectrum::ZERO;
                };
                weight *= sample.weight;
                mirrors += u32::from(!sample.lobe.has(Lobes::NULL));
                weighted = true;
                d = sample.wi;
            }
            let ray = s.spawn(d);
            let Some(next) = scene.intersect(&ray, f32::INFINITY) else {
                return match weighted {
                    true => weight * outside(scene, &ray),
                    false => Spectrum::ZERO,
                };
            };
            s = next;
            if let Some(j) = self.patch_at(&s, -d) {
                found(j, weighted.then_some(weight));
            }
        }
        Spectrum::ZERO
    }
}
