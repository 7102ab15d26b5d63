//! What is learned about: lights, regions of environments, and parts of the hierarchy of lights
//! where they are many.

use super::super::bvh::{Branch, LightBvh};
use super::super::{Light, LightChoice, mean_power};
use crate::Scene;
use crate::surface::LightId;
use kaustika_math::{Vec2, Vec3};
use std::f32::consts::PI;

/// Clusters at most: what is known of each is kept for each part of the scene.
const MOST_CLUSTERS: usize = 2048;

/// Parts of the hierarchy at most.
const MOST_BRANCHES: usize = 64;

/// One of the clusters.
#[derive(Clone, Copy, Debug)]
enum Cluster {
    /// A region of an environment.
    Region(LightId, u32),
    /// A light at infinity.
    Infinite(LightId),
    /// A light, or many, that are somewhere.
    Branch(Branch),
}

/// All clusters of a scene.
#[derive(Debug)]
pub(super) struct Clusters {
    list: Vec<Cluster>,
    /// Luminous power (for what is at infinity, irradiance), none negative.
    pub power: Vec<f32>,
    /// Probabilities of the clusters as long as nothing is known; they sum to 1.
    pub prior: Vec<f64>,
    /// Regions beside each region; itself where there is none.
    pub beside: Vec<[u32; 4]>,
    /// The cluster of each light; the first one of an environment.
    of_light: Vec<u32>,
    /// For each environment's cluster 1 over the probability of its region.
    per_pmf: Vec<f32>,
    tree: LightBvh,
}

impl Clusters {
    /// Of the scene's lights; `None` if there are none with any power, or too many at infinity to
    /// tell apart.
    pub fn new(scene: &Scene) -> Option<Clusters> {
        let mut of_light = vec![u32::MAX; scene.lights.len()];
        let (mut list, mut power, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let (mut near, mut beside) = (Vec::new(), Vec::new());
        for (i, light) in scene.lights.iter().enumerate() {
            let id = LightId(i as u32);
            let irradiance = || mean_power(light, scene) / (PI * scene.radius * scene.radius);
            match light {
                Light::Environment(environment) => {
                    of_light[i] = list.len() as u32;
                    let all = irradiance();
                    let [columns, rows] = environment.regions();
                    for region in 0..columns * rows {
                        let pmf = environment.region_pmf(region);
                        list.push(Cluster::Region(id, region));
                        beside.push(beside_region(of_light[i], region, [columns, rows]));
                        power.push(all * pmf);
                        weights.push(f64::from(pmf));
                    }
                }
                Light::Directional(_) => {
                    of_light[i] = list.len() as u32;
                    beside.push([list.len() as u32; 4]);
                    list.push(Cluster::Infinite(id));
                    power.push(irradiance());
                    weights.push(1.0);
                }
                _ => near.extend(light.bounds(scene).map(|bounds| (id, bounds))),
            }
        }
        let tree = LightBvh::new(near, scene.lights.len());
        let branches = tree.branches(MOST_BRANCHES);
        let first = list.len() as u32;
        for light in 0..scene.lights.len() as u32 {
            if let Some(branch) = tree.branch_of(&branches, LightId(light)) {
                of_light[light as usize] = first + branch as u32;
            }
        }
        list.extend(branches.iter().map(|b| Cluster::Branch(*b)));
        beside.extend((first..list.len() as u32).map(|cluster| [cluster; 4]));
        power.resize(list.len(), 0.0);
        for (light, &cluster) in scene.lights.iter().zip(&of_light) {
            if cluster >= first && cluster != u32::MAX {
                power[cluster as usize] += mean_power(light, scene);
            }
        }
        // All near ones together count as one more light at infinity, as in the hierarchy.
        let of_branches: f32 = power[first as usize..].iter().sum();
        let share = |p: f32| if of_branches > 0.0 { f64::from(p / of_branches) } else { 0.0 };
        weights.extend(power[first as usize..].iter().map(|&p| share(p)));
        let sum: f64 = weights.iter().sum();
        let prior: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        let per_pmf = list.iter().map(|c| match *c {
            Cluster::Region(light, region) => match scene.light(light) {
                Light::Environment(e) => Some(1.0 / e.region_pmf(region)),
                _ => None,
            }
            .filter(|k| k.is_finite())
            .unwrap_or(0.0),
            _ => 1.0,
        });
        let per_pmf = per_pmf.collect();
        let few = list.len() <= MOST_CLUSTERS;
        let sound = few && sum > 0.0 && sum.is_finite() && power.iter().all(|p| p.is_finite());
        sound.then_some(Clusters { list, power, prior, beside, of_light, per_pmf, tree })
    }

    /// Number of clusters.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// True if the cluster is at infinity.
    pub fn is_infinite(&self, cluster: usize) -> bool {
        !matches!(self.list[cluster], Cluster::Branch(_))
    }

    /// A light of a cluster, with its probability there.
    #[inline]
    pub fn sample(&self, cluster: usize, p: Vec3, n: Vec3, u: f32, u2: Vec2) -> LightChoice {
        let (light, region, pmf) = match self.list[cluster] {
            Cluster::Region(light, region) => (light, Some(region), 1.0),
            Cluster::Infinite(light) => (light, None, 1.0),
            Cluster::Branch(branch) => {
                let (light, pmf) = self.tree.sample_branch(branch, p, n, u);
                (light, None, pmf)
            }
        };
        LightChoice { light, region, p: pmf, u: u2 }
    }

    /// The cluster of a light, and the light's probability there.
    #[inline]
    pub fn of_light(&self, p: Vec3, n: Vec3, light: LightId) -> (usize, f32) {
        let cluster = self.of_light[light.0 as usize] as usize;
        let pmf = match self.list[cluster] {
            Cluster::Branch(branch) => self.tree.pmf_in_branch(branch, p, n, light),
            _ => 1.0,
        };
        (cluster, pmf)
    }

    /// The cluster of an environment's region, and 1 over the environment's own probability of
    /// that region.
    #[inline]
    pub fn of_region(&self, light: LightId, region: u32) -> (usize, f32) {
        let cluster = (self.of_light[light.0 as usize] + region) as usize;
        (cluster, self.per_pmf[cluster])
    }
}

/// The clusters left, right, above and below a region of an environment whose first has the
/// number `first`.
fn beside_region(first: u32, region: u32, [columns, rows]: [u32; 2]) -> [u32; 4] {
    let (x, y) = (region % columns, region / columns);
    let at = |x: u32, y: u32| first + y * columns + x;
    [
        at((x + columns - 1) % columns, y),
        at((x + 1) % columns, y),
        at(x, y.saturating_sub(1)),
        at(x, (y + 1).min(rows - 1)),
    ]
}
