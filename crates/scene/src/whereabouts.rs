//! In which medium things are.

use crate::description::MediumId;
use crate::{LightId, Scene};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_spectra::Wavelengths;

/// Rays that are sent out to find in which medium a light is.
const PROBES: u32 = 64;
/// Surfaces that a probe passes.
const MAX_PASSAGES: u32 = 1000;

impl Scene {
    /// The medium that the light's light enters where it leaves a point with normal `n` along `d`.
    #[inline]
    pub fn medium_at_light(&self, id: LightId, n: Vec3, d: Vec3) -> Option<MediumId> {
        if self.media.is_empty() {
            return None;
        }
        let side = usize::from(n.dot(d) > 0.0);
        self.boundary_of(id).map_or_else(|| self.light_media[id.0 as usize], |sides| sides[side])
    }

    /// The media on both sides of the surface that emits, if it bounds any.
    fn boundary_of(&self, id: LightId) -> Option<[Option<MediumId>; 2]> {
        self.shape_of_light(id)?.boundary
    }

    /// For each light the medium around it: the one that `given` says; else the one behind the
    /// first boundary that its light meets; else, if that meets none, the camera's.
    pub(crate) fn find_light_media(&self, given: &[Option<MediumId>]) -> Vec<Option<MediumId>> {
        let described = self.lights.len() - given.len();
        let medium = |i: usize| {
            let given = i.checked_sub(described).and_then(|k| given[k]);
            given.or_else(|| self.probe(LightId(i as u32)).unwrap_or(self.camera_medium))
        };
        (0..self.lights.len()).map(medium).collect()
    }

    fn probe(&self, id: LightId) -> Option<Option<MediumId>> {
        let lambda = Wavelengths::sample_for(self.mode, 0.5);
        // Four numbers for each ray: the R4 sequence (Roberts 2018), x⁵ = x + 1.
        const R4: [f32; 4] = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_2];
        (1..=PROBES).find_map(|k| {
            let [a, b, c, d] = R4.map(|r| (r * k as f32).fract());
            let (u, v) = (Vec2::new(a, b), Vec2::new(c, d));
            let emitted = self.light(id).sample_le(self, u, v, &lambda)?;
            self.medium_along(emitted.ray)
        })
    }

    /// The medium on the near side of the first boundary that the ray meets, whatever else is in
    /// its way.
    fn medium_along(&self, mut ray: Ray) -> Option<Option<MediumId>> {
        for _ in 0..MAX_PASSAGES {
            let surface = self.intersect(&ray, f32::INFINITY)?;
            if let Some(sides) = self.shapes[surface.shape as usize].boundary {
                return Some(sides[usize::from(surface.ng.dot(ray.d) < 0.0)]);
            }
            ray = surface.spawn(ray.d);
        }
        None
    }
}
