//! The estimator of one tree of rays.
//!
//! ```text
//! L(x) = Lₑ + Σ_l (f_o + w_l f_w) |cos θ_l| Lₑ V / q_l  +  Σ_j β_j w_b L(x_j)               (1)
//! q_l = N_l p_l p(l),   or p_l where every light is asked                                  (2)
//! Whitted:  the rays j are those of the Dirac lobes, each followed,   β_j = f |cos|          (3)
//! Cook:     n rays drawn from glossy and Dirac lobes alike,           β_j = f |cos| / (n p)  (4)
//! w_l = h(q_l, n p),  w_b = 1 - w_l                                                        (5)
//! ```
//!
//! f_w is the part of f by which rays go on, and f_o the rest: all that is smooth for Whitted, the
//! diffuse part for Cook. So light that two surfaces scatter everywhere is never found. w_b weighs
//! only the Lₑ of x_j; it is 1 where the light could not have been asked for: along Dirac lobes, from
//! lights without surface.
//!
//! Rays wait on a stack and carry their β; what they find goes to the film at once, as the
//! wavelengths of some may have ended. Where several numbers of a kind are needed at a hit they
//! are one number of the sampler's and its translations by an additive recurrence (6), (Roberts 2018),
//! so that they are spread over the lens of the light or the lobe, and each is uniform.

use super::params::{Secondary, TreeParams};
use crate::features::describe;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::path_space::MAX_PASSAGES;
use crate::roulette::{Roulette, WalkState};
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{ONE_MINUS_EPSILON, Ray, Vec2, Vec3};
use kaustika_sampling::{MisHeuristic, Sampler};
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::{LightChoice, LightId, LightSelection, Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Which lights a hit asks for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asked<'a> {
    /// Every one, once.
    Each,
    /// So many, chosen.
    Chosen(&'a LightSelection, u32),
}

/// Rays of a bounce beyond which roulette keeps their number: in clear glass, which takes no light, trees would never end.
const ABREAST: f32 = 1024.0;

/// Estimates pixels.
pub(super) struct Estimator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    asked: Asked<'a>,
    secondary: Secondary,
    /// By which lobes rays go on.
    walked: Lobes,
    mis: MisHeuristic,
    roulette: Roulette,
    max_depth: u32,
    hide_emitters: bool,
}

/// What threads work in.
#[derive(Default)]
pub(super) struct Room<'a> {
    bsdf: Bsdf<'a>,
    /// Rays that are still to be traced.
    rays: Vec<Branch<'a>>,
    record: PixelRecord,
}

/// A ray of the tree, and what it has behind it.
struct Branch<'a> {
    ray: Ray,
    t_max: f32,
    /// What the light that it finds is multiplied by.
    beta: Spectrum,
    /// The same without the numbers of rays: for roulette, which is to see one path, but of trees that grow [too wide](ABREAST).
    throughput: Spectrum,
    eta_scale: f32,
    depth: u32,
    passages: u32,
    footprint: f32,
    spread: f32,
    lambda: Wavelengths,
    /// The hit that sent it, with the normal on its side.
    from: (Vec3, Vec3),
    /// n p of its direction; `None` if lights could not be asked for in its place.
    density: Option<f32>,
    sampler: Sampler<'a>,
}

/// (6): number `i` of a sequence of points of the unit square that begins at `u`.
fn translated(u: Vec2, i: u32) -> Vec2 {
    // 1/φ and 1/φ², φ³ = φ + 1.
    let next = |u: f32, step: f64| ((f64::from(u) + f64::from(i) * step).fract()) as f32;
    let p = Vec2::new(next(u.x, 0.754_877_666_246_693), next(u.y, 0.569_840_290_998_053));
    Vec2::new(p.x.min(ONE_MINUS_EPSILON), p.y.min(ONE_MINUS_EPSILON))
}

/// Number `i` of `n`, one in each nth of the unit interval.
fn stratum(u: f32, i: u32, n: u32) -> f32 {
    ((i as f32 + u) / n as f32).min(ONE_MINUS_EPSILON)
}

