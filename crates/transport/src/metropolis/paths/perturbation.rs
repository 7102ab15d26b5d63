//! Perturbations: a path's end is moved a little and regrown with the same classes of scattering
//! (Veach & Guibas 1997, sec. 5.3.2).
//!
//! ```text
//! lens         … (L|D) D S* E     the place on the film moves                          (1)
//! multi-chain  … D S+ D S* E      and at each D before an S the direction, too         (2)
//! caustic      … (L|D) S* D E     the direction moves in which the light leaves (L|D)  (3)
//!
//! r = r₂ exp(-ln(r₂/r₁) ξ),   r₁ = 0.1 pixel,   π r₂² = 5 % of the film               (4)
//! θ likewise; of (3) times what moves the film as far: pixel angle · |xₖ - xₖ₋₁| / Σ |xᵢ₊₁ - xᵢ|
//! T(x→y) = Π g←ᵢ(y)              over what (1), (2) regrow beyond xₖ₋₁                 (5)
//! T(x→y) = Π g→ᵢ(y) J_i / (n P←ₖ₋₁(y))        of (3)                                   (6)
//! ```
//!
//! The densities of r and θ are the same in both directions and left out, but where y could not go back
//! to x by (3), which depends on the scale at y. What was D stays D, whatever its class allows.

use super::mutation::Proposal;
use super::params::Mutation;
use super::path::{Path, Sensed, Source, Turn, toward};
use super::tracer::{Met, Tracer};
use crate::metropolis::Draws;
use crate::path_space::Departure;
use kaustika_math::ray::offset_origin;
use kaustika_math::{Frame, Ray, Vec2, Vec3};
use kaustika_scene::bsdf::Mode;
use kaustika_spectra::Wavelengths;
use std::f32::consts::TAU;

/// r₁ in pixels.
const NEAREST: f64 = 0.1;
/// r₂'s share of the film's area.
const AREA: f64 = 0.05;
/// θ₁ and θ₂ of (2), radians: 0.0001° and 0.1° (as Jakob 2010 has them).
const ANGLES: [f64; 2] = [1.745e-6, 1.745e-3];

/// Which perturbation of the eye's side a path allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EyeSide {
    /// (1)
    Lens,
    /// (2)
    MultiChain,
}

impl EyeSide {
    /// The mutation that makes it.
    pub(super) fn mutation(self) -> Mutation {
        match self {
            EyeSide::Lens => Mutation::Lens,
            EyeSide::MultiChain => Mutation::MultiChain,
        }
    }
}

/// (1) or (2): which, by the form of the path alone, which they keep.
pub(super) fn eye_side(x: &Path) -> EyeSide {
    let first_d = x.turns.iter().rposition(|t| t.dirac.is_none());
    match first_d.and_then(|i| i.checked_sub(1)) {
        Some(next) if x.turns[next].dirac.is_some() => EyeSide::MultiChain,
        _ => EyeSide::Lens,
    }
}

/// (4), in pixels.
pub(super) fn radii(area: f64) -> [f64; 2] {
    [NEAREST, (AREA * area / std::f64::consts::PI).sqrt().max(2.0 * NEAREST)]
}

pub(super) fn between([low, high]: [f64; 2], draws: &mut Draws) -> f64 {
    high * (-(high / low).ln() * draws.f64()).exp()
}

/// `d` turned by θ in any direction.
pub(super) fn turned(d: Vec3, theta: f64, draws: &mut Draws) -> Vec3 {
    let frame = Frame::from_normal(d);
    let (sin, cos) = (theta as f32).sin_cos();
    let (y, x) = (TAU * draws.f32()).sin_cos();
    frame.to_world(Vec3::new(sin * x, sin * y, cos)).normalize()
}

/// (1) and (2).
pub(super) fn move_eye<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    which: EyeSide,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    if eye_side(x) != which {
        return None;
    }
    let (r, phi) = (between(radii(tracer.field.area()), draws) as f32, TAU * draws.f32());
    let film = x.sensed.film + Vec2::new(r * phi.cos(), r * phi.sin());
    if !tracer.field.has(film) {
        return None;
    }
    let lambda = x.lambda_of_all(tracer.scene);
    let (sensed, t_max) = tracer.see(film, x.sensed.lens, x.time);
    let mut turns = x.turns.clone();
    let mut source = x.source;
    let mut ray = sensed.ray;
    let mut limit = t_max;
    let mut i = x.len();
    // From the eye on: vertex by vertex, until what comes is not regrown.
    loop {
        i -= 1;
        let node = tracer.node(ray, limit, &lambda)?;
        limit = f32::INFINITY;
        let wo = -ray.d;
        let old = &x.turns[i];
        if let Some(dirac) = &old.dirac {
            let onward = tracer.turn(&node, wo, dirac.lobe, Mode::Radiance)?;
            turns[i] = Turn { node, dirac: onward.dirac };
            ray = onward.ray;
            if i == 0 {
                source = light_met(tracer, x, ray)?;
                break;
            }
            continue;
        }
        if !node.connects() {
            return None;
        }
        turns[i] = Turn { node: node.clone(), dirac: None };
        match i.checked_sub(1) {
            None => {
                source = tracer.again(&x.source.end, &node.surface, &lambda)?;
                break;
            }
            Some(next) if x.turns[next].dirac.is_none() => {
                if !tracer.sees(&x.turns[next].node, &node) {
                    return None;
                }
                break;
            }
            // (2)
            Some(next) => {
                let old_d = toward(old.node.p(), x.turns[next].node.p());
                ray = node.surface.spawn(turned(old_d, between(ANGLES, draws), draws));
            }
        }
    }
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, sensed)?;
    // (5); where nothing was connected, x₀ was regrown too.
    let regrown = |path: &Path| {
        let g = (i + 1..path.len()).map(|k| path.turns[k - 1].node.g(path.turns[k].node.p()));
        let g: f64 = g.product();
        match i == 0 && path.turns[0].dirac.is_some() {
            true => g * path.source.end.area(path.turns[0].node.p()),
            false => g,
        }
    };
    let (there, back) = (x.f * regrown(&y), y.f * regrown(x));
    Some(Proposal { path: y, there, back })
}

