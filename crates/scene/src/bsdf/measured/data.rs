//! A measured BRDF prepared for one colour mode.

use super::Measured;
use super::squares::{Densities, Node, bilinear, interval};
use crate::description::{MeasuredBrdf, MeasuredChannels, SquareTable};
use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::{
    ColorMode, ColorSpace, Spectrum, SpectrumDesc, SpectrumRole, Wavelengths, eval_rgb_unbounded,
    xyz_of,
};
use std::f32::consts::PI;

/// Tables of [`Measured`], shared by all surfaces of that material.
#[derive(Debug)]
pub struct MeasuredData {
    phi: Vec<f32>,
    theta: Vec<f32>,
    pub(super) ndf: SquareTable,
    pub(super) sigma: SquareTable,
    pub(super) vndf: Densities,
    pub(super) luminance: Densities,
    reflectance: SquareTable,
    channels: MeasuredChannels,
    pub(super) jacobian: bool,
    pub(super) isotropic: bool,
    /// Into how many equal sectors the measurement repeats about the normal: 1, 2 or 4.
    pub(super) sectors: u32,
    /// Directional albedo of each φ, θ and channel.
    albedo: Vec<f32>,
    /// √ of the half vectors' mean squared slope, seen from the normal.
    pub(super) roughness: f32,
}

/// Samples along each side of the square for the albedo.
const SIDE: usize = 32;

impl MeasuredData {
    /// Prepares a measurement. In RGB mode one by wavelengths becomes linear sRGB, lit by D65.
    ///
    /// The tables must have the sizes that [`MeasuredBrdf`] says, as readers see to.
    pub fn new(brdf: &MeasuredBrdf, mode: ColorMode) -> MeasuredData {
        let (reflectance, channels) = match (&brdf.channels, mode) {
            (MeasuredChannels::Wavelengths(lambda), ColorMode::Rgb) => {
                (seen_in_rgb(&brdf.reflectance, lambda), MeasuredChannels::Rgb)
            }
            _ => (brdf.reflectance.clone(), brdf.channels.clone()),
        };
        let range = brdf.phi.last().zip(brdf.phi.first()).map_or(0.0, |(b, a)| b - a);
        let isotropic = brdf.phi.len() <= 2;
        let mut data = MeasuredData {
            phi: brdf.phi.clone(),
            theta: brdf.theta.clone(),
            ndf: brdf.ndf.clone(),
            sigma: brdf.sigma.clone(),
            vndf: Densities::new(&brdf.vndf),
            luminance: Densities::new(&brdf.luminance),
            reflectance,
            channels,
            jacobian: brdf.jacobian,
            isotropic,
            sectors: if isotropic { 1 } else { (2.0 * PI / range).round() as u32 },
            albedo: Vec::new(),
            roughness: 1.0,
        };
        data.find_albedo();
        data
    }

    /// The tables about a direction.
    pub(super) fn node(&self, phi: f32, theta: f32) -> Node {
        Node::at((&self.phi, phi), (&self.theta, theta))
    }

    /// Reflectance at a point of the square of samples.
    pub(super) fn reflectance(&self, node: &Node, s: Vec2, lambda: &Wavelengths) -> Spectrum {
        let n = self.channels.count();
        self.spectrum(lambda, |c| node.mean(|t| bilinear(&self.reflectance, t * n + c, s)))
    }

    /// Directional albedo.
    pub(super) fn albedo(&self, node: &Node, lambda: &Wavelengths) -> Spectrum {
        let n = self.channels.count();
        self.spectrum(lambda, |c| node.mean(|t| self.albedo[t * n + c]))
    }

