//! Collisions with a medium that varies: (3), delta tracking with majorants cell by cell
//! (Woodcock et al. 1965; Yue et al. 2010).

use super::{Shares, Stream, transmittance};
use kaustika_math::Ray;
use kaustika_scene::medium::{Coefficients, Medium};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A real collision.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// Along the ray.
    pub t: f32,
    /// What the medium is there.
    pub at: Coefficients,
}

/// Follows a ray from `t0` to `t1` in a medium whose coefficients vary, with `u` for the first
/// distance. Where it scatters; `None` if it passes, or if β has become black. `glow` gets what
/// the medium adds on the way, and the lanes' shares in the density of having found it.
#[expect(clippy::too_many_arguments)]
pub fn collide(
    medium: &Medium,
    ray: &Ray,
    (t0, t1): (f32, f32),
    lambda: &Wavelengths,
    u: f32,
    stream: &mut Stream,
    shares: &mut Shares,
    beta: &mut Spectrum,
    mut glow: impl FnMut(Spectrum, Spectrum),
) -> Option<Collision> {
    let hero = shares.hero;
    let mut rest = super::optical_distance(u);
    // T̄ since the last collision.
    let mut t_bar = Spectrum::ONE;
    for stretch in medium.stretches(ray, t0, t1, lambda) {
        let bar = stretch.majorant;
        let mut t = stretch.t0;
        while bar[hero] > 0.0 && rest < bar[hero] * (stretch.t1 - t) {
            let step = rest / bar[hero];
            t += step;
            t_bar *= transmittance(bar, step);
            let c = medium.at(ray.at(t), ray.d, lambda);
            let p = t_bar * bar;
            if !c.glow.is_black() {
                let mean = shares.mean(shares.path * p);
                glow(*beta * t_bar * c.glow / mean, shares.path * p / mean);
            }
            if medium.scatters && stream.draw() * bar[hero] < c.sigma_t[hero] {
                let (f, p) = (c.sigma_s * t_bar, c.sigma_t * t_bar);
                shares.event(beta, f, p, Spectrum::ZERO); // (3)
                return Some(Collision { t, at: c });
            }
            let null = (bar - c.sigma_t).clamp_zero() * t_bar;
            // What does not scatter needs no choice: the collision weakens the path.
            let chosen = if medium.scatters { null } else { p };
            shares.event(beta, null, chosen, p);
            if beta.is_black() {
                return None;
            }
            t_bar = Spectrum::ONE;
            rest = stream.distance();
        }
        let length = stretch.t1 - t;
        if bar[hero] > 0.0 {
            rest -= bar[hero] * length;
        }
        t_bar *= transmittance(bar, length);
    }
    shares.event(beta, t_bar, t_bar, t_bar);
    None
}
