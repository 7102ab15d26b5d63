//! The light below a coat by random walks (Guo, Hašan & Zhao 2018; pbrt-v4, sec. 14.3).
//!
//! A walk enters from one direction; the other one is refracted into the coat once, to w₂, and
//! every event of the walk is connected to it. At a metallic base under a rough coat the walk's
//! own next direction is connected too, through the coat's surface, and the first reflection is
//! also found from the other end. These techniques are weighted by the power heuristic (Veach
//! 1997, eq. 9.13).
//!
//! ```text
//! β = Π f |cos|/pdf along the walk,  β₂ of the refraction to w₂
//! scattering  β albedo p(w, w₂) τ(z, w₂) β₂/|cos w₂| · C                                (1)
//! base        β f_base(w, w₂) τ(thickness, w₂) β₂ · weight                              (2)
//! through     β τ(thickness, w) f_t(ω_b, w) · weight                                    (3)
//! from b      β₂ τ(thickness, w₂) β_base τ(thickness, w) f_t(ω_a, w) · weight            (4)
//! ```
//!
//! Between a smooth coat and a mirror nothing connects the paths that leave by reflections only:
//! (1) then adds those that go down first, and C sums the rounds between coat and mirror.

use super::{Base, Layered, geometric};
use crate::bsdf::fresnel::fresnel_dielectric;
use crate::bsdf::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, mix_bits, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;

const TRANSMISSION: Lobes = Lobes(Lobes::GLOSSY_TRANSMISSION.0 | Lobes::DELTA_TRANSMISSION.0);
const REFLECTION: Lobes = Lobes(Lobes::GLOSSY_REFLECTION.0 | Lobes::DELTA_REFLECTION.0);
/// Events before roulette may end a walk, and the throughput below which it does.
const ROULETTE_FROM: u32 = 4;
const ROULETTE_BELOW: f32 = 0.25;

/// The mean of `samples` walks between two directions from above, symmetric in them.
pub(super) fn average<B: Base>(layered: &Layered<B>, wo: Vec3, wi: Vec3) -> Spectrum {
    let bits = |w: Vec3| [w.z + 0.0, w.x + 0.0, w.y + 0.0].map(f32::to_bits);
    let (a, b) = if bits(wo) <= bits(wi) { (wo, wi) } else { (wi, wo) };
    let seed = bits(a)
        .into_iter()
        .chain(bits(b))
        .fold(mix_bits(layered.coat.salt), |h, v| mix_bits(h.rotate_left(5) ^ v as u64));
    let mut numbers = Numbers { state: seed };
    let n = layered.coat.samples;
    let sum = (0..n).fold(Spectrum::ZERO, |sum, _| sum + walk(layered, a, b, &mut numbers));
    sum / (n as f32 * sqr(layered.coat.ior))
}

/// Uniform numbers of one evaluation.
struct Numbers {
    state: u64,
}

impl Numbers {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix_bits(self.state) >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
    }

    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        let x = self.next_1d();
        Vec2::new(x, self.next_1d())
    }
}

/// The power heuristic's weight of a density among others.
#[inline]
fn power(p: f32, q: f32, r: f32) -> f32 {
    sqr(p) / (sqr(p) + sqr(q) + sqr(r))
}

/// Transmittance of matter of this depth along `w`.
#[inline]
fn passage(depth: f32, w: Vec3) -> f32 {
    (-depth / w.z.abs()).exp()
}

