//! Lobes side by side: density, sampling, the same seen from elsewhere, the product with a cosine.
//!
//! ```text
//! p(ω) = Σ πₖ v(ω; μₖ, κₖ) = Σ aₖ e^{-κₖ |ω - μₖ|²/2},      aₖ = πₖ c(κₖ)                (1)
//! 1 - cos θ = -ln(1 + u (e^{-2κ} - 1))/κ                                                 (2)
//! μₖ' ∝ μₖ + (x₀ - x)/dₖ                                                                 (3)
//! v(ω; μ, κ) v(ω; n, κ₀) = c(κ) c(κ₀) e^{κ' - κ - κ₀} / c(κ') · v(ω; μ', κ'),
//!     κ' μ' = κ μ + κ₀ n                                                                 (4)
//! ∫ p max(0, n·ω) dω ≈ Σ πₖ ½ (m + s √(2/π) e^{-m²/2s²} + m erf(m/√2 s)),
//!     m = R(κₖ) n·μₖ,   s = √(π/2) I₁(κₖ)/sinh κₖ                                        (5)
//! ```
//!
//! In (1) the exponent is κ (μ·ω - 1) without the cancellation of the difference. (2): Jakob 2012,
//! "Numerically stable sampling of the von Mises Fisher distribution on S²". (3): Ruppert, Herholz
//! & Lensch 2020, sec. 3; dₖ is the distance from x₀ to what lobe k stands for. (5) takes n·ω as
//! normally distributed, with the mean that it has and the spread that is right for n ⟂ μ, where
//! the cosine is cut; it is right for n ⟂ μ, for uniform lobes and for narrow ones, and between
//! them within 0.01 of the lobe's fluence.

use super::vmf::{self, LEAST_KAPPA};
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s};
use kaustika_math::special::sin_cos_turn;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3, safe_sqrt};
use std::f32::consts::{FRAC_2_SQRT_PI, FRAC_PI_2, PI, SQRT_2};

/// Lobes of a mixture at most.
pub const MOST: usize = BLOCKS * LANES;
const BLOCKS: usize = 2;
/// κ₀ of (4): the vMF most like a clamped cosine.
const COSINE_KAPPA: f32 = 2.19;

/// Below it e^x is no normal number, and those take long.
const LEAST_EXPONENT: f32 = -87.0;

/// One lobe.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// μ, unit.
    pub mean: Vec3,
    /// κ.
    pub kappa: f32,
    /// π; those of a mixture add up to 1.
    pub weight: f32,
    /// 1/d, 0 for surroundings.
    pub nearness: f32,
}

/// Sixteen lobes; without weight where there are fewer.
#[derive(Clone, Copy, Debug)]
struct Block {
    mean: Vec3s,
    kappa: Lanes,
    /// a.
    peak: Lanes,
    weight: Lanes,
}

/// A density of directions.
#[derive(Clone, Copy, Debug)]
pub struct Lobes {
    blocks: [Block; BLOCKS],
    count: usize,
}

/// Sixteen numbers of lobes, `none` where there are fewer.
pub fn row(lobes: &[Lobe], none: f32, f: impl Fn(&Lobe) -> f32) -> Lanes {
    let row: Row = std::array::from_fn(|i| lobes.get(i).map_or(none, &f));
    Lanes::new(row)
}

/// Those of block `b`.
fn block_of(lobes: &[Lobe], b: usize) -> &[Lobe] {
    lobes.chunks(LANES).nth(b).unwrap_or(&[])
}

fn splat(v: Vec3) -> Vec3s {
    Vec3s { x: Lanes::splat(v.x), y: Lanes::splat(v.y), z: Lanes::splat(v.z) }
}

