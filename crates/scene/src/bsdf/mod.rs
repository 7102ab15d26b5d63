//! BSDFs: how a surface point scatters light.
//!
//! # Contract
//!
//! Every model lives in its own file and works in the local shading frame, where the shading
//! normal is +z. `wo` is the known direction, `wi` the sampled one; **both point away from the
//! surface** and are unit. A model is a small value built at each hit from evaluated parameters.
//!
//! * [`Scatter::eval`]`(wo, wi, mode, lobes)` = f(wo, wi) |cos θᵢ|, Dirac lobes left out.
//! * [`Scatter::pdf`] = (density of `wi` given `wo`, density of `wo` given `wi`) per solid
//!   angle, Dirac lobes left out; both of the same `lobes` and `mode` (the reverse one with the
//!   other mode's sampling where that differs).
//! * [`Scatter::sample`] draws `wi`; `weight = eval / pdf` for the same `lobes`, where for
//!   models with several smooth lobes `eval` and `pdf` are those of all of them together. For
//!   Dirac lobes `pdf` is the probability of the choice and `weight` = value / probability.
//! * In [`Mode::Radiance`] refraction scales by 1/η² (radiance is compressed into the smaller
//!   solid angle); in [`Mode::Importance`] it does not (Veach 1997, sec. 5.2). f(wo, wi) in one
//!   mode equals f(wi, wo) in the other, up to the cosines.
//! * Reflecting models are **one-sided**: black where `wo.z <= 0`. [`crate::description`]'s
//!   `TwoSided` makes them reflect on both sides.
//! * `eval` and `pdf` are pure functions of their arguments.

mod albedo;
mod coating;
mod composite;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
pub mod fresnel;
mod grating;
mod hair;
mod height_field;
mod layered;
mod lobes;
mod measured;
mod measured_polarized;
mod metallic_roughness;
mod microfacet;
mod model;
mod null;
mod oren_nayar;
mod phong;
mod plastic;
mod polarize;
mod polarizing_filter;
mod principled;
mod rough_plastic;
mod rough_transmittance;
mod share;
#[cfg(test)]
mod testing;
mod thin_dielectric;
mod ward;

pub use albedo::microfacet_albedo;
pub use coating::{Coating, CoatingLayer};
pub use composite::{Bsdf, MAX_PARTS, Part, relief_roughness, relief_shadowing};
pub use conductor::{Conductor, ConductorFresnel};
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use diffuse_transmission::DiffuseTransmission;
pub use grating::{Grating, GratingLight, GratingProfile};
pub use hair::{Across, EUMELANIN, Hair, HairParameters, PHEOMELANIN, absorption_of_color};
pub use height_field::{HeightField, HeightFieldData};
pub use layered::{Coat, CoatedConductor, CoatedDiffuse, Layered};
pub use lobes::Lobes;
pub use measured::{Measured, MeasuredData};
pub use measured_polarized::{MeasuredPolarized, MuellerData};
pub use metallic_roughness::{
    Boundary, Clearcoat, Film, MetallicRoughness, MetallicRoughnessParameters,
};
pub use microfacet::{Masking, Microfacet};
pub use model::Model;
pub use null::Null;
pub use oren_nayar::OrenNayar;
pub use phong::Phong;
pub use plastic::{Plastic, PlasticCoat};
pub use polarize::Polarize;
pub use polarizing_filter::{FilterElement, PolarizingFilter};
pub(crate) use principled::facets as principled_facets;
pub use principled::{
    Principled, PrincipledParameters, PrincipledThin, PrincipledThinParameters, eta_from_specular,
};
pub use rough_plastic::RoughPlastic;
pub use rough_transmittance::{AlphaIndex, RoughTransmittance};
pub use thin_dielectric::ThinDielectric;
pub use ward::Ward;

use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// Which quantity a path carries from its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The path started at the camera; light flows from `wi` to `wo`.
    Radiance,
    /// The path started at a light; light flows from `wo` to `wi`.
    Importance,
}

impl Mode {
    /// The other one.
    #[inline]
    pub fn adjoint(self) -> Mode {
        match self {
            Mode::Radiance => Mode::Importance,
            Mode::Importance => Mode::Radiance,
        }
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction, unit, away from the surface.
    pub wi: Vec3,
    /// f |cos θᵢ| / pdf.
    pub weight: Spectrum,
    /// Density of `wi` per solid angle; for Dirac lobes a probability.
    pub pdf: f32,
    /// Density (or probability) of `wo` if `wi` had been known.
    pub pdf_rev: f32,
    /// Index of refraction on the side of `wi` over that on the side of `wo`; 1 for reflection.
    pub eta: f32,
    /// The one class that was sampled.
    pub lobe: Lobes,
}

impl BsdfSample {
    /// Of a smooth model that drew the reflection `wi` from `lobe`, one of `lobes`: by its own density and value there;
    /// `None` if it does not reflect there.
    #[inline]
    fn reflection(
        model: &impl Scatter,
        (wo, wi): (Vec3, Vec3),
        (mode, lobes): (Mode, Lobes),
        lobe: Lobes,
    ) -> Option<BsdfSample> {
        let (pdf, pdf_rev) = model.pdf(wo, wi, mode, lobes);
        let weight = || model.eval(wo, wi, mode, lobes) / pdf;
        (pdf > 0.0).then(|| BsdfSample { wi, weight: weight(), pdf, pdf_rev, eta: 1.0, lobe })
    }
}

/// What every scattering model answers, in its local frame. See the module's contract.
pub trait Scatter {
    /// f(wo, wi) |cos θᵢ| of the smooth classes in `lobes`.
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum;

    /// Densities per solid angle (forward, reverse) of sampling from `lobes`.
    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32);

    /// [`Scatter::eval`] and [`Scatter::pdf`] at once, for models where they share work.
    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (Spectrum, (f32, f32)) {
        (self.eval(wo, wi, mode, lobes), self.pdf(wo, wi, mode, lobes))
    }

    /// Draws a direction from `lobes` with `uc` (choice) and `u2` (direction), uniform in [0,1).
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample>;

    /// Directional albedo for `wo`: ∫ f |cos θᵢ| dωᵢ with Dirac lobes, exact or a smooth
    /// approximation (each model says which); for feature layers, roulette, photon choice.
    fn albedo(&self, wo: Vec3) -> Spectrum;

    /// Roughness in [0,1]: 0 mirror, 1 diffuse (for microfacets √(αᵤ αᵥ), clamped).
    fn roughness(&self) -> f32;

    /// The classes this value can scatter into.
    fn lobes(&self) -> Lobes;
}
