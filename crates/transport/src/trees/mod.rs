//! Paths that split: trees of vertices in one flat list.
//!
//! ```text
//! ⟨L(y)⟩ = (1/q) Σⱼ xⱼ,    xⱼ = dⱼ + wⱼ vⱼ/rⱼ                                             (1)
//! ⟨L²⟩   = (1/q) Σⱼ xⱼ²,   ⟨C⟩ = (1/q) Σⱼ cⱼ                                              (2)
//! ```
//!
//! At a vertex y a path goes on in n = ⌊q + ξ⌋ copies. Copy j asks for light directly (dⱼ), draws a
//! direction with weight wⱼ = f |cos θ|/p, and finds the radiance vⱼ along it, if it survives with
//! probability rⱼ. Paths of light are the same with the importance of the picture in the place of
//! radiance, and are shown to the lens where they arrive. A [`Node`] is one copy: its direction, and what its ray met. Parents stand before
//! their children, so that one sweep from the last node to the first makes all estimates (1) and
//! (2), and with them the records that fields and factors learn from. They are estimates of light
//! as it is, whatever the factors q were: what is learned does not depend on what was decided
//! by it.

use crate::guiding::{LightRecord, ReflectedRecord};
use kaustika_math::{Vec3, mix_bits};
use kaustika_sampling::hash::combine;
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// The parent of a tree's first node.
pub const ROOT: u32 = u32::MAX;
/// Cost of a ray to the next surface.
pub const RAY: f32 = 1.0;
/// Cost of a shadow ray.
const SHADOW: f32 = 0.5;

/// One copy of a path from one vertex to the next.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Number of the node whose ray met the vertex that this one leaves.
    pub parent: u32,
    /// The vertex.
    pub p: Vec3,
    /// Direction drawn, unit, away from the vertex.
    pub w: Vec3,
    /// Its density per solid angle; 0 if there is nothing to be learned of it.
    pub pdf: f32,
    /// Density with which the BSDF alone draws it.
    pub pdf_bsdf: f32,
    /// f |cos θ| over the density.
    pub weight: Spectrum,
    /// Probability with which it survived roulette after the bounce.
    pub survival: f32,
    /// Light found by asking for it, that belongs to this copy.
    pub direct: Spectrum,
    /// True if it asked, for a light or, where its ray ended, for the lens.
    pub asked: bool,
    /// True if its ray was traced.
    pub traced: bool,
    /// Light found where the ray ended, of wavelengths as the parent's.
    pub found: Spectrum,
    /// Distance to there.
    pub distance: f32,
    /// True if the secondary wavelengths had ended before: of spectra the first lane counts.
    pub hero: bool,
    /// True if they ended there.
    pub dispersed: bool,
    /// What the ray met, if a smooth surface scatters it on.
    pub met: Option<Met>,
    /// 1/q there.
    pub inv_q: f32,
    /// Σ xⱼ of its copies.
    pub sum: Spectrum,
    /// Σ xⱼ².
    pub squares: f32,
    /// Σ cⱼ.
    pub costs: f32,
}

/// A vertex where something can be learned of reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// Where.
    pub p: Vec3,
    /// Mean albedo toward the path.
    pub albedo: f32,
}

impl Node {
    /// The first node of a tree: its direction is given.
    pub fn root(p: Vec3, w: Vec3) -> Node {
        Node {
            parent: ROOT,
            p,
            w,
            pdf: 0.0,
            pdf_bsdf: 0.0,
            weight: Spectrum::ONE,
            survival: 1.0,
            direct: Spectrum::ZERO,
            asked: false,
            traced: true,
            found: Spectrum::ZERO,
            distance: 0.0,
            hero: false,
            dispersed: false,
            met: None,
            inv_q: 1.0,
            sum: Spectrum::ZERO,
            squares: 0.0,
            costs: 0.0,
        }
    }

    /// A copy that leaves the vertex at `p`, met by the ray of node `parent`, and has no direction.
    pub fn copy(parent: u32, p: Vec3) -> Node {
        Node { parent, traced: false, ..Node::root(p, Vec3::ZERO) }
    }

