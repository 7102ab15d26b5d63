//! The BSDF of a hit: one or several models, each in its frame, with weights.
//!
//! ```text
//! f = Σ wᵢ fᵢ,   pdf = Σ pᵢ pdfᵢ,   pᵢ = wᵢ / Σ w                              (1)
//! importance: f · |ωₒ·nₛ| |ωᵢ·n_g| / (|ωₒ·n_g| |ωᵢ·nₛ|)   (Veach 1997, eq. 5.19) (2)
//! ```

mod polarized;

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
    /// Roughness α² that stands for the relief a bump or normal map hides, 0 for none; see
    /// [`relief_shadowing`].
    pub relief: f32,
    /// Factor of its value, and its share in sampling.
    pub weight: f32,
    /// The model.
    pub model: Model<'a>,
}

/// Shadowing by the relief that a turned normal stands for, toward the light at `cos` from the
/// unturned normal: the Smith term of Conty Estevez, Lecocq & Stein 2019, "A Microfacet-Based
/// Shadowing Function to Solve the Bump Terminator Problem",
///
/// ```text
/// G = 2 / (1 + √(1 + α² tan²θ)),   α² = tan²δ / 8,  δ the angle between the normals
/// ```
#[inline]
pub fn relief_shadowing(alpha2: f32, cos: f32) -> f32 {
    if alpha2 == 0.0 {
        return 1.0;
    }
    let cos2 = (cos * cos).clamp(1e-12, 1.0);
    2.0 / (1.0 + (1.0 + alpha2 * (1.0 - cos2) / cos2).sqrt())
}

/// α² of [`relief_shadowing`] for normals whose cosine is `cos`.
#[inline]
pub fn relief_roughness(cos: f32) -> f32 {
    let cos2 = (cos * cos).clamp(1e-6, 1.0);
    (0.125 * (1.0 - cos2) / cos2).min(1.0)
}

impl Part<'_> {
    /// Shadowing toward the light, `wi` for radiance and `wo` for importance.
    #[inline]
    fn shadowing(&self, wo: Vec3, wi: Vec3, mode: Mode) -> f32 {
        match (self.guard, mode) {
            (Some(n), Mode::Radiance) => relief_shadowing(self.relief, n.dot(wi)),
            (Some(n), Mode::Importance) => relief_shadowing(self.relief, n.dot(wo)),
            (None, _) => 1.0,
        }
    }

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
    lobes: Lobes,
}

impl Default for Bsdf<'_> {
    /// Absorbs everything.
    fn default() -> Self {
        Bsdf { ng: Vec3::ZERO, parts: ArrayVec::new(), total: 0.0, lobes: Lobes::NONE }
    }
}

impl<'a> Bsdf<'a> {
    /// Forgets all models, for a surface with geometric normal `ng`.
    #[inline]
    pub fn reset(&mut self, ng: Vec3) {
        self.ng = ng;
        self.parts.clear();
        self.total = 0.0;
        self.lobes = Lobes::NONE;
    }

    /// Adds a model.
    #[inline(always)]
    pub fn push(&mut self, part: Part<'a>) {
        if part.weight > 0.0 && !self.parts.is_full() {
            self.total += part.weight;
            self.lobes = self.lobes | part.model.lobes();
            self.parts.push(part);
        }
    }

    /// Replaces the models from number `first` on.
    pub fn replace_from(&mut self, first: usize, f: impl Fn(Part<'a>) -> Part<'a>) {
        self.parts[first..].iter_mut().for_each(|part| *part = f(*part));
        let lobes = self.parts.iter().map(|part| part.model.lobes());
        self.lobes = lobes.fold(Lobes::NONE, |a, b| a | b);
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
                let k = part.weight
                    * part.correction(wo, wi, self.ng, mode)
                    * part.shadowing(wo, wi, mode);
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

    /// [`Bsdf::eval`] and [`Bsdf::pdf`] at once: what light sampling asks for.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (Spectrum, (f32, f32)) {
        let (mut value, mut forward, mut reverse) = (Spectrum::ZERO, 0.0, 0.0);
        for part in &self.parts {
            let (o, i) = (part.frame.to_local(wo), part.frame.to_local(wi));
            if part.passes_guard((o, wo), (i, wi), mode) {
                let k = part.weight
                    * part.correction(wo, wi, self.ng, mode)
                    * part.shadowing(wo, wi, mode);
                let (v, (f, r)) = part.model.eval_pdf(o, i, mode, lobes);
                value += v * k;
                forward += part.weight * f;
                reverse += part.weight * r;
            }
        }
        let inv = 1.0 / self.total;
        (value, (forward * inv, reverse * inv))
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
        let k = part.correction(wo, wi, self.ng, mode) * part.shadowing(wo, wi, mode);
        let k = k * part.weight / p;
        let mut s = BsdfSample { wi, weight: local.weight * k, ..local };
        if self.parts.len() > 1 {
            if s.lobe.has(Lobes::DELTA) {
                s.pdf *= p;
                s.pdf_rev *= p;
            } else {
                let (value, pdf) = self.eval_pdf(wo, wi, mode, lobes);
                (s.pdf, s.pdf_rev) = pdf; // (1)
                s.weight = value / s.pdf;
            }
        }
        (s.pdf > 0.0).then_some(s)
    }

    /// Draws from each model, and each of its classes in `lobes`, apart: `each` gets one direction of
    /// every one, where [`Bsdf::sample`] chooses. What they lead to, each times its weight, is
    /// together what the surface scatters. A mirror and clear glass leave nothing to chance.
    pub fn sample_each(
        &self,
        wo: Vec3,
        (uc, u2): (f32, Vec2),
        mode: Mode,
        lobes: Lobes,
        mut each: impl FnMut(&BsdfSample),
    ) {
        for part in &self.parts {
            let o = part.frame.to_local(wo);
            for class in (part.model.lobes() & lobes).classes() {
                let Some(local) = part.model.sample(o, uc, u2, mode, class) else { continue };
                let wi = part.frame.to_world(local.wi);
                if local.pdf > 0.0 && part.passes_guard((o, wo), (local.wi, wi), mode) {
                    let k = part.weight
                        * part.correction(wo, wi, self.ng, mode)
                        * part.shadowing(wo, wi, mode);
                    each(&BsdfSample { wi, weight: local.weight * k, ..local });
                }
            }
        }
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

    /// What passes straight through from `wo`, and the probability that [`Bsdf::sample`] lets it
    /// pass. `panes` says whether thin panes of glass count: what they transmit is not turned.
    pub fn straight(&self, wo: Vec3, panes: bool) -> (Spectrum, f32) {
        let (mut value, mut p) = (Spectrum::ZERO, 0.0);
        for part in &self.parts {
            let (passes, chance) = match &part.model {
                Model::Null(_) => (Spectrum::ONE, 1.0),
                Model::ThinDielectric(pane) if panes => pane.straight(part.frame.to_local(wo)),
                _ => continue,
            };
            value += passes * part.weight;
            p += chance * part.weight;
        }
        (value, if self.total > 0.0 { p / self.total } else { 0.0 })
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
        self.lobes
    }

    /// Normal of the first model's frame.
    pub fn shading_normal(&self) -> Vec3 {
        self.parts.first().map_or(self.ng, |p| p.frame.n)
    }
}
