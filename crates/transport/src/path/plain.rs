//! The vertices of sixteen paths on plain surfaces at once: the twin of [`Integrator::vertex`],
//! whose formulas these are, for by far the most frequent cases.

use super::integrate::Integrator;
use super::pack::{Pack, lanes_of};
use crate::features::describe;
use crate::roulette::WalkStates;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s, cosine_hemisphere, mask_of};
use kaustika_math::{INV_PI, Ray, Vec2, Vec3};
use kaustika_sampling::sampler::VERTEX_NUMBERS;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::lanes::{Glosses, LampSamples, Plain, SurfaceHits, Surfaces, shadow_end};
use kaustika_scene::{Hit, Surface, TexturePoint};
use kaustika_spectra::{Spectrum, Wavelengths};

/// What the rays of a pack met, where it is plain.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(super) struct PlainHits<'a> {
    /// Which lanes.
    pub(super) lanes: u32,
    pub(super) surfaces: SurfaceHits,
    /// Distances.
    pub(super) t: Row,
    /// Albedo of the bare surface, or what a glossy lobe makes of it.
    pub(super) base: [Row; 4],
    pub(super) glosses: Glosses<'a>,
    /// Lanes whose surfaces reflect on their back.
    pub(super) two_sided: u32,
    /// The vertices' random numbers.
    pub(super) u: [Row; VERTEX_NUMBERS],
}

impl<'a> PlainHits<'a> {
    /// Sets what a lane's surface is made of, its albedo `rho`.
    #[inline(always)]
    pub(super) fn set_material(&mut self, lane: usize, plain: &'a Plain, rho: Spectrum) {
        let base = match &plain.gloss {
            Some(gloss) => self.glosses.set(lane, gloss, rho),
            None => rho,
        };
        self.base.iter_mut().zip(base.0).for_each(|(row, v)| row[lane % LANES] = v);
        let bit = 1 << (lane % LANES);
        self.two_sided = self.two_sided & !bit | if plain.two_sided { bit } else { 0 };
    }
}

/// Where the paths go from there.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Onward {
    /// Paths that go on.
    pub(super) alive: u32,
    /// Where their next rays start.
    pub(super) origin: [Row; 3],
    /// Paths with a light that is still to be seen.
    pub(super) lit: u32,
    /// Origins and directions of the rays to it, 1 long.
    pub(super) shadow_origin: [Row; 3],
    pub(super) shadow_d: [Row; 3],
    /// What it adds if nothing is in the way.
    pub(super) light: [Row; 4],
    /// Paths that met numbers that are none: they end, or lose their light, and are counted.
    pub(super) bad: u32,
}

impl<'a> Integrator<'a> {
    /// What only some vertices on plain surfaces need, of one path: adds what the surface emits,
    /// looks up its albedo where that varies, and takes note of the first surface's features. The
    /// point and its albedo.
    pub(super) fn plain_extras(
        &self,
        plain: &Plain,
        hit: &Hit,
        ray: &Ray,
        lambda: &Wavelengths,
        pack: &mut Pack,
        lane: usize,
        bsdf: &mut Bsdf<'a>,
        record: Option<&mut PixelRecord>,
    ) -> (Surface, Spectrum) {
        let scene = self.scene();
        let depth = pack.depth[lane];
        let mut surface = scene.geometry.surface(hit, ray);
        if self.shows(depth)
            && let Some(id) = surface.light
        {
            let le = self.emitted(id, &surface, ray, &pack.previous(lane), lambda);
            pack.add(lane, pack.beta(lane) * le);
        }
        surface.footprint = pack.footprint[lane] + pack.spread[lane] * surface.t;
        if let (Some(record), 0) = (record, depth)
            && scene.bsdf_into(&surface, -ray.d, &mut lambda.clone(), bsdf)
        {
            describe(scene, &surface, bsdf, -ray.d, lambda, record);
        }
        let rho = plain.constant.unwrap_or_else(|| {
            let at = TexturePoint::of(&scene.geometry, &surface);
            scene.textures.spectrum(plain.reflectance, &at, lambda)
        });
        (surface, rho)
    }

