//! Candidates that look for caustics where light's paths say they come from.
//!
//! ```text
//! p_i = α p_bsdf + (1 - α) p_guide,     r_i = p_i / p_bsdf            at a vertex of the eye's     (1)
//! q'_s = q_s Π_{i≥s} r_i                                        of all that the eye's side has drawn (2)
//! ```
//!
//! Every other candidate is drawn by (1), and all of them divide by (2) as well (see [`super::candidates`]).

use super::path::{Node, Path, Turn};
use super::tracer::{Onward, Tracer};
use crate::guiding::{Guide, LocalDirections, LocalMixture};
use crate::metropolis::Draws;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::bsdf::{Lobes, Mode};

impl<'a> Tracer<'a> {
    /// What is known at a vertex that is seen from `wo`; the same for all paths through it.
    fn guide(&self, node: &Node, wo: Vec3) -> Option<Guide<LocalMixture<'a>>> {
        self.guides?.at(&node.surface, &node.bsdf, wo)
    }

    /// As [`Tracer::scatter`], by (1).
    pub(super) fn scatter_guided(
        &self,
        node: &Node,
        wo: Vec3,
        draws: &mut Draws,
    ) -> Option<Onward> {
        let guide = self.guide(node, wo);
        let Some(guide) = guide.filter(|guide| draws.f32() >= guide.alpha) else {
            return self.scatter(node, wo, Mode::Radiance, draws);
        };
        let (wi, _) = guide.directions.sample(Vec2::new(draws.f32(), draws.f32()));
        let (f, (pdf, _)) = node.bsdf.eval_pdf(wo, wi, Mode::Radiance, Lobes::ALL);
        // Of what the BSDF never draws (2) knows nothing.
        let possible = pdf > 0.0 && !f.is_black();
        possible.then(|| Onward { ray: node.surface.spawn(wi), dirac: None })
    }

    /// The products of (2), for each s of the path's q.
    pub(super) fn guided(&self, path: &Path, products: &mut Vec<f64>) {
        products.clear();
        products.resize(path.q.len(), 1.0);
        let mut product = 1.0;
        for i in (0..path.len()).rev() {
            product *= self.ratio(&path.turns[i], path.to_eye(i), path.to_light(i));
            products[i] = product;
        }
    }

    /// r of (1); of what the BSDF never draws q is 0 anyway.
    pub(super) fn ratio(&self, Turn { node, dirac }: &Turn, to_eye: Vec3, to_light: Vec3) -> f64 {
        let Some(guide) = self.guide(node, to_eye) else { return 1.0 };
        let alpha = f64::from(guide.alpha);
        if dirac.is_some() {
            return alpha;
        }
        let (_, (pdf, _)) = node.bsdf.eval_pdf(to_eye, to_light, Mode::Radiance, Lobes::ALL);
        match pdf > 0.0 {
            true => alpha + (1.0 - alpha) * f64::from(guide.directions.pdf(to_light) / pdf),
            false => 1.0,
        }
    }
}
