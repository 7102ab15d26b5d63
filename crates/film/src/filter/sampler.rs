//! Importance sampling of filters (Ernst, Stamminger and Greiner 2006, "Filter Importance
//! Sampling"): each sample serves one pixel and has the same weight up to its sign.

use kaustika_math::{ONE_MINUS_EPSILON, Vec2};

use super::FilterDesc;
use super::kernel::Kernel;

/// A position on the film for one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// From the pixel's centre, in pixels.
    pub offset: Vec2,
    /// f(offset) / (pdf(offset) · ∫ f): a pixel is the mean of weight · radiance. Its mean is 1;
    /// it is exactly 1 for filters without negative lobes and negative in such lobes.
    pub weight: f32,
}

/// Samples offsets in proportion to |f|.
///
/// Box and tent are inverted exactly. The other kernels are replaced by their linear
/// interpolation over 1024 segments a side (off by less than 1e-5 of the peak); that
/// interpolation is sampled and weighted exactly, so that weights have no variance but sign.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    x: AxisSampler,
    y: AxisSampler,
}

impl FilterSampler {
    /// Tabulates a filter, whose [`defect`](FilterDesc::defect) must be `None`.
    pub fn new(desc: &FilterDesc) -> Self {
        let [x, y] = desc.kernels().map(|kernel| AxisSampler::new(&kernel));
        FilterSampler { x, y }
    }

    /// Maps the unit square, monotonically in each axis.
    #[inline]
    pub fn sample(&self, u2: Vec2) -> FilterSample {
        let (x, weight_x) = self.x.sample(u2.x);
        let (y, weight_y) = self.y.sample(u2.y);
        FilterSample { offset: Vec2::new(x, y), weight: weight_x * weight_y }
    }
}

/// Samples an even, piecewise linear function k on [-r, r] in proportion to |k|.
#[derive(Clone, Debug)]
struct AxisSampler {
    segments: Vec<Segment>,
    /// ∫|k| / ∫k.
    weight: f32,
}

/// One linear piece on the positive side; the value does not change sign inside.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Share of ∫|k| (over the positive side) up to the start of this piece.
    cdf: f32,
    /// Share of this piece.
    mass: f32,
    start: f32,
    width: f32,
    /// |k| at both ends.
    from: f32,
    to: f32,
    /// Sign of k.
    sign: f32,
}

impl AxisSampler {
    fn new(kernel: &Kernel) -> Self {
        let nodes = kernel.nodes();
        let area = |w: &[(f64, f64)]| 0.5 * (w[1].0 - w[0].0) * (w[0].1 + w[1].1);
        let absolute: f64 = nodes.windows(2).map(|w| area(w).abs()).sum();
        let signed: f64 = nodes.windows(2).map(area).sum();
        let mut sum = 0.0;
        let mut segments = Vec::with_capacity(nodes.len());
        for w in nodes.windows(2) {
            let mass = area(w).abs() / absolute;
            if mass > 0.0 {
                segments.push(Segment {
                    cdf: sum as f32,
                    mass: mass as f32,
                    start: w[0].0 as f32,
                    width: (w[1].0 - w[0].0) as f32,
                    from: w[0].1.abs() as f32,
                    to: w[1].1.abs() as f32,
                    sign: area(w).signum() as f32,
                });
            }
            sum += mass;
        }
        AxisSampler { segments, weight: (absolute / signed) as f32 }
    }

    /// Position and weight for u in [0, 1).
    #[inline]
    fn sample(&self, u: f32) -> (f32, f32) {
        // u below ½ is the negative side, mirrored so that the map is monotone.
        let side = 2.0 * u - 1.0;
        let v = side.abs().min(ONE_MINUS_EPSILON);
        let i = self.segments.partition_point(|s| s.cdf <= v).max(1) - 1;
        let s = &self.segments[i];
        let inside = ((v - s.cdf) / s.mass).min(ONE_MINUS_EPSILON);
        let x = s.start + s.width * invert_linear(inside, s.from, s.to);
        (x.copysign(side), self.weight * s.sign)
    }
}

