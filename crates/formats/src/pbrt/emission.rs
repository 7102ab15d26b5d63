//! `AreaLightSource` (pbrt-v4, lights.cpp): light that shapes emit.

use super::build::Builder;
use super::entity::Entity;
use super::images;
use super::spectrum::unit_luminance;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, DisplacedMesh, EmissionDesc, GeometryDesc,
    TextureMapping, TextureNode, Wrap,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::f32::consts::PI;

impl Builder {
    /// What an `AreaLightSource` makes a shape emit.
    pub fn emission_of(&mut self, light: usize) -> Option<EmissionDesc> {
        if let Some(known) = &self.emissions[light] {
            return known.clone();
        }
        let mut e = std::mem::take(&mut self.scene.area_lights[light]);
        let emission = self.area_light(&mut e);
        if emission.is_some() {
            let what = format!("area light `{}`", e.kind.text);
            e.params.report_unused(&mut self.desc.diagnostics, &what);
        }
        self.emissions[light] = Some(emission.clone());
        emission
    }

    fn area_light(&mut self, e: &mut Entity) -> Option<EmissionDesc> {
        if e.kind.text != "diffuse" {
            let message = format!("unknown area light `{}`", e.kind.text);
            let error = self.desc.diagnostics.error(e.kind.span, message);
            error.nearest(&e.kind.text, &["diffuse"]);
            return None;
        }
        let spectrum = self.spectrum(e, "L");
        let diag = &mut self.desc.diagnostics;
        let mut scale = e.params.float(diag, "scale", 1.0);
        let two_sided = e.params.boolean(diag, "twosided", false);
        let power = e.params.float_or_none(diag, "power").filter(|p| *p > 0.0);
        let filename = e.params.string(diag, "filename");
        let mut mean = 1.0;
        let node = if let Some(name) = filename {
            if spectrum.is_some() {
                let message = "an area light has `L` or `filename`, not both";
                self.desc.diagnostics.error(e.params.place("L"), message);
                return None;
            }
            let bitmap = self.light_image(&name)?;
            if power.is_some() {
                mean = images::mean(&bitmap, |x, y| images::luminance(&bitmap, x, y));
            }
            TextureNode::Bitmap(BitmapTexture {
                bitmap,
                channels: BitmapChannels::Color,
                filter: BitmapFilter::Bilinear,
                wrap: [Wrap::Clamp; 2],
                mapping: TextureMapping::default(),
                scale: 1.0,
                invert: false,
                raw: false,
                space: ColorSpace::Srgb,
            })
        } else {
            let white = SpectrumDesc::Rgb { rgb: [1.0; 3], space: e.params.space };
            let spectrum = spectrum.unwrap_or(white);
            scale *= unit_luminance(&spectrum);
            TextureNode::Spectrum(spectrum)
        };
        let radiance = self.desc.add_texture(node, Some(e.params.place("L")));
        // Divided by the area and the sides once the meshes are there.
        let power = power.map(|p| if mean > 0.0 { p / mean } else { 0.0 });
        Some(EmissionDesc {
            radiance,
            scale,
            power,
            two_sided,
            along_normal: false,
            span: Some(e.span),
        })
    }

    /// Turns `power` into a factor of `scale`: radiance = power / (area π sides). pbrt's lights
    /// are single triangles or patches, each of which emits `power`; where their areas differ we
    /// give all the same radiance.
    pub fn powers(&mut self) {
        for s in self.desc.shapes.iter_mut() {
            let Some(emission) = &mut s.emission else { continue };
            let Some(power) = emission.power.take() else { continue };
            let (area, count, equal) = area(&s.geometry, &s.transform);
            let sides = if emission.two_sided { 2.0 } else { 1.0 };
            emission.scale *= power * count as f32 / (area * PI * sides);
            if !emission.scale.is_finite() {
                emission.scale = 0.0;
            }
            if !equal {
                let message = "pbrt gives `power` to each triangle; all shine equally here";
                self.notes.warning(emission.span.unwrap_or_default(), message);
            }
        }
    }
}