/// The light that a path through Dirac lobes alone meets at its end: the same as before.
fn light_met<'a>(tracer: &mut Tracer<'a>, x: &Path<'a>, ray: Ray) -> Option<Source> {
    let lambda = x.lambda_of_all(tracer.scene);
    let source = match tracer.meet(ray, f32::INFINITY, &lambda)? {
        Met::Surface(node) => tracer.found(&node, &lambda),
        Met::Nothing(ray) => {
            let is_it = |id: &_| *id == x.source.end.light;
            let nth = tracer.scene.environments.iter().position(is_it)?;
            tracer.escaped(&ray, nth, &lambda)
        }
    };
    source.filter(|s| s.end.infinite == x.source.end.infinite)
}

/// (3).
pub(super) fn move_caustic<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let n = x.len();
    if x.turns[n - 1].dirac.is_some() || !x.sensed.end.seen {
        return None;
    }
    // The vertex (from 1; 0 is the light) whose direction moves.
    let base = (1..n).rev().find(|&i| x.turns[i - 1].dirac.is_none()).unwrap_or(0);
    let end = &x.source.end;
    if base == 0 && end.infinite {
        return None;
    }
    let from =
        |path: &Path| if base == 0 { path.source.end.p } else { path.turns[base - 1].node.p() };
    let scale = |path: &Path| scale(path, from(path), base, tracer.measure.pixels);
    let [low, high] = radii(tracer.field.area());
    let scale_x = scale(x)?;
    let theta = between([low * scale_x, high * scale_x], draws);
    if theta > 1.5 {
        return None;
    }
    let lambda = x.lambda_of_all(tracer.scene);
    let old_d = toward(from(x), x.turns[base].node.p());
    let d = turned(old_d, theta, draws);
    let mut ray = match base {
        0 => leaving(x, d),
        _ => x.turns[base - 1].node.surface.spawn(d),
    };
    let mut turns = x.turns.clone();
    for i in base..n {
        let node = tracer.node(ray, f32::INFINITY, &lambda)?;
        let dirac = match &x.turns[i].dirac {
            Some(dirac) => {
                let onward = tracer.turn(&node, -ray.d, dirac.lobe, Mode::Importance)?;
                ray = onward.ray;
                onward.dirac
            }
            None if node.connects() => None,
            None => return None,
        };
        turns[i] = Turn { node, dirac };
    }
    let source = match base {
        0 => tracer.again(end, &turns[0].node.surface, &lambda)?,
        _ => x.source,
    };
    let last = turns[n - 1].node.clone();
    let sensed: Sensed = tracer.ask_lens(&last, x.sensed.lens, x.time)?;
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, sensed)?;
    // (6)
    let regrown = |path: &Path| {
        let mut t = 1.0;
        let mut p = from(path);
        for turn in &path.turns[base..] {
            t *= turn.node.g(p) * turn.dirac.as_ref().map_or(1.0, |d| d.jacobian);
            p = turn.node.p();
        }
        let last = &path.turns[n - 1].node;
        t / path.sensed.end.departure.density_at(last.p(), last.surface.ng)
    };
    // Could y go back to x?
    let scale_y = self::scale(&y, from(&y), base, measure.pixels)?;
    let returns = (low * scale_y..=high * scale_y).contains(&theta);
    let (there, back) = (x.f * regrown(&y), if returns { y.f * regrown(x) } else { 0.0 });
    Some(Proposal { path: y, there, back })
}

/// Radians at the vertex before `base` that move the film by about a pixel.
fn scale(path: &Path, from: Vec3, base: usize, pixels: f64) -> Option<f64> {
    let mut chain = 0.0;
    let mut p = from;
    for turn in &path.turns[base..] {
        chain += f64::from((turn.node.p() - p).length());
        p = turn.node.p();
    }
    let pixel = match path.sensed.end.departure {
        Departure::Point { p: lens, pdf_w } => {
            f64::from((p - lens).length()) / (pdf_w * pixels).sqrt()
        }
        Departure::Parallel { pdf_a, .. } => 1.0 / (pdf_a * pixels).sqrt(),
        Departure::Fixed => return None,
    };
    Some(pixel / chain).filter(|s| s.is_finite() && *s > 0.0)
}

/// A ray from the path's light along `d`.
pub(super) fn leaving(x: &Path, d: Vec3) -> Ray {
    let end = &x.source.end;
    let error = (end.p.abs() + Vec3::splat(1e-3)) * 1e-6;
    Ray { o: offset_origin(end.p, error, end.n, d), d, time: x.time }
}

/// True of what scatters, by the path's form.
pub(super) fn is_d(x: &Path, i: usize) -> bool {
    x.turns[i].dirac.is_none()
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
