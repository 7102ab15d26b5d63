//! What the parameters of models are at a hit: textures evaluated there.

use crate::bsdf::{
    self, ConductorFresnel, FilterElement, Masking, Microfacet, Model, Principled,
    PrincipledParameters, PrincipledThin, PrincipledThinParameters,
};
use crate::description::{
    CoatDesc, ConductorColor, FilterModel, IorDesc, PrincipledDesc, RoughnessDesc, TextureId,
};
use crate::geometry::Geometry;
use crate::surface::Surface;
use crate::texture::{TexturePoint, Textures};
use kaustika_math::{Vec3, mix_bits};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};
use std::cell::OnceCell;

/// One hit: what the models' parameters depend on.
pub(super) struct Hit<'t, 'l> {
    pub(super) geometry: &'t Geometry,
    pub(super) textures: &'t Textures,
    pub(super) surface: &'l Surface,
    /// Where textures are evaluated, once one of them varies.
    pub(super) at: OnceCell<TexturePoint>,
    pub(super) wo: Vec3,
    pub(super) lambda: &'l mut Wavelengths,
}

impl Hit<'_, '_> {
    /// Where textures are evaluated.
    pub(super) fn at(&self) -> &TexturePoint {
        self.at.get_or_init(|| TexturePoint::of(self.geometry, self.surface))
    }

    /// A texture as a spectrum.
    #[inline]
    pub(super) fn spectrum(&self, id: TextureId) -> Spectrum {
        match self.textures.uniform(id, self.lambda) {
            Some(value) => value,
            None => self.textures.spectrum(id, self.at(), self.lambda),
        }
    }

    /// A texture as a number.
    #[inline]
    pub(super) fn float(&self, id: TextureId) -> f32 {
        match self.textures.constant(id) {
            Some(value) => value,
            None => self.textures.float(id, self.at()),
        }
    }

    /// An index of refraction at the hero wavelength; where it disperses, the path keeps only
    /// that wavelength.
    #[inline]
    pub(super) fn ior(&mut self, ior: &IorDesc) -> f32 {
        match ior {
            IorDesc::Constant(eta) => *eta,
            IorDesc::Spectrum(id) => {
                let eta = self.spectrum(*id);
                if eta.0[1..] != [eta.0[0]; 3] {
                    self.lambda.terminate_secondary();
                }
                match self.lambda.mode {
                    ColorMode::Rgb => self.textures.ior(*id).unwrap_or(eta.0[1]),
                    ColorMode::Spectral => eta.0[0],
                }
            }
        }
    }

    /// Facets of a roughness.
    #[inline]
    pub(super) fn microfacet(&self, r: &RoughnessDesc, masking: Masking) -> Microfacet {
        let alpha = |id| {
            let v = self.float(id).max(0.0);
            if r.remap { v.sqrt() } else { v }
        };
        let (u, v) = (alpha(r.alpha_u), alpha(r.alpha_v));
        if u == 0.0 && v == 0.0 {
            return Microfacet::smooth();
        }
        Microfacet::new(r.distribution, u, v).with_masking(masking)
    }

    /// A coat.
    pub(super) fn coat(&mut self, c: &CoatDesc, masking: Masking) -> bsdf::Coat {
        bsdf::Coat {
            ior: self.ior(&c.ior),
            surface: self.microfacet(&c.roughness, masking),
            thickness: self.float(c.thickness).max(0.0),
            albedo: self.spectrum(c.albedo),
            g: self.float(c.g).clamp(-0.999, 0.999),
            max_depth: c.max_depth,
            samples: c.samples,
            salt: place_hash(self.surface.p),
        }
    }

    /// Disney's model.
    pub(super) fn principled(&self, d: &PrincipledDesc) -> Model<'static> {
        let base_color = self.spectrum(d.base_color);
        let base_luminance = base_color.luminance(self.lambda);
        let unit = |id| self.float(id).clamp(0.0, 1.0);
        if d.thin {
            return Model::PrincipledThin(PrincipledThin::new(PrincipledThinParameters {
                base_color,
                base_luminance,
                roughness: unit(d.roughness),
                anisotropic: unit(d.anisotropic),
                spec_trans: unit(d.spec_trans),
                diff_trans: self.float(d.diff_trans).clamp(0.0, 2.0),
                eta: d.eta,
                spec_tint: unit(d.spec_tint),
                sheen: unit(d.sheen),
                sheen_tint: unit(d.sheen_tint),
                flatness: unit(d.flatness),
            }));
        }
        Model::Principled(Principled::new(PrincipledParameters {
            base_color,
            base_luminance,
            roughness: unit(d.roughness),
            anisotropic: unit(d.anisotropic),
            metallic: unit(d.metallic),
            spec_trans: unit(d.spec_trans),
            eta: d.eta,
            spec_tint: unit(d.spec_tint),
            sheen: unit(d.sheen),
            sheen_tint: unit(d.sheen_tint),
            flatness: unit(d.flatness),
            clearcoat: unit(d.clearcoat),
            clearcoat_gloss: unit(d.clearcoat_gloss),
        }))
    }

    /// An element of a filter.
    pub(super) fn filter(&self, element: &FilterModel) -> FilterElement {
        match *element {
            FilterModel::Linear { theta } => {
                FilterElement::Linear { theta: self.float(theta).to_radians() }
            }
            FilterModel::Retarder { theta, delta } => FilterElement::Retarder {
                theta: self.float(theta).to_radians(),
                delta: self.spectrum(delta).map(f32::to_radians),
            },
            FilterModel::Circular { left_handed } => FilterElement::Circular { left_handed },
            FilterModel::Grey => FilterElement::Grey,
        }
    }

    /// What a conductor reflects.
    #[inline]
    pub(super) fn conductor(&self, color: &ConductorColor) -> ConductorFresnel {
        match color {
            ConductorColor::EtaK { eta, k } => {
                ConductorFresnel::EtaK { eta: self.spectrum(*eta), k: self.spectrum(*k) }
            }
            ConductorColor::Reflectance(r) => ConductorFresnel::from_reflectance(self.spectrum(*r)),
            ConductorColor::Mirror => ConductorFresnel::Mirror,
        }
    }
}

/// A number that tells points apart.
fn place_hash(p: Vec3) -> u64 {
    let bits = |v: f32| v.to_bits() as u64;
    mix_bits(bits(p.x) ^ mix_bits(bits(p.y) ^ mix_bits(bits(p.z))))
}