/// Area as pbrt finds it (quadrics: in object space; displaced meshes: before), the number of pbrt's shapes, and whether
/// they are all of the same area.
fn area(geometry: &GeometryDesc, t: &Transform) -> (f32, usize, bool) {
    match geometry {
        GeometryDesc::Mesh(m) | GeometryDesc::Displaced(DisplacedMesh { mesh: m, .. }) => {
            let corner = |i: u32| t.point(m.positions[i as usize]);
            sum(m.indices.iter().map(|&[a, b, c]| {
                let (a, b, c) = (corner(a), corner(b), corner(c));
                0.5 * (b - a).cross(c - a).length()
            }))
        }
        GeometryDesc::BilinearPatches { positions, indices, .. } => {
            let corner = |i: u32| t.point(positions[i as usize]);
            sum(indices.iter().map(|&[a, b, c, d]| patch_area([a, b, c, d].map(corner))))
        }
        GeometryDesc::Sphere { radius, z_min, z_max, phi_max } => {
            (phi_max.to_radians() * radius * (z_max - z_min), 1, true)
        }
        GeometryDesc::Disk { radius, inner_radius, phi_max, .. } => {
            let rings = radius * radius - inner_radius * inner_radius;
            (phi_max.to_radians() * 0.5 * rings, 1, true)
        }
        GeometryDesc::Cylinder { radius, z_min, z_max, phi_max } => {
            ((z_max - z_min) * radius * phi_max.to_radians(), 1, true)
        }
        // They do not shine.
        GeometryDesc::Curves(_) => (0.0, 0, true),
        // pbrt has none.
        GeometryDesc::Ellipsoids(_) | GeometryDesc::SdfGrid(_) => (0.0, 0, true),
        GeometryDesc::Rectangle => (4.0, 1, true),
        GeometryDesc::Cube => (24.0, 1, true),
    }
}

fn sum(areas: impl Iterator<Item = f32> + Clone) -> (f32, usize, bool) {
    let (min, max) = areas.clone().fold((f32::INFINITY, 0f32), |(l, h), a| (l.min(a), h.max(a)));
    let total: f64 = areas.clone().map(|a| a as f64).sum();
    (total as f32, areas.count(), max - min <= 1e-3 * max)
}

/// Area of a bilinear patch with corners p00, p10, p01, p11, by small quadrilaterals.
fn patch_area([p00, p10, p01, p11]: [Vec3; 4]) -> f32 {
    const N: usize = 8;
    let p = |i: usize, j: usize| {
        let (u, v) = (i as f32 / N as f32, j as f32 / N as f32);
        p00.lerp(p10, u).lerp(p01.lerp(p11, u), v)
    };
    let cells = (0..N).flat_map(|i| (0..N).map(move |j| (i, j)));
    let areas = cells.map(|(i, j)| {
        let diagonals = (p(i + 1, j + 1) - p(i, j)).cross(p(i, j + 1) - p(i + 1, j));
        0.5 * diagonals.length()
    });
    areas.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_scene::description::TriMesh;
    use std::sync::Arc;

    #[test]
    fn areas_are_those_of_pbrt() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0, Vec3::new(2.0, 3.0, 0.0)];
        assert!((patch_area(corners) - 6.0).abs() < 1e-4);
        let double = Transform::scale(Vec3::splat(2.0)).unwrap();
        let ball = GeometryDesc::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
        assert!((area(&ball, &double).0 - 4.0 * PI).abs() < 1e-4);
        let mesh = TriMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            indices: vec![[0, 1, 2], [0, 2, 3]],
            ..TriMesh::default()
        };
        assert_eq!(area(&GeometryDesc::Mesh(Arc::new(mesh)), &double), (4.0, 2, true));
    }
}
