//! Which light to sample: uniformly, by power, by a hierarchy over position and direction, or by
//! what was learned.

use super::{LearnedLights, Light, LightBvh};
use crate::Scene;
use crate::surface::LightId;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3};
use kaustika_sampling::distribution::Discrete;
use kaustika_spectra::{ColorMode, Wavelengths};
use std::str::FromStr;

/// The ways to choose a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSelectionKind {
    /// Each with the same probability.
    Uniform,
    /// In proportion to power.
    Power,
    /// By a hierarchy of lights, in proportion to what may arrive at the point.
    Bvh,
    /// By what was learned of each part of the scene; by the hierarchy until a method learns it.
    Learned,
}

/// With at most this many lights a hierarchy, or learning, costs more than it gains: the two
/// triangles of a rectangle or two.
pub(crate) const FEW_LIGHTS: usize = 4;

impl LightSelectionKind {
    /// The default for these lights. Of an environment or of many lights most are often hidden:
    /// that is worth learning. Power says nothing about a lamp beside a directional light, whose
    /// power grows with the size of the scene: there the hierarchy decides.
    pub fn for_lights(lights: &[Light]) -> LightSelectionKind {
        let infinite = lights.iter().filter(|l| l.is_infinite()).count();
        let surrounded = lights.iter().any(|l| matches!(l, Light::Environment(_)));
        match (surrounded || lights.len() > FEW_LIGHTS, infinite > 0 && infinite < lights.len()) {
            (true, _) => LightSelectionKind::Learned,
            (false, true) => LightSelectionKind::Bvh,
            (false, false) => LightSelectionKind::Power,
        }
    }
}

impl FromStr for LightSelectionKind {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "uniform" => Ok(LightSelectionKind::Uniform),
            "power" => Ok(LightSelectionKind::Power),
            "bvh" => Ok(LightSelectionKind::Bvh),
            "learned" => Ok(LightSelectionKind::Learned),
            _ => Err(format!("unknown light sampler `{s}`; known: uniform, power, bvh, learned")),
        }
    }
}

/// A light that was chosen.
#[derive(Clone, Copy, Debug)]
pub struct LightChoice {
    /// Which.
    pub light: LightId,
    /// Which region of it, if only that is to be sampled.
    pub region: Option<u32>,
    /// Probability of the light, or of the region.
    pub p: f32,
    /// Uniform numbers for a point of it, in [0, 1)².
    pub u: Vec2,
}

/// Chooses lights; built once a scene.
#[derive(Debug, Default)]
pub struct LightSelection(Selection);

#[derive(Debug, Default)]
enum Selection {
    /// There is no light.
    #[default]
    Dark,
    /// The same everywhere.
    Table(Discrete),
    Hierarchy(Hierarchy),
    Learned(Box<LearnedLights>),
}

/// Lights at infinity beside a tree of the others.
#[derive(Debug)]
struct Hierarchy {
    tree: LightBvh,
    infinite: Vec<LightId>,
    /// Probability of each light at infinity.
    pmf_infinite: f32,
}

impl LightSelection {
    /// Builds tables or hierarchy over all lights of the scene.
    pub fn new(kind: LightSelectionKind, scene: &Scene) -> LightSelection {
        let count = scene.lights.len();
        if count == 0 {
            return LightSelection(Selection::Dark);
        }
        let weights: Vec<f32> = match kind {
            LightSelectionKind::Uniform => {
                scene.lights.iter().map(|l| if l.connects() { 1.0 } else { 0.0 }).collect()
            }
            LightSelectionKind::Power => {
                let weight = |l: &Light| if l.connects() { mean_power(l, scene) } else { 0.0 };
                scene.lights.iter().map(weight).collect()
            }
            LightSelectionKind::Bvh | LightSelectionKind::Learned => {
                return LightSelection(Selection::Hierarchy(Hierarchy::new(scene)));
            }
        };
        LightSelection::table(&weights)
    }

    /// Builds the table by which lights are chosen to emit, by power.
    pub fn for_emission(scene: &Scene) -> LightSelection {
        let weights: Vec<f32> = scene.lights.iter().map(|l| mean_power(l, scene)).collect();
        LightSelection::table(&weights)
    }

    /// All dark or not to be summed: any of them may as well be asked.
    fn table(weights: &[f32]) -> LightSelection {
        let table = Discrete::new(weights).or_else(|_| Discrete::new(&vec![1.0; weights.len()]));
        LightSelection(table.map_or(Selection::Dark, Selection::Table))
    }

    /// By what was learned.
    pub fn learned(lights: LearnedLights) -> LightSelection {
        LightSelection(Selection::Learned(Box::new(lights)))
    }

