//! Paths as far as the camera.

use super::integrate::Integrator;
use super::walk::{Previous, Walk};
use kaustika_math::lanes::{LANES, Lanes, Row};
use kaustika_math::{Ray, Vec2, Vec3, warp};
use kaustika_sampling::Sampler;
use kaustika_sampling::sampler::VERTEX_NUMBERS;
use kaustika_scene::{CameraRay, Segment, ShapeSample};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

impl<'a> Integrator<'a> {
    /// The path of one sample of one pixel.
    #[inline]
    pub(super) fn start(&self, pixel: [u32; 2], index: u64) -> (Walk, Sampler<'a>) {
        let frame = self.frame();
        let mut sampler = frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = self.scene().camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
        let walk = self.begin_at(&camera, self.wavelengths(u[5]), &mut sampler);
        (Walk { film_weight: film.weight, ..walk }, sampler)
    }

    /// [`Integrator::start`] of up to sixteen pixels at once; `each` gets the paths in order.
    pub(super) fn start_all(
        &self,
        pixels: &[[u32; 2]],
        index: u64,
        samplers: &mut Vec<Sampler<'a>>,
        mut each: impl FnMut(&Walk),
    ) {
        let first = samplers.len();
        samplers.extend(pixels.iter().map(|&pixel| self.frame().sampler.start(pixel, index)));
        let mut u = [[0.0; LANES]; VERTEX_NUMBERS];
        Sampler::get_vertices(&mut samplers[first..], (1 << pixels.len()) - 1, &mut u);
        let mut film: [Row; 2] = [[0.0; LANES]; 2];
        let mut weights = [0.0; LANES];
        for (i, &pixel) in pixels.iter().enumerate().take(LANES) {
            let sample = self.frame().film_sample(pixel, Vec2::new(u[0][i], u[1][i]));
            [film[0][i], film[1][i], weights[i]] = [sample.film.x, sample.film.y, sample.weight];
        }
        let lens = [u[2], u[3]].map(Lanes::new);
        let rays = self.scene().camera.sample_we_lanes(film.map(Lanes::new), lens);
        let rays = rays.map(|r| (r.o.to_rows(), r.d.to_rows(), r.t_max.to_array(), r));
        for i in 0..pixels.len().min(LANES) {
            let time = u[4][i];
            let camera = match &rays {
                Some((o, d, t_max, r)) => {
                    let at = |rows: &[Row; 3]| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
                    let ray = Ray { o: at(o), d: at(d), time };
                    let (spread, width) = (r.spread, r.width);
                    CameraRay { ray, t_max: t_max[i], spread, width, weight: 1.0, receiver: None }
                }
                None => {
                    let (film, lens) =
                        (Vec2::new(film[0][i], film[1][i]), Vec2::new(u[2][i], u[3][i]));
                    self.scene().camera.sample_we(film, lens, time)
                }
            };
            let lambda = self.wavelengths(u[5][i]);
            let walk = self.begin_at(&camera, lambda, &mut samplers[first + i]);
            each(&Walk { film_weight: weights[i], ..walk });
        }
    }

    #[inline]
    fn wavelengths(&self, u: f32) -> Wavelengths {
        match self.scene().mode {
            ColorMode::Rgb => Wavelengths::rgb(),
            ColorMode::Spectral => Wavelengths::sample(u),
        }
    }

    /// [`Integrator::begin`]; from a meter's surface, lights are sampled at once.
    #[inline]
    fn begin_at(&self, camera: &CameraRay, lambda: Wavelengths, sampler: &mut Sampler) -> Walk {
        let walk = self.begin(camera, lambda);
        match &camera.receiver {
            Some(receiver) => self.receive(walk, receiver, sampler),
            None => walk,
        }
    }

    /// A path that begins as if a white matte surface had scattered it: the light's term of (1)
    /// there, and what the next emitter needs to know.
    #[inline(never)]
    fn receive(&self, mut walk: Walk, at: &ShapeSample, sampler: &mut Sampler) -> Walk {
        let density = |w: Vec3| warp::cosine_hemisphere_pdf_w(at.n.dot(w).max(0.0));
        let pdf_w = density(walk.segment.ray.d);
        walk.previous = Previous { p: at.p, n: at.n, pdf_w, delta: false };
        let u = sampler.get_vertex();
        if !self.shows(0) {
            return walk;
        }
        let scene = self.scene();
        let choice = self.lights.sample(at.p, at.n, u[4], Vec2::new(u[0], u[1]));
        let Some(choice) = choice else { return walk };
        let light = scene.light(choice.light);
        if !light.is_delta() && !self.mis.samples_lights() {
            return walk;
        }
        let sample = light.sample_li_in(scene, at.p, choice.region, choice.u, &walk.lambda);
        let Some(l) = sample else { return walk };
        // f cos = cos/π is the density of the direction, too.
        let (pdf_l, pdf_b) = (choice.p * l.pdf_w, density(l.wi));
        let w = if l.delta { 1.0 } else { self.mis.light(pdf_l, pdf_b) };
        if w * pdf_b > 0.0 && !scene.occluded(&scene.shadow_ray_from(at, &l)) {
            walk.radiance += walk.beta * l.le * (w * pdf_b / pdf_l);
        }
        walk
    }

    /// The path that begins with a camera ray.
    #[inline]
    pub(super) fn begin(&self, camera: &CameraRay, lambda: Wavelengths) -> Walk {
        let footprint_scale = self.scene().footprint_scale;
        Walk {
            segment: Segment { ray: camera.ray, t_max: camera.t_max },
            radiance: Spectrum::ZERO,
            beta: Spectrum::splat(camera.weight),
            eta_scale: 1.0,
            depth: 0,
            passages: 0,
            footprint: camera.width * footprint_scale,
            spread: camera.spread * footprint_scale,
            previous: Previous { p: camera.ray.o, n: Vec3::ZERO, pdf_w: 1.0, delta: true },
            lambda,
            film_weight: 1.0,
        }
    }
}
