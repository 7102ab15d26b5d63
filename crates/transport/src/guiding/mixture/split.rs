//! Lobes that do not fit are divided, lobes that one can stand for are merged.
//!
//! ```text
//! χ²ₖ = ∫ γₖ (L/Φ - p)²/p dω = N Fₖ/W² - 2 sₖ/W + πₖ                                     (1)
//! a² = max(λ₁ - λ₂, λ₁/4),   μ± = cos a μ ± sin a e₁,   R± = R/cos a                     (2)
//! χ²ᵢⱼ = ∫ (πᵢvᵢ + πⱼvⱼ)²/(π v) dω - π                                                   (3)
//! ∫ v_a v_b/v dω = c_a c_b e^{κ' - κ_a - κ_b + κ}/(c c(κ')),   κ' = |κ_a μ_a + κ_b μ_b - κ μ|   (4)
//! ```
//!
//! (1) is lobe k's part of the variance that is left if directions are drawn with p (Ruppert,
//! Herholz & Lensch 2020, sec. 4), from N records of energy W in all. λ₁ ≥ λ₂ are the variances
//! of a lobe's records across μ, e₁ the direction of the first: (2) leaves the two halves what
//! spread the whole has across e₁, or, where it is round, parts it anyhow; r is kept.

use super::expectation::{Misfit, Sums};
use super::lobes::{Lobe, MOST};
use super::vmf::{LEAST_KAPPA, concentration, mean_cosine, normalization};
use kaustika_math::Vec3;

/// χ² of (1) above which a lobe is divided.
const SPLIT: f64 = 0.5;
/// Records that a lobe must have for that: fewer say little.
const SPLIT_RECORDS: f64 = 64.0;
/// χ² of (3) below which two lobes are merged.
const MERGE: f64 = 0.00625;

/// A lobe, what it was learned from, and how well it fits.
#[derive(Clone, Copy, Debug)]
pub struct Component {
    /// The lobe.
    pub lobe: Lobe,
    /// What it was learned from; fades.
    pub sums: Sums,
    /// Of the records since lobes were divided last.
    pub misfit: Misfit,
}

/// (1) of every lobe, from `records` records; `None` if they had no energy.
fn chi2(components: &[Component], records: f64) -> Option<Vec<f64>> {
    let energy: f64 = components.iter().map(|c| c.misfit.energy).sum();
    let of = |c: &Component| {
        records * c.misfit.squares / (energy * energy) - 2.0 * c.misfit.energy / energy
            + f64::from(c.lobe.weight)
    };
    (energy > 0.0).then(|| components.iter().map(of).collect())
}

/// Divides the lobes that fit worst, given on how many records their misfits are. True if there
/// were any.
pub fn split(components: &mut Vec<Component>, records: f64) -> bool {
    let Some(chi2) = chi2(components, records) else { return false };
    let mut worst: Vec<(f64, usize)> = chi2
        .into_iter()
        .zip(0..)
        .filter(|&(chi2, k)| chi2 > SPLIT && components[k].sums.records() >= SPLIT_RECORDS)
        .collect();
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    worst.truncate(MOST - components.len().min(MOST));
    for &(_, k) in &worst {
        if let Some([a, b]) = halves(&components[k]) {
            components[k] = a;
            components.push(b);
        }
    }
    !worst.is_empty()
}

/// (2).
fn halves(c: &Component) -> Option<[Component; 2]> {
    let mean = c.lobe.mean;
    let (s, t) = mean.coordinate_system();
    let [xx, yy, zz, xy, yz, zx] = c.misfit.moments.map(|m| m / c.misfit.energy);
    let product = |a: Vec3, b: Vec3| {
        let [a, b] = [a, b].map(|v| <[f32; 3]>::from(v).map(f64::from));
        let row = |m: [f64; 3]| m[0] * b[0] + m[1] * b[1] + m[2] * b[2];
        a[0] * row([xx, xy, zx]) + a[1] * row([xy, yy, yz]) + a[2] * row([zx, yz, zz])
    };
    let (ss, tt, st) = (product(s, s), product(t, t), product(s, t));
    let (middle, half) = (0.5 * (ss + tt), (0.5 * (ss - tt)).hypot(st));
    let (l1, l2) = (middle + half, (middle - half).max(0.0));
    let angle = 0.5 * (2.0 * st).atan2(ss - tt);
    let e1 = s * angle.cos() as f32 + t * angle.sin() as f32;
    // At most 45°.
    let sin = (l1 - l2).max(0.25 * l1).min(0.5).sqrt();
    let cos = (1.0 - sin * sin).sqrt();
    let half = |sign: f64| {
        let (sin, tan) = (sign * sin, sign * sin / cos);
        let mean = (mean * cos as f32 + e1 * sin as f32).try_normalize()?;
        let r = (mean_cosine(f64::from(c.lobe.kappa)) / cos).min(1.0);
        let kappa = concentration(r) as f32;
        let lobe = Lobe { mean, kappa, weight: 0.5 * c.lobe.weight, ..c.lobe };
        let mut sums = Sums::default().plus(&c.sums, 0.5);
        // As many records each as half of all.
        sums.squares = 0.5 * c.sums.squares;
        let length = sums.length();
        let e: [f32; 3] = e1.into();
        for (r, e) in sums.direction.iter_mut().zip(e) {
            *r += length * tan * f64::from(e);
        }
        limit(&mut sums);
        Some(Component { lobe, sums, misfit: Misfit::default() })
    };
    Some([half(1.0)?, half(-1.0)?])
}

