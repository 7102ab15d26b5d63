//! Media, the volumes that describe them, and phase functions.

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId, Value};
use super::textures::Role;
use crate::presets::{preset, preset_names};
use crate::vol;
use kaustika_math::{Bounds3, Transform, Vec3};
use kaustika_scene::description::{
    CoefficientsDesc, FieldDesc, GridDesc, GridLayout, MediumDesc, MediumId, PhaseDesc, Span,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::sync::Arc;

const KNOWN: &[&str] = &["homogeneous", "heterogeneous"];
const VOLUMES: &[&str] = &["constvolume", "gridvolume"];

/// A volume and the unit cube it fills.
struct Volume {
    desc: FieldDesc,
    to_world: Transform,
}

fn constant(desc: SpectrumDesc) -> Volume {
    Volume { desc: FieldDesc::Constant(desc), to_world: Transform::IDENTITY }
}

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

    /// A volume parameter: a number, a colour, a spectrum or a volume.
    fn volume(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
        role: Role,
    ) -> Volume {
        let fallback = constant(SpectrumDesc::Constant(default));
        let Some(p) = object.get(name) else { return fallback };
        if let Some((desc, _)) = self.plain_value(object, p, role) {
            return constant(desc);
        }
        let Some(id) = self.target(p) else {
            // Dangling references were reported.
            if !matches!(p.value, Value::Reference(_)) {
                self.wrong_type(object, p, "a number, colour, spectrum or volume");
            }
            return fallback;
        };
        match self.object(id).kind {
            Kind::Volume => self.volume_object(id, role).unwrap_or(fallback),
            Kind::Texture => match self.spectrum_object(id, role) {
                Some((desc, _)) => constant(desc),
                None => {
                    self.wrong_type(object, p, "a spectrum or volume");
                    fallback
                }
            },
            _ => {
                self.wrong_type(object, p, "a number, colour, spectrum or volume");
                fallback
            }
        }
    }

    fn volume_object(&mut self, id: ObjectId, role: Role) -> Option<Volume> {
        let object = self.object(id);
        let made = match object.plugin.as_str() {
            "constvolume" => {
                let to_world = self.transform(object, "to_world");
                let value = object.get("value").and_then(|p| {
                    let plain = self.plain_value(object, p, role);
                    let spectrum = || {
                        let id = self.target(p)?;
                        self.spectrum_object(id, role)
                    };
                    plain.or_else(spectrum)
                });
                let (desc, _) = value.unwrap_or((SpectrumDesc::Constant(1.0), 1.0));
                Some(Volume { desc: FieldDesc::Constant(desc), to_world })
            }
            "gridvolume" => self.grid_volume(object),
            _ => {
                self.unknown_plugin(object, VOLUMES);
                self.replaced_silently(object);
                None
            }
        };
        self.finish(id);
        made
    }

    fn grid_volume(&mut self, object: &'a Object) -> Option<Volume> {
        let (grid, span) = self.grid(object)?;
        if grid.channels == 6 {
            let message = "samples of six channels are for the phase function `sggx`";
            self.out.diagnostics.error(span, message);
            return None;
        }
        let to_world = grid.to_world;
        Some(Volume { desc: FieldDesc::Grid(grid), to_world })
    }

    /// The samples of a `gridvolume`, and where their file was named.
    pub(super) fn grid(&mut self, object: &'a Object) -> Option<(Arc<GridDesc>, Span)> {
        object.ignore(&["raw", "accel", "max_value", "send_data"]);
        let filter =
            self.choice(object, "filter_type", &[("trilinear", true), ("nearest", false)], true);
        if !filter {
            let span = object.get("filter_type").map(|p| p.span);
            let message = "volumes are always interpolated trilinearly";
            self.out.diagnostics.warning(span, message);
        }
        let wraps = [("clamp", true), ("repeat", false), ("mirror", false)];
        if !self.choice(object, "wrap_mode", &wraps, true) {
            let span = object.get("wrap_mode").map(|p| p.span);
            self.out.diagnostics.warning(span, "volumes are not repeated").label("clamped");
        }
        let to_world = self.transform(object, "to_world");
        let by_file = self.boolean(object, "use_grid_bbox", old(object));
        // 0.6 lets the scene say which box it is.
        let given = ["min", "max"].map(|n| self.vector(object, n));
        let (path, span) = self.file(object, "filename")?;
        let file = match vol::read(&path, vol::Samples::Amounts) {
            Ok(file) => file,
            Err(cause) => {
                let message = format!("can't read the volume `{}`: {cause}", path.display());
                self.out.diagnostics.error(span, message);
                return None;
            }
        };
        let bounds = match given {
            [Some(a), Some(b)] => Bounds3::new(super::convert::vec3(a), super::convert::vec3(b)),
            _ => file.bounds,
        };
        let to_world = match by_file {
            true => match of_box(&bounds) {
                Some(place) => to_world * place,
                None => {
                    self.out.diagnostics.error(span, "the box of the volume has no extent");
                    return None;
                }
            },
            false => to_world,
        };
        let layout = if old(object) { GridLayout::Corners } else { GridLayout::CellsClamped };
        let grid = GridDesc {
            resolution: file.resolution,
            channels: file.channels,
            values: file.values,
            to_world,
            layout,
        };
        Some((Arc::new(grid), span))
    }
}

/// Neither absorbs nor scatters.
fn clear() -> CoefficientsDesc {
    let zero = FieldDesc::Constant(SpectrumDesc::Constant(0.0));
    CoefficientsDesc::AbsorptionScattering(zero.clone(), zero)
}

/// The unit cube to a box; `None` if it is flat.
fn of_box(b: &Bounds3) -> Option<Transform> {
    Some(Transform::translate(b.min) * Transform::scale(b.diagonal())?)
}
