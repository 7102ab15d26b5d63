//! Photons of trees stay where they arrive.

use super::super::lobes::parts;
use super::super::photon::{Arrival, Photon};
use super::super::tracing::Keep;
use crate::particle::light_trees::{Arriving, Onward, Receiver};
use crate::path_space::Vertex;
use crate::trees::{Node, mean};
use kaustika_math::Vec3;
use kaustika_sampling::hash::{combine, unit};
use kaustika_scene::bsdf::Lobes;

/// Photons of a group of trees.
#[derive(Default)]
pub(super) struct Deposits {
    pub places: Vec<Vec3>,
    pub photons: Vec<Photon>,
    pub origins: Vec<Origin>,
}

/// Where a photon came from.
#[derive(Clone, Copy)]
pub(super) struct Origin {
    /// The node whose ray brought it.
    pub node: u32,
    /// What it would bring if it were the only one: its flux times those that were emitted, the mean
    /// over the lanes.
    pub flux: f32,
}

/// A surface of the scene, and what stays on it.
pub(super) struct Floor<'f> {
    pub deposits: &'f mut Deposits,
    pub keep: Keep,
    /// One over the photons that were emitted.
    pub share: f32,
    /// Glossy surfaces from this roughness on are matte.
    pub matte: f32,
    /// A number of its own for every group.
    pub seed: u64,
}

impl<'a> Receiver<'a> for Floor<'_> {
    fn arrive(&mut self, at: &Vertex<'a>, light: &Arriving, _: &mut Node) -> Onward {
        let parts = parts(&at.bsdf, self.matte);
        let wanted = self.keep == Keep::All || light.depth > 1;
        if !parts.matte.is_empty() && wanted {
            let arrival = Arrival {
                wi: at.wo,
                power: light.beta * self.share,
                depth: light.depth as u32,
                indirect: light.indirect,
                dispersed: at.lambda.secondary_terminated(),
            };
            let u = unit((combine(self.seed, light.node.into()) >> 32) as u32);
            let flux = mean(light.beta, &at.lambda);
            self.deposits.places.push(at.surface.p);
            self.deposits.photons.push(Photon::new(&arrival, u));
            self.deposits.origins.push(Origin { node: light.node, flux });
        }
        Onward {
            lobes: match self.keep {
                Keep::All => Lobes::ALL,
                Keep::Caustics => parts.sharp,
            },
            matte: !parts.matte.is_empty(),
        }
    }
}
