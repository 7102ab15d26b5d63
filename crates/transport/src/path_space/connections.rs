//! Where paths are closed: a surface asks for a light, two surfaces are joined, a surface asks
//! for the lens. Contributions without weights, and all that weights ask for.
//!
//! ```text
//! C_{1,t} = βᴱ f |cos| Lₑ / p_D                 (3)
//! C_{s,t} = βᴸ f |cos| / d² f |cos| βᴱ          (4)
//! C_{s,1} = βᴸ f |cos| Wₑ / p_C                 (5)
//! ```
//!
//! Whether anything stands between is asked last, by whoever needs it.

use super::{CameraEnd, LightEnd, Vertex};
use kaustika_math::{Ray, Vec2};
use kaustika_scene::bsdf::Mode;
use kaustika_scene::{LightSelection, Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A path closed in one of the three ways.
#[derive(Clone, Copy, Debug)]
pub struct Connection<E> {
    /// Contribution if nothing is in the way.
    pub value: Spectrum,
    /// The ray that finds out.
    pub segment: Segment,
    /// Densities per solid angle at the surface that asks: of the connection's direction, and of
    /// the way back.
    pub pdf: (f64, f64),
    /// What it was connected to.
    pub end: E,
}

/// A place on the film.
#[derive(Clone, Copy, Debug)]
pub struct LensConnection {
    /// The end.
    pub camera: CameraEnd,
    /// Where it shows.
    pub film: Vec2,
}

/// The other end of (4).
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// As [`Connection::pdf`], at the eye's vertex.
    pub pdf_eye: (f64, f64),
    /// Wavelengths that both have.
    pub lambda: Wavelengths,
}

impl Vertex<'_> {
    /// (3): this vertex of an eye path asks `lights` for a light; `emission` is how lights are
    /// chosen to emit.
    pub fn next_event(
        &self,
        scene: &Scene,
        lights: &LightSelection,
        emission: &LightSelection,
    ) -> Option<Connection<LightEnd>> {
        let [u0, u1, u] = self.u;
        let s = &self.surface;
        let choice = lights.sample(s.p, self.light_normal(), u, Vec2::new(u0, u1))?;
        let light = scene.light(choice.light);
        let l = light.sample_li_in(scene, s.p, choice.region, choice.u, &self.lambda)?;
        let (f, pdf) = self.eval_pdf(l.wi, Mode::Radiance);
        let value = self.beta * f * l.le / (choice.p * l.pdf_w);
        let end = || LightEnd::new(scene, emission, choice.light, l.p, l.n, -l.wi);
        let segment = || match self.inside {
            None => scene.shadow_ray(s, &l),
            Some(_) => scene.shadow_ray_in_space(s.p, s.time, &l),
        };
        (!value.is_black()).then(|| Connection { value, segment: segment(), pdf, end: end() })
    }
}

/// (4): the vertices `y` of a light path and `z` of an eye path are joined.
pub fn join(y: &Vertex, z: &Vertex) -> Option<Connection<Joined>> {
    let to_eye = z.surface.p - y.surface.p;
    let d2 = to_eye.length_squared();
    let d = to_eye.try_normalize()?;
    let (f_y, pdf_y) = y.eval_pdf(d, Mode::Importance);
    let (f_z, pdf_z) = z.eval_pdf(-d, Mode::Radiance);
    let value = y.beta * f_y * f_z * z.beta / d2;
    if value.is_black() {
        return None;
    }
    // Ends before the other surface as it begins before its own.
    let target = y.spawn(to_eye).o;
    // A dispersed path leaves the other nothing but the hero.
    let lambda = if y.lambda.secondary_terminated() { y.lambda } else { z.lambda };
    Some(Connection {
        value,
        segment: Segment { ray: z.spawn_to(target), t_max: 1.0 },
        pdf: pdf_y,
        end: Joined { pdf_eye: pdf_z, lambda },
    })
}

/// (5): the vertex `y` of a light path asks for the lens. The value is that of one light path
/// for each picture.
pub fn to_lens(scene: &Scene, y: &Vertex) -> Option<Connection<LensConnection>> {
    let c = scene.camera.sample_wi(y.surface.p, Vec2::new(y.u[0], y.u[1]), y.surface.time)?;
    let (f, pdf) = y.eval_pdf(c.wi, Mode::Importance);
    let value = y.beta * f * (c.we / c.pdf_w);
    let ray = Ray { o: c.p_lens, d: -c.wi, time: y.surface.time };
    (!value.is_black()).then(|| Connection {
        value,
        segment: Segment { ray: y.spawn_to(c.p_near), t_max: 1.0 },
        pdf,
        end: LensConnection { camera: CameraEnd::new(scene, &ray), film: c.film },
    })
}