    /// Takes paths on from what their rays met to their next rays.
    #[inline(never)]
    pub(super) fn plain_vertices(
        &self,
        at: &PlainHits,
        lambdas: &[Wavelengths],
        pack: &mut Pack,
        out: &mut Onward,
    ) {
        let (zero, inv_pi) = (Lanes::splat(0.0), Lanes::splat(INV_PI));
        let lanes = mask_of(at.lanes);
        let s = at.surfaces.surfaces();
        let footprint = Lanes::new(pack.footprint);
        let grown = Lanes::new(pack.spread).mul_add(Lanes::new(at.t), footprint);
        pack.footprint = lanes.select(grown, footprint).to_array();

        // The side that is seen, and its frame.
        let d = Vec3s::load(&pack.d);
        let toward = -s.ns.dot(d);
        let behind = toward.simd_lt(zero);
        let n = (-s.ns).or(behind, s.ns);
        let ng = s.ng.face_forward(-d);
        let (b, t) = s.ns.coordinate_system();
        let t = (-t).or(behind, t);
        let to_local = |v: Vec3s| Vec3s { x: v.dot(b), y: v.dot(t), z: v.dot(n) };
        let base = at.base.map(Lanes::new);
        let glossy = at.glosses.lanes();
        let wo = -to_local(d);
        let seen = (glossy != 0).then(|| at.glosses.seen(wo));
        let eval_pdf = |wi: Vec3s| match &seen {
            Some(seen) => at.glosses.eval_pdf(seen, &base, wi),
            None => (base.map(|rho| rho * inv_pi * wi.z), wi.z * inv_pi),
        };

        let some = (base[0] + base[1] + base[2] + base[3]).simd_gt(zero) | mask_of(glossy);
        let depth = pack.depths();
        let open = depth.simd_lt(Lanes::splat(self.max_depth as f32));
        let live = lanes & (toward.simd_gt(zero) | (behind & mask_of(at.two_sided))) & some & open;
        let mut beta = pack.beta.map(Lanes::new);
        let u = at.u.map(Lanes::new);

        // Sample a light: its term of (1).
        (out.lit, out.bad) = (0, 0);
        let wanted = (live & self.counts_lanes(depth + Lanes::splat(1.0))).to_bitmask();
        if wanted != 0 {
            let (l, delta) = self.sample_lights(wanted, &s, ng, at, lambdas);
            let wi = to_local(l.wi);
            let (f, pdf_b) = eval_pdf(wi);
            let w = self.mis.light_lanes(l.pdf_w, pdf_b); // (3)
            let k = mask_of(delta).select(Lanes::splat(1.0), w) / l.pdf_w;
            let term: [Lanes; 4] = std::array::from_fn(|i| beta[i] * f[i] * l.le[i] * k);
            let sum = term[0] + term[1] + term[2] + term[3];
            let lit = mask_of(wanted) & wi.z.simd_gt(zero) & l.pdf_w.simd_gt(zero);
            out.bad = (lit & sum.is_nan()).to_bitmask();
            let ok = lit & sum.simd_gt(zero);
            out.lit = ok.to_bitmask();
            let o = s.origins(l.target - s.p);
            out.shadow_origin = o.to_rows();
            out.shadow_d = (l.target - o).to_rows();
            out.light = term.map(Lanes::to_array);
        }

        // Sample the BSDF for the next direction.
        let mut wi = cosine_hemisphere([u[2], u[3]]);
        let (mut pdf_w, mut weight) = (wi.z * inv_pi, base);
        if let Some(seen) = &seen {
            wi = at.glosses.sample(seen, u[5], [u[2], u[3]], wi);
            let (f, pdf) = eval_pdf(wi);
            let glossy = mask_of(glossy);
            pdf_w = pdf;
            weight = std::array::from_fn(|i| glossy.select(f[i] / pdf, base[i]));
        }
        let d = (n * wi.z).plus(b, wi.x).plus(t, wi.y);
        beta = std::array::from_fn(|i| beta[i] * weight[i]); // (2)
        let depth = depth + Lanes::splat(1.0);
        let scatters = wi.z.simd_gt(zero) & pdf_w.simd_gt(zero);
        let sum = beta[0] + beta[1] + beta[2] + beta[3];
        out.bad |= (live & scatters & sum.is_nan()).to_bitmask();

        // Russian roulette.
        let eta_scale = Lanes::new(pack.eta_scale);
        let q =
            self.roulette.q_lanes(&WalkStates { beta: &beta, eta_scale, weight: &weight, depth });
        let one = Lanes::splat(1.0);
        let survives = q.simd_ge(one) | u[6].simd_lt(q);
        let boost = q.simd_lt(one).select(one / q, one);
        let alive = live & scatters & survives;
        out.alive = alive.to_bitmask();

        // The other lanes keep what they have.
        let keep = |new: Lanes, old: &mut Row| {
            *old = alive.select(new, Lanes::new(*old)).to_array();
        };
        let keep_vec = |new: Vec3s, old: &mut [Row; 3]| {
            *old = new.or(alive, Vec3s::load(old)).to_rows();
        };
        for (new, old) in beta.into_iter().zip(&mut pack.beta) {
            keep(new * boost, old); // (4)
        }
        keep_vec(d, &mut pack.d);
        keep_vec(s.p, &mut pack.previous_p);
        keep_vec(ng, &mut pack.previous_n);
        keep(pdf_w, &mut pack.previous_pdf_w);
        pack.delta &= !out.alive;
        for (i, depth) in pack.depth.iter_mut().enumerate() {
            *depth += out.alive >> i & 1;
        }
        out.origin = s.origins(d).to_rows();
    }

