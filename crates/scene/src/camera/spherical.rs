//! A camera that sees every direction: latitude-longitude or equal-area octahedral pictures.

use super::{CameraConnection, CameraRay};
use crate::description::CameraDesc;
use kaustika_math::{Ray, Transform, Vec2, Vec3, safe_acos, warp};
use std::f32::consts::PI;

/// pbrt's spherical camera.
#[derive(Clone, Debug)]
pub struct Spherical {
    to_world: Transform,
    resolution: [f32; 2],
    equal_area: bool,
}

impl Spherical {
    /// From a description.
    pub fn new(desc: &CameraDesc, equal_area: bool, resolution: [u32; 2]) -> Spherical {
        Spherical { to_world: desc.transform, resolution: resolution.map(|v| v as f32), equal_area }
    }

    /// The ray through a film position.
    pub fn sample_we(&self, film: Vec2, time: f32) -> CameraRay {
        let u = Vec2::new(film.x / self.resolution[0], film.y / self.resolution[1]);
        let d = if self.equal_area {
            let wrapped = Vec2::new(u.x.clamp(0.0, 1.0), u.y.clamp(0.0, 1.0));
            warp::equal_area_square_to_sphere(wrapped)
        } else {
            let (theta, phi) = (PI * u.y, 2.0 * PI * u.x);
            let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
            Vec3::new(st * cp, st * sp, ct)
        };
        // pbrt: the map's z axis is the camera's y.
        let d = self.to_world.vector(Vec3::new(d.x, d.z, d.y)).normalize();
        CameraRay {
            ray: Ray { o: self.position(), d, time },
            t_max: f32::INFINITY,
            spread: PI / self.resolution[1],
            width: 0.0,
            weight: 1.0,
            receiver: None,
        }
    }

    /// Connects a scene point to the camera's centre.
    pub fn sample_wi(&self, p: Vec3) -> Option<CameraConnection> {
        let to_camera = self.position() - p;
        let d2 = to_camera.length_squared();
        let wi = to_camera.try_normalize()?;
        let d = self.to_world.inverse().vector(-wi).normalize();
        let d = Vec3::new(d.x, d.z, d.y);
        let pixels = self.resolution[0] * self.resolution[1];
        let (u, pdf_w) = if self.equal_area {
            (warp::equal_area_sphere_to_square(d), pixels * warp::UNIFORM_SPHERE_PDF_W)
        } else {
            let mut phi = d.y.atan2(d.x);
            if phi < 0.0 {
                phi += 2.0 * PI;
            }
            let theta = safe_acos(d.z);
            let sin = theta.sin().max(1e-7);
            (Vec2::new(phi / (2.0 * PI), theta / PI), pixels / (2.0 * PI * PI * sin))
        };
        // The end of a circle is its start, the pole belongs to the last row.
        let below = kaustika_math::ONE_MINUS_EPSILON;
        let film =
            Vec2::new(u.x.min(below) * self.resolution[0], u.y.min(below) * self.resolution[1]);
        Some(CameraConnection {
            wi,
            p_lens: self.position(),
            p_near: self.position(),
            film,
            we: pdf_w / d2,
            pdf_w: 1.0,
            delta: true,
        })
    }

    /// Densities over the whole film: (1 for the centre, per solid angle).
    pub fn pdf_we(&self, ray: &Ray) -> (f32, f32) {
        match self.sample_wi(ray.o + ray.d) {
            Some(k) => (1.0, k.we / (self.resolution[0] * self.resolution[1])),
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
