//! The manifold perturbation (Jakob & Marschner 2012): a vertex that scatters moves a little, and the mirrors
//! and interfaces between it and a neighbour that stays follow.
//!
//! ```text
//! a  S*  b  S+  c         a, c: D or an end; from the light, or from the eye                    (1)
//! the direction at a (at the lens: the film's place) moves, and is traced to b′
//! S′ between c and b′     by Newton's method on ∂S₁/∂b, S₁ next to c                        (2)
//! T(x→y) = Π_{a…b} g→ᵢ J_i  or  Π_{a…b} g←ᵢ  of the vertices beyond a                         (3)
//!          · Π_{e…l} g←ᵢ / D,   D = |∂ω_e/∂x_l| = |∂S₁/∂x_l| g(S₁), S₁ next to e                 (4)
//! ```
//!
//! e is that of b and c which lies toward the eye, l the other. F has a g for each of the vertices between
//! them, as if the chain had been traced from e (see `path.rs`); (4) says what it is of x_l's area. The walk of (2)
//! must lead back, or y can't go to x.

use super::mutation::Proposal;
use super::path::{Node, Path, Sensed, Source, Turn, toward};
use super::perturbation::{between, follow, is_d, leaving, radii, turned};
use super::specular::{Interface, Place, first_by_last};
use super::tracer::Tracer;
use crate::metropolis::Draws;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::bsdf::Mode;
use kaustika_spectra::Wavelengths;
use std::f32::consts::TAU;

/// Smallest and largest angle by which the direction at a moves, radians.
const ANGLES: [f64; 2] = [1e-4, 0.1];
/// Steps of Newton's method.
const STEPS: u32 = 20;
/// How near b′ the walk must come, and how near its start it must lead back, over the chain's length.
const NEAR: f32 = 2e-5;
const BACK: f32 = 1e-3;

/// Which vertices (from 0) a move is about. Ends are −1 (the light) and n (the lens).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Move {
    a: isize,
    b: usize,
    c: isize,
}

impl Move {
    /// All moves that a path's form allows.
    fn all(x: &Path) -> Vec<Move> {
        let n = x.len() as isize;
        let ds: Vec<isize> = std::iter::once(-1)
            .chain((0..n).filter(|&i| is_d(x, i as usize)))
            .chain(std::iter::once(n))
            .collect();
        let mut moves = Vec::new();
        for w in ds.windows(3) {
            let [before, b, after] = [w[0], w[1], w[2]];
            let mut add = |a: isize, c: isize| {
                if (c - b).abs() > 1 {
                    moves.push(Move { a, b: b as usize, c });
                }
            };
            add(before, after);
            add(after, before);
        }
        // Ends of which (4) is not known.
        let end = &x.source.end;
        moves.retain(|m| {
            (m.a != -1 || !end.infinite) && (m.c != -1 || end.hittable && !end.infinite)
        });
        moves.retain(|m| m.c != n || x.sensed.end.seen);
        moves
    }

    /// True if a is on the eye's side of b.
    fn goes_from_eye(self) -> bool {
        self.a > self.b as isize
    }

    /// S between b and c, from c on.
    fn chain(self) -> Vec<usize> {
        let b = self.b as isize;
        match self.c < b {
            true => (self.c + 1..b).map(|i| i as usize).collect(),
            false => (b + 1..self.c).rev().map(|i| i as usize).collect(),
        }
    }
}

/// A perturbation of one of the vertices that may move.
pub(super) fn propose<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let moves = Move::all(x);
    let m = *moves.get(draws.below(moves.len()))?;
    let lambda = x.lambda_of_all(tracer.scene);
    let mut y = x.clone();
    move_b(tracer, x, &mut y, m, &lambda, draws)?;
    let target = y.turns[m.b].node.clone();
    let chain = m.chain();
    let there = walk(tracer, x, m, &x.turns, &target, &lambda)?;
    for (&i, turn) in chain.iter().zip(there) {
        y.turns[i] = turn;
    }
    // Does it lead back?
    let back = walk(tracer, x, m, &y.turns, &x.turns[m.b].node, &lambda)?;
    let length = length_of(x, m);
    let same = |(i, turn): (&usize, &Turn)| {
        (turn.node.p() - x.turns[*i].node.p()).length() < BACK * length
    };
    if !chain.iter().zip(&back).all(same) {
        return None;
    }
    connect(tracer, x, &mut y, m, &lambda)?;
    let Path { source, turns, sensed, .. } = y;
    let measure = tracer.measure;
    let y = Path::new(&measure, (x.u_lambda, x.time), source, turns, sensed)?;
    let (there, back) = (x.f * density(tracer, &y, m)?, y.f * density(tracer, x, m)?);
    Some(Proposal { path: y, there, back })
}

