//! The metallic-roughness model of a material, and the older specular-glossiness one.

use super::json::{Fault, Json};
use super::materials::Maker;
use super::textures::Use;
use kaustika_scene::description::{
    AnisotropyDesc, ClearcoatDesc, DiffuseTransmissionDesc, IorDesc, IridescenceDesc,
    MetallicRoughnessDesc, SheenDesc, TextureId, TextureNode, VolumeDesc,
};
use kaustika_spectra::SpectrumDesc;

impl Maker<'_, '_, '_, '_> {
    /// A plain dielectric of this base colour, roughness 1.
    fn plain(&mut self, base_color: TextureId) -> MetallicRoughnessDesc {
        let white = self.reader.white();
        MetallicRoughnessDesc {
            base_color,
            metallic: self.reader.out.float(0.0),
            roughness: white,
            ior: IorDesc::Constant(1.5),
            specular: white,
            specular_color: white,
            anisotropy: None,
            sheen: None,
            clearcoat: None,
            transmission: None,
            diffuse_transmission: None,
            volume: None,
            iridescence: None,
        }
    }

    /// The older model: a reflectance at normal incidence, which metallic-roughness has with
    /// index 0 and a tint (README of KHR_materials_ior).
    pub(super) fn specular_glossiness(
        &mut self,
        old: &Json,
        base_color: TextureId,
    ) -> Result<MetallicRoughnessDesc, Fault> {
        const MAP: &str = "specularGlossinessTexture";
        let specular_color = self.color(old, ("specularFactor", [1.0; 3]), MAP)?;
        let amount = self.scalar(old, ("glossinessFactor", 1.0), (MAP, Use::Alpha))?;
        let (a, b) = (self.reader.white(), self.reader.out.float(0.0));
        let roughness = self.node(TextureNode::Mix { a, b, amount });
        let ior = IorDesc::Constant(0.0);
        Ok(MetallicRoughnessDesc { specular_color, roughness, ior, ..self.plain(base_color) })
    }

    pub(super) fn metallic_roughness(
        &mut self,
        json: &Json,
        section: &Json,
        base_color: TextureId,
    ) -> Result<MetallicRoughnessDesc, Fault> {
        const MAP: &str = "metallicRoughnessTexture";
        let mut desc = self.plain(base_color);
        desc.metallic = self.scalar(section, ("metallicFactor", 1.0), (MAP, Use::Channel(2)))?;
        desc.roughness = self.scalar(section, ("roughnessFactor", 1.0), (MAP, Use::Channel(1)))?;
        desc.ior = self.ior(json)?;
        if let Some(e) = json.extension("KHR_materials_specular") {
            let (factor, map) = (("specularFactor", 1.0), ("specularTexture", Use::Alpha));
            desc.specular = self.scalar(&e, factor, map)?;
            let factor = ("specularColorFactor", [1.0; 3]);
            desc.specular_color = self.color(&e, factor, "specularColorTexture")?;
        }
        if let Some(e) = json.extension("KHR_materials_anisotropy") {
            desc.anisotropy = Some(AnisotropyDesc {
                strength: self.reader.out.float(e.float("anisotropyStrength", 0.0)?),
                rotation: e.float("anisotropyRotation", 0.0)?,
                direction: self.texture(&e, "anisotropyTexture", Use::Raw),
            });
        }
        if let Some(e) = json.extension("KHR_materials_sheen") {
            let color = self.color(&e, ("sheenColorFactor", [0.0; 3]), "sheenColorTexture")?;
            let map = ("sheenRoughnessTexture", Use::Alpha);
            let roughness = self.scalar(&e, ("sheenRoughnessFactor", 0.0), map)?;
            desc.sheen = Some(SheenDesc { color, roughness });
        }
        if let Some(e) = json.extension("KHR_materials_clearcoat") {
            let map = ("clearcoatTexture", Use::Channel(0));
            let factor = self.scalar(&e, ("clearcoatFactor", 0.0), map)?;
            let map = ("clearcoatRoughnessTexture", Use::Channel(1));
            let roughness = self.scalar(&e, ("clearcoatRoughnessFactor", 0.0), map)?;
            let normals = self.normals(&e, "clearcoatNormalTexture")?;
            desc.clearcoat = Some(ClearcoatDesc { factor, roughness, normals });
        }
        if let Some(e) = json.extension("KHR_materials_iridescence") {
            let map = ("iridescenceTexture", Use::Channel(0));
            let factor = self.scalar(&e, ("iridescenceFactor", 0.0), map)?;
            let ior = e.float("iridescenceIor", 1.3)?.max(1.0);
            let least = e.float("iridescenceThicknessMinimum", 100.0)?;
            let most = e.float("iridescenceThicknessMaximum", 400.0)?;
            let most = self.reader.out.float(most);
            let map = self.texture(&e, "iridescenceThicknessTexture", Use::Channel(1));
            let thickness = match map {
                Some(amount) => {
                    let a = self.reader.out.float(least);
                    self.node(TextureNode::Mix { a, b: most, amount })
                }
                None => most,
            };
            desc.iridescence = Some(IridescenceDesc { factor, ior, thickness });
        }
        self.through(json, &mut desc)?;
        Ok(desc)
    }