    /// A light for the scene point `p` with normal `n` on the side of interest (zero where there
    /// is none); `None` if there is no light.
    ///
    /// A table of few lights takes the choice out of `u2` and returns what it leaves, so that
    /// the points of few lights, as of the two triangles of a rectangle, are stratified
    /// together; otherwise `u` is spent.
    #[inline]
    pub fn sample(&self, p: Vec3, n: Vec3, u: f32, u2: Vec2) -> Option<LightChoice> {
        let whole = |light, p, u| LightChoice { light, region: None, p, u };
        let choice = match &self.0 {
            Selection::Dark => return None,
            Selection::Table(table) if table.len() <= FEW_LIGHTS => {
                let s = table.sample(u2.x);
                whole(LightId(s.index as u32), s.pmf, Vec2::new(s.u, u2.y))
            }
            Selection::Table(table) => {
                let s = table.sample(u);
                whole(LightId(s.index as u32), s.pmf, u2)
            }
            Selection::Hierarchy(h) => {
                let (light, pmf) = h.sample(p, n, u)?;
                whole(light, pmf, u2)
            }
            Selection::Learned(learned) => learned.sample(p, n, u, u2),
        };
        (choice.p > 0.0).then_some(choice)
    }

    /// The table, if it is of few lights, whose choice is taken out of `u2.x`.
    pub(crate) fn of_few(&self) -> Option<&Discrete> {
        match &self.0 {
            Selection::Table(table) if table.len() <= FEW_LIGHTS => Some(table),
            _ => None,
        }
    }

    /// Probability of [`LightSelection::sample`] choosing `light` for the same point; not of
    /// environments.
    #[inline]
    pub fn pmf(&self, p: Vec3, n: Vec3, light: LightId) -> f32 {
        match &self.0 {
            Selection::Dark => 0.0,
            Selection::Table(table) => table.pmf(light.0 as usize),
            Selection::Hierarchy(h) => h.pmf(p, n, light),
            Selection::Learned(learned) => learned.pmf(p, n, light),
        }
    }

    /// What the density `pdf_li` of an environment's direction in `region` is multiplied by if
    /// [`LightSelection::sample`] chooses for the same point: the environment's probability, or
    /// the region's over that which the environment gives it.
    #[inline]
    pub fn pmf_escaped(&self, p: Vec3, n: Vec3, light: LightId, region: u32) -> f32 {
        match &self.0 {
            Selection::Learned(learned) => learned.pmf_escaped(p, n, light, region),
            _ => self.pmf(p, n, light),
        }
    }
}

impl Hierarchy {
    fn new(scene: &Scene) -> Hierarchy {
        let (mut infinite, mut near) = (Vec::new(), Vec::new());
        for (i, light) in scene.lights.iter().enumerate() {
            let id = LightId(i as u32);
            match light.bounds(scene) {
                Some(bounds) => near.push((id, bounds)),
                None => infinite.push(id),
            }
        }
        // All near ones together count as one more light at infinity (as in pbrt-v4).
        let others = if near.is_empty() { 0.0 } else { 1.0 };
        let pmf_infinite = 1.0 / (infinite.len() as f32 + others);
        Hierarchy { tree: LightBvh::new(near, scene.lights.len()), infinite, pmf_infinite }
    }

    /// Probability of the tree.
    fn pmf_tree(&self) -> f32 {
        if self.tree.is_empty() { 0.0 } else { self.pmf_infinite }
    }

    #[inline]
    fn sample(&self, p: Vec3, n: Vec3, u: f32) -> Option<(LightId, f32)> {
        let slot = u / self.pmf_infinite;
        match self.infinite.get(slot as usize) {
            Some(&light) => Some((light, self.pmf_infinite)),
            None if self.tree.is_empty() => Some((*self.infinite.last()?, self.pmf_infinite)),
            None => {
                let rest = (slot - self.infinite.len() as f32).clamp(0.0, ONE_MINUS_EPSILON);
                let (light, pmf) = self.tree.sample(p, n, rest)?;
                Some((light, self.pmf_tree() * pmf))
            }
        }
    }

    #[inline]
    fn pmf(&self, p: Vec3, n: Vec3, light: LightId) -> f32 {
        // A few at most, and usually none or one.
        if self.infinite.contains(&light) {
            return self.pmf_infinite;
        }
        self.pmf_tree() * self.tree.pmf(p, n, light)
    }
}

/// Luminous power, averaged over wavelengths in spectral mode.
pub fn mean_power(light: &Light, scene: &Scene) -> f32 {
    let count = if scene.mode == ColorMode::Spectral { 8 } else { 1 };
    let power: f32 = (0..count)
        .map(|i| {
            let lambda =
                Wavelengths::sample_for(scene.mode, (i as f32 + 0.5) / (4.0 * count as f32));
            light.power(scene, &lambda).luminance(&lambda)
        })
        .sum();
    (power / count as f32).max(0.0)
}
