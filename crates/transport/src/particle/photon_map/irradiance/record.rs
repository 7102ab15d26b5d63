//! One place where irradiance is known, and how it changes around it (Ward, Rubinstein & Clear
//! 1988; Ward & Heckbert 1992, in the form of Křivánek & Gautron 2009, sec. 3).
//!
//! ```text
//! E     = π/(MN) Σ L_jk,   sin²θ_j = (j+ξ)/M,  φ_k = 2π (k+ξ)/N                                (7)
//! ∇_r E = π/(MN) Σ_k v_k Σ_j t_j L_jk,   t_j the mean of tan θ over the stratum                (8)
//! ∇_t E = Σ_k { u_k 2π/N Σ_{j≥1} sin θ_j₋ cos²θ_j₋ (L_jk - L_{j-1,k}) / min(R_jk, R_{j-1,k})
//!             + v_k₋ Σ_j cos θ_j (cos θ_j₋ - cos θ_j₊)/sin θ_j (L_jk - L_{j,k-1}) / min(R_jk, R_{j,k-1}) }   (9)
//! ```
//!
//! u_k points along φ_k in the surface, v_k at a right angle to it, v_k₋ to the border of the
//! strata k - 1 and k; R are the lengths of the rays. The mean of tan θ in place of its middle
//! is ours: tan has no bound.

use kaustika_math::{Frame, Vec3};
use kaustika_spectra::Spectrum;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A record of the cache.
#[derive(Clone, Debug)]
pub(in super::super) struct Record {
    pub(in super::super) p: Vec3,
    pub(in super::super) n: Vec3,
    pub(in super::super) irradiance: Spectrum,
    /// How far it is valid, world units, once multiplied by the allowed error.
    pub(in super::super) radius: f32,
    /// ∇_t E and ∇_r E, channel by channel.
    translation: [Vec3; 4],
    rotation: [Vec3; 4],
}

/// Strata of the hemisphere: M rings of N for about this many rays, so that they are about as wide as long.
pub(super) fn strata(rays: u32) -> [usize; 2] {
    let rings = (rays as f32 / PI).sqrt().round().max(2.0);
    [rings as usize, (rings * PI).round() as usize]
}

/// ∫ tan θ over a stratum of sin²θ, up to `u`.
fn tan_integral(u: f32) -> f32 {
    u.sqrt().min(1.0).asin() - (u * (1.0 - u)).max(0.0).sqrt()
}

impl Record {
    /// At `p` with the normal of `frame`; `trace` tells radiance and distance along a direction,
    /// `random` gives numbers in [0, 1).
    pub(super) fn new(
        p: Vec3,
        frame: &Frame,
        [rings, sectors]: [usize; 2],
        mut random: impl FnMut() -> [f32; 2],
        mut trace: impl FnMut(Vec3) -> (Spectrum, f32),
    ) -> Record {
        let (m, n) = (rings as f32, sectors as f32);
        let mut cells = Vec::with_capacity(rings * sectors);
        let mut inverse = 0.0;
        let mut irradiance = Spectrum::ZERO;
        for k in 0..sectors {
            for j in 0..rings {
                let [a, b] = random();
                let sin2 = (j as f32 + a) / m;
                let (sin, cos) = (TAU * (k as f32 + b) / n).sin_cos();
                let (r, z) = (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt());
                let (l, distance) = trace(frame.to_world(Vec3::new(r * cos, r * sin, z)));
                irradiance += l * (PI / (m * n)); // (7)
                inverse += 1.0 / distance.max(1e-30);
                cells.push((l, distance));
            }
        }
        let radius = if inverse > 0.0 { m * n / inverse } else { f32::INFINITY };
        let mut record = Record {
            p,
            n: frame.n,
            irradiance,
            radius,
            translation: [Vec3::ZERO; 4],
            rotation: [Vec3::ZERO; 4],
        };
        record.differentiate(frame, [rings, sectors], &cells);
        record
    }

    fn differentiate(
        &mut self,
        frame: &Frame,
        [rings, sectors]: [usize; 2],
        cells: &[(Spectrum, f32)],
    ) {
        let (m, n) = (rings as f32, sectors as f32);
        let cell = |j: usize, k: usize| cells[(k % sectors) * rings + j];
        let along = |phi: f32| frame.to_world(Vec3::new(phi.cos(), phi.sin(), 0.0));
        let (sin, cos) = (|u: f32| u.sqrt(), |u: f32| (1.0 - u).max(0.0).sqrt());
        // (L - L') / min(R, R')
        let slope = |(l, r): (Spectrum, f32), (l2, r2): (Spectrum, f32)| (l - l2) / r.min(r2);
        for k in 0..sectors {
            let phi = TAU * (k as f32 + 0.5) / n;
            let (u, v) = (along(phi), along(phi + FRAC_PI_2));
            let v_before = along(TAU * k as f32 / n + FRAC_PI_2);
            let (mut turned, mut outward, mut around) =
                (Spectrum::ZERO, Spectrum::ZERO, Spectrum::ZERO);
            for j in 0..rings {
                let (low, middle, high) =
                    (j as f32 / m, (j as f32 + 0.5) / m, (j as f32 + 1.0) / m);
                let tan = m * (tan_integral(high) - tan_integral(low));
                turned += cell(j, k).0 * tan;
                if j > 0 {
                    let weight = sin(low) * (1.0 - low);
                    outward += slope(cell(j, k), cell(j - 1, k)) * weight;
                }
                let weight = cos(middle) * (cos(low) - cos(high)) / sin(middle);
                around += slope(cell(j, k), cell(j, k + sectors - 1)) * weight;
            }
            for c in 0..4 {
                self.rotation[c] += v * (turned[c] * PI / (m * n)); // (8)
                self.translation[c] += u * (outward[c] * TAU / n) + v_before * around[c]; // (9)
            }
        }
    }

