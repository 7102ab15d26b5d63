//! The bidirectional mutation (Veach & Guibas 1997, sec. 5.3.1): a part of the path is deleted, and
//! as much, or a little more or less, is grown anew from the ends that are left.
//!
//! ```text
//! x keeps a vertices on the light's side and b on the eye's, of its n inner ones      (none: that end goes too)
//! p_d(a, b | n) = ε [a = b = 0] + (1 - ε) 2^-d / Σ 2^-d,    d vertices deleted         (1)
//! p_e(e) ∝ 2^-|e - (n - a - b)|,                            e inner ones made          (2)
//! f(x) T(x→y) ∝ f(x) p_d p_e Σ_s p(s) q_s(y)               s over all ways to make them  (3)
//! ```
//!
//! The densities of what is kept are the same in both directions and cancel.

use super::mutation::Proposal;
use super::path::{Path, Sensed, Source, Turn, toward};
use super::tracer::{Met, Tracer};
use crate::metropolis::Draws;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::bsdf::Mode;
use kaustika_spectra::Wavelengths;

/// ε of (1).
const WHOLE: f64 = 0.1;
/// Ratio of the probabilities of n + 1 and n inner vertices where all is made anew.
const LONGER: f64 = 0.7;

/// Numbers of inner vertices that paths may have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lengths {
    pub(super) fewest: usize,
    pub(super) most: usize,
}

/// What is kept: inner vertices on the light's side and on the eye's.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    a: usize,
    b: usize,
}

impl Cut {
    const NOTHING: Cut = Cut { a: 0, b: 0 };

    /// 2^-d.
    fn weight(self, n: usize) -> f64 {
        let ends = usize::from(self.a == 0) + usize::from(self.b == 0);
        0.5f64.powi((n - self.a - self.b + ends) as i32)
    }

    /// All of a path of n inner vertices.
    fn all(n: usize) -> impl Iterator<Item = Cut> {
        (0..=n).flat_map(move |a| (0..=n - a).map(move |b| Cut { a, b }))
    }

    /// (1)
    fn probability(self, n: usize) -> f64 {
        let sum: f64 = Cut::all(n).map(|c| c.weight(n)).sum();
        let whole = if self == Cut::NOTHING { WHOLE } else { 0.0 };
        whole + (1.0 - WHOLE) * self.weight(n) / sum
    }

    fn choose(n: usize, draws: &mut Draws) -> Cut {
        if draws.f64() < WHOLE {
            return Cut::NOTHING;
        }
        let sum: f64 = Cut::all(n).map(|c| c.weight(n)).sum();
        let mut rest = draws.f64() * sum;
        for cut in Cut::all(n) {
            rest -= cut.weight(n);
            if rest < 0.0 {
                return cut;
            }
        }
        Cut::NOTHING
    }

    /// Weights of (2), of e = 0, 1, …; of nothing kept a decay with length.
    fn added(self, n: usize, lengths: Lengths) -> impl Iterator<Item = (usize, f64)> + Clone {
        let Cut { a, b } = self;
        let old = n - a - b;
        // Nothing deleted and nothing made is the same path.
        let fewest =
            lengths.fewest.saturating_sub(a + b).max(usize::from(a > 0 && b > 0 && old == 0));
        (fewest..=lengths.most.saturating_sub(a + b)).map(move |e| {
            let weight = match self == Cut::NOTHING {
                true => LONGER.powi(e as i32),
                false => 0.5f64.powi(e.abs_diff(old) as i32),
            };
            (e, weight)
        })
    }

    /// (2)
    fn p_added(self, n: usize, e: usize, lengths: Lengths) -> f64 {
        let all = self.added(n, lengths);
        let sum: f64 = all.clone().map(|(_, w)| w).sum();
        all.filter(|&(k, _)| k == e).map(|(_, w)| w / sum).sum()
    }

    fn choose_added(self, n: usize, lengths: Lengths, draws: &mut Draws) -> Option<usize> {
        let all = self.added(n, lengths);
        let sum: f64 = all.clone().map(|(_, w)| w).sum();
        let mut rest = draws.f64() * sum;
        for (e, w) in all {
            rest -= w;
            if rest < 0.0 {
                return Some(e);
            }
        }
        None
    }

    /// Fewest and most vertices from the light of a path with `n` inner ones.
    fn splits(self, n: usize) -> [usize; 2] {
        let fewest = if self.a == 0 { 0 } else { 1 + self.a };
        let most = if self.b == 0 { n + 1 } else { n + 1 - self.b };
        [fewest, most]
    }

    /// Σ p(s) q_s of (3).
    fn density(self, y: &Path) -> f64 {
        let [fewest, most] = self.splits(y.len());
        y.q[fewest..=most].iter().sum::<f64>() / (most - fewest + 1) as f64
    }
}

/// The mutation of x.
pub(super) fn propose<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    lengths: Lengths,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    let n = x.len();
    let cut = Cut::choose(n, draws);
    let e = cut.choose_added(n, lengths, draws)?;
    let y = grow(tracer, x, cut, e, draws)?;
    let flow = |x: &Path, y: &Path| {
        let (n, e) = (x.len(), y.len() - cut.a - cut.b);
        x.f * cut.probability(n) * cut.p_added(n, e, lengths) * cut.density(y) // (3)
    };
    let (there, back) = (flow(x, &y), flow(&y, x));
    Some(Proposal { path: y, there, back })
}

