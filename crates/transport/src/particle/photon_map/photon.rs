//! Photons as they are kept: 20 bytes each, of which the search structure holds the position.
//!
//! ```text
//! Φₖ ≈ mₖ 2^(e-136),  mₖ in 0..=255, one exponent for all four lanes (Ward 1991, RGBE)
//! mₖ = ⌊Φₖ 2^(136-e) + u⌋,  u in [0, 1) uniform, so that E[mₖ] is exact
//! ω ≈ centre of one of 256 × 256 cells of equal area (Clarberg 2008)
//! ```
//!
//! Photons of equal power are rounded alike: to the nearest mantissa, all of them would be wrong by
//! the same, up to 0.4 %, more in a dim lane, and no number of photons would mend it.

use super::credits::Credits;
use crate::nearest::{Layout, Nearest, Points};
use kaustika_math::warp::{equal_area_sphere_to_square, equal_area_square_to_sphere};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// Light that arrived somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Unit direction to where it came from.
    pub wi: Vec3,
    /// Flux, W.
    pub power: Spectrum,
    /// Surfaces met, this one included.
    pub depth: u32,
    /// True if it has been scattered by a matte surface before.
    pub indirect: bool,
    /// True if only the hero wavelength is left.
    pub dispersed: bool,
}

/// Photons deeper than this are not followed.
pub const MAX_DEPTH: u32 = 63;

/// An [`Arrival`], packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Photon {
    mantissas: [u8; 4],
    exponent: u8,
    /// Depth, and the two properties above it.
    flags: u8,
    direction: [u8; 2],
}

const INDIRECT: u8 = 64;
const DISPERSED: u8 = 128;
/// What the exponent stands above.
const BIAS: i32 = 136;

impl Photon {
    /// Packs it; `u` in [0, 1) decides which way its power is rounded.
    pub fn new(a: &Arrival, u: f32) -> Photon {
        let (mantissas, exponent) = pack(a.power, u);
        let square = equal_area_sphere_to_square(a.wi);
        let cell = |v: f32| (v * 256.0) as u8;
        let flag = |is: bool, bit: u8| if is { bit } else { 0 };
        Photon {
            mantissas,
            exponent,
            flags: a.depth.min(MAX_DEPTH) as u8
                | flag(a.indirect, INDIRECT)
                | flag(a.dispersed, DISPERSED),
            direction: [cell(square.x), cell(square.y)],
        }
    }

    /// Flux, W.
    #[inline]
    pub fn power(&self) -> Spectrum {
        let scale =
            f32::from_bits((i32::from(self.exponent) - BIAS + 127).max(0) as u32 * (1 << 23));
        Spectrum(self.mantissas.map(f32::from)) * scale
    }

    /// Unit direction to where it came from.
    #[inline]
    pub fn wi(&self) -> Vec3 {
        let centre = |v: u8| (f32::from(v) + 0.5) / 256.0;
        equal_area_square_to_sphere(Vec2::new(centre(self.direction[0]), centre(self.direction[1])))
    }

    /// Surfaces met.
    #[inline]
    pub fn depth(&self) -> u32 {
        u32::from(self.flags & !(INDIRECT | DISPERSED))
    }

    /// See [`Arrival::indirect`].
    #[inline]
    pub fn indirect(&self) -> bool {
        self.flags & INDIRECT != 0
    }

    /// See [`Arrival::dispersed`].
    #[inline]
    pub fn dispersed(&self) -> bool {
        self.flags & DISPERSED != 0
    }
}

/// Mantissas and exponent; black if the power is too small to be written, or no number.
fn pack(power: Spectrum, u: f32) -> ([u8; 4], u8) {
    let most = power.max_component();
    // 2^e is the least power of two that is more than 256/255 of the largest lane: its mantissa is
    // at least 127, and 255 at most when it is rounded up.
    let e = ((most * (256.0 / 255.0)).to_bits() >> 23) as i32 - 126;
    let exponent = e - 8 + BIAS;
    if !(most > 0.0 && most.is_finite() && (10..=255).contains(&exponent)) {
        return ([0; 4], 0);
    }
    let scale = f32::from_bits(((8 - e + 127) as u32) << 23);
    (power.0.map(|v| (v * scale + u).floor().clamp(0.0, 255.0) as u8), exponent as u8)
}

/// A photon map: photons where they can be found.
#[derive(Debug)]
pub struct PhotonMap {
    points: Points,
    photons: Vec<Photon>,
    credits: Option<Credits>,
}

impl PhotonMap {
    /// Of photons and their places.
    pub fn new(layout: Layout, places: &[Vec3], photons: &[Photon]) -> PhotonMap {
        PhotonMap::ordered(layout, places, photons).0
    }

