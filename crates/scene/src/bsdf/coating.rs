//! A dielectric coat over any reflecting model, without light that goes between the two more than
//! once.
//!
//! With ω' the direction ω refracted into the coat, on the same side, and T what its surface lets
//! through (1 - F, or the tables of [`RoughTransmittance`] for a rough one):
//!
//! ```text
//! f = s f_coat + T(ωₒ) T(ωᵢ) f_base(ωₒ', ωᵢ') exp(-σd (1/cos θₒ' + 1/cos θᵢ')) / η²           (1)
//! pdf(ωᵢ) = p pdf_coat(ωᵢ) + (1-p) pdf_base(ωᵢ' | ωₒ') cos θᵢ / (η² cos θᵢ')                   (2)
//! p ∝ (1 - T(ωₒ)) w,   1-p ∝ T(ωₒ) (1 - w),   w = 1/(1 + exp(-2σd))                           (3)
//! ```
//!
//! Mitsuba 0.6's `coating` (smooth) and `roughcoating` (facts read in their sources), after Weidlich
//! & Wilkie 2007, "Arbitrarily Layered Micro-Facet Surfaces". Mitsuba 3's `pplastic` is a
//! rough coat that lets light through as a smooth one does, over a matte base; only that [`polarized`].

use super::fresnel::{fresnel_dielectric, reflect};
use super::{
    AlphaIndex, BsdfSample, Conductor, Diffuse, Lobes, Microfacet, Mode, Model, OrenNayar, Phong,
    Plastic, RoughPlastic, RoughTransmittance, Scatter, Ward,
};
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;

/// What can lie under the coat: the models of Mitsuba 0.6 that reflect.
macro_rules! bases {
    ($($Name:ident($T:ty)),+ $(,)?) => {
        /// A model under a coat.
        #[derive(Clone, Copy, Debug)]
        enum Base<'a> { $($Name($T)),+ }

        impl<'a> Base<'a> {
            fn of(model: Model<'a>) -> Option<Base<'a>> {
                match model {
                    $(Model::$Name(m) => Some(Base::$Name(m)),)+
                    _ => None,
                }
            }

            fn as_model(&self) -> Model<'a> {
                match self { $(Base::$Name(m) => Model::$Name(*m)),+ }
            }
        }
    };
}

bases! {
    Diffuse(Diffuse),
    Conductor(Conductor),
    OrenNayar(OrenNayar),
    Phong(Phong),
    Ward(Ward),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic<'a>),
}

/// The coat itself.
#[derive(Clone, Copy, Debug)]
pub struct CoatingLayer<'a> {
    /// Index over that outside, > 0.
    pub eta: f32,
    /// Facets of its surface.
    pub surface: Microfacet,
    /// What a rough surface lets through; `None`: as a smooth one.
    pub through: Option<(&'a RoughTransmittance, AlphaIndex)>,
    /// s: multiplies its reflection, in [0, 1].
    pub reflectance: Spectrum,
    /// σd: absorption times thickness, >= 0.
    pub depth: Spectrum,
}

/// A coated surface, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Coating<'a> {
    layer: CoatingLayer<'a>,
    base: Base<'a>,
}

impl<'a> Coating<'a> {
    /// The coat over `base`; `None` if that model can't be coated.
    pub fn new(layer: CoatingLayer<'a>, base: Model<'a>) -> Option<Coating<'a>> {
        Base::of(base).map(|base| Coating { layer, base })
    }

    fn coat_class(&self) -> Lobes {
        match self.layer.surface.is_smooth() {
            true => Lobes::DELTA_REFLECTION,
            false => Lobes::GLOSSY_REFLECTION,
        }
    }

    /// T for light along a direction at `cos` from the normal.
    fn transmittance(&self, cos: f32) -> f32 {
        match self.layer.through {
            Some((tables, at)) => tables.transmittance(at, cos),
            None => 1.0 - fresnel_dielectric(cos, self.layer.eta).reflectance,
        }
    }

    /// `w` (above the surface) refracted into the coat, or out of it; `None` if it can't leave.
    fn refracted(w: Vec3, eta: f32) -> Option<Vec3> {
        let (x, y) = (w.x / eta, w.y / eta);
        let sin2 = sqr(x) + sqr(y);
        (sin2 < 1.0).then(|| Vec3::new(x, y, safe_sqrt(1.0 - sin2)))
    }

    /// What the coat leaves of light on its way in along `wi` and out along `wo`, and the two
    /// directions inside.
    fn inside(&self, wo: Vec3, wi: Vec3) -> Option<(Spectrum, Vec3, Vec3)> {
        let eta = self.layer.eta;
        let (o, i) = (Coating::refracted(wo, eta)?, Coating::refracted(wi, eta)?);
        let t = self.transmittance(wo.z) * self.transmittance(wi.z);
        let kept = (self.layer.depth * -(1.0 / o.z + 1.0 / i.z)).exp();
        Some((kept * t, o, i))
    }

    /// p of (3), `None` if nothing may be drawn.
    fn choice(&self, wo: Vec3, lobes: Lobes) -> Option<f32> {
        match (lobes.has(self.coat_class()), lobes.has(self.base.as_model().lobes())) {
            (false, false) => None,
            (true, false) => Some(1.0),
            (false, true) => Some(0.0),
            (true, true) => {
                let t = self.transmittance(wo.z);
                let w = 1.0 / (1.0 + (self.layer.depth * -2.0).exp().max_component());
                let (coat, base) = ((1.0 - t) * w, t * (1.0 - w));
                Some(if coat + base > 0.0 { coat / (coat + base) } else { 1.0 })
            }
        }
    }

    /// The first part of (1), where it is no mirror.
    fn coat(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> Spectrum {
        if !lobes.has(self.coat_class() & Lobes::SMOOTH) {
            return Spectrum::ZERO;
        }
        let wm = (wo + wi).normalize();
        let f = fresnel_dielectric(wo.dot(wm), self.layer.eta).reflectance;
        let surface = self.layer.surface;
        let facets = surface.d(wm) * surface.g2(wo, wi) / (4.0 * wo.z);
        self.layer.reflectance * (f * facets)
    }

    /// The base's mirror seen through the coat: its value and probability among `lobes`.
    fn base_mirror(&self, wo: Vec3, lobes: Lobes) -> Option<(Spectrum, f32)> {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        let (kept, o, _) = self.inside(wo, wi)?;
        let base = self.base.as_model();
        // Models with a Dirac and a smooth lobe draw the Dirac one at one of the ends.
        let drawn = [0.0, ONE_MINUS_EPSILON].into_iter().find_map(|uc| {
            let s = base.sample(o, uc, Vec2::new(0.5, 0.5), Mode::Radiance, lobes)?;
            s.lobe.has(Lobes::DELTA).then_some(s)
        })?;
        Some((drawn.weight * drawn.pdf * kept, drawn.pdf))
    }

    /// The Dirac lobe of coat and base together, where the coat is drawn with probability `p`.
    fn mirror(&self, wo: Vec3, p: f32, lobes: Lobes) -> Option<BsdfSample> {
        let (mut value, mut pdf) = (Spectrum::ZERO, 0.0);
        if self.layer.surface.is_smooth() {
            let f = fresnel_dielectric(wo.z, self.layer.eta).reflectance;
            value += self.layer.reflectance * f;
            pdf += p;
        }
        if let Some((below, probability)) = self.base_mirror(wo, lobes) {
            value += below;
            pdf += (1.0 - p) * probability;
        }
        (pdf > 0.0).then(|| BsdfSample {
            wi: Vec3::new(-wo.x, -wo.y, wo.z),
            weight: value / pdf,
            pdf,
            pdf_rev: pdf,
            eta: 1.0,
            lobe: Lobes::DELTA_REFLECTION,
        })
    }
}

