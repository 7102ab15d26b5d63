//! Solvers of the radiosity system.
//!
//! ```text
//! B_i = S_i + ρ_i Σⱼ F_ij B_j                                                       (1)
//! H_i = Σⱼ F_ij B_j                                                                 (2)
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

    /// B of the irradiances.
    pub fn radiosity(&self, irradiance: &[Spectrum]) -> Vec<Spectrum> {
        let b = |((s, rho), h): ((&Spectrum, &Spectrum), &Spectrum)| *s + *rho * *h;
        self.source.iter().zip(&self.albedo).zip(irradiance).map(b).collect()
    }
}
