//! Glossy lobes over the bases of sixteen surfaces: the twins of
//! [`RoughPlastic`](crate::bsdf::RoughPlastic) and [`Principled`](crate::bsdf::Principled), seen
//! and lit from above.
//!
//! Both reflect at facets or at a base that is matte or nearly so:
//!
//! ```text
//! f cos θᵢ = (s F + metallic [ρ, 1]_s) D(m) G₂/(4 cos θₒ) + ρ g cos θᵢ/π                (1)
//! coat       s its colour, metallic = 0, ρ what is left of the albedo under it, g = T(ωₒ) T(ωᵢ)
//! principled s = 1 - metallic, ρ the base colour, g = (1 - metallic) (f_d + f_r)
//! ```
//!
//! The same facets and F serve both, so that surfaces of both kinds side by side cost little more.

use super::coat::Coat;
use super::facets::{fresnel, ggx, lambda, visible_facet};
use super::principled::{PrincipledLobes, diffuse, schlick_weight};
use crate::bsdf::RoughPlastic;
use kaustika_math::INV_PI;
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s, mask_of};
use kaustika_spectra::Spectrum;

/// What makes a plain surface glossy.
#[derive(Clone, Debug)]
pub enum Gloss {
    /// A rough coat over a matte base.
    Coat(Coat),
    /// The principled model.
    Principled(PrincipledLobes),
}

/// The glossy lobes of sixteen surfaces, gathered lane by lane.
#[repr(C, align(64))]
#[derive(Debug, Default)]
pub struct Glosses<'a> {
    /// Lanes with a coat, and which.
    coated: u32,
    coats: [Option<&'a Coat>; LANES],
    /// Lanes of the principled model.
    principled: u32,
    correlated: u32,
    alpha: Row,
    eta: Row,
    /// Factors s of F in (1).
    specular: [Row; 4],
    /// w of coats; the principled lobe's probability itself.
    weight: Row,
    metallic: Row,
    /// For [`diffuse`].
    roughness: Row,
}

/// Sixteen glossy surfaces seen from their directions ωₒ, which are in the shading frames.
#[derive(Clone, Copy, Debug)]
pub struct SeenGlosses {
    mask: Lanes,
    wo: Vec3s,
    /// T(ωₒ); 1 without a coat.
    t: Lanes,
    /// Probability of the glossy lobe; 0 without one.
    choice: Lanes,
    /// Λ(ωₒ).
    lambda: Lanes,
    alpha: Lanes,
}

impl<'a> Glosses<'a> {
    /// Takes all lobes away.
    #[inline]
    pub fn clear(&mut self) {
        (self.coated, self.principled, self.correlated) = (0, 0, 0);
    }

    /// Lanes that have one.
    #[inline]
    pub fn lanes(&self) -> u32 {
        self.coated | self.principled
    }

    /// Puts a glossy lobe over the base of albedo `rho` in a lane that has none; ρ of (1).
    #[inline]
    pub fn set(&mut self, lane: usize, gloss: &'a Gloss, rho: Spectrum) -> Spectrum {
        match gloss {
            Gloss::Coat(coat) => self.set_coat(lane % LANES, coat, rho),
            Gloss::Principled(lobes) => {
                self.set_principled(lane % LANES, lobes);
                rho
            }
        }
    }

    #[inline]
    fn set_coat(&mut self, lane: usize, coat: &'a Coat, rho: Spectrum) -> Spectrum {
        let (base, weight) =
            RoughPlastic::base(&coat.tables, coat.at, rho, coat.specular, coat.nonlinear);
        self.coated |= 1 << lane;
        self.coats[lane] = Some(coat);
        self.correlated |= u32::from(coat.correlated) << lane;
        self.alpha[lane] = coat.alpha;
        self.eta[lane] = coat.tables.eta();
        self.weight[lane] = weight;
        self.metallic[lane] = 0.0;
        self.specular.iter_mut().zip(coat.specular.0).for_each(|(row, s)| row[lane] = s);
        base
    }

    #[inline]
    fn set_principled(&mut self, lane: usize, lobes: &PrincipledLobes) {
        self.principled |= 1 << lane;
        self.alpha[lane] = lobes.alpha;
        self.eta[lane] = lobes.eta;
        self.weight[lane] = lobes.choice();
        self.metallic[lane] = lobes.metallic;
        self.roughness[lane] = lobes.roughness;
        self.specular.iter_mut().for_each(|row| row[lane] = 1.0 - lobes.metallic);
    }