impl Lobes {
    /// Of these, at most [`MOST`].
    pub fn new(lobes: &[Lobe]) -> Lobes {
        let blocks = std::array::from_fn(|b| {
            let lobes = block_of(lobes, b);
            let peak = |l: &Lobe| l.weight * vmf::normalization(f64::from(l.kappa)) as f32;
            Block {
                mean: Vec3s {
                    x: row(lobes, 0.0, |l| l.mean.x),
                    y: row(lobes, 0.0, |l| l.mean.y),
                    z: row(lobes, 1.0, |l| l.mean.z),
                },
                kappa: row(lobes, 1.0, |l| l.kappa),
                peak: row(lobes, 0.0, peak),
                weight: row(lobes, 0.0, |l| l.weight),
            }
        });
        Lobes { blocks, count: lobes.len().min(MOST) }
    }

    #[inline]
    fn used(&self) -> usize {
        self.count.div_ceil(LANES)
    }

    /// (1).
    #[inline]
    pub fn pdf(&self, w: Vec3) -> f32 {
        let w = splat(w);
        let mut sum = Lanes::splat(0.0);
        for b in &self.blocks[..self.used()] {
            let d = w - b.mean;
            let x = d.dot(d) * (b.kappa * Lanes::splat(-0.5));
            sum = b.peak.mul_add(x.fast_max(Lanes::splat(LEAST_EXPONENT)).exp(), sum);
        }
        sum.reduce_add()
    }

    /// A direction after (1), with `u` uniform in [0,1)². (2)
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let (mut k, mut left) = (0, u.x);
        let weight = |k: usize| self.blocks[k / LANES].weight.as_array()[k % LANES];
        while k + 1 < self.count && left >= weight(k) {
            left -= weight(k);
            k += 1;
        }
        // What rounding left over belongs to the last.
        let v = (left / weight(k)).min(ONE_MINUS_EPSILON);
        let b = &self.blocks[k / LANES];
        let [x, y, z, kappa] =
            [b.mean.x, b.mean.y, b.mean.z, b.kappa].map(|row| row.as_array()[k % LANES]);
        let mean = Vec3::new(x, y, z);
        let t = (-(v * (-2.0 * kappa).exp_m1()).ln_1p() / kappa).min(2.0);
        let r = safe_sqrt(t * (2.0 - t));
        let (sin, cos) = sin_cos_turn(u.y);
        let (a, b) = mean.coordinate_system();
        mean * (1.0 - t) + a * (r * cos) + b * (r * sin)
    }

    /// Turned as (3) has it.
    #[inline]
    fn moved(&self, shift: Vec3, nearness: &[Lanes; BLOCKS]) -> Lobes {
        let mut lobes = *self;
        let shift = splat(shift);
        for b in 0..self.used() {
            let mean = &mut lobes.blocks[b].mean;
            let v = mean.plus(shift, nearness[b]);
            let l2 = v.dot(v);
            // What stands where the lobe is looked from has no direction.
            let some = l2.simd_gt(Lanes::splat(1e-6)) & l2.simd_lt(Lanes::splat(1e30));
            *mean = (v * (Lanes::splat(1.0) / l2.sqrt())).or(some, *mean);
        }
        lobes
    }

    /// The product with a cosine about the unit normal `n`, normalised. (4)
    #[inline]
    pub fn with_cosine(&self, n: Vec3) -> Lobes {
        let mut lobes = *self;
        let (n, k0) = (splat(n), Lanes::splat(COSINE_KAPPA));
        let (one, two) = (Lanes::splat(1.0), Lanes::splat(2.0));
        let mut total = Lanes::splat(0.0);
        for b in &mut lobes.blocks[..self.used()] {
            let v = (b.mean * b.kappa).plus(n, k0);
            let kappa = v.dot(v).sqrt().fast_max(Lanes::splat(LEAST_KAPPA as f32));
            // κ' - κ as (κ'² - κ²)/(κ' + κ).
            let cos = b.mean.dot(n);
            let more = (k0 * (k0 + two * b.kappa * cos)) / (kappa + b.kappa);
            b.peak *= (more - k0).exp();
            let inverse = one / kappa;
            b.weight = b.peak
                * (one - (kappa * Lanes::splat(-2.0)).exp())
                * (inverse * Lanes::splat(2.0 * PI));
            b.mean = v * inverse;
            b.kappa = kappa;
            total += b.weight;
        }
        let scale = Lanes::splat(1.0 / total.reduce_add());
        for b in &mut lobes.blocks[..self.used()] {
            b.peak *= scale;
            b.weight *= scale;
        }
        lobes
    }
}

