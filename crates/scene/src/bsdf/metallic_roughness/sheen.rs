//! The sheen of fibres that stand on a surface.
//!
//! With α the square of the perceptual roughness:
//!
//! ```text
//! D(m) = (2 + 1/α) sin^{1/α} θₘ / 2π                                                      (1)
//! Λ(θ) = exp l(cos θ) for cos θ < ½, else exp(2 l(½) - l(1 - cos θ))
//! l(x) = a/(1 + b xᶜ) + d x + e,  a..e mixed between α = 0 and 1 by (1 - α)²              (2)
//! f    = color D / (4 cos θₒ cos θᵢ (1 + Λ(θₒ) + Λ(θᵢ)))                                  (3)
//! ```
//!
//! Conty Estevez & Kulla 2017, "Production friendly microfacet sheen BRDF", and the README of
//! KHR_materials_sheen. Its albedo E is tabulated over √cos θ and the roughness. At grazing
//! angles over smooth fibres E exceeds 1, up to 2.5: f is divided by the greater of both
//! directions' E where that is above 1.

use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;
use std::sync::OnceLock;

/// Least perceptual roughness: below it (1) overflows.
const LEAST: f32 = 0.07;
/// Nodes along the root of the cosine and the roughness, both uniform on [0, 1].
const SIZE: usize = 24;
/// Points of the quadrature along each angle.
const POINTS: usize = 48;

static TABLE: OnceLock<Box<[[f32; SIZE]; SIZE]>> = OnceLock::new();

/// A sheen at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheen {
    color: Spectrum,
    roughness: f32,
}

impl Sheen {
    /// Colour and perceptual roughness in [0,1].
    pub fn new(color: Spectrum, roughness: f32) -> Sheen {
        Sheen { color, roughness: roughness.clamp(LEAST, 1.0) }
    }

    /// f cos θᵢ for directions above the surface: (3).
    #[inline]
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let excess = self.white(wo.z).max(self.white(wi.z)).max(1.0);
        self.color * (value(sqr(self.roughness), wo, wi) * wi.z / excess)
    }

    /// Directional albedo at cos θ.
    #[inline]
    pub fn albedo(&self, cos: f32) -> Spectrum {
        self.color * self.white(cos).min(1.0)
    }

    /// What the sheen leaves of light at cos θ: 1 - max(color) E.
    #[inline]
    pub fn passed(&self, cos: f32) -> f32 {
        (1.0 - self.color.max_component() * self.white(cos).min(1.0)).max(0.0)
    }

    /// E of white fibres by its table, bilinear.
    fn white(&self, cos: f32) -> f32 {
        let table = TABLE.get_or_init(tabulate);
        let at = |x: f32| {
            let x = x.clamp(0.0, 1.0) * (SIZE - 1) as f32;
            let i = (x as usize).min(SIZE - 2);
            (i, x - i as f32)
        };
        let ((i, s), (j, t)) = (at(self.roughness), at(cos.max(0.0).sqrt()));
        let row = |r: &[f32; SIZE]| r[j] * (1.0 - t) + r[j + 1] * t;
        row(&table[i]) * (1.0 - s) + row(&table[i + 1]) * s
    }
}

/// f of a white sheen.
fn value(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    let Some(m) = (wo + wi).try_normalize() else { return 0.0 };
    let sin2 = sqr(m.x) + sqr(m.y);
    let d = (2.0 + 1.0 / alpha) * sin2.powf(0.5 / alpha) / (2.0 * PI); // (1)
    let (o, i) = (wo.z.max(1e-4), wi.z.max(1e-4));
    d / ((1.0 + lambda(o, alpha) + lambda(i, alpha)) * 4.0 * o * i)
}

/// Λ of (2).
fn lambda(cos: f32, alpha: f32) -> f32 {
    let t = sqr(1.0 - alpha);
    let mix = |x: f32, y: f32| x * (1.0 - t) + y * t;
    let a = mix(21.5473, 25.3245);
    let b = mix(3.82987, 3.32435);
    let c = mix(0.19823, 0.16801);
    let d = mix(-1.97760, -1.27393);
    let e = mix(-4.32054, -4.85967);
    let l = |x: f32| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cos < 0.5 { l(cos).exp() } else { (2.0 * l(0.5) - l(1.0 - cos)).exp() }
}

fn tabulate() -> Box<[[f32; SIZE]; SIZE]> {
    let mut table = Box::new([[0.0; SIZE]; SIZE]);
    let node = |i: usize| i as f32 / (SIZE - 1) as f32;
    for (i, row) in table.iter_mut().enumerate() {
        let alpha = sqr(node(i).max(LEAST));
        for (j, entry) in row.iter_mut().enumerate() {
            let mu = sqr(node(j)).max(1e-3);
            let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
            let mut sum = 0.0;
            for k in 0..POINTS * POINTS {
                let u = Vec2::new(
                    ((k % POINTS) as f32 + 0.5) / POINTS as f32,
                    ((k / POINTS) as f32 + 0.5) / POINTS as f32,
                );
                // Denser towards the horizon, where fibres shine: cos θ = u², dω = 2u du dφ.
                let (z, phi) = (sqr(u.y), 2.0 * PI * u.x);
                let r = (1.0 - z * z).sqrt();
                let wi = Vec3::new(r * phi.cos(), r * phi.sin(), z);
                sum += 2.0 * PI * 2.0 * u.y * z * value(alpha, wo, wi);
            }
            *entry = sum / (POINTS * POINTS) as f32;
        }
    }
    table
}