    /// What goes through the surface.
    fn through(&mut self, json: &Json, desc: &mut MetallicRoughnessDesc) -> Result<(), Fault> {
        if let Some(e) = json.extension("KHR_materials_transmission") {
            let factor = e.float("transmissionFactor", 0.0)?;
            if factor > 0.0 {
                let map = ("transmissionTexture", Use::Channel(0));
                desc.transmission = Some(self.scalar(&e, ("transmissionFactor", 0.0), map)?);
            }
        }
        if let Some(e) = json.extension("KHR_materials_diffuse_transmission")
            && e.float("diffuseTransmissionFactor", 0.0)? > 0.0
        {
            let map = ("diffuseTransmissionTexture", Use::Alpha);
            let factor = self.scalar(&e, ("diffuseTransmissionFactor", 0.0), map)?;
            let color = ("diffuseTransmissionColorFactor", [1.0; 3]);
            let color = self.color(&e, color, "diffuseTransmissionColorTexture")?;
            desc.diffuse_transmission = Some(DiffuseTransmissionDesc { factor, color });
        }
        if let Some(e) = json.extension("KHR_materials_volume")
            && e.float("thicknessFactor", 0.0)? > 0.0
        {
            let color = e.floats("attenuationColor", [1.0; 3])?;
            let distance = e.float("attenuationDistance", f32::INFINITY)?;
            if distance <= 0.0 {
                return Err(e.require("attenuationDistance")?.fault("expected a number above 0"));
            }
            desc.volume = Some(VolumeDesc {
                attenuation_color: self.rgb(color),
                attenuation_distance: distance,
            });
        }
        Ok(())
    }

    /// KHR_materials_ior and KHR_materials_dispersion: Cauchy's equation by Abbe's number,
    /// n(λ) = max(n_d + (n_d-1)/V (523655/λ² - 1.5168), 1), V = 20/dispersion.
    fn ior(&mut self, json: &Json) -> Result<IorDesc, Fault> {
        let nd = match json.extension("KHR_materials_ior") {
            Some(e) => e.float("ior", 1.5)?,
            None => 1.5,
        };
        if nd != 0.0 && nd < 1.0 {
            let e = json.extension("KHR_materials_ior").unwrap_or(json.clone());
            return Err(e.fault(format!("expected an index from 1, or 0, found {nd}")));
        }
        let dispersion = match json.extension("KHR_materials_dispersion") {
            Some(e) => e.float("dispersion", 0.0)?,
            None => 0.0,
        };
        if dispersion <= 0.0 || nd <= 1.0 {
            return Ok(IorDesc::Constant(nd));
        }
        let lambda: Vec<f32> = (0..=48).map(|i| 350.0 + 10.0 * i as f32).collect();
        let at = |l: &f32| {
            (nd + (nd - 1.0) * dispersion / 20.0 * (523_655.0 / (l * l) - 1.5168)).max(1.0)
        };
        let values: Vec<f32> = lambda.iter().map(at).collect();
        let span = self.reader.span(json);
        self.reader
            .out
            .diagnostics
            .note(span, "dispersion shows in spectral renders (`--mode spectral`)");
        Ok(match SpectrumDesc::sampled(&lambda, &values) {
            Ok(spectrum) => IorDesc::Spectrum(self.node(TextureNode::Spectrum(spectrum))),
            Err(_) => IorDesc::Constant(nd),
        })
    }
}
