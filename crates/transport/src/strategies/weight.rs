//! The weight of one strategy among all that can make the same path.
//!
//! ```text
//! q_s = Π_{i<s} P→ᵢ · Π_{i≥s} P←ᵢ,     w_s = h(q_s; q_0 … q_{k+1})                     (1)
//! ```
//!
//! s vertices come from the light, t = k + 1 - s from the eye. Where the light is asked for from
//! x₁ (s = 1) its density is p_D instead of P→₀, where the lens is asked for from xₖ₋₁ (t = 1) it
//! is p_C instead of P←ₖ; light paths count n times (Veach 1997, sec. 10.2; densities are those of
//! [`crate::path_space`]). A strategy cannot make the path if it would have to join a vertex that
//! scatters by a Dirac lobe, to find a light without extent or to meet a lens without one.

use kaustika_sampling::Heuristic;

/// Densities of one vertex of a path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Link {
    /// P→: from the light's side.
    pub light: f64,
    /// P←: from the eye's side.
    pub eye: f64,
    /// True if the path goes on there by a Dirac lobe.
    pub delta: bool,
}

/// What else decides which strategies are possible.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// p_D.
    pub next_event: f64,
    /// p_C.
    pub connection: f64,
    /// s = 0 is possible.
    pub hittable_light: bool,
    /// t = 0 is possible.
    pub hittable_lens: bool,
    /// t ≤ 1 is possible: the path is in the picture.
    pub seen: bool,
    /// n: light paths for each camera path.
    pub light_paths: f64,
}

/// w_s of (1) for the path x₀ … xₖ with these `links`; `q` is room to work in.
pub fn strategy_weight(
    links: &[Link],
    joint: &Joint,
    s: usize,
    heuristic: Heuristic,
    q: &mut Vec<f32>,
) -> f32 {
    let k = links.len() - 1;
    // Lights that are seen directly are left to the eye.
    if k < 2 {
        return if s == 0 { 1.0 } else { 0.0 };
    }
    // Inner vertices, as multiples of their product in strategy s.
    let step = |i: usize| links[i].light / links[i].eye;
    let inner = |i: usize| {
        let (s, i) = (s.clamp(1, k), i.clamp(1, k));
        let up: f64 = (s..i.max(s)).map(step).product();
        let down: f64 = (i.min(s)..s).map(|j| links[j].eye / links[j].light).product();
        up * down
    };
    let density = |i: usize| {
        let first = match i {
            0 => links[0].eye,
            1 => joint.next_event,
            _ => links[0].light,
        };
        let last = match k + 1 - i {
            0 => links[k].light * joint.light_paths,
            1 => joint.connection * joint.light_paths,
            _ => links[k].eye,
        };
        first * last
    };
    let possible = |i: usize| match i {
        0 => joint.hittable_light,
        i if i == k + 1 => joint.hittable_lens && joint.seen,
        i => {
            let dirac = i >= 2 && links[i - 1].delta || i < k && links[i].delta;
            !dirac && (i < k || joint.seen)
        }
    };
    let own = density(s);
    q.clear();
    q.extend((0..k + 2).map(|i| match possible(i) {
        true if i == s => 1.0,
        true => (density(i) / own * inner(i)) as f32,
        false => 0.0,
    }));
    heuristic.weight(s, q)
}
