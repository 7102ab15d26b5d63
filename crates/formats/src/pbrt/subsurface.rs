//! `subsurface`: a dielectric boundary around scattering matter that paths walk through.
//!
//! pbrt-v4 (materials.cpp, `SubsurfaceMaterial`) approximates that walk by the profile of a flat half
//! space (Habel, Christensen & Jarosz 2013, "Photon beam diffusion"). Parameters are as there, but
//! `reflectance` is turned into coefficients by [`half_space`](crate::half_space).

use super::build::Builder;
use super::entity::Entity;
use crate::half_space::albedo_for;
use crate::presets::{preset, preset_names};
use kaustika_scene::description::{
    CoatDesc, CoefficientsDesc, FieldDesc, IorDesc, MaterialModel, MediumDesc, MediumId, PhaseDesc,
    TextureNode,
};
use kaustika_spectra::{
    ColorMode, ColorSpace, CompiledSpectrum, SpectrumDesc, SpectrumRole, Wavelengths,
};

/// What matter is made of, per unit of length before `scale`.
struct Matter {
    sigma_a: SpectrumDesc,
    sigma_s: SpectrumDesc,
    /// Multiplies them.
    scale: f32,
    g: f32,
}

impl Builder {
    /// The boundary, and the medium that it encloses.
    pub(super) fn subsurface(
        &mut self,
        e: &mut Entity,
    ) -> (Option<MaterialModel>, Option<MediumId>) {
        let diag = &mut self.desc.diagnostics;
        let eta = e.params.float(diag, "eta", 1.33);
        let g = e.params.float(diag, "g", 0.0);
        let scale = e.params.float(diag, "scale", 1.0);
        if g.abs() >= 1.0 {
            let message = format!("`g` must lie between -1 and 1, found {g}");
            diag.error(e.params.place("g"), message);
        }
        let Some(matter) = self.matter(e, eta, if g.abs() < 1.0 { g } else { 0.0 }, scale) else {
            return (Some(self.painted(e, eta)), None);
        };
        let phase = match matter.g {
            0.0 => PhaseDesc::Isotropic,
            g => PhaseDesc::HenyeyGreenstein { g },
        };
        let [a, s] = [matter.sigma_a, matter.sigma_s].map(FieldDesc::Constant);
        let medium = MediumId(self.desc.media.len() as u32);
        self.desc.media.push(MediumDesc {
            name: String::new(),
            kind: "subsurface".into(),
            coefficients: CoefficientsDesc::AbsorptionScattering(a, s),
            scale: matter.scale,
            density: None,
            glow: None,
            phase,
            extent: None,
            span: Some(e.span),
        });
        let boundary = MaterialModel::Dielectric {
            ior: IorDesc::Constant(eta),
            specular_reflectance: self.constant(1.0),
            specular_transmittance: self.constant(1.0),
            roughness: self.roughness(e, ["uroughness", "vroughness", "roughness"]),
        };
        (Some(boundary), Some(medium))
    }

    /// What stands in for matter that varies over the surface.
    fn painted(&mut self, e: &mut Entity, eta: f32) -> MaterialModel {
        let reflectance = self.albedo(e, "reflectance", 0.8);
        let coat = CoatDesc {
            ior: IorDesc::Constant(eta),
            roughness: self.roughness(e, ["uroughness", "vroughness", "roughness"]),
            thickness: self.desc.float(0.01),
            albedo: self.constant(0.0),
            g: self.desc.float(0.0),
            max_depth: 10,
            samples: 1,
        };
        MaterialModel::CoatedDiffuse { reflectance, coat }
    }

    /// By name, by coefficients, by reflectance, or whole milk; `None`, and a warning, if it varies.
    fn matter(&mut self, e: &mut Entity, eta: f32, g: f32, scale: f32) -> Option<Matter> {
        let rgb = |rgb| SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb };
        if let Some(name) = e.params.string(&mut self.desc.diagnostics, "name") {
            if let Some((s, a)) = preset(&name.text) {
                // They are reduced coefficients, of isotropic scattering.
                return Some(Matter { sigma_a: rgb(a), sigma_s: rgb(s), scale, g: 0.0 });
            }
            let message = format!("no matter is called `{}`", name.text);
            let error = self.desc.diagnostics.error(name.span, message);
            error.nearest(&name.text, &preset_names());
        }
        let given = [self.inner_color(e, "sigma_a")?, self.inner_color(e, "sigma_s")?];
        match given {
            [Some(sigma_a), Some(sigma_s)] => return Some(Matter { sigma_a, sigma_s, scale, g }),
            [None, None] => {}
            _ => {
                let message = "`sigma_a` and `sigma_s` are needed together";
                self.desc.diagnostics.error(e.kind.span, message);
            }
        }
        let mfp = self.inner_color(e, "mfp")?.map_or([1.0; 3], |m| linear(&m));
        let reflectance = self.inner_color(e, "reflectance")?;
        let Some(reflectance) = reflectance else {
            let (sigma_s, sigma_a) = preset("Wholemilk").unwrap_or_default();
            return Some(Matter { sigma_a: rgb(sigma_a), sigma_s: rgb(sigma_s), scale, g });
        };
        let albedo = linear(&reflectance).map(|r| albedo_for(r, eta, g));
        // A mean free path of 0 is as short as it can be.
        let sigma_t = mfp.map(|m| 1.0 / m.max(1e-6));
        let a = rgb([0, 1, 2].map(|k| sigma_t[k] * (1.0 - albedo[k])));
        let s = rgb([0, 1, 2].map(|k| sigma_t[k] * albedo[k]));
        Some(Matter { sigma_a: a, sigma_s: s, scale: 1.0 / scale.max(1e-6), g })
    }

    /// A colour of the whole inside, if one is given; `None`, and a warning, if it varies over the
    /// surface.
    fn inner_color(&mut self, e: &mut Entity, name: &'static str) -> Option<Option<SpectrumDesc>> {
        let Some(id) = self.spectrum_texture_or_none(e, name) else { return Some(None) };
        if let TextureNode::Spectrum(desc) = &self.desc.textures[id.0 as usize].node {
            return Some(Some(desc.clone()));
        }
        let place = e.params.place(name);
        let message = format!("`{name}` varies over a `subsurface`, a coated diffuse is used");
        self.notes.warning(place, message);
        // The rest describes the inside.
        for p in &mut e.params.own {
            let inner = ["sigma_a", "sigma_s", "mfp", "reflectance", "scale", "g"];
            p.used |= inner.contains(&p.name.as_str());
        }
        None
    }
}

/// Linear sRGB.
fn linear(desc: &SpectrumDesc) -> [f32; 3] {
    let compiled = CompiledSpectrum::new(desc, SpectrumRole::Unbounded, ColorMode::Rgb);
    compiled.eval(&Wavelengths::rgb()).rgb()
}
