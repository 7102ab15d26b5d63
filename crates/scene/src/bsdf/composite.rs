//! The BSDF of a hit: one or several models, each in its frame, with weights.
//!
//! ```text
//! f = Σ wᵢ fᵢ,   pdf = Σ pᵢ pdfᵢ,   pᵢ = wᵢ / Σ w                              (1)
//! importance: f · |ωₒ·nₛ| |ωᵢ·n_g| / (|ωₒ·n_g| |ωᵢ·nₛ|)   (Veach 1997, eq. 5.19) (2)
//! ```

use super::{BsdfSample, Lobes, Mode, Model, Scatter};
use arrayvec::ArrayVec;
use kaustika_math::{Frame, ONE_MINUS_EPSILON, Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// Most models at one hit; what a file nests deeper is left out.
pub const MAX_PARTS: usize = 8;

/// One model of a hit.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Its frame in world space.
    pub frame: Frame,
    /// The shading normal before a bump or normal map turned it: light must arrive on the same
    /// side of both, or it would leak through.
    pub guard: Option<Vec3>,
    /// Factor of its value, and its share in sampling.
    pub weight: f32,
    /// The model.
    pub model: Model<'a>,
}

impl Part<'_> {
    /// True if the direction toward the light, `wi` for radiance and `wo` for importance, lies
    /// on the same side of both normals. The camera's side is not asked, as in Mitsuba: at
    /// silhouettes of smooth meshes it may lie behind either.
    #[inline]
    fn passes_guard(
        &self,
        (local_o, wo): (Vec3, Vec3),
        (local_i, wi): (Vec3, Vec3),
        mode: Mode,
    ) -> bool {
        let (local, world) = match mode {
            Mode::Radiance => (local_i, wi),
            Mode::Importance => (local_o, wo),
        };
        self.guard.is_none_or(|n| n.dot(world) * local.z > 0.0)
    }

    /// Factor (2).
    #[inline]
    fn correction(&self, wo: Vec3, wi: Vec3, ng: Vec3, mode: Mode) -> f32 {
        if mode == Mode::Radiance {
            return 1.0;
        }
        let ns = self.frame.n;
        let denominator = ng.abs_dot(wo) * ns.abs_dot(wi);
        if denominator == 0.0 { 0.0 } else { ns.abs_dot(wo) * ng.abs_dot(wi) / denominator }
    }
}

/// How a surface point scatters, in world space. The contract is the module's.
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    ng: Vec3,
    parts: ArrayVec<Part<'a>, MAX_PARTS>,
    total: f32,
}

impl<'a> Bsdf<'a> {
    /// A BSDF without any model yet: it absorbs everything.
    #[inline]
    pub fn new(ng: Vec3) -> Bsdf<'a> {
        Bsdf { ng, parts: ArrayVec::new(), total: 0.0 }
    }

    /// Adds a model.
    #[inline]
    pub fn push(&mut self, part: Part<'a>) {
        if part.weight > 0.0 && self.parts.try_push(part).is_ok() {
            self.total += part.weight;
        }
    }

    /// The models.
    pub fn parts(&self) -> &[Part<'a>] {
        &self.parts
    }

    /// f(wo, wi) |cos θᵢ| of the smooth classes in `lobes`.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        let mut f = Spectrum::ZERO;
        for part in &self.parts {
            let (o, i) = (part.frame.to_local(wo), part.frame.to_local(wi));
            if part.passes_guard((o, wo), (i, wi), mode) {
                let k = part.weight * part.correction(wo, wi, self.ng, mode);
                f += part.model.eval(o, i, mode, lobes) * k;
            }
        }
        f
    }

    /// Densities per solid angle (forward, reverse) of sampling from `lobes`.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        let (mut forward, mut reverse) = (0.0, 0.0);
        for part in &self.parts {
            let (o, i) = (part.frame.to_local(wo), part.frame.to_local(wi));
            if part.passes_guard((o, wo), (i, wi), mode) {
                let (f, r) = part.model.pdf(o, i, mode, lobes);
                forward += part.weight * f;
                reverse += part.weight * r;
            }
        }
        (forward / self.total, reverse / self.total)
    }

    /// Draws a direction from `lobes`.
    #[inline]
    pub fn sample(
        &self,
        wo: Vec3,
        uc: f32,
        u2: Vec2,
        mode: Mode,
        lobes: Lobes,
    ) -> Option<BsdfSample> {
        let (chosen, uc) = self.choose(uc)?;
        let part = &self.parts[chosen];
        let o = part.frame.to_local(wo);
        let local = part.model.sample(o, uc, u2, mode, lobes)?;
        let wi = part.frame.to_world(local.wi);
        if !part.passes_guard((o, wo), (local.wi, wi), mode) {
            return None;
        }
        let p = part.weight / self.total;
        let k = part.correction(wo, wi, self.ng, mode) * part.weight / p;
        let mut s = BsdfSample { wi, weight: local.weight * k, ..local };
        if self.parts.len() > 1 {
            if s.lobe.has(Lobes::DELTA) {
                s.pdf *= p;
                s.pdf_rev *= p;
            } else {
                (s.pdf, s.pdf_rev) = self.pdf(wo, wi, mode, lobes); // (1)
                s.weight = self.eval(wo, wi, mode, lobes) / s.pdf;
            }
        }
        (s.pdf > 0.0).then_some(s)
    }

    /// The model that `uc` chooses, and what is left of `uc`.
    #[inline]
    fn choose(&self, uc: f32) -> Option<(usize, f32)> {
        if self.parts.len() == 1 {
            return Some((0, uc));
        }
        let mut rest = uc * self.total;
        for (i, part) in self.parts.iter().enumerate() {
            if rest < part.weight || i + 1 == self.parts.len() {
                return Some((i, (rest / part.weight).clamp(0.0, ONE_MINUS_EPSILON)));
            }
            rest -= part.weight;
        }
        None
    }

    /// Directional albedo for `wo`; see [`Scatter::albedo`].
    pub fn albedo(&self, wo: Vec3) -> Spectrum {
        self.parts
            .iter()
            .fold(Spectrum::ZERO, |s, p| s + p.model.albedo(p.frame.to_local(wo)) * p.weight)
    }

    /// Mean roughness of the models, by weight.
    pub fn roughness(&self) -> f32 {
        let sum: f32 = self.parts.iter().map(|p| p.weight * p.model.roughness()).sum();
        if self.total > 0.0 { sum / self.total } else { 1.0 }
    }

    /// The classes it can scatter into.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.parts.iter().fold(Lobes::NONE, |l, p| l | p.model.lobes())
    }

    /// Normal of the first model's frame.
    pub fn shading_normal(&self) -> Vec3 {
        self.parts.first().map_or(self.ng, |p| p.frame.n)
    }
}
