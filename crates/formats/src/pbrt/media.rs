//! `MakeNamedMedium` (pbrt-v4, media.cpp).

use super::build::Builder;
use super::entity::{Entity, MediumEntity};
use super::param::Text;
use super::spectrum::unit_luminance;
use crate::presets::{preset, preset_names};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    CloudDesc, CoefficientsDesc, DensityDesc, FieldDesc, GlowDesc, GlowSource, GridDesc,
    GridFilter, GridLayout, MediumDesc, PhaseDesc,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::sync::Arc;

const KINDS: [&str; 5] = ["homogeneous", "uniformgrid", "rgbgrid", "cloud", "nanovdb"];

/// The coefficients, the density, the box and the emission of a medium.
pub(super) struct Parts {
    pub(super) coefficients: CoefficientsDesc,
    pub(super) density: Option<DensityDesc>,
    pub(super) extent: Option<Transform>,
    pub(super) glow: Option<GlowDesc>,
}

impl Builder {
    /// All media.
    pub fn media(&mut self) {
        for mut m in std::mem::take(&mut self.scene.media) {
            let desc = self.medium_of(&mut m);
            self.desc.media.push(desc);
        }
    }

    fn medium_of(&mut self, m: &mut MediumEntity) -> MediumDesc {
        let e = &mut m.entity;
        let kind = e.params.string(&mut self.desc.diagnostics, "type");
        let parts = self.parts(&m.name, kind.as_ref(), e, &m.transform);
        let kind = kind.map_or(String::new(), |k| k.text);
        let diag = &mut self.desc.diagnostics;
        let mut phase = PhaseDesc::Isotropic;
        let mut scale = 1.0;
        match &parts {
            Some(_) => {
                scale = e.params.float(diag, "scale", 1.0);
                let g = e.params.float(diag, "g", 0.0);
                if g.abs() >= 1.0 {
                    diag.error(
                        e.params.place("g"),
                        format!("`g` must lie between -1 and 1, found {g}"),
                    );
                } else if g != 0.0 {
                    phase = PhaseDesc::HenyeyGreenstein { g };
                }
                e.params.report_unused(diag, &format!("medium `{}`", m.name.text));
            }
            None => e.params.ignore_rest(),
        }
        let clear = FieldDesc::Constant(SpectrumDesc::Constant(0.0));
        let parts = parts.unwrap_or(Parts {
            coefficients: CoefficientsDesc::AbsorptionScattering(clear.clone(), clear),
            density: None,
            extent: None,
            glow: None,
        });
        MediumDesc {
            name: m.name.text.clone(),
            kind,
            coefficients: parts.coefficients,
            scale,
            density: parts.density,
            glow: parts.glow,
            phase,
            extent: parts.extent,
            span: Some(e.span),
        }
    }

    /// `None` for a medium that is left empty, which is reported.
    fn parts(
        &mut self,
        name: &Text,
        kind: Option<&Text>,
        e: &mut Entity,
        to_world: &Transform,
    ) -> Option<Parts> {
        let Some(kind) = kind else {
            let message = format!("medium `{}` has no type", name.text);
            let error = self.desc.diagnostics.error(name.span, message);
            error.hint("add \"string type\" \"homogeneous\"");
            return None;
        };
        match kind.text.as_str() {
            "homogeneous" => {
                let coefficients = self.coefficients(e);
                Some(Parts { coefficients, density: None, extent: None, glow: self.glow(e, true) })
            }
            // pbrt-v3 called it so.
            "uniformgrid" | "heterogeneous" => self.uniform_grid(e, to_world),
            "rgbgrid" => self.rgb_grid(e, to_world),
            "cloud" => self.cloud(e, to_world),
            "nanovdb" => self.nanovdb(e, to_world),
            _ => {
                let message = format!("unknown medium type `{}`", kind.text);
                self.desc.diagnostics.error(kind.span, message).nearest(&kind.text, &KINDS);
                None
            }
        }
    }