/// Keeps what `cut` says of x, and makes `e` inner vertices and the ends that are missing.
fn grow<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    cut: Cut,
    e: usize,
    draws: &mut Draws,
) -> Option<Path<'a>> {
    let Cut { a, b } = cut;
    let n = a + b + e;
    let (u_lambda, time) = match cut == Cut::NOTHING {
        false => (x.u_lambda, x.time),
        true => (draws.f32(), draws.f32()),
    };
    let lambda = Wavelengths::sample_for(tracer.scene.mode, u_lambda);
    let [fewest, most] = cut.splits(n);
    let s = fewest + draws.below(most - fewest + 1);

    // The light's side, from the light on.
    let mut source = None;
    let mut turns: Vec<Turn> = Vec::with_capacity(n);
    let of_light = s.saturating_sub(1);
    if a > 0 {
        source = Some(x.source);
        turns.extend_from_slice(&x.turns[..a]);
        turns[a - 1].dirac = None;
    } else if s >= 2 {
        let (light, node) = tracer.emit(&lambda, time, draws)?;
        source = Some(light);
        turns.push(Turn { node, dirac: None });
    }
    while turns.len() < of_light {
        let i = turns.len() - 1;
        let node = turns[i].node.clone();
        let onward =
            tracer.scatter(&node, -came(&turns, source.as_ref(), i), Mode::Importance, draws)?;
        turns[i].dirac = onward.dirac;
        let node = tracer.node(onward.ray, f32::INFINITY, &lambda)?;
        turns.push(Turn { node, dirac: None });
    }

    // The eye's side, from the lens on.
    let of_eye = n - turns.len();
    let mut sensed = None;
    let mut eye: Vec<Turn> = Vec::with_capacity(of_eye);
    if b > 0 {
        sensed = Some(x.sensed);
        eye.extend(x.turns[x.len() - b..].iter().rev().cloned());
        eye[b - 1].dirac = None;
    } else if of_eye > 0 || s == 0 {
        let film = tracer.field.place(Vec2::new(draws.f32(), draws.f32()));
        let (camera, t_max) = tracer.see(film, Vec2::new(draws.f32(), draws.f32()), time);
        sensed = Some(camera);
        let node = tracer.node(camera.ray, t_max, &lambda)?;
        eye.push(Turn { node, dirac: None });
    }
    let toward_eye = |eye: &[Turn], sensed: &Option<Sensed>, i: usize| match i {
        0 => sensed.map(|c| -c.ray.d),
        _ => Some(toward(eye[i].node.p(), eye[i - 1].node.p())),
    };
    while eye.len() < of_eye {
        let i = eye.len() - 1;
        let node = eye[i].node.clone();
        let wo = toward_eye(&eye, &sensed, i)?;
        let onward = tracer.scatter(&node, wo, Mode::Radiance, draws)?;
        eye[i].dirac = onward.dirac;
        let node = tracer.node(onward.ray, f32::INFINITY, &lambda)?;
        eye.push(Turn { node, dirac: None });
    }

    // What joins them.
    let connects = |turn: &Turn| turn.node.connects();
    match (s, of_eye) {
        (0, _) => {
            let i = eye.len() - 1;
            let node = eye[i].node.clone();
            let wo = toward_eye(&eye, &sensed, i)?;
            let onward = tracer.scatter(&node, wo, Mode::Radiance, draws)?;
            eye[i].dirac = onward.dirac;
            source = match tracer.meet(onward.ray, f32::INFINITY, &lambda)? {
                Met::Surface(node) => tracer.found(&node, &lambda),
                Met::Nothing(ray) => {
                    let nth = draws.below(tracer.scene.environments.len());
                    tracer.escaped(&ray, nth, &lambda)
                }
            };
        }
        (1, _) => {
            let i = eye.len() - 1;
            if !connects(&eye[i]) {
                return None;
            }
            source = tracer.ask(&eye[i], &lambda, draws);
        }
        (_, 0) => {
            let last = turns.last().filter(|t| connects(t))?.node.clone();
            let lens = Vec2::new(draws.f32(), draws.f32());
            sensed = tracer.ask_lens(&last, lens, time);
        }
        _ => {
            let (y, z) = (turns.last()?, eye.last()?);
            if !connects(y) || !connects(z) || !tracer.sees(&y.node, &z.node) {
                return None;
            }
        }
    }
    turns.extend(eye.into_iter().rev());
    let measure = tracer.measure;
    Path::new(&measure, (u_lambda, time), source?, turns, sensed?)
}

/// From where vertex `i` of the light's side came, as a direction to it.
fn came(turns: &[Turn], source: Option<&Source>, i: usize) -> Vec3 {
    match (i, source) {
        (0, Some(source)) if source.end.infinite => source.end.w,
        (0, Some(source)) => toward(source.end.p, turns[0].node.p()),
        _ => toward(turns[i - 1].node.p(), turns[i].node.p()),
    }
}
