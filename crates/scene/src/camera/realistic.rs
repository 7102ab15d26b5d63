//! A camera with a lens of many surfaces (Kolb, Mitchell & Hanrahan 1995, "A realistic camera model
//! for computer graphics"; Pharr et al. 2023, sec. 5.4.1 to 5.4.6 of the third edition).
//!
//! ```text
//! E(p) = ∫ L(p', p) cos⁴θ/z² dA    over the rear surface at distance z                       (1)
//! ray weight = T cos⁴θ / (p_A z²)                                                            (2)
//! (y, nu) ↦ M (y, nu),  M = (A B; C D),  f = -1/C                                            (3)
//! h' = (A - 1) f,  h = (1 - D) f    principal planes behind the rear and the front surface    (4)
//! 1/a + 1/(k - a) = 1/f             the film at a behind h', the object at k - a before h     (5)
//! ```
//!
//! A pixel is (1), the irradiance of the film for light of radiance L, as in pbrt: not the mean
//! radiance that cameras without a lens measure, from which it differs by the solid angle of the
//! exit pupil times cosines, about π/4N² at f-number N. (2) is drawn from a box around what the
//! film's point sees of the exit pupil. Nothing is connected to such a lens: no density tells where
//! on the film a point shows. Reflections at the surfaces are left out.

use super::CameraRay;
use super::aperture::Aperture;
use crate::description::{LensDesc, LensSurface, Span};
use crate::error::BuildError;
use kaustika_math::{Ray, Transform, Vec2, Vec3};
use std::sync::Arc;

/// Rings of the film, for each of which the exit pupil is bounded.
const RINGS: usize = 64;
/// Samples along a side that a pupil is bounded with.
const SIDE: u32 = 192;

/// A film behind a lens. In its space the film is at z = 0, the scene at positive z.
#[derive(Clone, Debug)]
pub struct Realistic {
    to_world: Transform,
    /// From the film to the scene.
    surfaces: Vec<Surface>,
    stop: Option<Arc<Aperture>>,
    /// What a ring of the film sees of the pupil, on the plane of the rear surface, for the point
    /// on the ring along +x.
    pupils: Vec<Option<Pupil>>,
    /// Extent of the film, m.
    extent: Vec2,
    resolution: [f32; 2],
    /// Angle that a pixel's width fills in the middle.
    spread: f32,
}

/// A part of the plane of the rear surface.
#[derive(Clone, Copy, Debug)]
struct Pupil {
    min: Vec2,
    max: Vec2,
}

impl Pupil {
    fn contains(&self, p: Vec2) -> bool {
        p.x >= self.min.x && p.y >= self.min.y && p.x <= self.max.x && p.y <= self.max.y
    }

    fn with(&self, p: Vec2) -> Pupil {
        Pupil {
            min: Vec2::new(self.min.x.min(p.x), self.min.y.min(p.y)),
            max: Vec2::new(self.max.x.max(p.x), self.max.y.max(p.y)),
        }
    }
}

/// A surface as light from the film meets it.
#[derive(Clone, Copy, Debug)]
struct Surface {
    /// Where its vertex is.
    z: f32,
    /// See [`LensSurface::radius`].
    radius: f32,
    /// Index before over index beyond.
    eta: f32,
    aperture_radius: f32,
}

impl Realistic {
    /// From a description.
    ///
    /// # Errors
    /// If the lens has no focal length, or can't be focused so near.
    pub fn new(
        lens: &LensDesc,
        to_world: Transform,
        resolution: [u32; 2],
        span: Option<Span>,
    ) -> Result<Realistic, BuildError> {
        let fault = |message: String| BuildError::new(span, message);
        let (film_distance, behind) = focus(lens).map_err(fault)?;
        let mut surfaces = Vec::with_capacity(lens.surfaces.len());
        let mut z = film_distance;
        for (i, s) in lens.surfaces.iter().enumerate().rev() {
            if i + 1 < lens.surfaces.len() {
                z += s.thickness;
            }
            let beyond = if i > 0 { ior(&lens.surfaces[i - 1]) } else { 1.0 };
            let (radius, aperture_radius) = (s.radius, s.aperture_radius);
            surfaces.push(Surface { z, radius, eta: ior(s) / beyond, aperture_radius });
        }
        let stop = match &lens.aperture {
            Some(shape) => {
                let dark = || fault("the lens's aperture lets no light through".into());
                Some(Arc::new(Aperture::new(shape).ok_or_else(dark)?))
            }
            None => None,
        };
        let size = resolution.map(|n| n as f32);
        let across = lens.film_diagonal / size[0].hypot(size[1]);
        let mut camera = Realistic {
            to_world,
            surfaces,
            stop,
            pupils: Vec::new(),
            extent: Vec2::new(size[0] * across, size[1] * across),
            resolution: size,
            spread: across / behind,
        };
        let radius = |ring: usize| 0.5 * lens.film_diagonal * ring as f32 / RINGS as f32;
        camera.pupils = (0..RINGS).map(|i| camera.pupil(radius(i), radius(i + 1))).collect();
        Ok(camera)
    }

