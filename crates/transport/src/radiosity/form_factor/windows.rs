//! Where light of the surroundings comes in by way of mirrors and glass, learned, so that rays of patches
//! go there.
//!
//! ```text
//! g(ω) ∝ Σ Lₑ Πₖ f_S,k |cos| / p_k   over cosine-distributed rays of patches nearby, by bins of ω   (1)
//! H_i = Σ_r Lₑ Πₖ f_S,k |cos| / p_k · cos θ_r / (n cos θ_r/π + m g(ω_r))                            (2)
//! ```
//!
//! A window is small beside a hemisphere, and what comes through it is most of the light. (2) is the
//! balance heuristic over n rays by cosine and m by (1) (Veach & Guibas 1995). Patches nearby that face
//! the same way learn together, from rays that estimate nothing.

use super::FormFactors;
use super::rays::by_cosine;
use crate::radiosity::mesh::Element;
use kaustika_math::{Bounds3, Vec2, Vec3, warp};
use kaustika_sampling::distribution::PiecewiseConstant2D;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Rays of a group that learn, at least, and of each of its patches.
const RAYS: (u32, u32) = (4096, 32);
/// Patches that learn together, at most.
const TOGETHER: usize = 128;
/// Bins of ω along each side of the square that the sphere is mapped to.
const BINS: usize = 32;
/// Names the rays that learn.
const KEY: u64 = 0x6c65_6172_6e65_6421;

/// (1) of groups of patches.
pub(super) struct Windows {
    /// The group of each patch.
    group: Vec<u32>,
    /// (1) of each group; `None` where nothing came in.
    guides: Vec<Option<PiecewiseConstant2D>>,
}

/// (1) of a patch.
#[derive(Clone, Copy)]
pub(super) struct Guide<'a>(&'a PiecewiseConstant2D);

impl Guide<'_> {
    /// A direction.
    pub(super) fn sample(self, u: Vec2) -> Vec3 {
        warp::equal_area_square_to_sphere(self.0.sample(u).0)
    }

    /// g, per solid angle.
    pub(super) fn pdf_w(self, d: Vec3) -> f32 {
        self.0.pdf(warp::equal_area_sphere_to_square(d)) / (4.0 * PI)
    }
}

impl Windows {
    /// Learns.
    pub(super) fn learn(ff: &FormFactors) -> Windows {
        let mut groups = Vec::new();
        for axis in 0..6 {
            let mut facing: Vec<u32> =
                (0..ff.len() as u32).filter(|&i| way(ff.element(i as usize)) == axis).collect();
            part(ff, &mut facing, &mut groups);
        }
        let guides = groups.par_iter().map(|patches| guide(ff, patches)).collect();
        let mut group = vec![0; ff.len()];
        for (k, patches) in groups.iter().enumerate() {
            patches.iter().for_each(|&i| group[i as usize] = k as u32);
        }
        Windows { group, guides }
    }

    /// (1) of patch `i`, if anything came in there.
    pub(super) fn of(&self, i: usize) -> Option<Guide<'_>> {
        self.guides[self.group[i] as usize].as_ref().map(Guide)
    }
}

/// Which of six ways an element faces.
fn way(element: &Element) -> usize {
    let axis = element.normal.abs().max_axis();
    2 * axis + usize::from(element.normal[axis] < 0.0)
}

/// Cuts patches into groups that lie together.
fn part(ff: &FormFactors, patches: &mut [u32], groups: &mut Vec<Vec<u32>>) {
    if patches.len() <= TOGETHER {
        return groups.push(patches.to_vec());
    }
    let center = |i: &u32| ff.element(*i as usize).center();
    let middles = patches.iter().fold(Bounds3::EMPTY, |b, i| b.with_point(center(i)));
    let axis = middles.diagonal().max_axis();
    let order = |a: &u32, b: &u32| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b));
    let half = patches.len() / 2;
    patches.select_nth_unstable_by(half, order);
    let (a, b) = patches.split_at_mut(half);
    part(ff, a, groups);
    part(ff, b, groups);
}

/// (1) of some patches.
fn guide(ff: &FormFactors, patches: &[u32]) -> Option<PiecewiseConstant2D> {
    let mut bins = vec![0.0; BINS * BINS];
    let bin = |x: f32| ((x * BINS as f32) as usize).min(BINS - 1);
    let rays = RAYS.1.max(RAYS.0 / patches.len().max(1) as u32);
    for &i in patches.iter().filter(|&&i| !ff.element(i as usize).albedo.is_black()) {
        let rays: Vec<_> = ff.starts(i as usize, rays, KEY).map(by_cosine).collect();
        ff.escaping(&rays, KEY ^ u64::from(i), |(_, d), light| {
            let at = warp::equal_area_sphere_to_square(d);
            bins[bin(at.y) * BINS + bin(at.x)] += light.average();
        });
    }
    PiecewiseConstant2D::new(&bins, BINS, BINS).ok()
}
