//! Paths that split: trees of vertices in one flat list.
//!
//! ```text
//! ⟨L(y)⟩ = (1/q) Σⱼ xⱼ,    xⱼ = dⱼ + wⱼ vⱼ/rⱼ                                             (1)
//! ⟨L²⟩   = (1/q) Σⱼ xⱼ²,   ⟨C⟩ = (1/q) Σⱼ cⱼ                                              (2)
//! ⟨V⟩    = (Σⱼ xⱼ² - (Σⱼ xⱼ)²/n)/(n - 1)   where n > 1                                     (3)
//! ⟨P⟩    = e² + (1/q) Σⱼ (dⱼ² + wⱼ² p(ω)/p_bsdf(ω) Pⱼ/rⱼ)                               (4)
//! ```
//!
//! At a vertex y a path goes on in n = ⌊q + ξ⌋ copies. Copy j asks for light directly (dⱼ), draws a
//! direction with weight wⱼ = f |cos θ|/p, and finds the radiance vⱼ along it, if it survives with
//! probability rⱼ. Paths of light are the same with the importance of the picture in the place of
//! radiance, and are shown to the lens where they arrive. A [`Node`] is one copy: its direction, and what its ray met. Parents stand before
//! their children, so that one sweep from the last node to the first makes all estimates (1) to
//! (4), and with them the records that fields and factors learn from. They are estimates of light
//! as it is, whatever the factors q were: what is learned does not depend on what was decided
//! by it.
//!
//! P is the second moment of what plain paths would find there, e being light where the ray ended: with
//! directions by the BSDF alone a sample weighs p/p_bsdf times as much and is p/p_bsdf times as rare.
//! That contributions of one path go together is left out, and P too small by it. Plain paths
//! themselves tell it badly as long as they have missed what is bright.

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
    /// n.
    pub copies: u32,
    /// Σⱼ of (4).
    pub plain: f32,
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
            copies: 0,
            plain: 0.0,
        }
    }

    /// A copy that leaves the vertex at `p`, met by the ray of node `parent`, and has no direction.
    pub fn copy(parent: u32, p: Vec3) -> Node {
        Node { parent, traced: false, ..Node::root(p, Vec3::ZERO) }
    }

    /// (4), where the light that was found is grey.
    pub fn plain(&self, found: f32) -> f32 {
        found * found + self.plain * self.inv_q
    }

    /// (3), for copies whose sum is `sum`.
    fn variance(&self, sum: f32) -> Option<f32> {
        let n = self.copies as f32;
        (self.copies > 1).then(|| ((self.squares - sum * sum / n) / (n - 1.0)).max(0.0))
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
            r.variance = r.variance.map(|_| nonsense(index, i, 5));
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
            let sum = grey(node.sum, node.hero || node.dispersed);
            records.reflected.push(ReflectedRecord {
                p: met.p,
                wo: -node.w,
                albedo: met.albedo,
                mean: sum * node.inv_q,
                moment: node.squares * node.inv_q,
                variance: node.variance(sum),
                cost: node.costs * node.inv_q,
            });
        }
        let Some(parent) = before.get_mut(node.parent as usize) else { continue };
        let carried = node.weight * value;
        let x = node.direct + carried * (1.0 / node.survival);
        let of_rays =
            RAY * f32::from(u8::from(node.traced)) + SHADOW * f32::from(u8::from(node.asked));
        parent.copies += 1;
        let rarer = if node.pdf > 0.0 { node.pdf / node.pdf_bsdf } else { 1.0 };
        let of_ray = node.plain(grey(node.found, node.hero)) / node.survival;
        parent.plain += grey(node.direct, node.hero).powi(2)
            + grey(node.weight, node.hero).powi(2) * rarer * of_ray;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A vertex from which light comes from two sides, 1 with probability 0.9 and 20, that a guide
    /// draws with other probabilities; copies at random, roulette after the bounce.
    #[test]
    fn trees_tell_variance_of_copies_and_second_moments_of_plain_paths() {
        let number = |i: u64, k: u64| (mix_bits(64 * i + k) >> 40) as f32 / (1u32 << 24) as f32;
        let (p, g, v) = ([0.9f32, 0.1], [0.3f32, 0.7], [1.0f32, 20.0]);
        let (survival, mut records) = (0.5, Records::default());
        let (trees, mut plain) = (200_000u64, 0.0f64);
        for i in 0..trees {
            let q = 0.5 + 3.0 * number(i, 0);
            let met = Some(Met { p: Vec3::ZERO, albedo: 1.0 });
            let mut nodes = vec![Node { met, inv_q: 1.0 / q, ..Node::root(Vec3::ZERO, Vec3::Z) }];
            for copy in 0..(q + number(i, 1)) as u64 {
                let side = usize::from(number(i, 2 + 2 * copy) >= g[0]);
                let traced = number(i, 3 + 2 * copy) < survival;
                nodes.push(Node {
                    pdf: g[side],
                    pdf_bsdf: p[side],
                    weight: Spectrum::splat(p[side] / g[side]),
                    found: Spectrum::splat(if traced { v[side] } else { 0.0 }),
                    survival,
                    traced,
                    ..Node::copy(0, Vec3::ZERO)
                });
            }
            sweep(&mut nodes, ColorMode::Rgb, Some(&mut records));
            plain += f64::from(nodes[0].plain(0.0));
        }
        let near = |found: f64, expected: f32| {
            assert!((found / f64::from(expected) - 1.0).abs() < 0.01, "{found} {expected}");
        };
        // Of plain paths: Σ p v².
        near(plain / trees as f64, p[0] * v[0] * v[0] + p[1] * v[1] * v[1]);
        // Of a copy: Σ g (p v/g)² over the probability of survival, and that less the square of the mean.
        let mean = p[0] * v[0] + p[1] * v[1];
        let of_side = |k: usize| (p[k] * v[k]).powi(2) / g[k] / survival;
        let moment = of_side(0) + of_side(1);
        let told: Vec<f64> =
            records.reflected.iter().filter_map(|r| r.variance.map(f64::from)).collect();
        near(told.iter().sum::<f64>() / told.len() as f64, moment - mean * mean);
        let moments: f64 = records.reflected.iter().map(|r| f64::from(r.moment)).sum();
        near(moments / trees as f64, moment);
    }
}
