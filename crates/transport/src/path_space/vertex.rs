//! What subpaths meet.

use super::solid_angle_to_area;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::description::MediumId;
use kaustika_scene::medium::Phase;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A surface that a subpath has met, or a point in a medium where it scattered.
#[derive(Clone, Debug)]
pub struct Vertex<'a> {
    /// Where; in a medium a point without a normal.
    pub surface: Surface,
    /// Unit direction to the vertex before.
    pub wo: Vec3,
    /// What arrives, over the density of the subpath; in a medium times its albedo.
    pub beta: Spectrum,
    /// Wavelengths, the secondary ones ended if the subpath was dispersed.
    pub lambda: Wavelengths,
    /// Scattering of a surface; empty in a medium.
    pub bsdf: Bsdf<'a>,
    /// Scattering in a medium.
    pub inside: Option<Inside<'a>>,
    /// The medium through which the subpath came.
    pub medium: Option<MediumId>,
    /// Numbers for a connection from here: two for a point, one for a choice.
    pub u: [f32; 3],
    /// Density per area, in a medium per volume, from the side of the subpath.
    pub arrival: f64,
    /// The factor of `arrival` that is the same from the other side: that nothing happened on
    /// the way from the vertex before.
    pub passing: f64,
    /// Density per solid angle of the direction in which the subpath went on; a Dirac lobe's
    /// probability; 0 if it ended.
    pub pdf: f64,
    /// That of the way back: of `wo` had the path come from there.
    pub pdf_rev: f64,
    /// The chance that a subpath which comes here in media does not go straight through what lets
    /// everything pass: part of `arrival` from both sides, and of no direction's density.
    pub share: f64,
    /// True if it went on by a Dirac lobe.
    pub delta: bool,
    /// True if that passes straight through, as if there were nothing.
    pub straight: bool,
    /// The ray on which it goes on and what that carries, if it does.
    pub onward: Option<(Ray, Spectrum)>,
}

impl Default for Vertex<'_> {
    /// Nowhere.
    fn default() -> Self {
        Vertex {
            surface: in_space(Vec3::ZERO, 0.0, 0.0),
            wo: Vec3::ZERO,
            beta: Spectrum::ZERO,
            lambda: Wavelengths::rgb(),
            bsdf: Bsdf::default(),
            inside: None,
            medium: None,
            u: [0.0; 3],
            arrival: 0.0,
            passing: 1.0,
            pdf: 0.0,
            pdf_rev: 0.0,
            share: 1.0,
            delta: false,
            straight: false,
            onward: None,
        }
    }
}

/// A point that is on no surface, `t` along the ray that led there.
pub(super) fn in_space(p: Vec3, t: f32, time: f32) -> Surface {
    Surface {
        p,
        p_error: Vec3::ZERO,
        t,
        ng: Vec3::ZERO,
        ns: Vec3::ZERO,
        uv: Vec2::ZERO,
        footprint: 0.0,
        shape: u32::MAX,
        triangle: u32::MAX,
        analytic: u32::MAX,
        instance: None,
        barycentrics: Vec2::ZERO,
        light: None,
        time,
    }
}

/// A point in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Inside<'a> {
    /// Into which directions it scatters.
    pub phase: &'a Phase,
    /// Extinction there for the light that came, the lanes' mean: collisions per unit of length.
    pub sigma_t: f64,
}

impl Inside<'_> {
    /// Extinction at `p` for light along `d`, of any length, where `wo` is the way it came.
    #[inline]
    fn sigma_t_along(&self, p: Vec3, wo: Vec3, d: Vec3) -> f64 {
        let Phase::Sggx(sggx) = self.phase else { return self.sigma_t };
        let flakes = sggx.at(p);
        match (flakes.area(wo), d.try_normalize()) {
            (area, Some(d)) if area > 0.0 => self.sigma_t * f64::from(flakes.area(d) / area),
            _ => self.sigma_t,
        }
    }
}

impl<'a> Vertex<'a> {
    /// The normal that lights are chosen with: that of the side which the path is on, the same
    /// whether it came from the light or from the eye. None where light passes through.
    #[inline]
    pub fn light_normal(&self) -> Vec3 {
        if self.bsdf.lobes().has(Lobes::TRANSMISSION) {
            return Vec3::ZERO;
        }
        let s = &self.surface;
        if s.ns.dot(self.wo) < 0.0 { -s.ng } else { s.ng }
    }

    /// True if it can be connected: not all it does is turn light by Dirac lobes.
    #[inline]
    pub fn connects(&self) -> bool {
        self.bsdf.lobes().has(Lobes::SMOOTH) || self.inside.is_some()
    }

    /// f |cos| for a direction, and the densities per solid angle of it and of the way back.
    #[inline]
    pub fn eval_pdf(&self, wi: Vec3, mode: Mode) -> (Spectrum, (f64, f64)) {
        let (f, (pdf, pdf_rev)) = match &self.inside {
            None => self.bsdf.eval_pdf(self.wo, wi, mode, Lobes::ALL),
            Some(inside) => {
                let p = self.surface.p;
                let there = inside.phase.eval(p, self.wo, wi);
                let back = inside.phase.eval(p, wi, self.wo);
                // σₛ(ωₒ) p(ωₒ, ωᵢ) is the same from both sides, and σₛ(ωₒ) is part of β.
                (Spectrum::splat(there), (there, back))
            }
        };
        (f, (f64::from(pdf) / self.share, f64::from(pdf_rev) / self.share))
    }

    /// What turns a density per solid angle at `from` into one of this vertex, if nothing
    /// happens on the way.
    #[inline]
    pub fn arriving_from(&self, from: Vec3) -> f64 {
        let p = self.surface.p;
        match &self.inside {
            None => solid_angle_to_area(from, p, self.surface.ng) * self.share,
            Some(inside) => {
                let d2 = f64::from((p - from).length_squared()).max(1e-30);
                inside.sigma_t_along(p, self.wo, p - from) / d2
            }
        }
    }

    /// The same for a density per area across parallel rays along `d`.
    #[inline]
    pub fn arriving_along(&self, d: Vec3) -> f64 {
        match &self.inside {
            None => f64::from(self.surface.ng.abs_dot(d)) * self.share,
            Some(inside) => inside.sigma_t_along(self.surface.p, self.wo, d),
        }
    }

    /// A ray from here along `d`.
    #[inline]
    pub fn spawn(&self, d: Vec3) -> Ray {
        match self.inside {
            None => self.surface.spawn(d),
            Some(_) => Ray { o: self.surface.p, d, time: self.surface.time },
        }
    }

    /// A ray from here to `q`, which it reaches at t = 1.
    #[inline]
    pub fn spawn_to(&self, q: Vec3) -> Ray {
        match self.inside {
            None => self.surface.spawn_to(q),
            Some(_) => self.spawn(q - self.surface.p),
        }
    }

    /// The medium that a ray from here along `d` goes through.
    #[inline]
    pub fn medium_toward(&self, scene: &Scene, d: Vec3) -> Option<MediumId> {
        match self.inside {
            None => scene.medium_beyond(&self.surface, d, self.medium),
            Some(_) => self.medium,
        }
    }
}
