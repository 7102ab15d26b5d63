//! Perspective and orthographic cameras with a pinhole or a thin lens.
//!
//! ```text
//! direction through film position (x, y):  d = (k X, k Y, 1),  X, Y in the screen window   (1)
//! importance per pixel (pinhole):          Wₑ = N / (A cos⁴θ),  pdf_ω = N / (A cos³θ)      (2)
//! parallel projection with a lens:         from (x, y) + l through (x, y, f): l uniform on the
//!                                          lens, pdf_ω = f² / (A_l cos³θ), at z (x, y) + l (1 - z/f)
//!                                                                                          (3)
//! ```
//!
//! A is the area of the picture on the plane z = 1 and N the number of its pixels: densities
//! over the film are per pixel (Pharr et al. 2023, sec. 13.2; Veach 1997, sec. 8.A).

mod lanes;

use super::{CameraConnection, CameraRay, LensHit};
use crate::description::{CameraDesc, CameraKind};
use kaustika_math::{Ray, Transform, Vec2, Vec3, sqr, warp};
use std::f32::consts::PI;

/// A camera with a flat film.
#[derive(Clone, Debug)]
pub struct Projective {
    to_world: Transform,
    /// Screen window on the plane z = 1 (perspective) or in camera space (orthographic).
    window: [f32; 4],
    resolution: [f32; 2],
    /// World-space size of one unit of camera space.
    scale: f32,
    perspective: bool,
    lens_radius: f32,
    focus_distance: f32,
    near: f32,
    far: f32,
}

/// A camera with a flat film as a matrix would have it: what a rasteriser needs.
#[derive(Clone, Copy, Debug)]
pub struct FlatView {
    /// Camera to world.
    pub to_world: Transform,
    /// x0, x1, y0, y1 of the picture on the plane z = 1, or in camera space of a parallel projection.
    pub window: [f32; 4],
    /// Pixels of the picture.
    pub resolution: [f32; 2],
    /// False: a parallel projection.
    pub perspective: bool,
    /// Depth before which nothing is seen.
    pub near: f32,
    /// Depth beyond which nothing is seen.
    pub far: f32,
}

impl Projective {
    /// As a pinhole, whatever the lens.
    pub fn flat(&self) -> FlatView {
        let Projective { to_world, window, resolution, perspective, near, far, .. } = *self;
        FlatView { to_world, window, resolution, perspective, near, far }
    }

    /// From a description; `desc.kind` must not be spherical.
    pub fn new(desc: &CameraDesc, resolution: [u32; 2]) -> Projective {
        let (mut window, shift, lens_radius, focus_distance, near, far, perspective) =
            match &desc.kind {
                CameraKind::Perspective {
                    fov,
                    fov_axis,
                    principal_point,
                    screen_window,
                    lens_radius,
                    focus_distance,
                    near_clip,
                    far_clip,
                } => {
                    let k = (0.5 * fov.to_radians()).tan();
                    let [x, y] = fov_axis.half_extents(resolution);
                    let window = screen_window.unwrap_or([-x, x, -y, y]).map(|v| v * k);
                    let lens = (*lens_radius, *focus_distance);
                    (window, *principal_point, lens.0, lens.1, *near_clip, *far_clip, true)
                }
                CameraKind::Orthographic {
                    screen_window,
                    unit_axis,
                    lens_radius,
                    focus_distance,
                    near_clip,
                    far_clip,
                } => {
                    let [x, y] = unit_axis.half_extents(resolution);
                    let window = screen_window.unwrap_or([-x, x, -y, y]);
                    (window, [0.0; 2], *lens_radius, *focus_distance, *near_clip, *far_clip, false)
                }
                _ => ([-1.0, 1.0, -1.0, 1.0], [0.0; 2], 0.0, 1.0, 0.0, f32::INFINITY, true),
            };
        let size = [window[1] - window[0], window[3] - window[2]];
        for (axis, s) in shift.iter().enumerate() {
            // Film y runs down, the window's up.
            let offset = s * size[axis] * if axis == 0 { 1.0 } else { -1.0 };
            window[2 * axis] += offset;
            window[2 * axis + 1] += offset;
        }
        Projective {
            to_world: desc.transform,
            window,
            resolution: resolution.map(|v| v as f32),
            scale: desc.transform.vector(Vec3::X).length(),
            perspective,
            lens_radius,
            focus_distance,
            near,
            far,
        }
    }