    /// The ray through a film position and a place of the exit pupil; its weight is 0 where the lens
    /// lets nothing through.
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let found = self.through(film, lens);
        let (o, d, weight) = found.unwrap_or((Vec3::ZERO, Vec3::Z, 0.0));
        let (o, d) = (self.to_world.point(o), self.to_world.vector(d).normalize());
        let t_max = if weight > 0.0 { f32::INFINITY } else { 0.0 };
        let ray = Ray { o, d, time };
        CameraRay { ray, t_max, spread: self.spread, width: 0.0, weight, receiver: None }
    }

    /// In the camera's space: origin and unit direction of the ray that leaves the lens, and (2).
    fn through(&self, film: Vec2, lens: Vec2) -> Option<(Vec3, Vec3, f32)> {
        // The picture on the film is upside down.
        let x = (0.5 - film.x / self.resolution[0]) * self.extent.x;
        let y = (film.y / self.resolution[1] - 0.5) * self.extent.y;
        let from = Vec3::new(x, y, 0.0);
        let r = x.hypot(y);
        let ring = (2.0 * r / self.extent.x.hypot(self.extent.y) * RINGS as f32) as usize;
        let pupil = self.pupils[ring.min(RINGS - 1)]?;
        let size = pupil.max - pupil.min;
        let p = Vec2::new(pupil.min.x + lens.x * size.x, pupil.min.y + lens.y * size.y);
        let (c, s) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
        let z = self.surfaces.first()?.z;
        let d = Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, z) - from;
        let d = d.normalize();
        let (o, out, t) = self.trace(from, d)?;
        let cos2 = d.z * d.z;
        Some((o, out, t * cos2 * cos2 * size.x * size.y / (z * z))) // (2)
    }

    /// A ray from the film through the lens: where and how it leaves, and what the stop lets
    /// through of it.
    fn trace(&self, mut o: Vec3, mut d: Vec3) -> Option<(Vec3, Vec3, f32)> {
        let mut let_through = 1.0;
        for s in &self.surfaces {
            if s.radius == 0.0 {
                if d.z <= 0.0 {
                    return None;
                }
                o += d * ((s.z - o.z) / d.z);
                let k = 1.0 / s.aperture_radius;
                match &self.stop {
                    Some(stop) if (o.x * k).abs().max((o.y * k).abs()) <= 1.0 => {
                        let_through *= stop.transmittance(Vec2::new(o.x * k, o.y * k));
                        if let_through <= 0.0 {
                            return None;
                        }
                    }
                    None if o.x * o.x + o.y * o.y <= s.aperture_radius * s.aperture_radius => {}
                    _ => return None,
                }
                continue;
            }
            // The sphere about z - R: its near side where it bulges toward the film.
            let to_center = Vec3::new(0.0, 0.0, s.z - s.radius) - o;
            let along = to_center.dot(d);
            let across = to_center - d * along;
            let half2 = s.radius * s.radius - across.length_squared();
            if half2 < 0.0 {
                return None;
            }
            let half = if s.radius < 0.0 { -half2.sqrt() } else { half2.sqrt() };
            let t = along + half;
            if t < 0.0 {
                return None;
            }
            let n = (d * t - to_center) / s.radius.abs();
            o += d * t;
            if o.x * o.x + o.y * o.y > s.aperture_radius * s.aperture_radius {
                return None;
            }
            // Snell's law, n against the ray.
            let n = if n.dot(d) > 0.0 { -n } else { n };
            let cos_i = -n.dot(d);
            let cos2_t = 1.0 - s.eta * s.eta * (1.0 - cos_i * cos_i);
            if cos2_t < 0.0 {
                return None;
            }
            d = (d * s.eta + n * (s.eta * cos_i - cos2_t.sqrt())).normalize();
        }
        Some((o, d, let_through))
    }

    /// A box around what the film's points (r, 0), r in [r0, r1], see of the exit pupil, on the plane
    /// of the rear surface.
    fn pupil(&self, r0: f32, r1: f32) -> Option<Pupil> {
        let rear = self.surfaces.first()?;
        let half = 1.5 * rear.aperture_radius;
        let step = 2.0 * half / SIDE as f32;
        let mut found: Option<Pupil> = None;
        for i in 0..SIDE * SIDE {
            let at = |k: u32| (k as f32 + 0.5) * step - half;
            let p = Vec2::new(at(i % SIDE), at(i / SIDE));
            if found.is_some_and(|b| b.contains(p)) {
                continue;
            }
            let seen = [r0, 0.5 * (r0 + r1), r1].iter().any(|r| {
                let from = Vec3::new(*r, 0.0, 0.0);
                self.trace(from, (Vec3::new(p.x, p.y, rear.z) - from).normalize()).is_some()
            });
            if seen {
                found = Some(found.map_or(Pupil { min: p, max: p }, |b| b.with(p)));
            }
        }
        let room = Vec2::splat(1.5 * step);
        found.map(|b| Pupil { min: b.min - room, max: b.max + room })
    }

    /// See [`super::Camera::up`].
    pub fn up(&self) -> Vec3 {
        self.to_world.vector(Vec3::Y)
    }

    /// Where the film is.
    pub fn position(&self) -> Vec3 {
        self.to_world.point(Vec3::ZERO)
    }
}