    /// Radiance along its ray: found where it ended, and reflected there (1).
    pub fn value(&self) -> Spectrum {
        let reflected = self.sum * self.inv_q;
        self.found + if self.dispersed { hero_for_all(reflected) } else { reflected }
    }
}

/// Radiance at a hero wavelength alone, for a path that has four: the others' shares are its own.
pub fn hero_for_all(s: Spectrum) -> Spectrum {
    Spectrum([4.0 * s[0], 0.0, 0.0, 0.0])
}

/// The mean over the lanes in use.
pub fn mean(s: Spectrum, lambda: &Wavelengths) -> f32 {
    grey(s, lambda.mode, lambda.secondary_terminated())
}

#[inline]
fn grey(s: Spectrum, mode: ColorMode, hero: bool) -> f32 {
    match mode {
        ColorMode::Rgb => (s[0] + s[1] + s[2]) * (1.0 / 3.0),
        ColorMode::Spectral if hero => s[0],
        ColorMode::Spectral => s.average(),
    }
}

/// Where records go; `None`: nothing is learned.
#[derive(Debug, Default)]
pub struct Records {
    /// Of directions.
    pub light: Vec<LightRecord>,
    /// Of vertices.
    pub reflected: Vec<ReflectedRecord>,
}

impl Records {
    /// Puts numbers at random in the place of what was found, and of the pixels' `values`; nothing
    /// at all in places. What a method renders must stay right.
    pub fn mislead(&mut self, values: &mut [f32], index: u64) {
        for (i, r) in self.light.iter_mut().enumerate() {
            r.radiance = if r.w.x > 0.2 { 0.0 } else { nonsense(index, i, 0) };
            r.product = r.pdf * nonsense(index, i, 1);
        }
        for (i, r) in self.reflected.iter_mut().enumerate() {
            (r.mean, r.cost) = (nonsense(index, i, 2), 1.0 + nonsense(index, i, 3));
            r.moment = r.mean * r.mean;
        }
        values.iter_mut().enumerate().for_each(|(i, v)| *v = nonsense(index, i, 4));
    }
}

/// A number between 0 and e⁸ for [`Records::mislead`].
pub fn nonsense(index: u64, i: usize, k: u64) -> f32 {
    let x = (mix_bits(combine(combine(index, k), i as u64)) >> 40) as f32 / (1u32 << 24) as f32;
    if x < 0.3 { 0.0 } else { (8.0 * x).exp() }
}

/// Makes the estimates of all nodes, and the records.
pub fn sweep(nodes: &mut [Node], mode: ColorMode, mut records: Option<&mut Records>) {
    let grey = |s: Spectrum, hero: bool| grey(s, mode, hero);
    for i in (0..nodes.len()).rev() {
        let (before, from) = nodes.split_at_mut(i);
        let node = &from[0];
        let value = node.value();
        if let (Some(records), Some(met)) = (&mut records, node.met) {
            records.reflected.push(ReflectedRecord {
                p: met.p,
                wo: -node.w,
                albedo: met.albedo,
                mean: grey(node.sum, node.hero || node.dispersed) * node.inv_q,
                moment: node.squares * node.inv_q,
                cost: node.costs * node.inv_q,
            });
        }
        let Some(parent) = before.get_mut(node.parent as usize) else { continue };
        let carried = node.weight * value;
        let x = node.direct + carried * (1.0 / node.survival);
        let of_rays =
            RAY * f32::from(u8::from(node.traced)) + SHADOW * f32::from(u8::from(node.asked));
        parent.sum += x;
        parent.squares += grey(x, node.hero).powi(2);
        parent.costs += of_rays + node.costs * node.inv_q;
        if let Some(records) = records.as_mut().filter(|_| node.pdf > 0.0) {
            records.light.push(LightRecord {
                p: node.p,
                w: node.w,
                pdf: node.pdf,
                // Those who survived stand for those who did not, which count as nothing.
                radiance: grey(value, node.hero) / node.survival,
                distance: node.distance,
                pdf_bsdf: node.pdf_bsdf,
                product: grey(carried, node.hero) * node.pdf / node.survival,
            });
        }
    }
}
