//! Chains and the film they draw on.
//!
//! ```text
//! I_j ≈ (b / N) Σᵢ wᵢ h_j(xᵢ) c(xᵢ) / f(xᵢ),    f = Σ lum |c|                        (1)
//! ```
//!
//! x are the chains' N states with their weights w, c(x) the colours that x leaves in places of the
//! film, h_j the filter of pixel j there. f is a sum of moduli, so that it vanishes only where all
//! colours do: those of a few wavelengths may be negative.

use super::Draws;
use super::tiles::Tiles;
use crate::frame::Frame;
use crate::method::RenderError;
use crate::path_space::Splat;
use crate::saved::Saved;
use crate::workers::Workers;
use kaustika_math::Vec2;
use kaustika_sampling::hash::combine;
use rayon::prelude::*;
use std::io::{self, Read, Write};

/// Groups of chains, where there are as many chains: enough to know an error to a fifth.
const GROUPS: u64 = 16;
/// Groups of [`MANY`] chains: they know it to an eleventh.
const GROUPS_OF_MANY: u64 = 64;
/// Chains that make groups of some size, however many groups there are.
const MANY: u64 = 1024;

/// Chains whose deposits are kept at the same time: bounds the memory they take.
const WINDOW: usize = 32;

/// The part of the film that paths of the picture may come from: the region and as far around as
/// filters reach.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    first: Vec2,
    size: Vec2,
    /// The region's first pixel, and how many there are.
    region: [u32; 4],
}

impl Field {
    /// Of this frame.
    pub fn new(frame: &Frame) -> Field {
        let [x0, y0, x1, y1] = frame.region.map(|v| v as f32);
        let r = frame.filter_desc.radius();
        // A filter of half a pixel ends with the pixel.
        let margin = Vec2::new(r.x - 0.5, r.y - 0.5);
        let margin = Vec2::new(margin.x.max(0.0), margin.y.max(0.0));
        let size = Vec2::new(x1 - x0, y1 - y0) + margin * 2.0;
        let [x, y, ..] = frame.region;
        let [w, h] = frame.size();
        Field { first: Vec2::new(x0, y0) - margin, size, region: [x, y, w, h] }
    }

    /// The tile of the region that a place lies in.
    pub fn tile(&self, p: Vec2) -> Option<usize> {
        let [x0, y0, w, h] = self.region;
        let (x, y) = (p.x - x0 as f32, p.y - y0 as f32);
        let inside = x >= 0.0 && y >= 0.0 && x < w as f32 && y < h as f32;
        inside.then(|| Tiles::new([w, h]).of(x as u32, y as u32))
    }

    /// Its area in pixels.
    pub fn area(&self) -> f64 {
        f64::from(self.size.x) * f64::from(self.size.y)
    }

    /// The place that two numbers in [0, 1) choose.
    pub fn place(&self, u: Vec2) -> Vec2 {
        self.first + Vec2::new(u.x * self.size.x, u.y * self.size.y)
    }

    /// True if it lies inside.
    pub fn has(&self, p: Vec2) -> bool {
        let q = p - self.first;
        q.x >= 0.0 && q.y >= 0.0 && q.x < self.size.x && q.y < self.size.y
    }
}

/// f of (1), of what a state leaves on the picture itself.
pub fn scalar(splats: &[Splat]) -> f64 {
    splats.iter().filter(|s| s.layer.is_none()).map(|s| modulus(s.rgb)).sum()
}

/// Where a state leaves most light on the picture itself.
pub fn brightest(splats: &[Splat]) -> Option<&Splat> {
    let of_picture = splats.iter().filter(|s| s.layer.is_none());
    of_picture.max_by(|a, b| modulus(a.rgb).total_cmp(&modulus(b.rgb)))
}

