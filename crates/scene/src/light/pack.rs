//! Samples of lights for sixteen points at once.
//!
//! A sample of an environment's image reads a tile of a table, then texels, and both are rarely in
//! the cache. One after the other, samples wait for the memory again and again; step by step for
//! all points, they wait together.

use super::{Light, LightChoice, LightSample};
use crate::Scene;
use kaustika_math::Vec3;
use kaustika_math::lanes::LANES;
use kaustika_spectra::Wavelengths;

impl Scene {
    /// [`Light::sample_li_in`] for up to sixteen choices; `each` gets the samples with their
    /// lanes. `from` and `lambda` are asked for the lanes that have a choice.
    #[inline]
    pub fn sample_li_all(
        &self,
        choices: &[Option<LightChoice>; LANES],
        from: impl Fn(usize) -> Vec3,
        lambda: impl Fn(usize) -> Wavelengths,
        mut each: impl FnMut(usize, &LightChoice, &LightSample),
    ) {
        let light = |choice: &LightChoice| self.light(choice.light);
        let mut tiles = [None; LANES];
        for (tile, choice) in tiles.iter_mut().zip(choices) {
            let Some(choice) = choice else { continue };
            let Light::Environment(environment) = light(choice) else { continue };
            *tile =
                environment.sky().and_then(|sky| Some((sky, sky.choose(choice.region, choice.u)?)));
        }
        for (sky, tile) in tiles.iter().flatten() {
            sky.touch_tile(tile);
        }
        let cells = tiles.map(|tile| tile.and_then(|(sky, tile)| Some((sky, sky.cell(&tile)?))));
        for (sky, cell) in cells.iter().flatten() {
            sky.touch(cell);
        }
        for (lane, (choice, cell)) in choices.iter().zip(&cells).enumerate() {
            let Some(choice) = choice else { continue };
            let (from, lambda) = (from(lane), lambda(lane));
            let sample = match (light(choice), cell) {
                (Light::Environment(environment), Some((_, cell))) => {
                    environment.sample_li_of_cell(self, from, cell, &lambda)
                }
                (light, _) => light.sample_li_in(self, from, choice.region, choice.u, &lambda),
            };
            if let Some(sample) = &sample {
                each(lane, choice, sample);
            }
        }
    }
}