/// Directions are no longer than 1, their mean neither.
fn limit(sums: &mut Sums) {
    let length = sums.length();
    if length > sums.energy {
        let scale = sums.energy / length;
        sums.direction.iter_mut().for_each(|r| *r *= scale);
    }
}

/// Merges pairs of lobes as long as (3) allows, the most alike first.
pub fn merge(components: &mut Vec<Component>) {
    let cost = |a: &Component, b: &Component| {
        let merged = merged_lobe(&a.lobe, &b.lobe);
        (merge_cost(&a.lobe, &b.lobe, &merged), merged)
    };
    while components.len() > 1 {
        let mut best: Option<(f64, usize, usize, Lobe)> = None;
        for i in 0..components.len() {
            for j in i + 1..components.len() {
                let (a, b) = (&components[i], &components[j]);
                if apart(&a.lobe, &b.lobe) {
                    continue;
                }
                let (cost, merged) = cost(a, b);
                if cost < best.map_or(MERGE, |b| b.0) {
                    best = Some((cost, i, j, merged));
                }
            }
        }
        let Some((_, i, j, lobe)) = best else { return };
        let (a, b) = (components[i], components[j]);
        let misfit = Misfit { energy: a.misfit.energy + b.misfit.energy, ..Misfit::default() };
        components[i] = Component { lobe, sums: a.sums.plus(&b.sums, 1.0), misfit };
        components.remove(j);
    }
}

/// Lobes of some weight that hardly overlap: no need to ask (3).
fn apart(a: &Lobe, b: &Lobe) -> bool {
    let t = 1.0 - a.mean.dot(b.mean);
    t * a.kappa.min(b.kappa) > 8.0 && a.weight.min(b.weight) as f64 > MERGE
}

/// One lobe with the mean of two.
fn merged_lobe(a: &Lobe, b: &Lobe) -> Lobe {
    let weight = a.weight + b.weight;
    let (ta, tb) = (a.weight / weight, b.weight / weight);
    let r = a.mean * (ta * mean_cosine(f64::from(a.kappa)) as f32)
        + b.mean * (tb * mean_cosine(f64::from(b.kappa)) as f32);
    Lobe {
        mean: r.try_normalize().unwrap_or(a.mean),
        kappa: concentration(f64::from(r.length())) as f32,
        weight,
        nearness: ta * a.nearness + tb * b.nearness,
    }
}

/// (3).
fn merge_cost(a: &Lobe, b: &Lobe, m: &Lobe) -> f64 {
    let part = |a: &Lobe, b: &Lobe| {
        // (4), in logarithms.
        let ln_c = |kappa: f64| normalization(kappa.max(LEAST_KAPPA)).ln();
        let [ka, kb, km] = [a.kappa, b.kappa, m.kappa].map(f64::from);
        let along = |f: fn(&Vec3) -> f32| {
            ka * f64::from(f(&a.mean)) + kb * f64::from(f(&b.mean)) - km * f64::from(f(&m.mean))
        };
        let (x, y, z) = (along(|v| v.x), along(|v| v.y), along(|v| v.z));
        let k = (x * x + y * y + z * z).sqrt();
        let ln = ln_c(ka) + ln_c(kb) - ln_c(km) - ln_c(k) + k - ka - kb + km;
        f64::from(a.weight) * f64::from(b.weight) / f64::from(m.weight) * ln.exp()
    };
    part(a, a) + part(b, b) + 2.0 * part(a, b) - f64::from(m.weight)
}

#[cfg(test)]
mod tests {
    use super::super::expectation::{Expectation, Sample};
    use super::super::lobes::Lobes;
    use super::*;
    use crate::guiding::tests::{over_the_sphere, uniform_record};

    fn lobe(x: f32, y: f32, z: f32, kappa: f32, weight: f32) -> Lobe {
        Lobe { mean: Vec3::new(x, y, z).normalize(), kappa, weight, nearness: 0.25 }
    }

    /// Uniform records of the radiance `of`, as a model of `lobes` sees them.
    fn seen(lobes: &[Lobe], of: &Lobes, n: u32) -> Vec<Component> {
        let samples: Vec<Sample> = (0..n)
            .map(|i| uniform_record(i, |w| of.pdf(w)))
            .map(|r| Sample { w: r.w, energy: r.radiance / r.pdf, pdf: r.pdf, nearness: 0.25 })
            .collect();
        let model = Expectation::new(lobes);
        let sums = model.sums(&samples).0;
        let parts = lobes.iter().zip(sums).zip(model.misfits(&samples));
        parts.map(|((&lobe, sums), misfit)| Component { lobe, sums, misfit }).collect()
    }

