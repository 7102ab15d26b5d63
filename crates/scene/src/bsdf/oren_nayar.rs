//! Rough diffuse reflection from V-shaped grooves of Lambert facets (Oren & Nayar 1994,
//! "Generalization of Lambert's reflectance model").
//!
//! With α = max(θₒ, θᵢ), β = min(θₒ, θᵢ), Δφ the difference of azimuths, k(c) = σ²/(σ² + c):
//!
//! ```text
//! single  C₁ = 1 - k(0.33)/2
//!         C₂ = 0.45 k(0.09) (sin α - [cos Δφ < 0] (2β/π)³)
//!         C₃ = 0.125 k(0.09) (4αβ/π²)²
//!         L₁ = C₁ + C₂ cos Δφ tan β + C₃ (1 - |cos Δφ|) tan((α + β)/2)           (1)
//! double  L₂ = 0.17 k(0.13) (1 - cos Δφ (2β/π)²)                                (2)
//! full    f  = (ρ L₁ + ρ² L₂)/π                                                 (3)
//! fast    f  = ρ/π (C₁ + 0.45 k(0.09) max(0, cos Δφ) sin α tan β)                (4)
//! ```
//!
//! (3) is the paper's eq. 30-31, (4) its "qualitative" model, eq. 27. Both are fits: a white
//! surface seen at a grazing angle reflects up to 1.5 % (4) or 5 % (3) more light than it gets. For
//! σ above 0.9 (3) could be negative opposite to the light; it is clamped there.

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, safe_acos, safe_sqrt, sqr, warp};
use kaustika_spectra::Spectrum;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_2_PI, FRAC_PI_2, PI};

/// A rough matte, one-sided surface.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    /// Albedo ρ of the facets in [0,1].
    pub reflectance: Spectrum,
    /// σ >= 0: standard deviation of the facets' angles, radians; 0 is Lambert's model.
    pub sigma: f32,
    /// True: (4) in place of (3).
    pub fast: bool,
}

/// One of the two directions, its angle and the functions of it that (1-4) need.
#[derive(Clone, Copy)]
struct Elevation {
    theta: f32,
    sin: f32,
    cos: f32,
}

impl Elevation {
    #[inline]
    fn of(w: Vec3) -> Elevation {
        Elevation { theta: safe_acos(w.z), sin: safe_sqrt(sqr(w.x) + sqr(w.y)), cos: w.z }
    }

    #[inline]
    fn at(theta: f32) -> Elevation {
        let (sin, cos) = theta.sin_cos();
        Elevation { theta, sin, cos }
    }
}

impl OrenNayar {
    /// From the root mean square slope `alpha` of other models' microfacets: σ = α/√2, the
    /// conversion of Mitsuba 0.6's `roughdiffuse`, whose fit is good up to α = 0.5.
    #[inline]
    pub fn from_slope(reflectance: Spectrum, alpha: f32, fast: bool) -> OrenNayar {
        OrenNayar { reflectance, sigma: alpha.max(0.0) * FRAC_1_SQRT_2, fast }
    }

    #[inline]
    fn k(&self, c: f32) -> f32 {
        let s2 = sqr(self.sigma);
        s2 / (s2 + c)
    }

    /// Factors of ρ and of ρ² in π f, for cos Δφ `c`: (3), (4).
    #[inline]
    fn factors(&self, o: Elevation, i: Elevation, c: f32) -> (f32, f32) {
        let (a, b) = if o.cos > i.cos { (i, o) } else { (o, i) };
        let tan_b = b.sin / b.cos;
        let c1 = 1.0 - 0.5 * self.k(0.33);
        let k09 = self.k(0.09);
        if self.fast {
            return (c1 + 0.45 * k09 * c.max(0.0) * a.sin * tan_b, 0.0);
        }
        let b2 = FRAC_2_PI * b.theta;
        let c2 = 0.45 * k09 * if c < 0.0 { a.sin - b2 * b2 * b2 } else { a.sin };
        let c3 = 0.125 * k09 * sqr(b2 * FRAC_2_PI * a.theta);
        let tan_half = (a.sin + b.sin) / (a.cos + b.cos);
        let single = c1 + c2 * c * tan_b + c3 * (1.0 - c.abs()) * tan_half; // (1)
        let double = 0.17 * self.k(0.13) * (1.0 - c * sqr(b2)); // (2)
        (single.max(0.0), double)
    }

    /// Factors of ρ and ρ² in the albedo: ∫ (L₁, L₂) cos θᵢ dωᵢ / π by the midpoint rule in φ,
    /// which the four kinks of |cos Δφ| suit, and Gauss's rule of three points in θᵢ on both
    /// sides of θₒ, where α and β change roles.
    fn albedo_factors(&self, o: Elevation) -> (f32, f32) {
        const NODES: [(f32, f32); 3] =
            [(0.112_701_67, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_33, 5.0 / 18.0)];
        const AZIMUTHS: usize = 8;
        let mut sum = (0.0, 0.0);
        for (low, high) in [(0.0, o.theta), (o.theta, FRAC_PI_2)] {
            for (x, weight) in NODES {
                let i = Elevation::at(low + x * (high - low));
                let measure = weight * (high - low) * i.sin * i.cos * (2.0 / AZIMUTHS as f32);
                for j in 0..AZIMUTHS {
                    let c = ((j as f32 + 0.5) * (PI / AZIMUTHS as f32)).cos();
                    let (single, double) = self.factors(o, i, c);
                    sum = (sum.0 + measure * single, sum.1 + measure * double);
                }
            }
        }
        sum
    }
}

