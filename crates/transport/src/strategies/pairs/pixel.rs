//! What a pair of subpaths shows in its own pixel.

use super::{Join, Pairs};
use crate::method::PassStats;
use crate::path_space::{self, CameraEnd, Closing, Escape, LightEnd, Subpath, Vertex};
use kaustika_math::Vec3;
use kaustika_scene::LightId;
use kaustika_spectra::{Spectrum, Wavelengths};

/// A light's subpath, and the end that emitted it, if one did.
pub(super) struct Lit<'l, 'a> {
    pub light: &'l [Vertex<'a>],
    pub end: Option<&'l LightEnd>,
}

impl<'a> Pairs<'a> {
    /// Those of (1) that end in this pixel, as linear RGB.
    pub(super) fn in_pixel(
        &mut self,
        lit: &Lit<'_, 'a>,
        (eye, escape): (&Subpath<'a>, Option<&Escape>),
        camera_end: &CameraEnd,
        stats: &mut PassStats,
    ) -> [f32; 3] {
        let (scene, frame) = (self.scene, self.frame);
        let mut rgb = [0.0; 3];
        let mut add = |l: Spectrum, lambda: &Wavelengths, stats: &mut PassStats| {
            let c = frame.sensor.rgb(l, lambda);
            match c.iter().all(|v| v.is_finite()) {
                true => rgb.iter_mut().zip(c).for_each(|(sum, v)| *sum += v),
                false => stats.bad_samples += 1,
            }
        };
        for glow in &eye.glows {
            if !self.wanted(0, glow.depth + 2) {
                continue;
            }
            add(glow.value, &glow.lambda, stats);
            let strategy = (0, glow.depth + 2);
            self.sort(strategy, &Closing::Glow(glow.depth), (glow.value, 1.0), &glow.lambda);
        }
        for (i, z) in eye.iter().enumerate() {
            if let Some(id) = z.surface.light {
                let le = scene.light(id).le(scene, &z.surface, z.wo, &z.lambda);
                let found = (id, z.surface.p, z.surface.ng, z.wo);
                if let Some(w) = self.found((&eye[..i], z.passing), camera_end, found, le) {
                    let l = z.beta * le;
                    add(l * w, &z.lambda, stats);
                    self.sort((0, i + 2), &Closing::Found(i, id), (l, w), &z.lambda);
                }
            }
            if !z.connects() {
                continue;
            }
            if let Some(l) = self.next_event(&eye[..=i], camera_end, stats) {
                add(l, &z.lambda, stats);
            }
            for j in 0..lit.light.len() {
                let Some(end) = lit.end else { break };
                let paths = (&lit.light[..=j], &eye[..=i]);
                if let Some((l, lambda)) = self.join(paths, end, camera_end, stats) {
                    add(l, &lambda, stats);
                }
            }
        }
        if let Some(escape) = escape {
            for &id in &scene.environments {
                let le = scene.light(id).escaped(escape.o, escape.d, &escape.lambda).le;
                let found = (id, Vec3::ZERO, Vec3::ZERO, -escape.d);
                if let Some(w) = self.found((eye, escape.passing), camera_end, found, le) {
                    let (l, i) = (escape.beta * le, eye.len());
                    add(l * w, &escape.lambda, stats);
                    self.sort((0, i + 2), &Closing::Found(i, id), (l, w), &escape.lambda);
                }
            }
        }
        rgb
    }

    /// w of (2): the eye's subpath, which met `eye`, found a light.
    fn found(
        &mut self,
        (eye, passing): (&[Vertex], f64),
        camera: &CameraEnd,
        (id, p, n, w): (LightId, Vec3, Vec3, Vec3),
        le: Spectrum,
    ) -> Option<f32> {
        let t = eye.len() + 2;
        if le.is_black() || !self.wanted(0, t) || (t == 2 && self.settings.hide_emitters) {
            return None;
        }
        let Some(last) = eye.last() else { return Some(1.0) };
        let end = LightEnd::new(self.scene, self.emission, id, p, n, w);
        let at_eye = (last.pdf, last.pdf_rev);
        let join = Join { at_eye, eye_delta: last.delta, passing, ..Join::default() };
        Some(self.weight(0, (&[], eye), &end, camera, &join))
    }

    /// (3), weighted.
    fn next_event(
        &mut self,
        eye: &[Vertex<'a>],
        camera: &CameraEnd,
        stats: &mut PassStats,
    ) -> Option<Spectrum> {
        if !self.wanted(1, eye.len() + 1) {
            return None;
        }
        let z = eye.last()?;
        let c = z.next_event(self.scene, self.lights, self.emission)?;
        let far = c.end.infinite;
        let (passage, w) = self.close(z, &c.segment, far, &z.lambda, stats, |this, passing| {
            let join = Join { at_eye: c.pdf, passing, ..Join::default() };
            this.weight(1, (&[], eye), &c.end, camera, &join)
        })?;
        let l = c.value * passage;
        let closing = Closing::NextEvent(eye.len() - 1, z, -c.end.w, c.end.light);
        self.sort((1, eye.len() + 1), &closing, (l, w), &z.lambda);
        Some(l * w)
    }

    /// (4), weighted.
    fn join(
        &mut self,
        (light, eye): (&[Vertex<'a>], &[Vertex<'a>]),
        end: &LightEnd,
        camera: &CameraEnd,
        stats: &mut PassStats,
    ) -> Option<(Spectrum, Wavelengths)> {
        let s = light.len() + 1;
        let (y, z) = (light.last()?, eye.last()?);
        if !self.wanted(s, eye.len() + 1) || !y.connects() {
            return None;
        }
        let c = path_space::join(y, z)?;
        let lambda = c.end.lambda;
        let (passage, w) = self.close(z, &c.segment, false, &lambda, stats, |this, passing| {
            let (at_light, at_eye) = (c.pdf, c.end.pdf_eye);
            let join = Join { at_light, at_eye, passing, ..Join::default() };
            this.weight(s, (light, eye), end, camera, &join)
        })?;
        let l = c.value * passage;
        let closing = Closing::Join((light.len() - 1, y), (eye.len() - 1, z));
        self.sort((s, eye.len() + 1), &closing, (l, w), &lambda);
        Some((l * w, lambda))
    }
}