    /// T at the angles of these cosines; 1 without a coat.
    #[inline]
    fn transmittances(&self, cos: Lanes) -> Lanes {
        if self.coated == 0 {
            return Lanes::splat(1.0);
        }
        let mut t = cos.to_array();
        for (i, t) in t.iter_mut().enumerate() {
            *t = match self.coats[i] {
                Some(coat) if self.coated >> i & 1 != 0 => coat.transmittance(*t),
                _ => 1.0,
            };
        }
        Lanes::new(t)
    }

    /// The surfaces as `wo` see them, from above.
    #[inline(always)]
    pub fn seen(&self, wo: Vec3s) -> SeenGlosses {
        let (zero, one) = (Lanes::splat(0.0), Lanes::splat(1.0));
        let mask = mask_of(self.lanes());
        let t = self.transmittances(wo.z);
        let weight = Lanes::new(self.weight);
        let (coat, base) = ((one - t) * weight, t * (one - weight));
        let sum = coat + base;
        let of_coat = sum.simd_gt(zero).select(coat / sum, one);
        let choice = mask_of(self.principled).select(weight, of_coat);
        let alpha = Lanes::new(self.alpha);
        let choice = mask.select(choice, zero);
        SeenGlosses { mask, wo, t, choice, lambda: lambda(wo, alpha), alpha }
    }

    /// Values f |cos θᵢ| of (1) and densities of `wi` above the surfaces, whose ρ are `base`;
    /// without a glossy lobe those of the bare base.
    #[inline(always)]
    pub fn eval_pdf(
        &self,
        seen: &SeenGlosses,
        base: &[Lanes; 4],
        wi: Vec3s,
    ) -> ([Lanes; 4], Lanes) {
        let (zero, one, quarter) = (Lanes::splat(0.0), Lanes::splat(1.0), Lanes::splat(0.25));
        let wo = seen.wo;
        let wm = (wo + wi).normalize();
        let cos_d = wo.dot(wm);
        let facets = ggx(wm, seen.alpha) * quarter / wo.z;
        let lambda_i = lambda(wi, seen.alpha);
        let (go, gi) = (one + seen.lambda, one + lambda_i);
        let g2 = one / mask_of(self.correlated).select(go + lambda_i, go * gi);
        let shape = seen.mask.select(facets * g2, zero);
        let f = seen.mask.select(fresnel(cos_d, Lanes::new(self.eta)), zero);
        let mut reflectance = self.specular.map(|s| Lanes::new(s) * f);
        let mut matte = seen.t * self.transmittances(wi.z);
        if self.principled != 0 {
            let metallic = Lanes::new(self.metallic);
            let s = schlick_weight(cos_d);
            reflectance = std::array::from_fn(|i| {
                metallic.mul_add((one - base[i]).mul_add(s, base[i]), reflectance[i])
            });
            let of_burley =
                (one - metallic) * diffuse(wo.z, wi.z, cos_d, Lanes::new(self.roughness));
            matte = mask_of(self.principled).select(of_burley, matte);
        }
        let cosine = Lanes::splat(INV_PI) * wi.z;
        let matte = matte * cosine;
        let value = std::array::from_fn(|i| reflectance[i].mul_add(shape, base[i] * matte)); // (1)
        let of_facets = seen.mask.select(seen.choice * facets / go, zero);
        (value, (one - seen.choice).mul_add(cosine, of_facets))
    }

    /// Directions: mirrored at visible facets where `uc` chooses the glossy lobe, elsewhere
    /// `matte`. They may point below the surface.
    #[inline(always)]
    pub fn sample(&self, seen: &SeenGlosses, uc: Lanes, u: [Lanes; 2], matte: Vec3s) -> Vec3s {
        let wo = seen.wo;
        let wm = visible_facet(wo, seen.alpha, u);
        let mirrored = wm * (Lanes::splat(2.0) * wo.dot(wm)) - wo;
        // The numbers below a coat's probability are the coat's, the principled lobe's come last.
        let matte_share = Lanes::splat(1.0) - seen.choice;
        let glossy =
            mask_of(self.principled).select(uc.simd_ge(matte_share), uc.simd_lt(seen.choice));
        mirrored.or(glossy, matte)
    }
}
