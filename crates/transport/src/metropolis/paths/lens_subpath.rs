//! The lens subpath mutation (Veach & Guibas 1997, sec. 5.3.3): what leads from the eye to the first D
//! is deleted and made anew, from anywhere on the film and through as many S as come.
//!
//! ```text
//! … (L|D) D S* E  →  … (L|D) D′ S*′ E                                                  (1)
//! T(x→y) ∝ s_D Π_S (1 - s_i) p_i g←ᵢ₋₁          of the vertices of y that are new      (2)
//! ```
//!
//! p_i is the probability of a Dirac lobe's choice, s that of an end: 1 of what has no Dirac lobes, ½ of
//! what has others, too. Where pictures show things through glass, chains get there by this: the
//! bidirectional mutation must guess the number of interfaces first.

use super::bidirectional::Lengths;
use super::mutation::Proposal;
use super::path::{Node, Path, Turn};
use super::tracer::Tracer;
use crate::metropolis::Draws;
use kaustika_math::Vec2;
use kaustika_scene::bsdf::{Lobes, Mode};

/// s of (2).
fn ends(node: &Node) -> f64 {
    match (node.connects(), node.bsdf.lobes().has(Lobes::DELTA)) {
        (true, true) => 0.5,
        (true, false) => 1.0,
        (false, _) => 0.0,
    }
}

/// The first D from the eye; `None` if there is none, or if what comes before it is an S.
fn first_d(x: &Path) -> Option<usize> {
    let i = x.turns.iter().rposition(|t| t.dirac.is_none())?;
    (i == 0 || x.turns[i - 1].dirac.is_none()).then_some(i)
}

/// (2), of a path whose first D from the eye is vertex `d`.
fn density(y: &Path, d: usize) -> f64 {
    let mut t = ends(&y.turns[d].node);
    for i in d + 1..y.len() {
        let Turn { node, dirac } = &y.turns[i];
        let p = dirac.map_or(0.0, |dirac| dirac.p[1]);
        t *= (1.0 - ends(node)) * p * y.turns[i - 1].node.g(node.p());
    }
    t
}

/// (1)
pub(super) fn propose<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    lengths: Lengths,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let d = first_d(x)?;
    let lambda = x.lambda_of_all(tracer.scene);
    let film = tracer.field.place(Vec2::new(draws.f32(), draws.f32()));
    let lens = Vec2::new(draws.f32(), draws.f32());
    let (sensed, mut limit) = tracer.see(film, lens, x.time);
    let mut ray = sensed.ray;
    let mut new: Vec<Turn> = Vec::new();
    while d + new.len() < lengths.most {
        let node = tracer.node(ray, limit, &lambda)?;
        limit = f32::INFINITY;
        if draws.f64() < ends(&node) {
            new.push(Turn { node, dirac: None });
            let fits = d + new.len() >= lengths.fewest;
            return fits.then(|| join(tracer, x, d, (sensed, new)))?;
        }
        let onward = tracer.scatter(&node, -ray.d, Mode::Radiance, draws)?;
        let dirac = Some(onward.dirac?);
        ray = onward.ray;
        new.push(Turn { node, dirac });
    }
    None
}

/// Joins what is `new`, from the eye on, to what comes before vertex `d` of x.
fn join<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    d: usize,
    (sensed, new): (super::path::Sensed, Vec<Turn<'a>>),
) -> Option<Proposal<'a>> {
    let node = &new.last()?.node;
    let source = match d.checked_sub(1) {
        None => {
            let lambda = x.lambda_of_all(tracer.scene);
            tracer.again(&x.source.end, &node.surface, &lambda)?
        }
        Some(before) => {
            if !tracer.sees(&x.turns[before].node, node) {
                return None;
            }
            x.source
        }
    };
    let mut turns = x.turns[..d].to_vec();
    turns.extend(new.into_iter().rev());
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, sensed)?;
    let (there, back) = (x.f * density(&y, d), y.f * density(x, d));
    Some(Proposal { path: y, there, back })
}
