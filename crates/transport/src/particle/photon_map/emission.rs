//! How photons leave the lights.
//!
//! ```text
//! Φ = Lₑ cos θ / (P p_A p_σ c N)                                                   (1)
//! ```
//!
//! P is the probability of the light, by its power: where a light samples its emission as it
//! emits, all photons have the same power. c is the projection map's (Jensen 1996): the
//! emission's directions, or for parallel light its places, are parted into cells of equal flux,
//! and those cells are preferred through which glossy surfaces are seen. Others keep a small
//! share, for the map is made from trials; their photons are rare and heavy, and few.

use super::lobes::parts;
use crate::method::PassStats;
use crate::particle::light_trees::{Start, Unguided};
use crate::path_space::emission_table;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::distribution::Discrete;
use kaustika_sampling::{Sampler, SamplerConfig, SamplerKind, SamplerPlan};
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{LightId, Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Cells of a projection map along each side.
const SIDE: usize = 32;
const CELLS: usize = SIDE * SIDE;
/// Rays that try the cells.
const TRIALS: u64 = 1 << 16;
/// A light needs as many trials for each cell to have a map.
const TRIALS_A_CELL: u64 = 2;
/// Share of the photons that go anywhere.
const ANYWHERE: f32 = 0.1;
/// Passages through interfaces before a ray is given up.
const MAX_PASSAGES: u32 = 1000;

/// How lights are chosen, and where they shine.
#[derive(Debug, Default)]
pub(super) struct Emission {
    lights: Option<Discrete>,
    /// Which of a light's numbers its cells are over: 0 those of the place, 1 those of the direction.
    aimed: Vec<usize>,
    /// A light's cells, if some are preferred.
    maps: Vec<Option<Box<Cells>>>,
}

/// A projection map.
#[derive(Debug)]
struct Cells {
    /// The cells that are preferred.
    marked: Vec<u16>,
    is_marked: [bool; CELLS],
}

impl Cells {
    /// Share of the emission that is preferred.
    fn share(&self) -> f32 {
        self.marked.len() as f32 / CELLS as f32
    }

    /// What a photon's power is divided by in a cell.
    fn density(&self, cell: usize) -> f32 {
        let marked = if self.is_marked[cell] { (1.0 - ANYWHERE) / self.share() } else { 0.0 };
        marked + ANYWHERE
    }

    /// A point of the unit square, most often in a marked cell.
    fn aim(&self, u: Vec2) -> (Vec2, f32) {
        let mut at = u;
        if u.x < 1.0 - ANYWHERE {
            // One number chooses the cell and the place in it.
            let x = u.x / (1.0 - ANYWHERE) * self.marked.len() as f32;
            let i = (x as usize).min(self.marked.len() - 1);
            let cell = self.marked[i] as usize;
            let corner = Vec2::new((cell % SIDE) as f32, (cell / SIDE) as f32);
            at = (corner + Vec2::new(x - i as f32, u.y)) / SIDE as f32;
        } else {
            at.x = (u.x - (1.0 - ANYWHERE)) / ANYWHERE;
        }
        let at = at.min(Vec2::splat(kaustika_math::ONE_MINUS_EPSILON));
        (at, self.density(cell_of(at)))
    }
}

fn cell_of(at: Vec2) -> usize {
    let along = |v: f32| ((v * SIDE as f32) as usize).min(SIDE - 1);
    along(at.y) * SIDE + along(at.x)
}

/// A photon on its way.
pub(super) struct Emitted {
    pub(super) ray: Ray,
    /// N Φ of (1).
    pub(super) power: Spectrum,
}

impl Emission {
    /// By power, in all directions.
    pub(super) fn new(scene: &Scene) -> Emission {
        let maps = scene.lights.iter().map(|_| None).collect();
        let aimed = scene.lights.iter().map(|l| usize::from(!l.is_infinite())).collect();
        Emission { lights: by_power(scene, |_| 1.0), aimed, maps }
    }

    /// By power, preferring what shines on surfaces that are glossier than `matte`.
    pub(super) fn toward_glossy(scene: &Scene, matte: f32, seed: u64) -> Emission {
        let everywhere = Emission::new(scene);
        let kind = SamplerKind::Sobol;
        let plan = SamplerPlan::new(SamplerConfig { kind, seed, spp: TRIALS, resolution: [1, 1] });
        let mut tried = vec![0; scene.lights.len()];
        let mut hit = vec![None; scene.lights.len()];
        let mut bsdf = Bsdf::default();
        for i in 0..TRIALS {
            let mut sampler = plan.start([0, 0], i);
            let mut lambda = Wavelengths::sample_for(scene.mode, 0.5);
            let Some((light, at, e)) = everywhere.choose(scene, &lambda, &mut sampler) else {
                continue;
            };
            tried[light] += 1;
            let stats = &mut PassStats::default();
            let met = next_surface(scene, e.ray, &mut lambda, &mut bsdf, stats);
            if met.is_some() && !parts(&bsdf, matte).sharp.is_empty() {
                hit[light].get_or_insert([false; CELLS])[cell_of(at)] = true;
            }
        }
        let enough = TRIALS_A_CELL * CELLS as u64;
        let map = |(hit, &tried): (Option<[bool; CELLS]>, &u64)| {
            hit.filter(|_| tried >= enough).map(|hit| Box::new(widened(&hit)))
        };
        let maps: Vec<_> = hit.into_iter().zip(&tried).map(map).collect();
        let useful = maps.iter().any(Option::is_some);
        let share = |i: usize| match &maps[i] {
            Some(cells) => (1.0 - ANYWHERE) * cells.share() + ANYWHERE,
            // It was tried as others were, and shines on nothing that is sharp.
            None if useful && tried[i] >= enough => ANYWHERE,
            None => 1.0,
        };
        Emission { lights: by_power(scene, share), maps, ..everywhere }
    }

    /// A light, its number, the point of the square that its map is over, and its ray.
    fn choose(
        &self,
        scene: &Scene,
        lambda: &Wavelengths,
        sampler: &mut Sampler,
    ) -> Option<(usize, Vec2, Emitted)> {
        let Start { light: id, numbers, p } = self.draw(&sampler.get_vertex())?;
        let (i, light) = (id.0 as usize, scene.light(id));
        let e = light.sample_le(scene, numbers[0], numbers[1], lambda)?;
        let power = e.le * (e.cos / (p * e.pdf_a * e.pdf_w)); // (1)
        let emitted = Emitted { ray: e.ray, power };
        (!emitted.power.is_black()).then(|| (i, numbers[self.aimed[i]], emitted))
    }

    /// A photon.
    pub(super) fn emit(
        &self,
        scene: &Scene,
        lambda: &Wavelengths,
        sampler: &mut Sampler,
    ) -> Option<Emitted> {
        self.choose(scene, lambda, sampler).map(|(.., emitted)| emitted)
    }
}

/// As photons leave that know nothing of what will be seen.
impl Unguided for Emission {
    fn draw(&self, u: &[f32; 8]) -> Option<Start> {
        let choice = self.lights.as_ref()?.sample(u[4]);
        let mut numbers = [Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3])];
        let mut p = choice.pmf;
        if let Some(cells) = &self.maps[choice.index] {
            let aimed = &mut numbers[self.aimed[choice.index]];
            let (at, density) = cells.aim(*aimed);
            *aimed = at;
            p *= density;
        }
        Some(Start { light: LightId(choice.index as u32), numbers, p })
    }

    fn density(&self, light: LightId, numbers: [Vec2; 2]) -> f32 {
        let of_light = |lights: &Discrete| lights.pmf(light.0 as usize);
        let p = self.lights.as_ref().map_or(0.0, of_light);
        let i = light.0 as usize;
        match &self.maps[i] {
            Some(cells) => p * cells.density(cell_of(numbers[self.aimed[i]])),
            None => p,
        }
    }
}