/// Incident radiance about a point.
#[derive(Clone, Debug)]
pub struct Known {
    lobes: Lobes,
    /// 1/dₖ.
    nearness: [Lanes; BLOCKS],
    /// R(κₖ).
    mean_cosine: [Lanes; BLOCKS],
    /// s of (5).
    spread: [Lanes; BLOCKS],
    /// x₀.
    pivot: Vec3,
    /// ∫ L̄ᵢ dω.
    fluence: f32,
}

impl Known {
    /// Of lobes about `pivot`.
    pub fn new(lobes: &[Lobe], pivot: Vec3, fluence: f32) -> Known {
        let rows = |none: f32, f: &dyn Fn(&Lobe) -> f32| {
            std::array::from_fn(|b| row(block_of(lobes, b), none, f))
        };
        Known {
            lobes: Lobes::new(lobes),
            nearness: rows(0.0, &|l| l.nearness),
            mean_cosine: rows(0.0, &|l| vmf::mean_cosine(f64::from(l.kappa)) as f32),
            spread: rows(1.0, &|l| {
                FRAC_PI_2.sqrt() * vmf::mean_abs_cosine(f64::from(l.kappa)) as f32
            }),
            pivot,
            fluence,
        }
    }

    /// As seen from `p`.
    #[inline]
    pub fn at(&self, p: Vec3) -> Lobes {
        self.lobes.moved(self.pivot - p, &self.nearness)
    }

    /// What it was made of.
    pub fn lobes(&self) -> Vec<Lobe> {
        let lobe = |k: usize| {
            let (block, at) = (k / LANES, |row: &Lanes| row.as_array()[k % LANES]);
            let b = &self.lobes.blocks[block];
            Lobe {
                mean: Vec3::new(at(&b.mean.x), at(&b.mean.y), at(&b.mean.z)),
                kappa: at(&b.kappa),
                weight: at(&b.weight),
                nearness: at(&self.nearness[block]),
            }
        };
        (0..self.lobes.count).map(lobe).collect()
    }

    /// x₀.
    pub fn pivot(&self) -> Vec3 {
        self.pivot
    }

    /// Number of lobes.
    pub fn count(&self) -> usize {
        self.lobes.count
    }

    /// ∫ L̄ᵢ dω.
    #[inline]
    pub fn fluence(&self) -> f32 {
        self.fluence
    }

    /// Irradiance, given [`Known::at`]. (5)
    pub fn irradiance(&self, lobes: &Lobes, n: Vec3) -> f32 {
        let (n, half) = (splat(n), Lanes::splat(0.5));
        let mut sum = Lanes::splat(0.0);
        for (i, b) in lobes.blocks[..lobes.used()].iter().enumerate() {
            let s = self.spread[i];
            let m = self.mean_cosine[i] * b.mean.dot(n);
            let x = m.abs() / (s * Lanes::splat(SQRT_2));
            let bell = (-(x * x)).exp();
            let abs = s * Lanes::splat(FRAC_2_SQRT_PI / SQRT_2) * bell + m.abs() * erf(x, bell);
            sum = (b.weight * half).mul_add(m + abs, sum);
        }
        self.fluence * sum.reduce_add().max(0.0)
    }
}

/// erf(x) for x ≥ 0, given e^{-x²}: Abramowitz & Stegun 1964, 7.1.26, to 1.5·10⁻⁷.
#[inline]
fn erf(x: Lanes, bell: Lanes) -> Lanes {
    let one = Lanes::splat(1.0);
    let t = one / x.mul_add(Lanes::splat(0.3275911), one);
    let c = [1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592].map(Lanes::splat);
    let sum = c[1..].iter().fold(c[0], |sum, &c| sum.mul_add(t, c));
    one - sum * t * bell
}