    /// As [`Integrator::counts`], of sixteen paths.
    #[inline(always)]
    fn counts_lanes(&self, depth: Lanes) -> Lanes {
        let short = depth.simd_le(Lanes::splat(self.max_depth as f32));
        match self.only_depth {
            Some(only) => short & depth.simd_eq(Lanes::splat(only as f32)),
            None => short,
        }
    }

    /// A point of a light for each of the `wanted` lanes, and the lanes whose light is a Dirac's.
    #[inline(always)]
    fn sample_lights(
        &self,
        wanted: u32,
        s: &Surfaces,
        ng: Vec3s,
        at: &PlainHits,
        lambdas: &[Wavelengths],
    ) -> (LampSamples, u32) {
        match self.lamps {
            Some(lamps) if self.mis.samples_lights() => {
                (lamps.sample(s.p, [at.u[0], at.u[1]].map(Lanes::new)), 0)
            }
            _ => self.any_lights(wanted, s, ng, at, lambdas),
        }
    }

    /// As [`Integrator::sample_lights`] for lights of any kind, path by path.
    #[inline(never)]
    fn any_lights(
        &self,
        wanted: u32,
        s: &Surfaces,
        ng: Vec3s,
        at: &PlainHits,
        lambdas: &[Wavelengths],
    ) -> (LampSamples, u32) {
        let scene = self.scene();
        let (p, ng) = (s.p.to_rows(), ng.to_rows());
        let column = |v: &[Row; 3], lane: usize| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let mut choices = [None; LANES];
        for lane in lanes_of(wanted) {
            let (u, u2) = (at.u[4][lane], Vec2::new(at.u[0][lane], at.u[1][lane]));
            let choice = self.lights.sample(column(&p, lane), column(&ng, lane), u, u2);
            choices[lane] =
                choice.filter(|c| self.mis.samples_lights() || scene.light(c.light).is_delta());
        }
        let mut rows = [[0.0; LANES]; 15];
        let mut delta = 0;
        scene.sample_li_all(
            &choices,
            |lane| column(&p, lane),
            |lane| lambdas[lane],
            |lane, choice, l| {
                delta |= u32::from(l.delta) << lane;
                let reach = l.n.abs().dot(l.p_error);
                let [r, g, b, w] = l.le.0;
                let all = [
                    [l.wi.x, l.wi.y, l.wi.z, l.p.x, l.p.y],
                    [l.p.z, l.n.x, l.n.y, l.n.z, reach],
                    [choice.p * l.pdf_w, r, g, b, w],
                ];
                for (row, v) in rows.iter_mut().zip(all.as_flattened()) {
                    row[lane] = *v;
                }
            },
        );
        let [wx, wy, wz, px, py, pz, nx, ny, nz, reach, pdf_w, r, g, b, w] = rows.map(Lanes::new);
        let at = Vec3s { x: px, y: py, z: pz };
        let n = Vec3s { x: nx, y: ny, z: nz };
        let sample = LampSamples {
            wi: Vec3s { x: wx, y: wy, z: wz },
            target: shadow_end(s.p, at, reach, n),
            pdf_w,
            le: [r, g, b, w],
        };
        (sample, delta)
    }
}