/// The direction at a moves, and b with it.
fn move_b<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    y: &mut Path<'a>,
    m: Move,
    lambda: &Wavelengths,
    draws: &mut Draws,
) -> Option<()> {
    let n = x.len();
    let (mut t_max, mut mode) = (f32::INFINITY, Mode::Radiance);
    let ray;
    if m.a == n as isize {
        let r = between(radii(tracer.field.area()), draws) as f32;
        let phi = TAU * draws.f32();
        let film = x.sensed.film + Vec2::new(r * phi.cos(), r * phi.sin());
        if !tracer.field.has(film) {
            return None;
        }
        (y.sensed, t_max) = tracer.see(film, x.sensed.lens, x.time);
        ray = y.sensed.ray;
    } else {
        let theta = between(ANGLES, draws);
        ray = match (usize::try_from(m.a), m.goes_from_eye()) {
            (Ok(a), true) => x.turns[a].node.surface.spawn(turned(-x.to_eye(a - 1), theta, draws)),
            (Ok(a), false) => {
                mode = Mode::Importance;
                x.turns[a].node.surface.spawn(turned(-x.to_light(a + 1), theta, draws))
            }
            (Err(_), _) => {
                mode = Mode::Importance;
                let d = toward(x.source.end.p, x.turns[0].node.p());
                leaving(x, turned(d, theta, draws))
            }
        };
    }
    match m.goes_from_eye() {
        true => {
            follow(tracer, x, (ray, t_max), (m.b..m.a as usize).rev(), mode, lambda, &mut y.turns)
        }
        false => {
            let way = (m.a + 1) as usize..=m.b;
            follow(tracer, x, (ray, t_max), way, mode, lambda, &mut y.turns)
        }
    }
}

/// A point and a normal at c, or where c is the lens the direction to the chain.
fn place_of_c(x: &Path, m: Move) -> Place {
    match usize::try_from(m.c) {
        Err(_) => Place::new(x.source.end.p, x.source.end.n),
        Ok(c) if c == x.len() => Place::new(x.sensed.ray.o, x.sensed.ray.d),
        Ok(c) => Place::new(x.turns[c].node.p(), x.turns[c].node.surface.ng),
    }
}

/// Length of the chain from c to b.
fn length_of(x: &Path, m: Move) -> f32 {
    let mut from = place_of_c(x, m).p;
    let mut length = 0.0;
    for i in m.chain().into_iter().chain([m.b]) {
        let p = x.turns[i].node.p();
        length += (p - from).length();
        from = p;
    }
    length
}

/// The vertices of a chain from c on, each with its indices of refraction before and after it.
fn interfaces<'n, 'a>(
    turns: &'n [Turn<'a>],
    chain: &[usize],
    toward_eye: bool,
) -> Vec<Interface<'n, 'a>> {
    let one = |&i: &usize| {
        let Turn { node, dirac } = &turns[i];
        let eta = dirac.map_or(1.0, |d| d.eta);
        // η of the light's side over that of the eye's.
        (&**node, if toward_eye { [eta, 1.0] } else { [1.0, eta] })
    };
    chain.iter().map(one).collect()
}