impl<'a> Estimator<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        frame: &'a Frame,
        params: &TreeParams,
        asked: Asked<'a>,
    ) -> Estimator<'a> {
        Estimator {
            scene,
            frame,
            asked,
            secondary: params.secondary,
            walked: match params.secondary {
                Secondary::Each => Lobes::DELTA,
                Secondary::Drawn(_) => Lobes::SPECULAR,
            },
            mis: MisHeuristic::default(),
            roulette: params.roulette,
            max_depth: params.max_depth,
            hide_emitters: params.hide_emitters,
        }
    }

    /// One sample of one pixel.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut sampler = frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
        room.record = PixelRecord::default();
        room.rays.clear();
        room.rays.push(Branch {
            ray: camera.ray,
            t_max: camera.t_max,
            beta: Spectrum::splat(camera.weight),
            throughput: Spectrum::ONE,
            eta_scale: 1.0,
            depth: 0,
            passages: 0,
            footprint: camera.width * scene.footprint_scale,
            spread: camera.spread * scene.footprint_scale,
            lambda: Wavelengths::sample_for(scene.mode, u[5]),
            from: (camera.ray.o, Vec3::ZERO),
            density: None,
            sampler,
        });
        while let Some(ray) = room.rays.pop() {
            self.follow(ray, features, room, stats);
        }
        let rgb = frame.clamp(room.record.rgb);
        PixelRecord { rgb, weight: film.weight, ..room.record }
    }

    /// Adds what a ray finds, and puts the rays on the stack that go on from there: (1).
    fn follow(
        &self,
        mut branch: Branch<'a>,
        features: bool,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) {
        let scene = self.scene;
        let (ray, wo) = (branch.ray, -branch.ray.d);
        stats.closest_rays += 1;
        let shows = !(branch.depth == 0 && self.hide_emitters);
        let Some(mut surface) = scene.intersect(&ray, branch.t_max) else {
            if shows {
                self.add(branch.beta * self.escaped(&branch), &branch.lambda, room, stats);
            }
            return;
        };
        if let (true, Some(id)) = (shows, surface.light) {
            let le = self.met(id, &surface, &branch);
            self.add(branch.beta * le, &branch.lambda, room, stats);
        }
        branch.footprint += branch.spread * surface.t;
        surface.footprint = branch.footprint;
        if !scene.bsdf_into(&surface, wo, &mut branch.lambda, &mut room.bsdf) {
            branch.passages += 1;
            (branch.ray, branch.t_max) = (surface.spawn(ray.d), f32::INFINITY);
            if branch.passages <= MAX_PASSAGES {
                room.rays.push(branch);
            }
            return;
        }
        if features && branch.depth == 0 {
            describe(scene, &surface, &room.bsdf, wo, &branch.lambda, &mut room.record);
        }
        if branch.depth >= self.max_depth {
            return;
        }
        // Every hit draws as many numbers, so that those of one kind stay together.
        let u = branch.sampler.get_vertex();
        if room.bsdf.lobes().has(Lobes::SMOOTH) {
            let direct = self.direct(&surface, wo, &u, &branch.lambda, &room.bsdf, stats);
            self.add(branch.beta * direct, &branch.lambda, room, stats);
        }
        self.branch(&surface, &branch, &u, room);
    }

    /// The shadow rays' part of (1).
    fn direct(
        &self,
        s: &Surface,
        wo: Vec3,
        u: &[f32],
        lambda: &Wavelengths,
        bsdf: &Bsdf,
        stats: &mut PassStats,
    ) -> Spectrum {
        let scene = self.scene;
        let u2 = Vec2::new(u[0], u[1]);
        let mut sum = Spectrum::ZERO;
        let mut ask = |choice: LightChoice, n: f32| {
            let light = scene.light(choice.light);
            let sample = light.sample_li_in(scene, s.p, choice.region, choice.u, lambda);
            let Some(l) = sample else { return };
            let f = bsdf.eval(wo, l.wi, Mode::Radiance, Lobes::ALL);
            if f.is_black() || l.le.is_black() {
                return;
            }
            let q = n * choice.p * l.pdf_w; // (2)
            let f = if light.is_delta() { f } else { self.weighted(f, bsdf, (wo, l.wi), q) };
            stats.shadow_rays += 1;
            if !f.is_black() && !scene.occluded(&scene.shadow_ray(s, &l)) {
                sum += f * l.le / q;
            }
        };
        match self.asked {
            Asked::Each => {
                for (i, _) in scene.lights.iter().enumerate().filter(|(_, l)| l.connects()) {
                    let (light, u) = (LightId(i as u32), translated(u2, i as u32));
                    ask(LightChoice { light, region: None, p: 1.0, u }, 1.0);
                }
            }
            Asked::Chosen(lights, n) => {
                for i in 0..n {
                    let (u, u2) = (stratum(u[4], i, n), translated(u2, i));
                    if let Some(choice) = lights.sample(s.p, s.facing(wo), u, u2) {
                        ask(choice, n as f32);
                    }
                }
            }
        }
        sum
    }

    /// f_o + w_l f_w of (1): what is left of `f` to a light sample of density `q`.
    fn weighted(&self, f: Spectrum, bsdf: &Bsdf, (wo, wi): (Vec3, Vec3), q: f32) -> Spectrum {
        let Secondary::Drawn(n) = self.secondary else { return f };
        let (walked, (pdf, _)) = bsdf.eval_pdf(wo, wi, Mode::Radiance, self.walked);
        match walked.is_black() {
            true => f,
            false => f - walked * (1.0 - self.mis.light(q, n as f32 * pdf)), // (5)
        }
    }

    /// (3) and (4): the rays that go on from a hit.
    fn branch(&self, s: &Surface, from: &Branch<'a>, u: &[f32], room: &mut Room<'a>) {
        let Room { bsdf, rays, .. } = room;
        let (wo, u2) = (-from.ray.d, Vec2::new(u[2], u[3]));
        match self.secondary {
            Secondary::Each => {
                let mut count = 0;
                bsdf.sample_each(wo, (u[5], u2), Mode::Radiance, self.walked, |sample| {
                    rays.extend(self.child(s, from, sample, (count, 1), u[6]));
                    count += 1;
                });
            }
            Secondary::Drawn(n) => {
                for i in 0..n {
                    let (uc, u2) = (stratum(u[5], i, n), translated(u2, i));
                    let sample = bsdf.sample(wo, uc, u2, Mode::Radiance, self.walked);
                    rays.extend(
                        sample.and_then(|sample| self.child(s, from, &sample, (i, n), u[6])),
                    );
                }
            }
        }
    }

    /// Ray `i`, one of `n` that stand for the same light, if it survives.
    fn child(
        &self,
        s: &Surface,
        from: &Branch<'a>,
        sample: &BsdfSample,
        (i, n): (u32, u32),
        u: f32,
    ) -> Option<Branch<'a>> {
        let weight = sample.weight;
        let (beta, throughput) = (from.beta * weight / n as f32, from.throughput * weight);
        if beta.is_black() {
            return None;
        }
        let (eta_scale, depth) = (from.eta_scale * sample.eta * sample.eta, from.depth + 1);
        let abreast = (n as f32).powi(depth.min(1 << 16) as i32);
        let seen = throughput * (ABREAST / abreast).min(1.0);
        let q = self.roulette.q(&WalkState { beta: seen, eta_scale, weight, depth });
        if q < 1.0 && translated(Vec2::new(u, 0.0), i).x >= q {
            return None;
        }
        let q = q.min(1.0);
        let delta = sample.lobe.has(Lobes::DELTA);
        Some(Branch {
            ray: s.spawn(sample.wi),
            t_max: f32::INFINITY,
            beta: beta / q,
            throughput: throughput / q,
            eta_scale,
            depth,
            passages: 0,
            from: (s.p, s.facing(-from.ray.d)),
            density: (!delta).then_some(n as f32 * sample.pdf),
            sampler: from.sampler.branch(i.into())?,
            ..*from
        })
    }

    /// w_b Lₑ of a light that a ray met.
    fn met(&self, id: LightId, s: &Surface, branch: &Branch) -> Spectrum {
        let (light, d) = (self.scene.light(id), branch.ray.d);
        let le = light.le(self.scene, s, -d, &branch.lambda);
        let Some(density) = branch.density.filter(|_| !le.is_black()) else { return le };
        let (p, n) = branch.from;
        let of_light = match self.asked {
            Asked::Each => 1.0,
            Asked::Chosen(lights, count) => count as f32 * lights.pmf(p, n, id),
        };
        let q = of_light * light.pdf_li(self.scene, p, s, d); // (2)
        le * self.mis.bsdf(q, density) // (5)
    }

    /// w_b Lₑ of what surrounds the scene.
    fn escaped(&self, branch: &Branch) -> Spectrum {
        let (p, n) = branch.from;
        self.scene.environments.iter().fold(Spectrum::ZERO, |sum, &id| {
            let found = self.scene.light(id).escaped(p, branch.ray.d, &branch.lambda);
            let Some(density) = branch.density else { return sum + found.le };
            let of_light = match self.asked {
                Asked::Each => 1.0,
                Asked::Chosen(lights, count) => {
                    count as f32 * lights.pmf_escaped(p, n, id, found.region)
                }
            };
            sum + found.le * self.mis.bsdf(of_light * found.pdf_li, density)
        })
    }

    /// Adds light to the pixel. Bad numbers count as black.
    fn add(&self, l: Spectrum, lambda: &Wavelengths, room: &mut Room, stats: &mut PassStats) {
        if l.is_black() {
            return;
        }
        self.frame.add(&mut room.record.rgb, l, lambda, stats);
    }
}