/// Position in [0, 1] for u under a density that runs linearly from `a` to `b`, not both zero:
/// the root of t² (b - a)/2 + a t = u (a + b)/2 in a form without cancellation.
#[inline]
fn invert_linear(u: f32, a: f32, b: f32) -> f32 {
    if a == b {
        return u;
    }
    let root = (a * a * (1.0 - u) + b * b * u).sqrt();
    let denominator = a + root;
    // Zero only for u = 0 where the density starts at zero.
    if denominator > 0.0 { (u * (a + b) / denominator).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use kaustika_math::{mix_bits, special::gamma_q};

    use super::super::tests::FILTERS;
    use super::*;

    /// Sample `i` of a fixed sequence of independent points.
    fn random2(i: u64) -> Vec2 {
        let uniform = |k: u64| (mix_bits(k.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 40) as f32;
        Vec2::new(uniform(2 * i + 1), uniform(2 * i + 2)) * (1.0 / (1 << 24) as f32)
    }

    /// χ² over a grid of cells against ∫|f|, significance 1e-3 divided by the number of filters.
    #[test]
    fn offsets_follow_the_absolute_filter() {
        const CELLS: usize = 24;
        const SAMPLES: u64 = 400_000;
        for text in FILTERS {
            let desc: FilterDesc = text.parse().unwrap();
            let sampler = FilterSampler::new(&desc);
            let r = desc.radius();
            let mut counts = vec![0.0f64; CELLS * CELLS];
            let cell =
                |x: f32, r: f32| (((x / r + 1.0) * 0.5 * CELLS as f32) as usize).min(CELLS - 1);
            for i in 0..SAMPLES {
                let s = sampler.sample(random2(i));
                assert!(s.offset.x.abs() <= r.x && s.offset.y.abs() <= r.y, "{text}: {s:?}");
                counts[cell(s.offset.y, r.y) * CELLS + cell(s.offset.x, r.x)] += 1.0;
            }
            // Midpoint rule with SUB² points a cell.
            const SUB: usize = 16;
            let n = CELLS * SUB;
            let at = |i: usize, r: f32| ((i as f32 + 0.5) / n as f32 * 2.0 - 1.0) * r;
            let mut expected = vec![0.0f64; CELLS * CELLS];
            for j in 0..n {
                for i in 0..n {
                    let f = desc.evaluate(Vec2::new(at(i, r.x), at(j, r.y)));
                    expected[j / SUB * CELLS + i / SUB] += f.abs() as f64;
                }
            }
            let scale = SAMPLES as f64 / expected.iter().sum::<f64>();
            let (mut chi2, mut dof, mut pooled) = (0.0, -1.0, [0.0f64; 2]);
            for (&count, &e) in counts.iter().zip(&expected) {
                let e = e * scale;
                if e < 5.0 {
                    pooled = [pooled[0] + count, pooled[1] + e];
                } else {
                    chi2 += (count - e).powi(2) / e;
                    dof += 1.0;
                }
            }
            if pooled[1] >= 5.0 {
                chi2 += (pooled[0] - pooled[1]).powi(2) / pooled[1];
                dof += 1.0;
            }
            let p = gamma_q(0.5 * dof, 0.5 * chi2);
            assert!(
                p > 1e-3 / FILTERS.len() as f64,
                "{text}: chi2 {chi2:.1}, dof {dof}, p {p:.2e}"
            );
        }
    }

    /// The mean weight is 1 and the sign is that of f; the tolerance is 5 standard errors.
    #[test]
    fn weights_average_to_one() {
        const SAMPLES: u64 = 200_000;
        for text in FILTERS {
            let desc: FilterDesc = text.parse().unwrap();
            let sampler = FilterSampler::new(&desc);
            let magnitude = sampler.sample(Vec2::splat(0.5)).weight.abs() as f64;
            let mut sum = 0.0f64;
            for i in 0..SAMPLES {
                let s = sampler.sample(random2(i));
                let f = desc.evaluate(s.offset);
                assert!(f * s.weight > 0.0 || f.abs() < 1e-3, "{text}: {s:?} {f}");
                assert!((s.weight.abs() as f64 - magnitude).abs() < 1e-6);
                sum += s.weight as f64;
            }
            let mean = sum / SAMPLES as f64;
            let error = ((magnitude * magnitude - 1.0).max(0.0) / SAMPLES as f64).sqrt();
            assert!((mean - 1.0).abs() < 5.0 * error + 1e-6, "{text}: {mean} ± {error}");
        }
    }

    /// Against a smooth integrand with known answer: E[weight · cos(ax)] = ∫ f cos(ax) / ∫ f.
    #[test]
    fn estimates_match_quadrature() {
        for text in FILTERS {
            let desc: FilterDesc = text.parse().unwrap();
            let sampler = FilterSampler::new(&desc);
            let r = desc.radius();
            let n = 1 << 16;
            let (mut sampled, mut exact) = (0.0f64, 0.0f64);
            for i in 0..n {
                let u = (i as f32 + 0.5) / n as f32;
                let s = sampler.sample(Vec2::new(u, 0.5));
                sampled += (s.weight * (1.7 * s.offset.x).cos()) as f64 / n as f64;
                let x = (2.0 * u - 1.0) * r.x;
                exact += (desc.evaluate(Vec2::new(x, 0.0)) * (1.7 * x).cos()) as f64 / n as f64;
            }
            // Along y the sampler stays at the centre: take its constant factor out.
            let centre = desc.evaluate(Vec2::ZERO) as f64;
            let [kx, ky] = desc.kernels();
            let exact = exact * (2.0 * r.x) as f64 / kx.integral() / (centre / kx.evaluate(0.0));
            let sampled = sampled / AxisSampler::new(&ky).weight as f64;
            assert!((sampled - exact).abs() < 2e-4, "{text}: {sampled} {exact}");
        }
    }

    #[test]
    fn box_is_the_identity_and_maps_are_monotone() {
        let sampler = FilterSampler::new(&FilterDesc::BOX);
        for u in [0.0, 0.1, 0.5, 0.75, ONE_MINUS_EPSILON] {
            let s = sampler.sample(Vec2::new(u, 1.0 - u));
            assert!((s.offset.x - (u - 0.5)).abs() < 1e-6 && s.weight == 1.0, "{s:?}");
        }
        let sampler = FilterSampler::new(&FilterDesc::LANCZOS);
        let xs = (0..10_000).map(|i| sampler.sample(Vec2::splat(i as f32 / 1e4)).offset.x);
        assert!(xs.collect::<Vec<_>>().is_sorted());
    }
}
