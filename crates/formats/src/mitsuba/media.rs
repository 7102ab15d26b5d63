//! Media; the volumes that describe them are read in [`super::volumes`].

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId};
use super::textures::Role;
use super::volumes::of_box;
use crate::presets::{preset, preset_names};
use kaustika_math::{Bounds3, Transform, Vec3};
use kaustika_scene::description::{CoefficientsDesc, FieldDesc, MediumDesc, MediumId, PhaseDesc};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

const KNOWN: &[&str] = &["homogeneous", "heterogeneous"];

impl<'a> Converter<'a> {
    /// A medium, by whichever role.
    pub(super) fn medium(&mut self, id: ObjectId) -> MediumId {
        if let Some(known) = self.media.get(&id) {
            return *known;
        }
        let object = self.object(id);
        object.ignore(&[
            "has_spectral_extinction",
            "sample_emitters",
            "majorant_resolution_factor",
            "majorant_factor",
            "method",
            "strategy",
            "monochromatic",
            "step_size",
        ]);
        let (coefficients, extent) = match object.plugin.as_str() {
            "homogeneous" => (self.homogeneous(object), None),
            "heterogeneous" => self.heterogeneous(object),
            _ => {
                self.unknown_plugin(object, KNOWN);
                self.replaced_silently(object);
                (clear(), None)
            }
        };
        let scale = self.number(object, "scale", 1.0);
        let phase = match self.child(object, Kind::Phase) {
            Some((_, phase)) => self.phase(phase),
            None => PhaseDesc::Isotropic,
        };
        self.finish(id);
        self.out.media.push(MediumDesc {
            name: object.id.clone(),
            kind: object.plugin.clone(),
            coefficients,
            scale,
            density: None,
            glow: None,
            phase,
            extent,
            span: Some(object.span),
        });
        let made = MediumId(self.out.media.len() as u32 - 1);
        self.media.insert(id, made);
        made
    }

    fn homogeneous(&mut self, object: &'a Object) -> CoefficientsDesc {
        if !old(object) {
            let sigma_t = self.volume(object, "sigma_t", 1.0, Role::Unbounded);
            let albedo = self.volume(object, "albedo", 0.75, Role::Reflectance);
            return CoefficientsDesc::ExtinctionAlbedo(sigma_t.desc, albedo.desc);
        }
        // 0.6: σₐ and σₛ, or σₜ and the albedo, or else a preset, by default skin.
        let (by_sigma, by_albedo) = (
            object.has("sigma_a") || object.has("sigma_s"),
            object.has("sigma_t") || object.has("albedo"),
        );
        if by_sigma && by_albedo {
            let message = "a medium has `sigmaA` and `sigmaS`, or `sigmaT` and `albedo`, not both";
            self.out.diagnostics.error(object.span, message);
        }
        if by_albedo {
            let sigma_t = self.volume(object, "sigma_t", 1.0, Role::Unbounded);
            let albedo = self.volume(object, "albedo", 0.75, Role::Reflectance);
            return CoefficientsDesc::ExtinctionAlbedo(sigma_t.desc, albedo.desc);
        }
        let material = self.string(object, "material");
        let mut found = preset(material.map_or("skin1", |(name, _)| name));
        if let (None, Some((name, span))) = (found, material) {
            let message = format!("no medium is called `{name}`");
            self.out.diagnostics.error(span, message).nearest(name, &preset_names());
        }
        if by_sigma && material.is_none() {
            found = None;
        }
        if let Some((s, a)) = found {
            let volume =
                |rgb| FieldDesc::Constant(SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb });
            return CoefficientsDesc::AbsorptionScattering(volume(a), volume(s));
        }
        let [a, s] = ["sigma_a", "sigma_s"].map(|n| self.volume(object, n, 0.0, Role::Unbounded));
        CoefficientsDesc::AbsorptionScattering(a.desc, s.desc)
    }

    /// The coefficients, and the box around the volume of the extinction, in which alone the
    /// medium is.
    fn heterogeneous(&mut self, object: &'a Object) -> (CoefficientsDesc, Option<Transform>) {
        // 0.6 calls it `density`.
        let name = if old(object) { "density" } else { "sigma_t" };
        if !object.has(name) && old(object) {
            let message = format!("medium `heterogeneous` needs `{name}`");
            self.out.diagnostics.error(object.span, message);
        }
        if let Some(p) = object.get("orientation") {
            let message = "oriented particles are not supported";
            self.out.diagnostics.warning(p.span, message).label("left out");
        }
        let sigma_t = self.volume(object, name, 1.0, Role::Unbounded);
        let albedo = self.volume(object, "albedo", 0.75, Role::Reflectance);
        let unit = Bounds3 { min: Vec3::ZERO, max: Vec3::splat(1.0) };
        let bounds = sigma_t.to_world.bounds(&unit);
        let extent = of_box(&bounds);
        if extent.is_none() {
            self.out.diagnostics.error(object.span, "the volume of the medium has no extent");
        }
        (CoefficientsDesc::ExtinctionAlbedo(sigma_t.desc, albedo.desc), extent)
    }
}

/// Neither absorbs nor scatters.
fn clear() -> CoefficientsDesc {
    let zero = FieldDesc::Constant(SpectrumDesc::Constant(0.0));
    CoefficientsDesc::AbsorptionScattering(zero.clone(), zero)
}