    /// The ray through a film position and a lens sample.
    #[inline]
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let (x, y) = self.screen(film);
        let (mut o, mut d) = if self.perspective {
            (Vec3::ZERO, Vec3::new(x, y, 1.0)) // (1)
        } else {
            (Vec3::new(x, y, 0.0), Vec3::Z)
        };
        if self.lens_radius > 0.0 {
            let focus = o + d * self.focus_distance;
            let p = warp::disk(lens) * self.lens_radius;
            o += Vec3::new(p.x, p.y, 0.0);
            d = focus - o;
        }
        // d.z is 1 or the focus distance: the near plane is reached at this parameter.
        let start = self.near / d.z;
        let o = self.to_world.point(o + d * start);
        let d = self.to_world.vector(d);
        let per_z = d.length() / if self.lens_radius > 0.0 { self.focus_distance } else { 1.0 };
        let pixel = (self.window[1] - self.window[0]) / self.resolution[0];
        CameraRay {
            ray: Ray { o, d: d.normalize(), time },
            t_max: (self.far - self.near) * per_z,
            spread: if self.perspective { pixel } else { 0.0 },
            width: if self.perspective { 0.0 } else { pixel * self.scale },
            weight: 1.0,
            receiver: None,
        }
    }

    /// Film position to the screen window.
    #[inline]
    fn screen(&self, film: Vec2) -> (f32, f32) {
        let [x0, x1, y0, y1] = self.window;
        (x0 + (x1 - x0) * film.x / self.resolution[0], y1 - (y1 - y0) * film.y / self.resolution[1])
    }

    /// Screen window to film position, if it is in the picture.
    fn film(&self, x: f32, y: f32) -> Option<Vec2> {
        let [x0, x1, y0, y1] = self.window;
        let film = Vec2::new(
            (x - x0) / (x1 - x0) * self.resolution[0],
            (y1 - y) / (y1 - y0) * self.resolution[1],
        );
        let inside = film.x >= 0.0
            && film.y >= 0.0
            && film.x < self.resolution[0]
            && film.y < self.resolution[1];
        inside.then_some(film)
    }

    /// Area of the picture on z = 1 (perspective) or in camera space.
    fn screen_area(&self) -> f32 {
        ((self.window[1] - self.window[0]) * (self.window[3] - self.window[2])).abs()
    }

    fn pixels(&self) -> f32 {
        self.resolution[0] * self.resolution[1]
    }

    /// World area of the lens; 1 for a pinhole, whose density is a Dirac's.
    fn lens_area(&self) -> f32 {
        if self.lens_radius > 0.0 { PI * sqr(self.lens_radius * self.scale) } else { 1.0 }
    }

    /// Connects a scene point to the lens.
    pub fn sample_wi(&self, p: Vec3, lens: Vec2) -> Option<CameraConnection> {
        let q = self.to_world.inverse().point(p);
        if q.z <= self.near.max(0.0) || q.z > self.far {
            return None;
        }
        if !self.perspective && self.lens_radius == 0.0 {
            // Only one ray of a parallel bundle reaches the point; the film is the source.
            let film = self.film(q.x, q.y)?;
            let p_lens = self.to_world.point(Vec3::new(q.x, q.y, self.near));
            let area = self.screen_area() * sqr(self.scale);
            return Some(CameraConnection {
                wi: (p_lens - p).normalize(),
                p_lens,
                p_near: p_lens,
                film,
                we: self.pixels() / area,
                pdf_w: 1.0,
                delta: true,
            });
        }
        let l = warp::disk(lens) * self.lens_radius;
        let (lens_point, film) = if self.perspective {
            let lens_point = Vec3::new(l.x, l.y, 0.0);
            let d = q - lens_point;
            // Where the ray meets the plane in focus, seen from the lens centre.
            let focus = lens_point + d * (self.focus(q.z) / d.z);
            (lens_point, self.film(focus.x / focus.z, focus.y / focus.z)?)
        } else {
            // The lens moves along with the film position: (3).
            let k = 1.0 - q.z / self.focus_distance;
            let (x, y) = (q.x - l.x * k, q.y - l.y * k);
            (Vec3::new(x + l.x, y + l.y, 0.0), self.film(x, y)?)
        };
        let p_near = self.to_world.point(lens_point + (q - lens_point) * (self.near / q.z));
        let p_lens = self.to_world.point(lens_point);
        let to_lens = p_lens - p;
        let d2 = to_lens.length_squared();
        let wi = to_lens / d2.sqrt();
        let cos = self.forward().abs_dot(wi);
        let we = self.importance(cos);
        let pdf_w = match (self.perspective, self.lens_radius > 0.0) {
            (true, true) => d2 / (cos * self.lens_area()),
            (false, true) => self.parallel_pdf_w(cos),
            _ => 1.0,
        };
        // A pinhole has no area: the connection's 1/d² and cosine at the lens stand in `we`.
        let we = if self.lens_radius > 0.0 { we } else { we * cos / d2 };
        let delta = self.lens_radius == 0.0;
        Some(CameraConnection { wi, p_lens, p_near, film, we, pdf_w, delta })
    }

    /// The point of the lens that a ray comes through.
    pub fn lens_point(&self, ray: &Ray) -> Vec3 {
        let inverse = self.to_world.inverse();
        let (o, d) = (inverse.point(ray.o), inverse.vector(ray.d));
        self.to_world.point(o - d * (o.z / d.z))
    }

    /// The axis of a parallel projection.
    pub fn parallel(&self) -> Option<Vec3> {
        (!self.perspective).then(|| self.forward())
    }

    /// The normal of a lens that light paths can meet. Of a parallel projection's they cannot:
    /// it moves with the film.
    pub fn aperture(&self) -> Option<Vec3> {
        (self.perspective && self.lens_radius > 0.0).then(|| self.forward())
    }

    /// Where a light path meets the lens.
    pub fn meet_lens(&self, ray: &Ray) -> Option<LensHit> {
        let axis = self.aperture()?;
        let inverse = self.to_world.inverse();
        let (q, d) = (inverse.point(ray.o), inverse.vector(ray.d));
        if d.z >= 0.0 || q.z <= self.near.max(0.0) || q.z > self.far {
            return None;
        }
        let l = q - d * (q.z / d.z);
        if sqr(l.x) + sqr(l.y) > sqr(self.lens_radius) {
            return None;
        }
        let back = q - l;
        let focus = l + back * (self.focus_distance / back.z);
        let film = self.film(focus.x / focus.z, focus.y / focus.z)?;
        let p_near = self.to_world.point(l + back * (self.near / back.z));
        let we = self.importance(axis.abs_dot(ray.d));
        Some(LensHit { p: self.to_world.point(l), p_near, film, we })
    }

    /// Distance at which rays of one film position meet; of a pinhole any.
    fn focus(&self, any: f32) -> f32 {
        if self.lens_radius > 0.0 { self.focus_distance } else { any }
    }

    /// Importance per pixel toward a direction at angle cos from the axis: (2) spread over the
    /// lens; for parallel projection the value that makes `we / pdf_w` of (3).
    fn importance(&self, cos: f32) -> f32 {
        let per_area = self.pixels() / self.screen_area();
        if self.perspective {
            per_area / (self.lens_area() * sqr(sqr(cos)))
        } else {
            per_area / sqr(self.scale) * self.parallel_pdf_w(cos) / cos
        }
    }

    /// Density per solid angle of directions through a lens that moves along: (3).
    fn parallel_pdf_w(&self, cos: f32) -> f32 {
        sqr(self.focus_distance * self.scale) / (self.lens_area() * cos * cos * cos)
    }

    fn forward(&self) -> Vec3 {
        self.to_world.vector(Vec3::Z).normalize()
    }

    /// Densities over the whole film: (per lens area, per solid angle).
    pub fn pdf_we(&self, ray: &Ray) -> (f32, f32) {
        let inverse = self.to_world.inverse();
        let (o, d) = (inverse.point(ray.o), inverse.vector(ray.d));
        if d.z <= 0.0 {
            return (0.0, 0.0);
        }
        let cos = self.forward().dot(ray.d);
        let at_lens = o - d * (o.z / d.z);
        if !self.perspective {
            // (3): the direction tells the lens point, and that the film position.
            let l = Vec2::new(-d.x / d.z, -d.y / d.z) * self.focus_distance;
            let through = l.length_squared() <= sqr(self.lens_radius) * 1.001 + 1e-12;
            let film = self.film(at_lens.x - l.x, at_lens.y - l.y).filter(|_| through);
            let pdf_a = 1.0 / (self.screen_area() * sqr(self.scale));
            return match film {
                Some(_) if self.lens_radius > 0.0 => (pdf_a, self.parallel_pdf_w(cos)),
                Some(_) => (pdf_a, 1.0),
                None => (0.0, 0.0),
            };
        }
        let film = if self.lens_radius > 0.0 {
            let focus = at_lens + d * (self.focus_distance / d.z);
            self.film(focus.x / self.focus_distance, focus.y / self.focus_distance)
        } else {
            self.film(d.x / d.z, d.y / d.z)
        };
        match film {
            Some(_) => (1.0 / self.lens_area(), 1.0 / (self.screen_area() * cos * cos * cos)),
            None => (0.0, 0.0),
        }
    }

    /// See [`super::Camera::up`].
    pub fn up(&self) -> Vec3 {
        self.to_world.vector(Vec3::Y)
    }

    /// Where the camera stands.
    pub fn position(&self) -> Vec3 {
        self.to_world.point(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{FilmDesc, FilterChoice, FovAxis};

    fn desc(kind: CameraKind) -> CameraDesc {
        let place = Transform::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y).unwrap();
        let film = FilmDesc::new([40, 30], FilterChoice::Box { radius: [0.5; 2] });
        CameraDesc { shutter: [0.0, 1.0], ..CameraDesc::new(kind, place, film) }
    }

    fn perspective(lens_radius: f32) -> Projective {
        Projective::new(
            &desc(CameraKind::Perspective {
                fov: 60.0,
                fov_axis: FovAxis::X,
                principal_point: [0.0; 2],
                screen_window: None,
                lens_radius,
                focus_distance: 3.0,
                near_clip: 0.0,
                far_clip: f32::INFINITY,
            }),
            [40, 30],
        )
    }

    #[test]
    fn the_view_spans_its_field() {
        let c = perspective(0.0);
        let l = c.sample_we(Vec2::new(0.0, 15.0), Vec2::ZERO, 0.0).ray.d;
        let r = c.sample_we(Vec2::new(40.0, 15.0), Vec2::ZERO, 0.0).ray.d;
        assert!((l.dot(r).acos().to_degrees() - 60.0).abs() < 1e-3);
        let up = c.sample_we(Vec2::new(20.0, 0.0), Vec2::ZERO, 0.0).ray.d;
        let down = c.sample_we(Vec2::new(20.0, 30.0), Vec2::ZERO, 0.0).ray.d;
        assert!(up.y > down.y);
    }

    #[test]
    fn points_in_focus_are_sharp_and_connections_invert_rays() {
        for lens_radius in [0.0, 0.3] {
            let c = perspective(lens_radius);
            let film = Vec2::new(11.3, 22.7);
            let through = |u| c.sample_we(film, u, 0.0).ray;
            let (a, b) = (through(Vec2::new(0.1, 0.9)), through(Vec2::new(0.8, 0.3)));
            // Both pass the same point of the plane z = 3 of camera space.
            let plane = |r: &Ray| {
                let i = c.to_world.inverse();
                let (o, d) = (i.point(r.o), i.vector(r.d));
                c.to_world.point(o + d * ((3.0 - o.z) / d.z))
            };
            assert!((plane(&a) - plane(&b)).length() < 1e-4);
            let q = plane(&a);
            let k = c.sample_wi(q, Vec2::new(0.1, 0.9)).unwrap();
            assert!((k.film - film).length() < 1e-2, "{:?}", k.film);
            assert!((k.wi + a.d).length() < 1e-4);
        }
    }

    #[test]
    fn circle_of_confusion_follows_the_thin_lens_formula() {
        // In focus at z_f, a point at z blurs over a circle of diameter A |z - z_f| / z on the
        // plane in focus; /z_f on the screen at distance 1.
        let c = perspective(0.25);
        let (z_f, z, aperture) = (3.0f32, 5.0f32, 0.5f32);
        let p = c.to_world.point(Vec3::new(0.0, 0.0, z));
        let (mut lo, mut hi) = (f32::MAX, f32::MIN);
        for i in 0..4000 {
            let u = Vec2::new((i as f32 * 0.618).fract(), i as f32 / 4000.0);
            let film = c.sample_wi(p, u).unwrap().film;
            lo = lo.min(film.x);
            hi = hi.max(film.x);
        }
        let window = 2.0 * 30f32.to_radians().tan();
        let expected = aperture * (z - z_f) / z / z_f / window * 40.0;
        assert!(((hi - lo) / expected - 1.0).abs() < 5e-3, "{} {expected}", hi - lo);
    }

    #[test]
    fn importance_of_a_pixel_integrates_to_one() {
        // ∫ Wₑ cosθ dω over the picture = number of pixels (pinhole, per pixel).
        let c = perspective(0.0);
        let n = 400;
        let mut sum = 0.0f64;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let w = warp::uniform_sphere(u);
            let Some(k) = c.sample_wi(c.position() + w, Vec2::ZERO) else { continue };
            sum += k.we as f64 * 4.0 * std::f64::consts::PI / (n * n) as f64;
        }
        assert!((sum / 1200.0 - 1.0).abs() < 5e-3, "{sum}");
    }
}
