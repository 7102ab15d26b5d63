//! x₀: where a path meets a light, and with what densities.

use super::{Departure, Start, Vertex, solid_angle_to_area};
use kaustika_math::{Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::{Light, LightChoice, LightId, LightSelection, Scene};
use kaustika_spectra::Wavelengths;

/// How lights are chosen to emit: by power.
pub fn emission_table(scene: &Scene) -> LightSelection {
    LightSelection::for_emission(scene)
}

/// The light's end of a path.
#[derive(Clone, Copy, Debug)]
pub struct LightEnd {
    /// Which light.
    pub light: LightId,
    /// The point; of a light at infinity any on the ray.
    pub p: Vec3,
    /// Normal there; zero for lights without a surface.
    pub n: Vec3,
    /// Direction in which the light goes.
    pub w: Vec3,
    /// Density of x₀ by emission, the choice of the light included.
    pub emission: f64,
    /// How x₁ follows by emission.
    pub departure: Departure,
    /// True if the eye's side can find it.
    pub hittable: bool,
    /// True if it is a direction.
    pub infinite: bool,
}

impl LightEnd {
    /// The end of a path that leaves the point `p`, with normal `n`, of a light along `w`;
    /// `table` is [`emission_table`]'s.
    pub fn new(
        scene: &Scene,
        table: &LightSelection,
        id: LightId,
        p: Vec3,
        n: Vec3,
        w: Vec3,
    ) -> LightEnd {
        let light = scene.light(id);
        let pmf = f64::from(table.pmf(p, n, id));
        let (pdf_a, pdf_w) = light.pdf_le(scene, p, n, w);
        let infinite = light.is_infinite();
        // Dirac densities are 0 there.
        let dirac = |fixed: bool, pdf: f32| if fixed { 1.0 } else { f64::from(pdf) };
        let (emission, departure) = match infinite {
            // Whatever makes the path has the same density of x₀ and x₁ as any other way.
            _ if !light.connects() => (1.0, Departure::Fixed),
            true => {
                let pdf_a = f64::from(pdf_a);
                (dirac(light.is_dirac(), pdf_w), Departure::Parallel { d: w, pdf_a })
            }
            false => {
                let pdf_w = f64::from(pdf_w);
                (dirac(light.is_dirac(), pdf_a), Departure::Point { p, pdf_w })
            }
        };
        let hittable = !light.is_delta();
        LightEnd { light: id, p, n, w, emission: pmf * emission, departure, hittable, infinite }
    }

    /// An emitted ray, its light chosen by `table`.
    pub fn emit(
        scene: &Scene,
        table: &LightSelection,
        lambda: &Wavelengths,
        time: f32,
        sampler: &mut Sampler,
    ) -> Option<(LightEnd, Start)> {
        let u = sampler.get_vertex();
        let choice = table.sample(Vec3::ZERO, Vec3::ZERO, u[4], Vec2::new(u[0], u[1]))?;
        LightEnd::emit_chosen(scene, table, &choice, Vec2::new(u[2], u[3]), lambda, time)
    }

    /// As [`LightEnd::emit`], where light and point were chosen, `v` chooses the direction, and
    /// `choice.p` is the density of all these choices.
    pub fn emit_chosen(
        scene: &Scene,
        table: &LightSelection,
        choice: &LightChoice,
        v: Vec2,
        lambda: &Wavelengths,
        time: f32,
    ) -> Option<(LightEnd, Start)> {
        let light = scene.light(choice.light);
        let mut e = light.sample_le(scene, choice.u, v, lambda)?;
        e.ray.time = time;
        // The normal as the surface has it, on whichever side the ray leaves.
        let end = LightEnd::new(scene, table, choice.light, e.ray.o, e.n, e.ray.d);
        let start = Start {
            ray: e.ray,
            t_max: f32::INFINITY,
            beta: e.le * (e.cos / (choice.p * e.pdf_a * e.pdf_w)),
            lambda: *lambda,
            departure: end.departure,
            medium: scene.medium_at_light(choice.light, e.n, e.ray.d),
            footprint: 0.0,
            spread: 0.0,
        };
        (!start.beta.is_black()).then_some((end, start))
    }

    /// Density of x₀ if the vertex x₁ asks `lights` for a light.
    pub fn next_event(&self, scene: &Scene, lights: &LightSelection, x1: &Vertex) -> f64 {
        self.asked_from(scene, lights, x1.surface.p, x1.light_normal())
    }

    /// The same, x₁ being at `p` and choosing lights with the normal `n`.
    pub fn asked_from(&self, scene: &Scene, lights: &LightSelection, p: Vec3, n: Vec3) -> f64 {
        let light = scene.light(self.light);
        let wi = -self.w;
        if let Light::Environment(_) = light {
            let e = light.escaped(p, wi, &Wavelengths::rgb());
            let pmf = lights.pmf_escaped(p, n, self.light, e.region);
            return f64::from(pmf) * f64::from(e.pdf_li);
        }
        let pmf = f64::from(lights.pmf(p, n, self.light));
        if !light.connects() {
            return 0.0;
        }
        if light.is_dirac() {
            return pmf;
        }
        pmf * f64::from(light.pdf_li_at(scene, p, self.p, self.n, wi)) * self.area(p)
    }

    /// What turns a density per solid angle at `from` into one of x₀.
    #[inline]
    pub fn area(&self, from: Vec3) -> f64 {
        if self.infinite { 1.0 } else { solid_angle_to_area(from, self.p, self.n) }
    }
}
