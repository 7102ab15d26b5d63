//! What a pair of subpaths shows in other pixels: its light's side, at the lens.
//!
//! ```text
//! C_{s,1} = βᴸ f |cos| V Wₑ / p_C                   to the lens                         (1)
//! C_{s,0} = βᴸ Wₑ                                   light meets the lens                (2)
//! ```

use super::{Join, Pairs, Piece};
use crate::method::PassStats;
use crate::path_space::{self, CameraEnd, Closing, LightEnd, Splat, Vertex, splat};
use kaustika_math::Vec2;
use kaustika_scene::Segment;
use kaustika_spectra::{Spectrum, Wavelengths};

impl<'a> Pairs<'a> {
    /// (1) and (2), weighted.
    pub(super) fn connect_lens(
        &mut self,
        light: &[Vertex<'a>],
        end: &LightEnd,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let Some(y) = light.last() else { return };
        let s = light.len() + 1;
        if self.wanted(s, 1)
            && y.connects()
            && let Some(c) = path_space::to_lens(self.scene, y)
        {
            let closed = self.close(y, &c.segment, false, &y.lambda, stats, |this, passing| {
                let join = Join { at_light: c.pdf, passing, ..Join::default() };
                this.weight(s, (light, &[]), end, &c.end.camera, &join)
            });
            if let Some((passage, w)) = closed {
                let d = c.segment.ray.d.normalize();
                let closing = Closing::ToLens(light.len() - 1, y, d);
                let l = (c.value * passage, w);
                self.splat((s, 1), &closing, l, c.end.film, &y.lambda, splats, stats);
            }
        }
        if y.onward.is_some() && self.wanted(s + 1, 0) {
            self.at_lens(light, end, splats, stats);
        }
    }

    /// (2), weighted: where the light path goes on from its last vertex.
    fn at_lens(
        &mut self,
        light: &[Vertex<'a>],
        end: &LightEnd,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let (scene, Some(y)) = (self.scene, light.last()) else { return };
        let Some((ray, beta)) = y.onward else { return };
        let Some(hit) = scene.camera.meet_lens(&ray) else { return };
        let back = kaustika_math::Ray { o: hit.p, d: -ray.d, time: ray.time };
        let camera = CameraEnd::new(scene, &back);
        let segment = Segment { ray, t_max: (hit.p_near - ray.o).length() };
        let s = light.len() + 2;
        let closed = self.close(y, &segment, false, &y.lambda, stats, |this, passing| {
            let at_light = (y.pdf, y.pdf_rev);
            let join = Join { at_light, light_delta: y.delta, passing, ..Join::default() };
            this.weight(s, (light, &[]), end, &camera, &join)
        });
        if let Some((passage, w)) = closed {
            let closing = Closing::AtLens(light.len());
            let l = (beta * hit.we * passage, w);
            self.splat((s, 0), &closing, l, hit.film, &y.lambda, splats, stats);
        }
    }

    #[expect(clippy::too_many_arguments)]
    fn splat(
        &mut self,
        (s, t): (usize, usize),
        closing: &Closing,
        (value, w): (Spectrum, f32),
        film: Vec2,
        lambda: &Wavelengths,
        splats: &mut Vec<Splat>,
        stats: &mut PassStats,
    ) {
        let (frame, tracks) = (self.frame, self.tracks.as_ref());
        let value = value * self.splat_scale;
        if w > 0.0 {
            splat(frame, tracks, closing, value * w, film, lambda, splats, stats);
        }
        if let (Some(pieces), true) = (&mut self.pieces, w > 0.0) {
            let rgb = frame.clamp(frame.sensor.rgb(value * w, lambda));
            pieces.push(Piece { strategy: (s, t), film: Some(film), rgb });
        }
        let layers = self.pyramid.as_ref().and_then(|p| p.numbers(s, t));
        for (layer, v) in layers.into_iter().flatten().zip([value * w, value]) {
            let rgb = frame.sensor.rgb(v, lambda);
            if rgb.iter().all(|v| v.is_finite()) {
                splats.push(Splat { film, layer: Some(layer), rgb: frame.clamp(rgb) });
            }
        }
    }
}