    /// Irradiance at `p` with normal `n`, extrapolated; not below 0.
    pub(super) fn extrapolate(&self, p: Vec3, n: Vec3) -> Spectrum {
        let (axis, step) = (self.n.cross(n), p - self.p);
        let change = |c: usize| axis.dot(self.rotation[c]) + step.dot(self.translation[c]);
        let e = self.irradiance;
        Spectrum(std::array::from_fn(|c| (e[c] + change(c)).max(0.0)))
    }

    /// Where irradiance changes faster than the radius says, the radius is made to agree; then
    /// it is kept within `[least, most]`, and the gradient bounded where it was raised.
    pub(super) fn bound(&mut self, [least, most]: [f32; 2]) {
        for c in 0..4 {
            let steep = self.translation[c].length();
            if steep > 0.0 {
                self.radius = self.radius.min(self.irradiance[c] / steep);
            }
        }
        if self.radius < least {
            let k = self.radius / least;
            self.translation.iter_mut().for_each(|g| *g *= k);
        }
        self.radius = self.radius.clamp(least, most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_sampling::hash::{combine, unit};

    /// A room without walls but a floor z = 0, under a plane z = 1 whose radiance changes.
    fn ceiling(o: Vec3, d: Vec3) -> (Spectrum, f32) {
        if d.z <= 1e-6 {
            return (Spectrum::ZERO, f32::INFINITY);
        }
        let t = (1.0 - o.z) / d.z;
        let at = o + d * t;
        let l = |k: f32| (-(at.x - k).powi(2) - 0.5 * at.y * at.y).exp();
        (Spectrum([l(0.0), l(0.5), l(1.0), 0.0]), t)
    }

    fn record(p: Vec3, n: Vec3, rays: u32, seed: u64) -> Record {
        let mut i = 0;
        let random = || {
            i += 1;
            [1, 2].map(|k| unit((combine(combine(seed, k), i) >> 32) as u32))
        };
        Record::new(p, &Frame::from_normal(n), strata(rays), random, |d| ceiling(p, d))
    }

    fn tilted(x: f32, y: f32) -> Vec3 {
        Vec3::new(x, y, 1.0).normalize()
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let (p, n) = (Vec3::new(0.3, -0.2, 0.0), tilted(0.1, 0.2));
        // The mean of many records, so that what is left is the formulas' own error.
        let mean = |p: Vec3, n: Vec3, rays: u32, count: u64| {
            let all = (0..count).map(|s| record(p, n, rays, s));
            all.fold(Spectrum::ZERO, |sum, r| sum + r.irradiance * (1.0 / count as f32))
        };
        // (8) and (9) are right in the limit: their error falls as 1/M, here about 100.
        let count = 10;
        let many: Vec<Record> = (0..count).map(|s| record(p, n, 30_000, 100 + s)).collect();
        let gradient = |of: &dyn Fn(&Record) -> Vec3| {
            many.iter().fold(Vec3::ZERO, |sum, r| sum + of(r) * (1.0 / count as f32))
        };
        let h = 0.05;
        let frame = Frame::from_normal(n);
        for c in 0..3 {
            let (t, r) = (gradient(&|r| r.translation[c]), gradient(&|r| r.rotation[c]));
            for step in [frame.s, frame.t] {
                let e = |k: f32| f64::from(mean(p + step * (k * h), n, 100_000, 2)[c]);
                let truth = (e(1.0) - e(-1.0)) / f64::from(2.0 * h);
                let size = f64::from(t.length());
                let error = (f64::from(t.dot(step)) - truth).abs();
                assert!(error < 0.02 * size, "translation, {c}: {} {truth}", t.dot(step));
                let turn = |k: f32| (n + step * (k * h)).normalize();
                let e = |k: f32| f64::from(mean(p, turn(k), 100_000, 2)[c]);
                let truth = (e(1.0) - e(-1.0)) / f64::from(2.0 * h);
                let along = f64::from(n.cross(step).dot(r));
                let size = f64::from(r.length());
                assert!((along - truth).abs() < 0.02 * size, "rotation, {c}: {along} {truth}");
            }
        }
    }

    #[test]
    fn in_a_uniform_field_nothing_changes() {
        let frame = Frame::from_normal(Vec3::Z);
        let field = |_| (Spectrum::ONE, 2.0);
        let r = Record::new(Vec3::ZERO, &frame, strata(512), || [0.5, 0.5], field);
        assert!((r.irradiance[0] - PI).abs() < 1e-5);
        assert!((r.radius - 2.0).abs() < 1e-5);
        let gradients = r.translation.iter().chain(&r.rotation);
        assert!(gradients.into_iter().all(|g| g.length() < 1e-4));
    }

    #[test]
    fn extrapolation_is_better_than_the_value_itself() {
        let p = Vec3::new(0.4, 0.1, 0.0);
        let near = p + Vec3::new(0.08, -0.05, 0.0);
        let (here, there) = (record(p, Vec3::Z, 20_000, 1), record(near, Vec3::Z, 20_000, 2));
        let error = |e: Spectrum| (e - there.irradiance).map(f32::abs).max_component();
        assert!(error(here.extrapolate(near, Vec3::Z)) < 0.3 * error(here.irradiance));
    }
}