impl Scatter for OrenNayar {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return Spectrum::ZERO;
        }
        let (o, i) = (Elevation::of(wo), Elevation::of(wi));
        let sines = o.sin * i.sin;
        let cos_phi = if sines > 1e-8 { (wo.x * wi.x + wo.y * wi.y) / sines } else { 0.0 };
        let (first, second) = self.factors(o, i, cos_phi.clamp(-1.0, 1.0));
        self.reflectance * (Spectrum::splat(first) + self.reflectance * second) * (INV_PI * wi.z)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return (0.0, 0.0);
        }
        (warp::cosine_hemisphere_pdf_w(wi.z), warp::cosine_hemisphere_pdf_w(wo.z))
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return None;
        }
        let wi = warp::cosine_hemisphere(u2);
        BsdfSample::reflection(self, (wo, wi), (mode, lobes), Lobes::DIFFUSE_REFLECTION)
    }

    /// By quadrature, within 0.01.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if self.sigma == 0.0 {
            return self.reflectance;
        }
        let (first, second) = self.albedo_factors(Elevation::of(wo));
        self.reflectance * (Spectrum::splat(first) + self.reflectance * second)
    }

    #[inline]
    fn roughness(&self) -> f32 {
        1.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.reflectance.is_black() { Lobes::NONE } else { Lobes::DIFFUSE_REFLECTION }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Diffuse;
    use super::super::testing::{Expect, Random, check_model};
    use super::*;

    #[test]
    fn holds_the_contract() {
        let reflectance = Spectrum([1.0, 0.6, 0.2, 0.0]);
        for fast in [false, true] {
            // What a white surface may gain, by the fits' fault.
            let albedo_max = if fast { 1.016 } else { 1.052 };
            for sigma in [0.0, 0.1, 0.2, 0.35, 0.6, 1.2] {
                let expect = Expect { albedo_max, albedo_error: 0.01, ..Expect::default() };
                let model = OrenNayar { reflectance, sigma, fast };
                check_model(&format!("Oren-Nayar {sigma} fast {fast}"), &model, expect);
            }
        }
    }

    #[test]
    fn without_roughness_it_is_lambert() {
        let reflectance = Spectrum([0.9, 0.5, 0.1, 0.0]);
        let lambert = Diffuse { reflectance };
        let mut random = Random::new(1);
        for fast in [false, true] {
            let model = OrenNayar { reflectance, sigma: 0.0, fast };
            for _ in 0..1000 {
                let wo = warp::uniform_hemisphere(random.next_2d());
                let wi = warp::uniform_hemisphere(random.next_2d());
                let a = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
                let b = lambert.eval(wo, wi, Mode::Radiance, Lobes::ALL);
                for lane in 0..4 {
                    assert!(
                        (a[lane] - b[lane]).abs() <= 2.0 * f32::EPSILON * b[lane],
                        "{a:?} {b:?}"
                    );
                }
            }
        }
    }

    /// Lit from the camera, a sphere's disc gets flatter as σ grows: the ratio of what is seen
    /// near the rim and at the centre rises from Lambert's cos θ.
    #[test]
    fn a_sphere_lit_from_the_camera_gets_flatter() {
        let rim = Elevation::at(1.2);
        let w = Vec3::new(rim.sin, 0.0, rim.cos);
        for fast in [false, true] {
            let flatness = |sigma| {
                let model = OrenNayar { reflectance: Spectrum::splat(0.8), sigma, fast };
                let seen = |w| model.eval(w, w, Mode::Radiance, Lobes::ALL)[0];
                seen(w) / seen(Vec3::Z)
            };
            let ratios = [0.0, 0.1, 0.3, 0.6].map(flatness);
            assert!((ratios[0] - rim.cos).abs() < 1e-5, "{ratios:?}");
            assert!(ratios.windows(2).all(|r| r[1] > r[0] + 0.03), "{ratios:?}");
        }
    }

    /// Figures by hand: σ = 0.3 (k(0.33) = 3/14, k(0.09) = 1/2, k(0.13) = 9/22), both directions
    /// at 45°, seen from the light's side and opposite to it.
    #[test]
    fn has_its_known_values() {
        let h = FRAC_1_SQRT_2;
        let (wo, wi) = (Vec3::new(h, 0.0, h), Vec3::new(-h, 0.0, h));
        let at = |wi, fast| {
            let model = OrenNayar { reflectance: Spectrum::splat(0.5), sigma: 0.3, fast };
            PI / h * model.eval(wo, wi, Mode::Radiance, Lobes::ALL)[0]
        };
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5, "{a} {b}");
        near(at(wo, true), 0.5 * (0.892_857 + 0.225 * h));
        near(at(wi, true), 0.5 * 0.892_857);
        let double = 0.25 * 0.17 * 9.0 / 22.0;
        near(at(wo, false), 0.5 * (0.892_857 + 0.225 * h) + double * 0.75);
        near(at(wi, false), 0.5 * (0.892_857 - 0.225 * (h - 0.125)) + double * 1.25);
    }
}