/// One walk from `a` to `b`, without 1/η²: importance mode everywhere.
fn walk<B: Base>(l: &Layered<B>, a: Vec3, b: Vec3, r: &mut Numbers) -> Spectrum {
    let mode = Mode::Importance;
    let thickness = l.coat.thickness;
    let scatters = !l.coat.albedo.is_black();
    let connects = !l.has_mirror();
    let passes_through = !l.is_smooth() && l.base.facets().is_some();
    let ideal = l.is_smooth() && l.has_mirror();

    let enter = l.surface.sample(a, 0.5, r.next_2d(), mode, TRANSMISSION);
    let leave = l.surface.sample(b, 0.5, r.next_2d(), mode, TRANSMISSION);
    let mut value = Spectrum::ZERO;
    if passes_through && let Some(leave) = leave {
        value += from_the_end(l, a, &leave, r);
    }
    let Some(enter) = enter else { return value };
    if leave.is_none() && !passes_through {
        return value;
    }
    // One round of the way out between coat and mirror, from the coat's surface and back.
    let round = leave.filter(|_| ideal).map_or(Spectrum::ZERO, |s| l.mirrored(-s.wi));
    let round_again = round * fresnel_dielectric(b.z, l.coat.ior).reflectance;

    let (mut beta, mut w) = (enter.weight, enter.wi);
    // Depth below the coat's surface.
    let mut z = 0.0;
    for event in 0..l.coat.max_depth {
        let most = beta.max_component();
        if event >= ROULETTE_FROM && most < ROULETTE_BELOW {
            if r.next_1d() >= most {
                break;
            }
            beta /= most;
        }
        if w.z == 0.0 {
            break;
        }

        // Scattered on the way?
        if scatters {
            z -= -(1.0 - r.next_1d()).ln() * w.z;
            if z > 0.0 && z < thickness {
                beta *= l.coat.albedo;
                if let Some(leave) = leave {
                    let up = -leave.wi;
                    let phase = |out: Vec3| henyey_greenstein(w.dot(out), l.coat.g);
                    let mut out = Spectrum::splat(phase(up) * passage(z, up));
                    if ideal {
                        let rest = l.coat.max_depth - 1 - event;
                        let down = phase(Vec3::new(up.x, up.y, -up.z)) / passage(z, up);
                        out = out * geometric(round_again, rest / 2 + 1)
                            + round * geometric(round_again, rest.div_ceil(2)) * down;
                    }
                    value += beta * leave.weight * out / up.z; // (1)
                }
                w = sample_henyey_greenstein(w, l.coat.g, r.next_2d());
                continue;
            }
        } else {
            beta *= passage(thickness, w);
        }
        z = if w.z < 0.0 { thickness } else { 0.0 };

        // Back from the coat's surface.
        if w.z > 0.0 {
            let Some(s) = l.surface.sample(-w, 0.5, r.next_2d(), mode, REFLECTION) else { break };
            beta *= s.weight;
            w = s.wi;
            continue;
        }

        // Reflected by the base. Densities below are over that of `enter`; (4) finds only the
        // first event.
        let from_end = |p: f32| if event == 0 { p / enter.pdf } else { 0.0 };
        if let Some(leave) = leave.filter(|_| connects) {
            let up = -leave.wi;
            let f = l.base.eval(-w, up, mode, Lobes::ALL) / up.z;
            let mut weight = passage(thickness, up);
            if passes_through {
                let (forward, reverse) = l.base.pdf(-w, up, mode, Lobes::ALL);
                weight *= power(leave.pdf, forward, from_end(leave.pdf * reverse));
            }
            value += beta * leave.weight * f * weight; // (2)
        }
        let Some(s) = l.base.sample(-w, r.next_1d(), r.next_2d(), mode, Lobes::ALL) else { break };
        beta *= s.weight;
        w = s.wi;
        if passes_through {
            let f = l.surface.eval(b, -w, mode, TRANSMISSION) * passage(thickness, w) / w.z;
            let leaves = l.surface.pdf(b, -w, mode, TRANSMISSION).0;
            let connected = if connects { leaves } else { 0.0 };
            value += beta * f * power(s.pdf, connected, from_end(leaves * s.pdf_rev)); // (3)
        }
    }
    value
}

/// (4): the paths of one reflection by the base, from `leave` to `a` through a rough coat.
fn from_the_end<B: Base>(l: &Layered<B>, a: Vec3, leave: &BsdfSample, r: &mut Numbers) -> Spectrum {
    let mode = Mode::Importance;
    let thickness = l.coat.thickness;
    let s = l.base.sample(-leave.wi, r.next_1d(), r.next_2d(), mode, Lobes::ALL);
    let Some(s) = s else { return Spectrum::ZERO };
    let enters = l.surface.pdf(a, -s.wi, mode, TRANSMISSION).0;
    let connected = if l.has_mirror() { 0.0 } else { enters * leave.pdf };
    let f = l.surface.eval(a, -s.wi, mode, TRANSMISSION) / s.wi.z;
    let factor = passage(thickness, leave.wi)
        * passage(thickness, s.wi)
        * power(leave.pdf * s.pdf, connected, enters * s.pdf_rev);
    leave.weight * s.weight * f * factor
}

/// The phase function for the cosine between directions of travel; ∫ p dω = 1.
fn henyey_greenstein(cos: f32, g: f32) -> f32 {
    let d = 1.0 + sqr(g) - 2.0 * g * cos;
    0.25 * INV_PI * (1.0 - sqr(g)) / (d * safe_sqrt(d)).max(1e-9)
}

/// A direction of travel after `w`, distributed as the phase function.
fn sample_henyey_greenstein(w: Vec3, g: f32, u: Vec2) -> Vec3 {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u.x
    } else {
        let ratio = (1.0 - sqr(g)) / (1.0 + g - 2.0 * g * u.x);
        ((1.0 + sqr(g) - sqr(ratio)) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = safe_sqrt(1.0 - sqr(cos));
    let (y, x) = (2.0 * PI * u.y).sin_cos();
    let (s, t) = w.coordinate_system();
    (s * (sin * x) + t * (sin * y) + w * cos).normalize()
}