    #[test]
    fn misfit_is_the_variance_that_is_left() {
        let truth = Lobes::new(&[lobe(1.0, 0.3, 0.0, 30.0, 0.7), lobe(0.0, -1.0, 0.4, 3.0, 0.3)]);
        let lobes = [lobe(1.0, 0.0, 0.0, 12.0, 0.6), lobe(0.0, -1.0, 0.4, 2.0, 0.4)];
        let model = Lobes::new(&lobes);
        let n = 40_000;
        let ours: f64 = chi2(&seen(&lobes, &truth, n), f64::from(n)).expect("energy").iter().sum();
        let exact = over_the_sphere(|w| (truth.pdf(w) - model.pdf(w)).powi(2) / model.pdf(w));
        assert!(exact > 0.2 && (ours / exact - 1.0).abs() < 0.01, "{ours} {exact}");
    }

    #[test]
    fn the_cost_of_merging_is_the_variance_it_makes() {
        for (a, b) in [
            (lobe(1.0, 0.1, 0.0, 30.0, 0.2), lobe(1.0, -0.1, 0.1, 20.0, 0.1)),
            (lobe(1.0, 0.0, 0.0, 200.0, 0.1), lobe(1.0, 0.2, 0.0, 5.0, 0.8)),
            (lobe(1.0, 0.0, 0.0, 0.5, 0.1), lobe(-1.0, 0.2, 0.0, 1.0, 0.3)),
        ] {
            let m = merged_lobe(&a, &b);
            let (both, one) = (Lobes::new(&[a, b]), Lobes::new(&[m]));
            let exact = over_the_sphere(|w| both.pdf(w).powi(2) / one.pdf(w)) - f64::from(m.weight);
            let ours = merge_cost(&a, &b, &m);
            assert!((ours - exact).abs() < 0.01 * exact.max(0.01), "{ours} {exact}");
        }
    }

    #[test]
    fn halves_part_two_lights_and_keep_what_was_learned() {
        let apart = 0.35f32;
        let truth = Lobes::new(&[
            lobe(1.0, apart.tan(), 0.0, 90.0, 0.5),
            lobe(1.0, -apart.tan(), 0.0, 90.0, 0.5),
        ]);
        let mean = vmf_of_both(apart, 90.0);
        let whole = lobe(1.0, 0.0, 0.0, mean, 1.0);
        let before = seen(&[whole], &truth, 40_000);
        let mut after = before.clone();
        assert!(split(&mut after, 40_000.0));
        assert_eq!(after.len(), 2);
        for c in &after {
            assert!((c.lobe.mean.y.abs() - apart.sin()).abs() < 0.03, "{:?}", c.lobe);
            assert!((c.lobe.kappa / 90.0 - 1.0).abs() < 0.2, "{:?}", c.lobe);
            assert_eq!(c.lobe.nearness, 0.25);
            let r = Vec3::from(c.sums.direction.map(|x| x as f32)).normalize();
            assert!(r.dot(c.lobe.mean) > 0.9999, "{:?} {r:?}", c.lobe);
            assert!((c.sums.records() / (0.5 * before[0].sums.records()) - 1.0).abs() < 1e-6);
        }
        let sum = after[0].sums.plus(&after[1].sums, 1.0);
        for k in 0..3 {
            let off = (sum.direction[k] - before[0].sums.direction[k]) / sum.energy;
            assert!(off.abs() < 0.01, "{k} {off}");
        }
        // As they are, they stay apart; put together again they are what they were.
        let mut merged = after.clone();
        merge(&mut merged);
        assert_eq!(merged.len(), 2);
        let m = merged_lobe(&after[0].lobe, &after[1].lobe);
        assert!((m.kappa / mean - 1.0).abs() < 0.05 && m.mean.x > 0.999, "{m:?} {mean}");
    }

    /// κ of one lobe for two, `angle` to either side.
    fn vmf_of_both(angle: f32, kappa: f64) -> f32 {
        concentration(mean_cosine(kappa) * f64::from(angle.cos())) as f32
    }

    #[test]
    fn alike_lobes_merge() {
        let one = |x: f32| lobe(1.0, x, 0.0, 40.0, 0.25);
        let components = [one(0.0), one(0.01), lobe(-1.0, 0.0, 0.0, 40.0, 0.25), one(-0.01)];
        let sums = Sums { energy: 1.0, direction: [0.9, 0.0, 0.0], squares: 1.0, nearness: 0.2 };
        let mut components: Vec<Component> =
            components.map(|lobe| Component { lobe, sums, misfit: Misfit::default() }).into();
        merge(&mut components);
        assert_eq!(components.len(), 2);
        assert!((components[0].lobe.weight - 0.75).abs() < 1e-6);
        assert!((components[0].sums.energy - 3.0).abs() < 1e-9);
    }
}