    /// The same, and which photon stands where in the map's order.
    pub fn ordered(layout: Layout, places: &[Vec3], photons: &[Photon]) -> (PhotonMap, Vec<u32>) {
        let (points, order) = Points::new(layout, places);
        let photons = order.iter().map(|&i| photons[i as usize]).collect();
        (PhotonMap { points, photons, credits: None }, order)
    }

    /// From now on it is noted what photons contribute.
    pub(super) fn ask(&mut self) {
        self.credits = Some(Credits::new(self.photons.len()));
    }

    /// What they contribute, if that is noted.
    #[inline]
    pub(super) fn credits(&self) -> Option<&Credits> {
        self.credits.as_ref()
    }

    /// Finds the photons nearest to `q`.
    #[inline]
    pub fn nearest(&self, q: Vec3, found: &mut Nearest) {
        self.points.nearest(q, found);
    }

    /// The photon at a place of the map's order.
    #[inline]
    pub fn photon(&self, i: u32) -> &Photon {
        &self.photons[i as usize]
    }

    /// Where it is.
    #[inline]
    pub fn at(&self, i: u32) -> Vec3 {
        self.points.at(i)
    }

    /// How many photons there are.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// All photons.
    pub fn iter(&self) -> impl Iterator<Item = &Photon> {
        self.photons.iter()
    }

    /// Bytes it takes.
    pub fn memory_bytes(&self) -> usize {
        self.points.memory_bytes() + size_of::<Photon>() * self.photons.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::warp::uniform_sphere;
    use kaustika_sampling::hash::{combine, unit};

    fn number(i: u64, k: u64) -> f32 {
        unit((combine(i, k) >> 32) as u32)
    }

    #[test]
    fn packing_is_near_enough() {
        let mut worst: f32 = 1.0;
        for i in 0..20_000 {
            let wi = uniform_sphere(Vec2::new(number(i, 1), number(i, 2)));
            let scale = 10f32.powf(60.0 * number(i, 3) - 33.0);
            let power = Spectrum(std::array::from_fn(|k| number(i, 4 + k as u64) * scale));
            let (indirect, dispersed) = (i % 2 == 0, i % 3 == 0);
            let a = Arrival { wi, power, depth: i as u32 % 64, indirect, dispersed };
            let p = Photon::new(&a, number(i, 8));
            let step = power.max_component() / 126.0;
            for (a, b) in power.0.iter().zip(p.power().0) {
                assert!((a - b).abs() <= step, "{a} became {b}");
            }
            worst = worst.min(wi.dot(p.wi()));
            let flags = (p.depth(), p.indirect(), p.dispersed());
            assert_eq!(flags, (a.depth, indirect, dispersed));
        }
        assert!(worst > 1f32.to_radians().cos(), "{} degrees", worst.acos().to_degrees());
        for nothing in [0.0, 1e-38, f32::NAN, f32::INFINITY] {
            assert!(pack(Spectrum::splat(nothing), 0.5).0 == [0; 4], "{nothing}");
        }
    }

    #[test]
    fn packing_keeps_every_lane_in_the_mean() {
        // Powers whose largest mantissa is a little below and above 255, and lanes far below one step.
        let n = 4096;
        for most in [0.51, 0.7, 0.9958, 0.9963, 0.9999, 1.0] {
            let power = Spectrum([most, 0.61 * most, 0.004, 0.0007]);
            let mut mean = [0.0; 4];
            for i in 0..n {
                let wi = Vec3::Z;
                let a = Arrival { wi, power, depth: 1, indirect: false, dispersed: false };
                let p = Photon::new(&a, (i as f32 + 0.5) / n as f32).power();
                mean.iter_mut().zip(p.0).for_each(|(m, v)| *m += f64::from(v) / f64::from(n));
            }
            for (m, v) in mean.iter().zip(power.0) {
                // A step is at most 2/128, and u has n places.
                assert!((m - f64::from(v)).abs() < 0.02 / f64::from(n), "{v} became {m}");
            }
        }
    }

    #[test]
    fn a_photon_takes_no_more_than_22_bytes_with_its_tree() {
        let n = 100_000;
        let places: Vec<Vec3> =
            (0..n).map(|i| Vec3::new(number(i, 1), number(i, 2), number(i, 3))).collect();
        for layout in Layout::ALL {
            let map = PhotonMap::new(layout, &places, &vec![Photon::default(); n as usize]);
            assert!(map.memory_bytes() <= 22 * n as usize, "{layout:?}: {}", map.memory_bytes());
        }
    }
}
