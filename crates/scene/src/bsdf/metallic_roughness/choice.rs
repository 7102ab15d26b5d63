//! Which part of the metallic-roughness model is drawn, and with which density.
//!
//! ```text
//! choice   matte : matte through : coat : facets, each by about its albedo                (1)
//! facets   reflect with probability F / (F + (1-m) t base (1-F_d)), greatest components   (2)
//! pdf(ωᵢ)  = Σ P(part) pdf(ωᵢ | part): cosine, or visible normals with their Jacobian     (3)
//! ```

use super::super::albedo::microfacet_albedo_terms;
use super::{Boundary, Lobes, MetallicRoughness, mirrored};
use kaustika_math::{Vec3, sqr, warp};
use kaustika_spectra::Spectrum;

/// Weights of (1).
pub(super) struct Choice {
    pub matte: f32,
    pub matte_through: f32,
    pub coat: f32,
    pub facets: f32,
}

impl Choice {
    #[inline]
    pub fn total(&self) -> f32 {
        self.matte + self.matte_through + self.coat + self.facets
    }
}

impl MetallicRoughness {
    /// Albedo of the facets' reflection to the outside.
    #[inline]
    pub(super) fn facets_albedo(&self, up: Vec3) -> Spectrum {
        let [a, b] = microfacet_albedo_terms(&self.surface, up);
        self.reflected(true, Some(1.0)) * a + Spectrum::splat(self.r90 * b)
    }

    /// Weights for directions at `wo`, unfolded.
    pub(super) fn choice(&self, wo: Vec3, lobes: Lobes) -> Choice {
        let on = |class, weight: f32| if lobes.has(class) { weight } else { 0.0 };
        let (coat, sheen) = self.layers_passed(wo);
        let under = coat * sheen;
        let seen = if self.is_matte_from(wo) { under } else { 0.0 };
        let passed = if seen > 0.0 { seen * self.matte_passed(wo) } else { 0.0 };
        let matte = |i: usize| self.matte[i].max_component() * passed;
        let fibres =
            self.sheen.filter(|_| wo.z > 0.0).map_or(0.0, |s| coat * (1.0 - s.passed(wo.z)));
        let clear = self.clear.max_component();
        let reflected = if wo.z > 0.0 {
            self.facets_albedo(wo).max_component().max(0.01)
        } else {
            self.through
        };
        let (r, t) = (Lobes::GLOSSY_REFLECTION, Lobes::GLOSSY_TRANSMISSION);
        Choice {
            matte: on(Lobes::DIFFUSE_REFLECTION, matte(0) + fibres),
            matte_through: on(Lobes::DIFFUSE_TRANSMISSION, matte(1)),
            coat: on(r, if wo.z > 0.0 { 1.0 - coat } else { 0.0 }),
            facets: under * (on(r, reflected) + on(t, clear)),
        }
    }

    /// Probability (2) that a facet reflects.
    #[inline]
    pub(super) fn reflects(&self, outside: bool, cos: Option<f32>, lobes: Lobes) -> f32 {
        let on = |class, weight: f32| if lobes.has(class) { weight } else { 0.0 };
        let r = on(Lobes::GLOSSY_REFLECTION, self.reflected(outside, cos).max_component());
        let t = self.clear.max_component() * self.passed(cos);
        let t = on(Lobes::GLOSSY_TRANSMISSION, t);
        if r + t > 0.0 { r / (r + t) } else { on(Lobes::GLOSSY_REFLECTION, 1.0) }
    }

    /// Density (3) of `wi` given `wo`.
    pub(super) fn density(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> f32 {
        let (wo, wi) = self.unfolded(wo, wi);
        let choice = self.choice(wo, lobes);
        let total = choice.total();
        if total == 0.0 {
            return 0.0;
        }
        let same_side = wo.z * wi.z > 0.0;
        let matte = if same_side { choice.matte } else { choice.matte_through };
        let mut sum = matte * warp::cosine_hemisphere_pdf_w(wi.z.abs());
        if let (true, Some(coat)) = (same_side && choice.coat > 0.0, &self.coat) {
            sum += choice.coat * coat.pdf(wo, wi);
        }
        if choice.facets > 0.0
            && let Some(f) = self.facet(wo, wi)
        {
            let reflects = self.reflects(self.is_outside(wo), f.cos, lobes);
            let visible = choice.facets * self.surface.pdf_visible(wo, f.wm);
            sum += if same_side {
                visible * reflects / (4.0 * f.cos_o)
            } else if self.boundary == Boundary::Sheet {
                let wm = (wo + mirrored(wi)).normalize();
                visible * (1.0 - reflects) / (4.0 * wo.dot(wm).abs())
            } else {
                visible * (1.0 - reflects) * f.cos_i / sqr(f.cos_o / f.eta - f.cos_i)
            };
        }
        sum / total
    }
}
