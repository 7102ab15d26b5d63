//! Solvers of the radiosity system.
//!
//! ```text
//! B_i = S_i + ρ_i Σⱼ F_ij B_j                                                       (1)
//! H_i = Σⱼ F_ij B_j                                                                 (2)
//! ```
//!
//! ```text
//! rest ≈ δ q/(1 - q),   δ = Σ A |ΔB| of an iteration, q = δ/δ of the one before      (3)
//! ```
//!
//! S is what patches send by themselves: what they emit, and what they reflect of light that is not a
//! patch's. All answer the irradiance H, W/m², which neighbouring surfaces of different colours share.

mod matrix;
mod shooting;

pub use matrix::{direct, gauss_seidel, jacobi};
pub use shooting::{Shooting, shoot};

use super::mesh::{Element, Mesh};
use kaustika_spectra::Spectrum;

/// Whether iterations may end: changes of the light shrink as a geometric series, whose rest (3) tells.
/// Not those of the brightest patch, which is a lamp that does not change at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest {
    before: Option<f64>,
}

impl Rest {
    /// (3): true if the rest is no more than `tolerance` of all the light. `change` and `all` are
    /// Σ A |ΔB| and Σ A B.
    pub fn is_within(&mut self, change: f64, all: f64, tolerance: f32) -> bool {
        let q = self.before.replace(change).map(|before| change / before);
        let rest = q.filter(|q| *q < 1.0).map(|q| change * q / (1.0 - q));
        change == 0.0 || rest.is_some_and(|rest| rest <= f64::from(tolerance) * all)
    }
}

/// Sum over the colours.
pub fn sum(s: Spectrum) -> f64 {
    s.rgb().iter().map(|x| f64::from(x.abs())).sum()
}

/// What is known of the patches.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// ρ.
    pub albedo: Vec<Spectrum>,
    /// S, W/m².
    pub source: Vec<Spectrum>,
    /// A.
    pub area: Vec<f32>,
}

impl Patches {
    /// Of a mesh's leaves; `direct` is the irradiance of each by light that is no patch's.
    pub fn new(mesh: &Mesh, leaves: &[u32], direct: &[Spectrum], emits: bool) -> Patches {
        let elements = || leaves.iter().map(|&e| &mesh.elements[e as usize]);
        let source = |(e, h): (&Element, &Spectrum)| match emits {
            true => e.emission + e.albedo * *h,
            false => e.albedo * *h,
        };
        Patches {
            albedo: elements().map(|e| e.albedo).collect(),
            source: elements().zip(direct).map(source).collect(),
            area: elements().map(|e| e.area).collect(),
        }
    }

    /// A ρ H of patch `i`, over the colours, whatever the sign of H.
    fn power(&self, i: usize, h: Spectrum) -> f64 {
        f64::from(self.area[i]) * sum(self.albedo[i] * h)
    }

    /// B of the irradiances.
    pub fn radiosity(&self, irradiance: &[Spectrum]) -> Vec<Spectrum> {
        let b = |((s, rho), h): ((&Spectrum, &Spectrum), &Spectrum)| *s + *rho * *h;
        self.source.iter().zip(&self.albedo).zip(irradiance).map(b).collect()
    }
}