    /// What the values of the channels are to a path.
    fn spectrum(&self, lambda: &Wavelengths, channel: impl Fn(usize) -> f32) -> Spectrum {
        match (&self.channels, lambda.mode) {
            (MeasuredChannels::Wavelengths(nodes), _) => Spectrum(lambda.lambda.map(|l| {
                let (i, t) = interval(nodes, l);
                let next = (i + 1).min(nodes.len() - 1);
                ((1.0 - t) * channel(i) + t * channel(next)).max(0.0)
            })),
            (MeasuredChannels::Rgb, mode) => {
                let rgb = std::array::from_fn(|c| channel(c).max(0.0));
                match mode {
                    ColorMode::Rgb => Spectrum::from_rgb(rgb),
                    ColorMode::Spectral => eval_rgb_unbounded(rgb, lambda),
                }
            }
        }
    }

    /// Means of value over density at a grid of samples, for each direction of the tables.
    fn find_albedo(&mut self) {
        let n = self.channels.count();
        let mut albedo = vec![0.0; self.phi.len() * self.theta.len() * n];
        let mut slope = 0.0;
        for (p, &phi) in self.phi.iter().enumerate() {
            for (t, &theta) in self.theta.iter().enumerate() {
                let table = p * self.theta.len() + t;
                let model = Measured { data: self, lambda: Wavelengths::rgb() };
                let wo = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                let mut sums = vec![0.0; n];
                for k in 0..SIDE * SIDE {
                    let u = Vec2::new((k % SIDE) as f32, (k / SIDE) as f32);
                    let u = (u + Vec2::new(0.5, 0.5)) * (1.0 / SIDE as f32);
                    let Some((wi, place)) = model.drawn(wo, u) else { continue };
                    let pdf = model.density(&place);
                    if pdf <= 0.0 {
                        continue;
                    }
                    let k = model.scale(&place) / pdf;
                    for (c, sum) in sums.iter_mut().enumerate() {
                        let value = bilinear(&self.reflectance, table * n + c, place.sample);
                        *sum += k * value.max(0.0);
                    }
                    if p == 0 && t == 0 {
                        let m = (wo + wi).normalize();
                        slope += (1.0 - sqr(m.z)) / sqr(m.z);
                    }
                }
                let share = 1.0 / (SIDE * SIDE) as f32;
                sums.iter().enumerate().for_each(|(c, s)| albedo[table * n + c] = s * share);
            }
        }
        self.roughness = (slope / (SIDE * SIDE) as f32).sqrt().min(1.0);
        self.albedo = albedo;
    }
}

/// Tables by wavelengths as linear sRGB under D65.
fn seen_in_rgb(table: &SquareTable, lambda: &[f32]) -> SquareTable {
    let size = table.width * table.height;
    let parts = rgb_of_nodes(lambda);
    let mut values = Vec::with_capacity(table.values.len() / lambda.len() * 3);
    for grids in table.values.chunks_exact(size * lambda.len()) {
        for channel in 0..3 {
            values.extend((0..size).map(|at| {
                let sum: f32 =
                    parts.iter().enumerate().map(|(i, p)| p[channel] * grids[i * size + at]).sum();
                sum.max(0.0)
            }));
        }
    }
    SquareTable { values, ..*table }
}

/// The linear sRGB under D65 of each wavelength's part (1 there, 0 at the others) of a piecewise
/// linear spectrum that is constant beyond its ends.
pub(in crate::bsdf) fn rgb_of_nodes(lambda: &[f32]) -> Vec<[f32; 3]> {
    (0..lambda.len())
        .map(|i| {
            let hat: Vec<f32> = (0..lambda.len()).map(|k| (k == i) as u32 as f32).collect();
            let (mut l, mut v) = (lambda.to_vec(), hat);
            if l[0] > 1.0 {
                l.insert(0, 0.0);
                v.insert(0, v[0]);
            }
            l.push(l[l.len() - 1] + 1e4);
            v.push(v[v.len() - 1]);
            let desc = SpectrumDesc::sampled(&l, &v).unwrap_or(SpectrumDesc::Constant(0.0));
            ColorSpace::Srgb.from_xyz().apply(xyz_of(&desc, SpectrumRole::Albedo))
        })
        .collect()
}
