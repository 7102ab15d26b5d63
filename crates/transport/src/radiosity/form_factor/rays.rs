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
//! scene, L S+ D; more rays look for it where it is known to come from ([`super::windows`]).

use super::{FormFactors, Row};
use crate::path_space::Chain;
use crate::radiosity::mesh::Point;
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

/// Names the rays that look where light is known to come from.
const GUIDED: u64 = 0x6775_6964_6564_2121;

/// A ray along a direction by its cosine.
pub(super) fn by_cosine((x, u): (Point, Vec2)) -> (Point, Vec3) {
    (x, Frame::from_normal(x.n).to_world(warp::cosine_hemisphere(u)))
}

fn segment((x, d): (Point, Vec3)) -> Segment {
    Segment { ray: x.ray(d), t_max: f32::INFINITY }
}

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
        self.starts(i, self.samples, 0).map(by_cosine).map(segment).collect()
    }

    /// Points of patch `i`, and numbers for directions; another set for another `name`.
    pub(super) fn starts(
        &self,
        i: usize,
        n: u32,
        name: u64,
    ) -> impl Iterator<Item = (Point, Vec2)> {
        let (scene, mesh) = (self.scene, self.mesh);
        let e = self.patches[i];
        let key = mix_bits(u64::from(e) ^ name);
        (0..n).map(move |k| {
            // Places and directions are one stratified set each, paired by chance.
            let point = mesh.sample(scene, e, rotated(r2(k), combine(key, 1)));
            let k = permute(k, n, combine(key, 2));
            (point, rotated(r2(k), combine(key, 3)))
        })
    }

    /// (1) and (2).
    pub(super) fn by_rays(&self, i: usize) -> Row {
        let n = self.samples;
        let guide = self.windows.as_ref().and_then(|windows| windows.of(i));
        let rays: Vec<(Point, Vec3)> = self.starts(i, n, 0).map(by_cosine).collect();
        let (mut seen, mut mirrored) = (BTreeMap::<u32, u32>::new(), BTreeMap::new());
        let key = mix_bits(u64::from(self.patches[i]));
        let mut escaped = Spectrum::ZERO;
        let mut add = |(x, d): (Point, Vec3), light: Spectrum| {
            let cos = x.n.dot(d).max(0.0);
            let others = guide.map_or(0.0, |guide| guide.pdf_w(d));
            escaped += light * (cos / (n as f32 * (cos / PI + others)).max(f32::MIN_POSITIVE));
        };
        self.trace(&rays, |k, s| {
            let d = rays[k].1;
            if let Some(j) = self.patch_at(&s, -d) {
                *seen.entry(j).or_default() += 1; // (1)
            }
            if self.chain != Chain::NONE {
                let key = combine(key, 8 + k as u64);
                let light = self.follow(s, d, key, &mut |j, weight| match weight {
                    Some(k) => *mirrored.entry(j).or_insert(Spectrum::ZERO) += k / n as f32, // (2)
                    None => *seen.entry(j).or_default() += 1,
                });
                add(rays[k], light); // (3)
            }
        });
        if let Some(guide) = guide {
            let rays = self.starts(i, n, GUIDED).map(|(x, u)| (x, guide.sample(u)));
            let rays: Vec<_> = rays.filter(|(x, d)| x.n.dot(*d) > 0.0).collect();
            self.escaping(&rays, combine(key, GUIDED), add); // (3)
        }
        let share = 1.0 / n as f32;
        Row {
            outside: escaped,
            seen: seen.into_iter().map(|(j, count)| (j, count as f32 * share)).collect(),
            mirrored: mirrored.into_iter().collect(),
        }
    }

    /// What `found` is told: rays and the Lₑ of (3), weighted, of those that something takes on and that
    /// leave the scene then.
    pub(super) fn escaping(
        &self,
        rays: &[(Point, Vec3)],
        key: u64,
        mut found: impl FnMut((Point, Vec3), Spectrum),
    ) {
        self.trace(rays, |k, s| {
            let light = self.follow(s, rays[k].1, combine(key, 8 + k as u64), &mut |_, _| ());
            if !light.is_black() {
                found(rays[k], light);
            }
        });
    }

    /// What `met` is told: the number of a ray, and the surface that it meets.
    fn trace(&self, rays: &[(Point, Vec3)], mut met: impl FnMut(usize, Surface)) {
        let segments: Vec<Segment> = rays.iter().copied().map(segment).collect();
        let mut batch = RayBatch::default();
        self.scene.hit_all(&segments, &mut batch);
        for (k, segment) in segments.iter().enumerate() {
            if let Some(hit) = batch.hit(k) {
                met(k, self.scene.geometry.surface(&hit, &segment.ray));
            }
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
