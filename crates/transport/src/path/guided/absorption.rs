//! Media that absorb and glow, the same everywhere, along the rays of trees.
//!
//! ```text
//! L(x, ω) = T(d) L(y, ω) + ∫₀ᵈ T(t) Lₑ dt,    T(t) = e^{-σₜ t}                            (1)
//! ```

use super::super::integrate::{LightRay, MAX_PASSAGES};
use crate::extinction::{self, optical_length};
use kaustika_math::Ray;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::description::MediumId;
use kaustika_scene::medium::Medium;
use kaustika_scene::{Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// What a medium does to light that comes along a ray.
pub(super) struct Absorption {
    /// T(d).
    pub t: Spectrum,
    /// The integral of (1).
    pub glow: Spectrum,
}

impl Absorption {
    /// As far as `length` along a ray of unit direction.
    pub(super) fn along(
        medium: &Medium,
        ray: &Ray,
        length: f32,
        lambda: &Wavelengths,
    ) -> Absorption {
        let nothing = Absorption { t: Spectrum::ONE, glow: Spectrum::ZERO };
        let Some((t0, t1)) = medium.interval(ray, length) else { return nothing };
        let Some(c) = medium.uniform(ray.d, lambda) else { return nothing };
        let t = extinction::transmittance(c.sigma_t, t1 - t0);
        Absorption { t, glow: c.glow * optical_length(c.sigma_t, t1 - t0) }
    }
}

/// True if all media of a scene are of this kind.
pub(super) fn only_absorbs(scene: &Scene) -> bool {
    scene.media().iter().all(|m| !m.scatters && !m.varies())
}

/// T of (1) on the way to a light, through all boundaries of media; black if something stands
/// there. The way begins in `medium`; `room` is room to work in.
pub(super) fn transmittance<'a>(
    scene: &'a Scene,
    light: &LightRay,
    mut medium: Option<MediumId>,
    lambda: &Wavelengths,
    room: &mut Bsdf<'a>,
) -> Spectrum {
    let Segment { mut ray, mut t_max } = light.segment;
    let target = ray.at(t_max);
    let mut t = Spectrum::ONE;
    for _ in 0..MAX_PASSAGES {
        let hit = scene.hit(&ray, t_max);
        if let Some(id) = medium {
            let scale = ray.d.length();
            let end = match &hit {
                Some(hit) => hit.t,
                None if light.far => f32::INFINITY,
                None => t_max,
            };
            let unit = Ray { d: ray.d * (1.0 / scale), ..ray };
            t *= Absorption::along(scene.medium(id), &unit, end * scale, lambda).t;
        }
        let Some(hit) = hit else { return t };
        let surface = scene.geometry.surface(&hit, &ray);
        if scene.bsdf_into(&surface, -ray.d.normalize(), &mut lambda.clone(), room) {
            return Spectrum::ZERO;
        }
        medium = scene.medium_beyond(&surface, ray.d, medium);
        (ray, t_max) = (surface.spawn_to(target), 1.0);
    }
    Spectrum::ZERO
}