    /// `preset`, or else `sigma_a` and `sigma_s`, each 1 if it is not given.
    pub(super) fn coefficients(&mut self, e: &mut Entity) -> CoefficientsDesc {
        let mut found = None;
        if let Some(name) = e.params.string(&mut self.desc.diagnostics, "preset") {
            found = preset(&name.text);
            if found.is_none() {
                let message = format!("no medium preset is called `{}`", name.text);
                let warning = self.desc.diagnostics.warning(name.span, message);
                warning.nearest(&name.text, &preset_names());
            }
        }
        let given = [self.spectrum(e, "sigma_a"), self.spectrum(e, "sigma_s")];
        let [sigma_a, sigma_s] = match found {
            Some((s, a)) => [a, s].map(|rgb| SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb }),
            None => given.map(|s| s.unwrap_or(SpectrumDesc::Constant(1.0))),
        };
        let [a, s] = [sigma_a, sigma_s].map(FieldDesc::Constant);
        CoefficientsDesc::AbsorptionScattering(a, s)
    }

    /// `Le`, with `Lescale` if that is one number.
    fn glow(&mut self, e: &mut Entity, one_scale: bool) -> Option<GlowDesc> {
        let le = self.spectrum(e, "Le");
        let mut scale = match one_scale {
            true => e.params.float(&mut self.desc.diagnostics, "Lescale", 1.0),
            false => 1.0,
        };
        let le = le?;
        scale *= unit_luminance(&le);
        let source = GlowSource::Radiance(FieldDesc::Constant(le));
        Some(GlowDesc { source, scale, grid: None })
    }

    /// The box from `p0` to `p1`.
    fn extent(&mut self, e: &mut Entity, to_world: &Transform) -> Option<Transform> {
        let diag = &mut self.desc.diagnostics;
        let p0 = e.params.point3(diag, "p0", Vec3::ZERO);
        let p1 = e.params.point3(diag, "p1", Vec3::splat(1.0));
        let (low, high) = (p0.min(p1), p0.max(p1));
        let Some(size) = Transform::scale(high - low) else {
            diag.error(e.params.place("p0"), "the box from `p0` to `p1` has no extent");
            return None;
        };
        Some(*to_world * Transform::translate(low) * size)
    }

    fn resolution(&mut self, e: &mut Entity) -> Option<[u32; 3]> {
        let diag = &mut self.desc.diagnostics;
        let mut n = [1; 3];
        for (n, name) in n.iter_mut().zip(["nx", "ny", "nz"]) {
            let given = e.params.int(diag, name, 1);
            if given < 1 {
                diag.error(
                    e.params.place(name),
                    format!("`{name}` must be at least 1, found {given}"),
                );
                return None;
            }
            *n = given as u32;
        }
        Some(n)
    }

    /// The grid of a parameter's values, which must be as many as the resolution says.
    fn grid(
        &mut self,
        e: &Entity,
        name: &'static str,
        (values, channels): (Vec<f32>, u32),
        resolution: [u32; 3],
        extent: &Transform,
    ) -> Option<Arc<GridDesc>> {
        let expected: u64 = resolution.iter().map(|n| u64::from(*n)).fold(1, u64::saturating_mul);
        let found = values.len() as u64 / u64::from(channels);
        if expected != found {
            let message = format!("`{name}` needs nx · ny · nz = {expected} values, {found} given");
            self.desc.diagnostics.error(e.params.place(name), message);
            return None;
        }
        if name != "temperature" && values.iter().any(|v| *v < 0.0) {
            let message = format!("`{name}` has a value below 0");
            self.desc.diagnostics.error(e.params.place(name), message);
            return None;
        }
        let layout = GridLayout::CellsFading;
        Some(Arc::new(GridDesc {
            resolution,
            channels,
            values,
            to_world: *extent,
            layout,
            filter: GridFilter::Trilinear,
        }))
    }

    fn uniform_grid(&mut self, e: &mut Entity, to_world: &Transform) -> Option<Parts> {
        let coefficients = self.coefficients(e);
        let extent = self.extent(e, to_world)?;
        let resolution = self.resolution(e)?;
        let Some(density) = e.params.floats(&mut self.desc.diagnostics, "density") else {
            if !e.params.has("density") {
                let message = "medium `uniformgrid` needs `density`";
                self.desc.diagnostics.error(e.span, message);
            }
            return None;
        };
        let density = self.grid(e, "density", (density, 1), resolution, &extent)?;
        let mut glow = self.glow(e, false);
        let diag = &mut self.desc.diagnostics;
        let temperature = e.params.floats(diag, "temperature");
        let cutoff = e.params.float(diag, "temperaturecutoff", 0.0);
        let offset = e.params.float(diag, "temperatureoffset", cutoff);
        let factor = e.params.float(diag, "temperaturescale", 1.0);
        let scales = e.params.floats(diag, "Lescale");
        if let Some(values) = temperature {
            if glow.is_some() {
                let message = "a medium glows by `Le` or by `temperature`, not both";
                self.desc.diagnostics.error(e.params.place("temperature"), message);
            }
            let grid = self.grid(e, "temperature", (values, 1), resolution, &extent)?;
            let source = GlowSource::Temperature { grid, offset, factor };
            glow = Some(GlowDesc { source, scale: 1.0, grid: None });
        }
        if let (Some(values), Some(glow)) = (scales, &mut glow) {
            // One number stands for all.
            match values.as_slice() {
                [one] => glow.scale *= one,
                _ => {
                    glow.grid = Some(self.grid(e, "Lescale", (values, 1), resolution, &extent)?);
                }
            }
        }
        let density = Some(DensityDesc::Grid(density));
        Some(Parts { coefficients, density, extent: Some(extent), glow })
    }

    /// `cloud`
    fn cloud(&mut self, e: &mut Entity, to_world: &Transform) -> Option<Parts> {
        let coefficients = self.coefficients(e);
        let extent = Some(self.extent(e, to_world)?);
        let diag = &mut self.desc.diagnostics;
        let density = Some(DensityDesc::Cloud(CloudDesc {
            density: e.params.float(diag, "density", 1.0),
            wispiness: e.params.float(diag, "wispiness", 1.0),
            frequency: e.params.float(diag, "frequency", 5.0),
            to_world: *to_world,
        }));
        Some(Parts { coefficients, density, extent, glow: None })
    }

    fn rgb_grid(&mut self, e: &mut Entity, to_world: &Transform) -> Option<Parts> {
        let extent = self.extent(e, to_world)?;
        let resolution = self.resolution(e)?;
        let mut volumes = [None, None, None];
        for (volume, name) in volumes.iter_mut().zip(["sigma_a", "sigma_s", "Le"]) {
            if let Some(values) = e.params.colors(&mut self.desc.diagnostics, name) {
                let grid = self.grid(e, name, (values, 3), resolution, &extent)?;
                *volume = Some(FieldDesc::Grid(grid));
            }
        }
        let [sigma_a, sigma_s, le] = volumes;
        if sigma_a.is_none() && sigma_s.is_none() {
            let message = "medium `rgbgrid` needs `sigma_a` or `sigma_s`";
            self.desc.diagnostics.error(e.span, message);
            return None;
        }
        let scale = e.params.float(&mut self.desc.diagnostics, "Lescale", 1.0);
        let one = FieldDesc::Constant(SpectrumDesc::Constant(1.0));
        let glow = le.map(|le| GlowDesc { source: GlowSource::Radiance(le), scale, grid: None });
        let [a, s] = [sigma_a, sigma_s].map(|v| v.unwrap_or(one.clone()));
        let coefficients = CoefficientsDesc::AbsorptionScattering(a, s);
        Some(Parts { coefficients, density: None, extent: Some(extent), glow })
    }
}
