//! From numbers to light on the film: C(u), the integrand over primary sample space.
//!
//! ```text
//! pssmlt:  C(u) = Σ_{s,t} w_{s,t} C_{s,t}(u)                                          (1)
//! mmlt:    C(u, v) = n w_{s,t} C_{s,t}(u),    s = ⌊n v⌋, t = k + 1 - s, n = k + 2       (2)
//! ```
//!
//! (1): Kelemen et al. 2002; (2): Hachisuka, Kaplanyan & Dachsbacher 2014, for the paths of k edges.
//! t = 0 is a strategy only where the lens can be met. Numbers of the eye's and of the light's
//! subpath are apart, so that a change of the one's length does not shift what the other's mean.

use super::candidates::{Candidates, Kept, origin, subpaths};
use super::eye_paths::EyePaths;
use super::params::{Over, PrimaryParams};
use crate::frame::Frame;
use crate::method::PassStats;
use crate::metropolis::Draws;
use crate::metropolis::film::{Field, scalar};
use crate::path_space::{Guides, Splat};
use crate::roulette::Survival;
use crate::strategies::{Pairs, Settings};
use kaustika_math::Vec2;
use kaustika_sampling::{PrimarySample, Sampler};
use kaustika_scene::{LightSelection, Scene};

/// Bounces of the longest paths of (2) without a limit.
const LONGEST: u32 = 64;

/// Which integrand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    /// (1)
    Whole,
    /// (2)
    Multiplexed,
}

/// Makes paths of numbers.
pub(super) struct Estimator<'a> {
    scene: &'a Scene,
    field: Field,
    maker: Maker<'a>,
    /// Of multiplexed chains.
    candidates: Option<Candidates<'a>>,
    /// Vertices that the light's side may have at most of all of a path: all but one, or all.
    lens_can_be_met: bool,
}

enum Maker<'a> {
    Eye(EyePaths<'a>),
    Whole(Pairs<'a>),
    Multiplexed(Pairs<'a>),
}

/// Sources of a path's numbers: the eye's, the light's, and the choice of a strategy.
pub(super) type Sources<'r> = [&'r mut (dyn PrimarySample + Send); 3];

impl<'a> Estimator<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &PrimaryParams,
        space: Space,
        (lights, emission): (&'a LightSelection, &'a LightSelection),
        guides: Option<&'a Guides>,
    ) -> Estimator<'a> {
        let field = Field::new(frame);
        let mut settings = params.settings(params.depths_of_chains());
        let pairs = |settings: Settings| {
            let pairs = Pairs::new(scene, frame, settings, lights, emission);
            pairs.over(field.area()).guided(guides)
        };
        let mut candidates = None;
        let maker = match (space, params.over) {
            (Space::Whole, Over::Path) => {
                Maker::Eye(EyePaths::new(scene, frame, settings, (lights, emission), guides))
            }
            (Space::Whole, Over::Bdpt) => Maker::Whole(pairs(settings)),
            (Space::Multiplexed, _) => {
                // Lengths of subpaths are chosen, not left to chance.
                settings.roulette.survival = Survival::None;
                settings.depths[1] = settings.depths[1].min(LONGEST);
                let of_all = pairs(settings.clone()).with_pieces();
                candidates = Some(Candidates::new(scene, frame, field, of_all));
                Maker::Multiplexed(pairs(settings))
            }
        };
        let lens_can_be_met = scene.camera.aperture().is_some();
        Estimator { scene, field, maker, candidates, lens_can_be_met }
    }

    /// n of (2).
    fn strategies(lens_can_be_met: bool, depth: usize) -> usize {
        depth + 2 + usize::from(lens_can_be_met)
    }

    /// A candidate for the start of a multiplexed chain: its worth W, and what is kept of it; `None` of other
    /// chains, whose starts are states as they are.
    pub(super) fn candidate(
        &mut self,
        sources: Sources,
        draws: &mut Draws,
        stats: &mut PassStats,
    ) -> Option<(f64, Option<Kept>)> {
        let met = self.lens_can_be_met;
        let candidates = self.candidates.as_mut()?;
        Some(candidates.find(sources, draws, |depth| Self::strategies(met, depth), stats))
    }

    /// The tile of the picture that a place of the film lies in.
    pub(super) fn tile(&self, film: Vec2) -> Option<usize> {
        self.field.tile(film)
    }

    /// What the film gets, of paths of `depth` bounces if they are multiplexed: into `splats`, and f. What
    /// is no number makes f one that is none.
    pub(super) fn light(
        &mut self,
        depth: usize,
        [eye, light, choice]: Sources,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) -> f64 {
        splats.clear();
        let bad = stats.bad_samples;
        let mut eye = Sampler::from_primary(eye);
        let mut light = Sampler::from_primary(light);
        let area = self.field.area() as f32;
        let scale = match &mut self.maker {
            Maker::Eye(paths) => {
                paths.trace(&mut eye, splats, stats);
                area
            }
            Maker::Whole(pairs) => {
                let most = pairs.longest();
                pair(self.scene, &self.field, pairs, most, [&mut eye, &mut light], splats, stats);
                area
            }
            Maker::Multiplexed(pairs) => {
                let n = Self::strategies(self.lens_can_be_met, depth);
                let s = ((n as f32 * choice.get_1d()) as usize).min(n - 1);
                let t = depth + 2 - s;
                pairs.keep_to(s, t);
                let most = subpaths((s, t));
                pair(self.scene, &self.field, pairs, most, [&mut eye, &mut light], splats, stats);
                area * n as f32
            }
        };
        splats.retain(|s| self.field.has(s.film));
        splats.iter_mut().for_each(|s| s.rgb = s.rgb.map(|v| scale * v));
        let sound = stats.bad_samples == bad;
        if sound { scalar(splats) } else { f64::NAN }
    }
}

/// A pair of subpaths, its strategies joined.
fn pair(
    scene: &Scene,
    field: &Field,
    pairs: &mut Pairs,
    most: [usize; 2],
    [eye, light]: [&mut Sampler; 2],
    splats: &mut Vec<Splat>,
    stats: &mut PassStats,
) {
    let (film, origin) = origin(scene, field, eye, most);
    let record = pairs.pair(&origin, [eye, light], false, splats, stats);
    let [by_path, _] = pairs.layers();
    let layers = by_path.iter().enumerate().map(|(k, c)| (Some(k), *c));
    for (layer, rgb) in std::iter::once((None, record.rgb)).chain(layers) {
        if rgb != [0.0; 3] {
            splats.push(Splat { film, layer, rgb });
        }
    }
}