impl Scatter for Coating<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let mut value = self.coat(wo, wi, lobes);
        if let Some((kept, o, i)) = self.inside(wo, wi) {
            let below = self.base.as_model().eval(o, i, mode, lobes);
            value += below * kept * (wi.z / (sqr(self.layer.eta) * i.z));
        }
        value // (1)
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return (0.0, 0.0);
        }
        let (Some(po), Some(pi)) = (self.choice(wo, lobes), self.choice(wi, lobes)) else {
            return (0.0, 0.0);
        };
        let (mut forward, mut reverse) = (0.0, 0.0);
        if lobes.has(self.coat_class() & Lobes::SMOOTH) {
            let (f, r) = self.layer.surface.pdf_reflection(wo, wi, (wo + wi).normalize());
            (forward, reverse) = (po * f, pi * r);
        }
        let eta = self.layer.eta;
        if let (Some(o), Some(i)) = (Coating::refracted(wo, eta), Coating::refracted(wi, eta)) {
            let (f, r) = self.base.as_model().pdf(o, i, mode, lobes);
            forward += (1.0 - po) * f * wi.z / (sqr(eta) * i.z);
            reverse += (1.0 - pi) * r * wo.z / (sqr(eta) * o.z);
        }
        (forward, reverse) // (2)
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let p = self.choice(wo, lobes)?;
        let (wi, lobe) = if uc < p {
            if self.layer.surface.is_smooth() {
                return self.mirror(wo, p, lobes);
            }
            (reflect(wo, self.layer.surface.sample_visible(wo, u2)), Lobes::GLOSSY_REFLECTION)
        } else {
            let eta = self.layer.eta;
            let uc = ((uc - p) / (1.0 - p)).min(ONE_MINUS_EPSILON);
            let o = Coating::refracted(wo, eta)?;
            let s = self.base.as_model().sample(o, uc, u2, mode, lobes)?;
            if s.lobe.has(Lobes::DELTA) {
                return self.mirror(wo, p, lobes);
            }
            (Coating::refracted(s.wi, 1.0 / eta)?, s.lobe)
        };
        if wi.z <= 0.0 {
            return None;
        }
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// The coat's reflection as that of a smooth one, and the base's albedo inside, of which the
    /// coat lets the part out that it would of a matte base: within 0.1 for diffuse bases, too low
    /// for glossy ones.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        let eta = self.layer.eta;
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let t = self.transmittance(wo.z);
        let mut albedo = self.layer.reflectance * (1.0 - t);
        if let Some(o) = Coating::refracted(wo, eta) {
            let out = (1.0 - super::fresnel::fresnel_diffuse_reflectance(1.0 / eta)).max(0.0);
            let kept = (self.layer.depth * -(1.0 / o.z + 1.5)).exp();
            albedo += self.base.as_model().albedo(o) * kept * (t * out);
        }
        albedo
    }

    fn roughness(&self) -> f32 {
        let coat =
            if self.layer.surface.is_smooth() { 0.0 } else { self.layer.surface.roughness() };
        self.base.as_model().roughness().max(coat)
    }

    fn lobes(&self) -> Lobes {
        self.coat_class() | self.base.as_model().lobes()
    }
}

mod polarized;
#[cfg(test)]
mod tests;