/// Σ lum |c|.
pub fn modulus(rgb: [f32; 3]) -> f64 {
    let [r, g, b] = rgb.map(|v| f64::from(v.abs()));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

impl Saved for Splat {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        [self.film.x, self.film.y].save(out)?;
        self.layer.map(|l| l as u64).save(out)?;
        self.rgb.save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Splat> {
        let [x, y] = <[f32; 2]>::load(from)?;
        let layer = Option::<u64>::load(from)?.map(|l| l as usize);
        Ok(Splat { film: Vec2::new(x, y), layer, rgb: Saved::load(from)? })
    }
}

/// How many chains there are, and steps of each in a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Groups of chains that are independent renders.
    pub groups: usize,
    /// Chains, as many in each group.
    pub chains: usize,
    /// Steps.
    pub steps: u64,
}

impl Schedule {
    /// At most `most` chains, and together so many steps or a little more for each pixel.
    pub fn new(frame: &Frame, most: u32, a_pixel: u32) -> Schedule {
        let [w, h] = frame.size().map(u64::from);
        let pixels = (w * h).max(1);
        let chains = u64::from(most).min(pixels).max(1);
        let groups = if chains < MANY { chains.min(GROUPS) } else { GROUPS_OF_MANY };
        let chains = chains / groups * groups;
        let steps = (pixels * u64::from(a_pixel)).div_ceil(chains);
        Schedule { groups: groups as usize, chains: chains as usize, steps }
    }

    /// Weight of a state of weight one: b / N of (1).
    pub fn unit(&self, brightness: f64) -> f64 {
        brightness / (self.chains as f64 * self.steps as f64)
    }
}

/// Adds `weight` times a state's colours.
pub fn deposit(splats: &[Splat], weight: f64, out: &mut Vec<Splat>) {
    let weight = weight as f32;
    out.extend(splats.iter().map(|s| Splat { rgb: s.rgb.map(|v| weight * v), ..*s }));
}

/// Moves every chain on by `advance`, which leaves splats, and gives back the chains as they are
/// then, and what each has counted. `keep` gets the splats, chain by chain in their order.
///
/// # Errors
/// If cancelled; what was kept is then useless, and `chains` are as they were.
pub fn run<K: Clone + Send + Sync, S: Send, T: Send>(
    workers: &Workers,
    chains: &[K],
    room: impl Fn() -> S + Sync + Send,
    advance: impl Fn(&mut S, usize, &mut K, &mut Vec<Splat>) -> T + Sync + Send,
    mut keep: impl FnMut(usize, &[Splat]) + Send,
) -> Result<(Vec<K>, Vec<T>), RenderError> {
    // All of it inside the pool: handing each window over would cost more than the window where the machine is busy.
    workers.install(|| {
        let mut moved = Vec::with_capacity(chains.len());
        let mut counts = Vec::with_capacity(chains.len());
        for (w, window) in chains.chunks(WINDOW).enumerate() {
            let one = |room: &mut S, (i, chain): (usize, &K)| {
                if workers.cancelled() {
                    return None;
                }
                let mut chain = chain.clone();
                let mut splats = Vec::new();
                let count = advance(room, w * WINDOW + i, &mut chain, &mut splats);
                Some((chain, count, splats))
            };
            let done: Vec<Option<(K, T, Vec<Splat>)>> =
                window.par_iter().enumerate().with_max_len(1).map_init(&room, one).collect();
            for (chain, count, splats) in
                done.into_iter().collect::<Option<Vec<_>>>().ok_or(RenderError::Cancelled)?
            {
                keep(moved.len(), &splats);
                moved.push(chain);
                counts.push(count);
            }
        }
        Ok((moved, counts))
    })
}

/// The stream of a chain's decisions; other streams have other purposes.
pub fn stream(seed: u64, purpose: u64, number: u64) -> Draws {
    Draws::new(combine(seed, purpose), number)
}

/// The seed of a generation of chains; the first one's is the picture's. Mixed before the number comes in: pictures of
/// neighbouring seeds would share generations.
pub fn of_generation(seed: u64, number: u64) -> u64 {
    if number == 0 { seed } else { combine(combine(seed, 0x6167_6573), number) }
}
