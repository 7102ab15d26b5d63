//! What a relief looks like from afar: the BRDF of a height field of small mirrors, as a table.
//!
//! ```text
//! f(ωₒ, ωᵢ) |cos θᵢ| = R D(m) G(ωₒ, ωᵢ) / (4 cos θₒ),   m = (ωₒ + ωᵢ)/|ωₒ + ωᵢ|               (1)
//! D(m) = P(s) / cos⁴ θ_m,   s = (-m_x/m_z, -m_y/m_z)                                        (2)
//! pdf(ωᵢ) = P(s) / cos³ θ_m / (4 ωₒ·m)                                                      (3)
//! ```
//!
//! P is the density of the field's slopes, tabulated ([`slopes`]); G the part of it that is in nobody's
//! shadow, found by the field's own horizons ([`shadows`]). Cabral, Max & Springmeyer 1987, "Bidirectional
//! reflection functions from surface bump maps"; (1) as microfacets have it (Cook & Torrance 1982), for of small
//! mirrors only those along m send light from ωᵢ to ωₒ. Light that facets send on to other facets is lost.

mod shadows;
mod slopes;
#[cfg(test)]
mod tests;

use super::fresnel::reflect;
use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::Spectrum;
use shadows::Shadows;
use slopes::Slopes;

/// What is known of a height field.
#[derive(Debug)]
pub struct HeightFieldData {
    slopes: Slopes,
    shadows: Shadows,
}

/// A height field of small mirrors, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct HeightField<'a> {
    /// Its tables.
    pub data: &'a HeightFieldData,
    /// R: what its mirrors reflect.
    pub reflectance: Spectrum,
}

/// Heights over the unit square, which repeats, in units of its side: bilinear between nodes.
#[derive(Debug)]
pub(super) struct Heights {
    n: usize,
    values: Vec<f32>,
    highest: f32,
}

impl HeightFieldData {
    /// Of `n` x `n` heights (n at least 2) over the unit square, which repeats, in units of its side; rows of
    /// growing v.
    pub fn new(n: usize, values: Vec<f32>) -> HeightFieldData {
        let heights = Heights::new(n, values);
        let slopes = Slopes::new(&heights);
        let shadows = Shadows::new(&heights, &slopes);
        HeightFieldData { slopes, shadows }
    }
}

impl Heights {
    fn new(n: usize, values: Vec<f32>) -> Heights {
        let highest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Heights { n, values, highest }
    }

    fn at(&self, i: isize, j: isize) -> f32 {
        let n = self.n as isize;
        self.values[(j.rem_euclid(n) * n + i.rem_euclid(n)) as usize]
    }

    /// The height, and its slopes along u and v.
    pub(super) fn look(&self, uv: Vec2) -> (f32, Vec2) {
        let n = self.n as f32;
        let (x, y) = (uv.x * n, uv.y * n);
        let (i, j) = (x.floor(), y.floor());
        let (x, y) = (x - i, y - j);
        let corner = |di, dj| self.at(i as isize + di, j as isize + dj);
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
        let along_u = (b - a) * (1.0 - y) + (d - c) * y;
        let along_v = (c - a) * (1.0 - x) + (d - b) * x;
        (a + (c - a) * y + along_u * x, Vec2::new(along_u, along_v) * n)
    }
}

impl HeightField<'_> {
    /// m of two directions above the surface, and its slopes.
    fn half(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec2)> {
        let m = (wo + wi).try_normalize().filter(|m| wo.z > 0.0 && wi.z > 0.0 && m.z > 1e-4)?;
        Some((m, Vec2::new(-m.x / m.z, -m.y / m.z)))
    }
}

impl Scatter for HeightField<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return Spectrum::ZERO;
        }
        let Some((m, s)) = Self::half(wo, wi) else { return Spectrum::ZERO };
        let d = self.data.slopes.density(s) / sqr(sqr(m.z)); // (2)
        self.reflectance * (d * self.data.shadows.open(wo, wi) * 0.25 / wo.z) // (1)
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return (0.0, 0.0);
        }
        let Some((m, s)) = Self::half(wo, wi) else { return (0.0, 0.0) };
        // (3): ωₒ·m = ωᵢ·m.
        let pdf = self.data.slopes.density(s) / (m.z * sqr(m.z) * 4.0 * wo.dot(m));
        (pdf, pdf)
    }

    fn sample(&self, wo: Vec3, _: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let s = self.data.slopes.sample(u2);
        let wi = reflect(wo, Vec3::new(-s.x, -s.y, 1.0).normalize());
        BsdfSample::reflection(self, (wo, wi), (mode, lobes), Lobes::GLOSSY_REFLECTION)
    }

    /// From a table; good to 0.01.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        match wo.z > 0.0 {
            true => self.reflectance * self.data.shadows.albedo(wo),
            false => Spectrum::ZERO,
        }
    }

    /// By the mean square of the slopes.
    fn roughness(&self) -> f32 {
        self.data.slopes.roughness()
    }

    fn lobes(&self) -> Lobes {
        match self.reflectance.is_black() {
            true => Lobes::NONE,
            false => Lobes::GLOSSY_REFLECTION,
        }
    }
}