/// A table of the lights by power times `share`; `None` if there is no light.
fn by_power(scene: &Scene, share: impl Fn(usize) -> f32) -> Option<Discrete> {
    let table = emission_table(scene);
    let pmf = |i: usize| table.pmf(Vec3::ZERO, Vec3::ZERO, LightId(i as u32));
    let weights: Vec<f32> = (0..scene.lights.len()).map(|i| pmf(i) * share(i)).collect();
    Discrete::new(&weights).ok()
}

/// The cells that were hit, and those beside them.
fn widened(hit: &[bool; CELLS]) -> Cells {
    let mut is_marked = [false; CELLS];
    for (i, _) in hit.iter().enumerate().filter(|&(_, &h)| h) {
        let (x, y) = (i % SIDE, i / SIDE);
        for y in y.saturating_sub(1)..(y + 2).min(SIDE) {
            for x in x.saturating_sub(1)..(x + 2).min(SIDE) {
                is_marked[y * SIDE + x] = true;
            }
        }
    }
    let marked = (0..CELLS as u16).filter(|&i| is_marked[i as usize]).collect();
    Cells { marked, is_marked }
}

/// What the ray meets that is more than an interface, and how that scatters.
pub(super) fn next_surface<'a>(
    scene: &'a Scene,
    mut ray: Ray,
    lambda: &mut Wavelengths,
    bsdf: &mut Bsdf<'a>,
    stats: &mut PassStats,
) -> Option<Surface> {
    for _ in 0..MAX_PASSAGES {
        stats.closest_rays += 1;
        let surface = scene.intersect(&ray, f32::INFINITY)?;
        if scene.bsdf_into(&surface, -ray.d, lambda, bsdf) {
            return Some(surface);
        }
        ray = surface.spawn(ray.d);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aiming_has_the_density_it_tells() {
        // Over random numbers the mean of 1/density in any part is its area.
        let mut hit = [false; CELLS];
        (hit[40], hit[500]) = (true, true);
        let cells = widened(&hit);
        assert_eq!(cells.marked.len(), 18);
        let (mut left, mut inside, n) = (0.0, 0.0, 400);
        for i in 0..n * n {
            let u = Vec2::new(((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32);
            let (at, density) = cells.aim(u);
            if at.x < 0.3 {
                left += 1.0 / density;
            }
            if cells.is_marked[cell_of(at)] {
                inside += 1.0 / density;
            }
        }
        let mean = |sum: f32| sum / (n * n) as f32;
        assert!((mean(left) - 0.3).abs() < 0.02, "{}", mean(left));
        assert!((mean(inside) - cells.share()).abs() < 1e-3, "{}", mean(inside));
    }
}