/// (2): the chain from c to `target`, by steps from the one that `start` has; c's side first.
fn walk<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    m: Move,
    start: &[Turn<'a>],
    target: &Node<'a>,
    lambda: &Wavelengths,
) -> Option<Vec<Turn<'a>>> {
    let chain = m.chain();
    let toward_eye = m.c < m.b as isize;
    let mode = if toward_eye { Mode::Importance } else { Mode::Radiance };
    let first = place_of_c(x, m);
    let near = NEAR * length_of(x, m);
    let mut turns = start.to_vec();
    let mut landing = start[m.b].node.clone();
    let mut distance = (target.p() - landing.p()).length();
    let mut share = 1.0;
    for _ in 0..STEPS {
        if distance < near {
            return Some(chain.iter().map(|&i| turns[i].clone()).collect());
        }
        let last = Place::new(landing.p(), landing.surface.ng);
        let all = interfaces(&turns, &chain, toward_eye);
        let by_last = first_by_last(&tracer.scene.geometry, first, &all, last)?;
        let [s, t] = by_last.of(last.local(target.p() - landing.p()));
        let next = &turns[chain[0]].node;
        let tangents = Place::new(next.p(), next.surface.ng).tangents;
        let step = tangents[0] * s as f32 + tangents[1] * t as f32;
        let aim = next.p() + step * share;
        let mut tried = turns.clone();
        let ray = from_c(x, m, toward(first.p, aim));
        let met = follow(
            tracer,
            x,
            (ray, f32::INFINITY),
            chain.iter().copied(),
            mode,
            lambda,
            &mut tried,
        )
        .and_then(|()| {
            let (before, at) = (chain.iter().rev().nth(1), &tried[*chain.last()?]);
            let from = before.map_or(first.p, |&i| tried[i].node.p());
            let wo = toward(at.node.p(), from);
            let onward = tracer.turn(&at.node, wo, at.dirac?.lobe, mode)?;
            tracer.node(onward.ray, f32::INFINITY, lambda)
        });
        match met {
            Some(node) if (target.p() - node.p()).length() < distance => {
                distance = (target.p() - node.p()).length();
                (turns, landing) = (tried, node);
                share = f32::min(1.0, 2.0 * share);
            }
            _ => share *= 0.5,
        }
    }
    None
}

/// A ray from c along `d`.
fn from_c(x: &Path, m: Move, d: Vec3) -> Ray {
    match usize::try_from(m.c) {
        Err(_) => leaving(x, d),
        Ok(c) if c == x.len() => Ray { d, ..x.sensed.ray },
        Ok(c) => x.turns[c].node.surface.spawn(d),
    }
}

/// The ends of y, asked for where something next to them moved.
fn connect<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    y: &mut Path<'a>,
    m: Move,
    lambda: &Wavelengths,
) -> Option<()> {
    let n = x.len();
    if m.a == -1 || m.c == -1 {
        let source: Source =
            tracer.again(&x.source.end, &y.turns[0].node.surface.clone(), lambda)?;
        y.source = source;
    }
    if m.c == n as isize {
        let last = y.turns[n - 1].node.clone();
        let sensed: Sensed = tracer.ask_lens(&last, x.sensed.lens, x.time)?;
        y.sensed = sensed;
    }
    Some(())
}

/// (3) and (4).
fn density(tracer: &Tracer, path: &Path, m: Move) -> Option<f64> {
    let n = path.len();
    let g = |i: usize, from: Vec3| path.turns[i].node.g(from);
    let p = |i: usize| path.turns[i].node.p();
    let mut t = 1.0;
    // (3)
    match m.goes_from_eye() {
        true => {
            for i in m.b..(m.a as usize).min(n - 1) {
                t *= g(i, p(i + 1));
            }
        }
        false => {
            let mut from = usize::try_from(m.a).map_or(path.source.end.p, p);
            for i in (m.a + 1) as usize..=m.b {
                t *= g(i, from) * path.turns[i].dirac.map_or(1.0, |d| d.jacobian);
                from = p(i);
            }
        }
    }
    // (4), from e on.
    let chain = m.chain();
    let geometry = &tracer.scene.geometry;
    let b = &path.turns[m.b].node;
    let of_b = Place::new(b.p(), b.surface.ng);
    let of_c = place_of_c(path, m);
    let (e, l, chain): (Place, Place, Vec<usize>) = match m.c < m.b as isize {
        true => (of_b, of_c, chain.into_iter().rev().collect()),
        false => (of_c, of_b, chain),
    };
    let first = first_by_last(geometry, e, &interfaces(&path.turns, &chain, false), l)?;
    // g of S₁ from e is on both sides of the fraction; from the lens F has none.
    for w in chain.windows(2) {
        t *= g(w[1], p(w[0]));
    }
    let last = p(*chain.last()?);
    t *= match m.c {
        -1 => path.source.end.area(last),
        c if c < m.b as isize => g(c as usize, last),
        _ => g(m.b, last),
    };
    if m.c == n as isize {
        let s = &path.turns[chain[0]].node;
        t /= path.sensed.end.departure.density_at(s.p(), s.surface.ng);
    }
    Some(t / first.det().abs())
}