/// The index beyond a surface; files write 0 for air.
fn ior(s: &LensSurface) -> f32 {
    if s.ior > 0.0 { s.ior } else { 1.0 }
}

/// Distance of the film from the rear surface, and from the principal plane, by (3) to (5).
fn focus(lens: &LensDesc) -> Result<(f32, f32), String> {
    let [mut a, mut b, mut c, mut d] = [1.0f64, 0.0, 0.0, 1.0];
    let (mut before, mut length) = (1.0f64, 0.0f64);
    for (i, s) in lens.surfaces.iter().enumerate() {
        let beyond = f64::from(ior(s));
        if s.radius != 0.0 {
            let power = (beyond - before) / f64::from(s.radius);
            (c, d) = (c - power * a, d - power * b);
        }
        before = beyond;
        if i + 1 < lens.surfaces.len() {
            let t = f64::from(s.thickness);
            (a, b) = (a + t / beyond * c, b + t / beyond * d);
            length += t;
        }
    }
    let f = -1.0 / c; // (3)
    if !(f.is_finite() && f > 0.0) {
        return Err("the lens gathers no light: its focal length is not positive".into());
    }
    let (behind, front) = ((a - 1.0) * f, (1.0 - d) * f); // (4)
    let k = f64::from(lens.focus_distance) - length + front - behind;
    let root = k * k - 4.0 * k * f;
    if root < 0.0 || k <= 0.0 {
        let message = format!(
            "the lens (f = {:.1} mm) can't be focused at {} m: choose a greater `focusdistance`",
            1000.0 * f,
            lens.focus_distance
        );
        return Err(message);
    }
    let from_plane = 0.5 * (k - root.sqrt()); // (5)
    let film = from_plane + behind;
    if film <= 0.0 {
        return Err("focused, the film would be within the lens".into());
    }
    Ok((film as f32, from_plane as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::ApertureShape;
    use std::f32::consts::PI;

    fn surface(radius: f32, thickness: f32, ior: f32, aperture_radius: f32) -> LensSurface {
        LensSurface { radius, thickness, ior, aperture_radius }
    }

    /// A thin lens of f = 0.1 m, f-number 0.1/2r, and behind it at once a stop.
    fn thin(stop: f32, focus_distance: f32, aperture: Option<ApertureShape>) -> LensDesc {
        // Thick enough that its surfaces do not meet within the stop.
        let thickness = (15.0 * stop * stop).max(2e-4);
        let surfaces = vec![
            surface(0.1, thickness, 1.5, 0.02),
            surface(-0.1, 1e-5, 1.0, 0.02),
            surface(0.0, 0.0, 0.0, stop),
        ];
        LensDesc { surfaces, focus_distance, film_diagonal: 0.04, aperture }
    }

    fn camera(lens: &LensDesc) -> Realistic {
        Realistic::new(lens, Transform::IDENTITY, [80, 60], None).expect("a lens")
    }

    fn grid(n: u32) -> impl Iterator<Item = Vec2> {
        (0..n * n).map(move |i| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32)
    }

    #[test]
    fn rays_meet_where_the_lens_equation_says() {
        // 1/a + 1/b = 1/f, a + b = 1.
        let camera = camera(&thin(0.002, 1.0, None));
        let a = 0.5 * (1.0 - (1.0f32 - 0.4).sqrt());
        assert!((camera.surfaces[0].z - a).abs() < 2e-4, "{}", camera.surfaces[0].z);
        for film in [Vec2::new(40.0, 30.0), Vec2::new(60.0, 20.0)] {
            let (mut points, mut n) = (Vec::new(), 0);
            for u in grid(8) {
                let r = camera.sample_we(film, u, 0.0);
                if r.weight > 0.0 {
                    points.push(r.ray.o + r.ray.d * ((1.0 - r.ray.o.z) / r.ray.d.z));
                    n += 1;
                }
            }
            assert!(n > 30);
            // A pixel is 0.4 mm; right in the picture is right in the scene, up is up.
            let magnified = 0.0004 * (1.0 - a) / a;
            let expected = Vec3::new((film.x - 40.0) * magnified, (30.0 - film.y) * magnified, 1.0);
            for p in points {
                assert!((p - expected).length() < 4e-4, "{film:?}: {p:?}, expected {expected:?}");
            }
        }
    }

    #[test]
    fn the_film_gets_what_its_pupil_sends() {
        // The stop is the exit pupil: E/L = π r²/(r² + z²) in the middle, for any opening.
        let r = 0.008;
        for shape in [
            None,
            Some(ApertureShape::Gaussian),
            Some(ApertureShape::Square),
            Some(ApertureShape::Pentagon),
            Some(ApertureShape::Star),
        ] {
            let camera = camera(&thin(r, 2.0, shape.clone()));
            let n = 300;
            let middle = Vec2::new(40.0, 30.0);
            let sum: f64 =
                grid(n).map(|u| f64::from(camera.sample_we(middle, u, 0.0).weight)).sum();
            let mean = sum / f64::from(n * n);
            let z = camera.surfaces[0].z;
            let expected = f64::from(PI * r * r / (r * r + z * z));
            // Other openings are as large, with other cosines.
            assert!((mean / expected - 1.0).abs() < 0.01, "{shape:?}: {mean}, expected {expected}");
        }
    }

    #[test]
    fn light_fades_toward_the_edge_and_ends_there() {
        // Two stops make a tunnel.
        let surfaces = vec![
            surface(0.05, 0.001, 1.5, 0.006),
            surface(-0.05, 0.03, 1.0, 0.006),
            surface(0.0, 0.0, 0.0, 0.004),
        ];
        let lens = LensDesc { surfaces, focus_distance: 3.0, film_diagonal: 0.08, aperture: None };
        let camera = camera(&lens);
        let mean = |x: f32| {
            let n = 100;
            let at = Vec2::new(40.0 + x, 30.0);
            grid(n).map(|u| camera.sample_we(at, u, 0.0).weight).sum::<f32>() / (n * n) as f32
        };
        let means: Vec<f32> = (0..40).step_by(5).map(|x| mean(x as f32)).collect();
        assert!(means.windows(2).all(|w| w[0] >= 0.995 * w[1]), "{means:?}");
        assert!(means[0] > 0.0 && *means.last().expect("some") == 0.0, "{means:?}");
    }

    #[test]
    fn lenses_that_cannot_be_used_say_why() {
        let why = |lens: &LensDesc| {
            Realistic::new(lens, Transform::IDENTITY, [4, 4], None).expect_err("no lens").message
        };
        assert!(why(&thin(0.01, 0.3, None)).contains("greater `focusdistance`"));
        let spread = LensDesc {
            surfaces: vec![surface(-0.1, 0.001, 1.5, 0.01), surface(0.1, 0.0, 1.0, 0.01)],
            ..thin(0.01, 1.0, None)
        };
        assert!(why(&spread).contains("gathers no light"));
    }
}
