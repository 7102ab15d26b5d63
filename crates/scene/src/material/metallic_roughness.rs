//! glTF's material at a hit.

use super::{Hit, Place, normal_mapped};
use crate::bsdf::{Boundary, Clearcoat, Film, MetallicRoughness, MetallicRoughnessParameters};
use crate::description::{AnisotropyDesc, MetallicRoughnessDesc, VolumeDesc};
use kaustika_math::{Frame, Vec3, lerp, sqr};
use kaustika_spectra::Spectrum;

impl Hit<'_, '_> {
    /// The model, and the place with the frame it stands in.
    pub(super) fn metallic_roughness(
        &mut self,
        desc: &MetallicRoughnessDesc,
        place: Place,
    ) -> (Place, MetallicRoughness) {
        let ior = self.ior(&desc.ior);
        let unit = |id| self.float(id).clamp(0.0, 1.0);
        let alpha = sqr(unit(desc.roughness));
        let mut parameters = MetallicRoughnessParameters {
            base_color: self.spectrum(desc.base_color),
            metallic: unit(desc.metallic),
            alpha: (alpha, alpha),
            ior,
            specular: unit(desc.specular),
            specular_color: self.spectrum(desc.specular_color),
            boundary: Boundary::Opaque,
            ..MetallicRoughnessParameters::default()
        };
        let mut frame = place.frame;
        if let Some(a) = &desc.anisotropy {
            let (strength, turned) = self.anisotropy(a, frame);
            parameters.alpha = (lerp(sqr(strength), alpha, 1.0), alpha);
            frame = turned;
        }
        parameters.sheen = desc.sheen.as_ref().map(|s| (self.spectrum(s.color), unit(s.roughness)));
        if let Some(c) = &desc.clearcoat {
            let unturned = place.guard.unwrap_or(place.frame.n);
            let normal = match c.normals {
                Some((normals, space)) => {
                    let tangent = self.geometry.tangents(self.surface).0;
                    let base = Frame::from_normal_tangent(unturned, tangent);
                    normal_mapped(self, base, normals, space).n
                }
                None => unturned,
            };
            let mut normal = frame.to_local(normal);
            // The part's frame is turned about its first tangent.
            if place.back {
                normal = Vec3::new(-normal.x, normal.y, normal.z);
            }
            parameters.clearcoat = Some(Clearcoat::new(unit(c.factor), unit(c.roughness), normal));
        }
        if let Some(film) = &desc.iridescence {
            let thickness = self.float(film.thickness).max(0.0);
            parameters.film = Some(Film::new(unit(film.factor), film.ior, thickness, self.lambda));
        }
        if let Some(d) = &desc.diffuse_transmission {
            parameters.diffuse_transmission = (unit(d.factor), self.spectrum(d.color));
            parameters.boundary = Boundary::Sheet;
        }
        if let Some(t) = desc.transmission {
            parameters.transmission = unit(t);
            parameters.boundary = Boundary::Sheet;
        }
        if let (Some(volume), true) = (&desc.volume, parameters.boundary == Boundary::Sheet) {
            parameters.boundary = Boundary::Solid;
            if self.surface.ng.dot(self.wo) < 0.0 {
                parameters.interior = self.interior(volume);
            }
        }
        (Place { frame, ..place }, MetallicRoughness::new(parameters))
    }

    /// Strength, and the frame whose first tangent is the direction of greater roughness.
    fn anisotropy(&self, a: &AnisotropyDesc, frame: Frame) -> (f32, Frame) {
        let (mut strength, mut direction) = (self.float(a.strength), (1.0, 0.0));
        if let Some(id) = a.direction {
            let [x, y, z] = self.textures.raw_rgb(id, self.at());
            direction = (2.0 * x - 1.0, 2.0 * y - 1.0);
            strength *= z;
        }
        let (dpdu, dpdv) = self.geometry.tangents(self.surface);
        let side = if frame.n.dot(dpdu.cross(dpdv)) < 0.0 { -1.0 } else { 1.0 };
        let (sin, cos) = a.rotation.sin_cos();
        let (x, y) = direction;
        let tangent = Vec3::new(cos * x - sin * y, side * (sin * x + cos * y), 0.0);
        let tangent = frame.to_world(tangent);
        (strength.clamp(0.0, 1.0), Frame::from_normal_tangent(frame.n, tangent))
    }

    /// What Beer's law leaves of light on the way through a solid that ends here,
    /// color^(t/distance): the ray that met a closed surface from behind came through its inside.
    fn interior(&self, volume: &VolumeDesc) -> Spectrum {
        if volume.attenuation_distance.is_infinite() {
            return Spectrum::ONE;
        }
        let exponent = self.surface.t / volume.attenuation_distance;
        self.spectrum(volume.attenuation_color).map(|c| c.clamp(0.0, 1.0).powf(exponent))
    }
}
