//! A measured pBRDF prepared for one colour mode.

use super::MeasuredPolarized;
use crate::bsdf::measured::{interval, rgb_of_nodes};
use crate::bsdf::{Lobes, Microfacet, Mode, Scatter};
use crate::description::{Distribution, MeasuredMueller, MeasuredPolarizedDesc};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// Tables of [`MeasuredPolarized`], shared by all surfaces of that material.
#[derive(Debug)]
pub struct MuellerData {
    pub(super) table: Arc<MeasuredMueller>,
    /// Linear sRGB that 1 at each wavelength of the table gives under D65.
    rgb: Vec<[f32; 3]>,
    /// nm: the only one.
    wavelength: Option<f32>,
    /// Facets that directions are drawn by.
    pub(super) surface: Microfacet,
    /// Directional albedo at even steps of the angle from the normal, a value for each wavelength.
    albedo: Vec<f32>,
}

/// Angles at which the albedo is known, and samples along each side of the square for it.
const STEPS: usize = 16;
const SIDE: usize = 16;

/// The matrices around a pair of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners([(usize, f32); 8]);

impl MuellerData {
    /// Prepares a measurement.
    ///
    /// The table must have the sizes that [`MeasuredMueller`] says, as readers see to.
    pub fn new(desc: &MeasuredPolarizedDesc) -> MuellerData {
        let mut data = MuellerData {
            table: desc.table.clone(),
            rgb: rgb_of_nodes(&desc.table.wavelengths),
            wavelength: desc.wavelength,
            surface: Microfacet::new(Distribution::Ggx, desc.alpha, desc.alpha),
            albedo: Vec::new(),
        };
        data.find_albedo();
        data
    }

    /// Around these angles; those beyond the table's count as its border.
    pub(super) fn corners(&self, phi_d: f32, theta_d: f32, theta_h: f32) -> Corners {
        let t = &*self.table;
        let (p, tp) = interval(&t.phi_d, phi_d);
        let (d, td) = interval(&t.theta_d, theta_d);
        let (h, th) = interval(&t.theta_h, theta_h);
        let along = |i: usize, t: f32, k: usize, n: usize| match k {
            0 => (i, 1.0 - t),
            _ => ((i + 1).min(n - 1), t),
        };
        Corners(std::array::from_fn(|k| {
            let (p, wp) = along(p, tp, k & 1, t.phi_d.len());
            let (d, wd) = along(d, td, k >> 1 & 1, t.theta_d.len());
            let (h, wh) = along(h, th, k >> 2, t.theta_h.len());
            let matrix = (p * t.theta_d.len() + d) * t.theta_h.len() + h;
            (matrix * t.wavelengths.len(), wp * wd * wh)
        }))
    }

    /// Element `k` of the matrix, row by row.
    pub(super) fn element(&self, c: &Corners, k: usize, lambda: &Wavelengths) -> Spectrum {
        self.spectrum(lambda, |node| {
            let value = |first: usize| self.table.values[(first + node) * 16 + k];
            // What counts for nothing may be unknown.
            c.0.iter().filter(|(_, w)| *w > 0.0).map(|(first, w)| w * value(*first)).sum()
        })
    }

    /// What values at the wavelengths of the table are to a path.
    fn spectrum(&self, lambda: &Wavelengths, value: impl Fn(usize) -> f32) -> Spectrum {
        let nodes = &self.table.wavelengths;
        let at = |nm: f32| {
            let (i, t) = interval(nodes, nm);
            if t > 0.0 { (1.0 - t) * value(i) + t * value(i + 1) } else { value(i) }
        };
        match (self.wavelength, lambda.mode) {
            (Some(nm), ColorMode::Rgb) => Spectrum::from_rgb([at(nm); 3]),
            (Some(nm), ColorMode::Spectral) => Spectrum::splat(at(nm)),
            (None, ColorMode::Spectral) => Spectrum(lambda.lambda.map(at)),
            (None, ColorMode::Rgb) => {
                let rgb = self.rgb.iter().enumerate().fold([0.0; 3], |sum, (i, part)| {
                    let v = value(i);
                    std::array::from_fn(|c| sum[c] + part[c] * v)
                });
                Spectrum::from_rgb(rgb)
            }
        }
    }

    /// Directional albedo at a cosine.
    pub(super) fn albedo(&self, cos: f32, lambda: &Wavelengths) -> Spectrum {
        let n = self.table.wavelengths.len();
        let at = (cos.clamp(0.0, 1.0).acos() / FRAC_PI_2 * (STEPS - 1) as f32).max(0.0);
        let i = (at as usize).min(STEPS - 2);
        let t = at - i as f32;
        let value =
            |k: usize| (1.0 - t) * self.albedo[i * n + k] + t * self.albedo[(i + 1) * n + k];
        self.spectrum(lambda, value).clamp_zero()
    }

    /// Means of m₀₀ cos θᵢ over the density at a grid of samples.
    fn find_albedo(&mut self) {
        let n = self.table.wavelengths.len();
        let mut albedo = vec![0.0; STEPS * n];
        for step in 0..STEPS {
            // Not quite grazing.
            let theta = (step as f32 / (STEPS - 1) as f32).min(0.99) * FRAC_PI_2;
            let wo = Vec3::new(theta.sin(), 0.0, theta.cos());
            let model = MeasuredPolarized { data: self, lambda: Wavelengths::rgb() };
            for k in 0..SIDE * SIDE {
                let u = |i: usize| (i as f32 + 0.5) / SIDE as f32;
                let (u, v) = (u(k % SIDE), u(k / SIDE));
                // A permutation of the rows chooses the lobe.
                let uc = ((k * 7 + k / SIDE) % SIDE) as f32 / SIDE as f32;
                let Some(wi) = model.drawn(wo, uc, Vec2::new(u, v)) else { continue };
                let (pdf, _) = model.pdf(wo, wi, Mode::Radiance, Lobes::ALL);
                let corners = model.corners(wo, wi);
                let (Some(corners), true) = (corners, pdf > 0.0) else { continue };
                for node in 0..n {
                    let value = |first: usize| self.table.values[(first + node) * 16];
                    let sum: f32 = corners
                        .0
                        .iter()
                        .filter(|(_, w)| *w > 0.0)
                        .map(|(first, w)| w * value(*first))
                        .sum();
                    // `max` leaves nothing of what is unknown.
                    albedo[step * n + node] += sum.max(0.0) * wi.z / pdf / (SIDE * SIDE) as f32;
                }
            }
        }
        self.albedo = albedo;
    }
}
