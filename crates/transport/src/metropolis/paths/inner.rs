//! The perturbation of inner vertices: one that scatters moves a little between its neighbours, which stay.
//!
//! ```text
//! … (L|D) S* D D …      from the light: the direction moves in which light leaves (L|D)      (1)
//! … (L|D) D S* D …      from the eye: the direction moves from which light comes to D        (2)
//!
//! θ = θ₂ exp(-ln(θ₂/θ₁) ξ)                                                            (3)
//! T(x→y) = Π g→ᵢ(y) J_i    of (1),        Π g←ᵢ(y)    of (2)       of what is regrown        (4)
//! ```
//!
//! Veach & Guibas' perturbations move what is next to the eye, and leave what is beyond to the
//! bidirectional mutation: a path through a gap then keeps its vertices there for long. Here they move as
//! easily. θ has the same density in both directions; θ₁ to θ₂ is wide, so that some of it fits whatever
//! surfaces and gaps ask for.

use super::mutation::Proposal;
use super::path::{Path, Turn, toward};
use super::perturbation::{between, leaving, turned};
use super::tracer::Tracer;
use crate::metropolis::Draws;
use kaustika_math::Ray;
use kaustika_scene::bsdf::Mode;
use kaustika_spectra::Wavelengths;

/// θ₁ and θ₂ of (3), radians.
const ANGLES: [f64; 2] = [0.002, 0.4];

/// True of what scatters, by the path's form.
pub(super) fn is_d(x: &Path, i: usize) -> bool {
    x.turns[i].dirac.is_none()
}

/// Vertices (from 0) that may move from the light: D before D.
fn from_light(x: &Path) -> impl Iterator<Item = usize> + Clone {
    (1..x.len()).filter(|&i| is_d(x, i - 1) && is_d(x, i)).map(|i| i - 1)
}

/// Vertices that may move from the eye: D behind D or the light, with a D before them.
fn from_eye(x: &Path) -> impl Iterator<Item = usize> + Clone {
    let last = (0..x.len()).rfind(|&i| is_d(x, i)).unwrap_or(0);
    (0..last).filter(|&i| is_d(x, i) && (i == 0 || is_d(x, i - 1)))
}

/// A perturbation of one of the vertices that may move.
pub(super) fn propose<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let all = [from_light(x).count(), from_eye(x).count()];
    let nth = draws.below(all[0] + all[1]);
    match nth.checked_sub(all[0]) {
        None => {
            let end = from_light(x).nth(nth)?;
            move_from_light(tracer, x, end, draws)
        }
        Some(nth) => {
            let end = from_eye(x).nth(nth)?;
            move_from_eye(tracer, x, end, draws)
        }
    }
}

/// Follows `ray` over vertices of x, each turned by a lobe of its class; those that scatter are met, and not
/// left.
pub(super) fn follow<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    (mut ray, mut t_max): (Ray, f32),
    way: impl Iterator<Item = usize>,
    mode: Mode,
    lambda: &Wavelengths,
    turns: &mut [Turn<'a>],
) -> Option<()> {
    for i in way {
        let node = tracer.node(ray, t_max, lambda)?;
        t_max = f32::INFINITY;
        let dirac = match &x.turns[i].dirac {
            Some(dirac) => {
                let onward = tracer.turn(&node, -ray.d, dirac.lobe, mode)?;
                ray = onward.ray;
                onward.dirac
            }
            None if node.connects() => None,
            None => return None,
        };
        turns[i] = Turn { node, dirac };
    }
    Some(())
}

/// (1), up to vertex `end`.
fn move_from_light<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    end: usize,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let base = (0..end).rfind(|&i| is_d(x, i));
    let first = base.map_or(0, |i| i + 1);
    if base.is_none() && x.source.end.infinite {
        return None;
    }
    let lambda = x.lambda_of_all(tracer.scene);
    let from = |path: &Path| base.map_or(path.source.end.p, |i| path.turns[i].node.p());
    let d = turned(toward(from(x), x.turns[first].node.p()), between(ANGLES, draws), draws);
    let ray = match base {
        None => leaving(x, d),
        Some(i) => x.turns[i].node.surface.spawn(d),
    };
    let mut turns = x.turns.clone();
    follow(tracer, x, (ray, f32::INFINITY), first..=end, Mode::Importance, &lambda, &mut turns)?;
    if !tracer.sees(&turns[end].node, &turns[end + 1].node) {
        return None;
    }
    let source = match base {
        None => tracer.again(&x.source.end, &turns[0].node.surface, &lambda)?,
        Some(_) => x.source,
    };
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, x.sensed)?;
    // (4)
    let regrown = |path: &Path| {
        let (mut t, mut p) = (1.0, from(path));
        for turn in &path.turns[first..=end] {
            t *= turn.node.g(p) * turn.dirac.map_or(1.0, |d| d.jacobian);
            p = turn.node.p();
        }
        t
    };
    let (there, back) = (x.f * regrown(&y), y.f * regrown(x));
    Some(Proposal { path: y, there, back })
}

/// (2), down to vertex `end`.
fn move_from_eye<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    end: usize,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let base = (end + 1..x.len()).find(|&i| is_d(x, i))?;
    let lambda = x.lambda_of_all(tracer.scene);
    let d = turned(-x.to_eye(base - 1), between(ANGLES, draws), draws);
    let ray = x.turns[base].node.surface.spawn(d);
    let mut turns = x.turns.clone();
    let way = (end..base).rev();
    follow(tracer, x, (ray, f32::INFINITY), way, Mode::Radiance, &lambda, &mut turns)?;
    let source = match end.checked_sub(1) {
        None => tracer.again(&x.source.end, &turns[0].node.surface, &lambda)?,
        Some(before) if tracer.sees(&turns[before].node, &turns[end].node) => x.source,
        Some(_) => return None,
    };
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, x.sensed)?;
    // (4)
    let regrown = |path: &Path| -> f64 {
        (end..base).map(|i| path.turns[i].node.g(path.turns[i + 1].node.p())).product()
    };
    let (there, back) = (x.f * regrown(&y), y.f * regrown(x));
    Some(Proposal { path: y, there, back })
}
