//! Spheres, disks and cylinders, whole or cut, under any affine transform.
//!
//! A ray is taken into the shape's own space and intersected there in double precision; the
//! hit is then put back onto the surface, so that its error is that of one rounding.

use super::ShapeSample;
use crate::description::TriMesh;
use crate::surface::{LightId, Surface};
use kaustika_math::{Bounds3, Ray, Transform, Vec2, Vec3, gamma, lerp, sqr, warp};
use std::f32::consts::PI;

/// The form in its own space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QuadricForm {
    /// About the origin, z within [z_min, z_max].
    Sphere {
        /// Radius.
        radius: f32,
        /// Lower cut.
        z_min: f32,
        /// Upper cut.
        z_max: f32,
    },
    /// In the plane z = height.
    Disk {
        /// z of the plane.
        height: f32,
        /// Outer radius.
        radius: f32,
        /// Inner radius.
        inner: f32,
    },
    /// About the z axis, open.
    Cylinder {
        /// Radius.
        radius: f32,
        /// Lower end.
        z_min: f32,
        /// Upper end.
        z_max: f32,
    },
}

/// An analytic shape.
#[derive(Clone, Debug)]
pub struct Quadric {
    /// Form.
    pub form: QuadricForm,
    /// Azimuth covered, radians, up to 2π.
    pub phi_max: f32,
    /// Own space to that of its group.
    pub to_world: Transform,
    /// True if normals point the other way.
    pub flip: bool,
    /// True if rays from inside pass: of two hits only the first counts.
    pub from_outside: bool,
    /// Shape in the scene's list.
    pub shape: u32,
    /// The light it is.
    pub light: Option<LightId>,
}

/// Where a ray meets a quadric, in its own space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadricHit {
    /// Ray parameter.
    pub t: f32,
    /// The point, on the surface up to rounding.
    pub p: Vec3,
    /// Azimuth in [0, 2π).
    pub phi: f32,
}

impl Quadric {
    /// The box around it.
    pub fn bounds(&self) -> Bounds3 {
        let b = match self.form {
            QuadricForm::Sphere { radius: r, z_min, z_max }
            | QuadricForm::Cylinder { radius: r, z_min, z_max } => {
                Bounds3::new(Vec3::new(-r, -r, z_min), Vec3::new(r, r, z_max))
            }
            QuadricForm::Disk { height, radius: r, .. } => {
                Bounds3::new(Vec3::new(-r, -r, height), Vec3::new(r, r, height))
            }
        };
        self.to_world.bounds(&b)
    }

    /// The nearest hit with t in (0, t_max).
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<QuadricHit> {
        let r = self.to_world.inverse().ray(ray);
        let (o, d) = (
            [r.o.x as f64, r.o.y as f64, r.o.z as f64],
            [r.d.x as f64, r.d.y as f64, r.d.z as f64],
        );
        match self.form {
            QuadricForm::Sphere { radius, .. } => {
                let a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
                let c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - (radius as f64).powi(2);
                self.first_valid(quadratic(a, b, c)?, o, d, t_max)
            }
            QuadricForm::Cylinder { radius, .. } => {
                let a = d[0] * d[0] + d[1] * d[1];
                let b = o[0] * d[0] + o[1] * d[1];
                let c = o[0] * o[0] + o[1] * o[1] - (radius as f64).powi(2);
                self.first_valid(quadratic(a, b, c)?, o, d, t_max)
            }
            QuadricForm::Disk { height, .. } => {
                if d[2] == 0.0 {
                    return None;
                }
                let t = (height as f64 - o[2]) / d[2];
                self.first_valid([t, f64::INFINITY], o, d, t_max)
            }
        }
    }

    fn first_valid(
        &self,
        roots: [f64; 2],
        o: [f64; 3],
        d: [f64; 3],
        t_max: f32,
    ) -> Option<QuadricHit> {
        let counted = if self.from_outside { 1 } else { 2 };
        roots.into_iter().take(counted).find_map(|t| {
            if !(t > 0.0 && (t as f32) < t_max && t as f32 > 0.0) {
                return None;
            }
            let mut q = [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]];
            // Back onto the surface, exactly.
            match self.form {
                QuadricForm::Sphere { radius, .. } => {
                    let s = radius as f64 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
                    q = q.map(|v| v * s);
                }
                QuadricForm::Cylinder { radius, .. } => {
                    let s = radius as f64 / (q[0] * q[0] + q[1] * q[1]).sqrt();
                    (q[0], q[1]) = (q[0] * s, q[1] * s);
                }
                QuadricForm::Disk { height, .. } => q[2] = height as f64,
            }
            let p = Vec3::new(q[0] as f32, q[1] as f32, q[2] as f32);
            let phi = azimuth(p);
            let inside = match self.form {
                QuadricForm::Sphere { radius, z_min, z_max } => {
                    (z_min <= -radius || p.z >= z_min) && (z_max >= radius || p.z <= z_max)
                }
                QuadricForm::Cylinder { z_min, z_max, .. } => p.z >= z_min && p.z <= z_max,
                QuadricForm::Disk { radius, inner, .. } => {
                    let r2 = sqr(p.x) + sqr(p.y);
                    r2 <= sqr(radius) && r2 >= sqr(inner)
                }
            };
            (inside && phi <= self.phi_max).then_some(QuadricHit { t: t as f32, p, phi })
        })
    }

    /// Parameters and tangents at a point of the surface, in own space.
    fn parameters(&self, p: Vec3, phi: f32) -> (Vec2, Vec3, Vec3) {
        let u = phi / self.phi_max;
        match self.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                // As pbrt: v runs from the lower cut (θ at z_min) to the upper.
                let theta_at = |z: f32| kaustika_math::safe_acos(z.clamp(-radius, radius) / radius);
                let (theta_min, theta_max) = (theta_at(z_min), theta_at(z_max));
                let theta = theta_at(p.z);
                let v = (theta - theta_min) / (theta_max - theta_min);
                let rho = (sqr(p.x) + sqr(p.y)).sqrt();
                let (cos_phi, sin_phi) =
                    if rho > 0.0 { (p.x / rho, p.y / rho) } else { (1.0, 0.0) };
                let dpdu = Vec3::new(-p.y, p.x, 0.0) * self.phi_max;
                let dpdv = Vec3::new(p.z * cos_phi, p.z * sin_phi, -rho) * (theta_max - theta_min);
                let dpdu = if rho > 0.0 { dpdu } else { Vec3::new(0.0, radius, 0.0) };
                (Vec2::new(u, v), dpdu, dpdv)
            }
            QuadricForm::Cylinder { z_min, z_max, .. } => {
                let v = (p.z - z_min) / (z_max - z_min);
                let dpdu = Vec3::new(-p.y, p.x, 0.0) * self.phi_max;
                (Vec2::new(u, v), dpdu, Vec3::new(0.0, 0.0, z_max - z_min))
            }
            QuadricForm::Disk { radius, inner, .. } => {
                let r = (sqr(p.x) + sqr(p.y)).sqrt();
                let v = (radius - r) / (radius - inner);
                let (dpdu, dpdv) = if r > 0.0 {
                    (
                        Vec3::new(-p.y, p.x, 0.0) * self.phi_max,
                        Vec3::new(p.x, p.y, 0.0) * ((inner - radius) / r),
                    )
                } else {
                    (Vec3::X, Vec3::Y)
                };
                (Vec2::new(u, v), dpdu, dpdv)
            }
        }
    }

    /// Outward normal in own space (disks: +z), unit.
    fn own_normal(&self, p: Vec3) -> Vec3 {
        match self.form {
            QuadricForm::Sphere { radius, .. } => p / radius,
            QuadricForm::Cylinder { radius, .. } => Vec3::new(p.x / radius, p.y / radius, 0.0),
            QuadricForm::Disk { .. } => Vec3::Z,
        }
    }

    fn world_normal(&self, p: Vec3) -> Vec3 {
        let n = self.to_world.normal(self.own_normal(p)).normalize();
        if self.flip { -n } else { n }
    }

    fn world_point(&self, p: Vec3) -> (Vec3, Vec3) {
        (self.to_world.point(p), self.to_world.point_error(p, p.abs() * gamma(5)))
    }

    /// The surface at a hit.
    /// `number` is the shape's own in the scene's list.
    pub fn surface(&self, number: u32, hit: &QuadricHit, time: f32) -> Surface {
        let (uv, ..) = self.parameters(hit.p, hit.phi);
        let ng = self.world_normal(hit.p);
        let (p, p_error) = self.world_point(hit.p);
        Surface {
            p,
            p_error,
            t: hit.t,
            ng,
            ns: ng,
            uv,
            footprint: 0.0,
            shape: self.shape,
            triangle: u32::MAX,
            analytic: number,
            instance: None,
            barycentrics: Vec2::ZERO,
            light: self.light,
            time,
        }
    }

    /// As a mesh of `around` by `along` cells, with the normals of the shape.
    pub fn tessellated(&self, around: u32, along: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        for j in 0..=along {
            let v = j as f32 / along as f32;
            for i in 0..=around {
                let phi = self.phi_max * i as f32 / around as f32;
                let (s, c) = phi.sin_cos();
                let p = match self.form {
                    QuadricForm::Sphere { radius, z_min, z_max } => {
                        let angle =
                            |z: f32| kaustika_math::safe_acos(z.clamp(-radius, radius) / radius);
                        let (s_theta, c_theta) = lerp(v, angle(z_min), angle(z_max)).sin_cos();
                        Vec3::new(c * s_theta, s * s_theta, c_theta) * radius
                    }
                    QuadricForm::Cylinder { radius, z_min, z_max } => {
                        Vec3::new(c * radius, s * radius, lerp(v, z_min, z_max))
                    }
                    QuadricForm::Disk { height, radius, inner } => {
                        let r = lerp(v, radius, inner);
                        Vec3::new(c * r, s * r, height)
                    }
                };
                mesh.positions.push(self.to_world.point(p));
                mesh.normals.push(self.world_normal(p));
                mesh.uvs.push(Vec2::new(i as f32 / around as f32, v));
            }
        }
        for j in 0..along {
            for i in 0..around {
                let a = j * (around + 1) + i;
                let (b, c, d) = (a + 1, a + around + 1, a + around + 2);
                mesh.indices.push([a, b, d]);
                mesh.indices.push([a, d, c]);
            }
        }
        mesh
    }

    /// A point of the surface, and its density per world area.
    ///
    /// Uniform over the area in own space: where the transform stretches differently in
    /// different directions the density varies, and is given exactly.
    pub fn sample(&self, u: Vec2) -> (ShapeSample, f32) {
        let phi = u.y * self.phi_max;
        let (s, c) = phi.sin_cos();
        let p = match self.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                let (lo, hi) = (z_min.max(-radius), z_max.min(radius));
                let z = hi + (lo - hi) * u.x;
                let rho = kaustika_math::safe_sqrt(sqr(radius) - sqr(z));
                Vec3::new(rho * c, rho * s, z)
            }
            QuadricForm::Cylinder { radius, z_min, z_max } => {
                Vec3::new(radius * c, radius * s, z_min + (z_max - z_min) * u.x)
            }
            QuadricForm::Disk { height, radius, inner }
                if self.phi_max >= 2.0 * PI && inner == 0.0 =>
            {
                let d = warp::disk(u) * radius;
                Vec3::new(d.x, d.y, height)
            }
            QuadricForm::Disk { height, radius, inner } => {
                let r = (sqr(inner) + u.x * (sqr(radius) - sqr(inner))).sqrt();
                Vec3::new(r * c, r * s, height)
            }
        };
        let (world, p_error) = self.world_point(p);
        let sample = ShapeSample { p: world, p_error, n: self.world_normal(p) };
        (sample, self.pdf_a(p))
    }

    /// Density of [`Quadric::sample`] per world area at the own-space point `p`.
    fn pdf_a(&self, p: Vec3) -> f32 {
        let (s, t) = self.own_normal(p).coordinate_system();
        let stretch = self.to_world.vector(s).cross(self.to_world.vector(t)).length();
        1.0 / (self.own_area() * stretch)
    }

    /// Density of [`Quadric::sample`] per world area at the world point `p`.
    pub fn pdf_a_at(&self, p: Vec3) -> f32 {
        self.pdf_a(self.to_world.inverse().point(p))
    }

    /// Area in own space.
    pub(crate) fn own_area(&self) -> f32 {
        match self.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                self.phi_max * radius * (z_max.min(radius) - z_min.max(-radius))
            }
            QuadricForm::Cylinder { radius, z_min, z_max } => {
                self.phi_max * radius * (z_max - z_min)
            }
            QuadricForm::Disk { radius, inner, .. } => {
                0.5 * self.phi_max * (sqr(radius) - sqr(inner))
            }
        }
    }

    /// Coordinates in [0, 1]² of the world point `p`, of which equal areas are equal areas in own
    /// space, and how wide a thing is that covers all of the first at the middle of the second,
    /// over how wide one is that covers the second.
    pub fn chart_at(&self, p: Vec3) -> (Vec2, f32) {
        let p = self.to_world.inverse().point(p);
        let (y, width, height) = match self.form {
            QuadricForm::Sphere { radius, z_min, z_max } => {
                let (lo, hi) = (z_min.max(-radius), z_max.min(radius));
                ((p.z - lo) / (hi - lo), radius, hi - lo)
            }
            QuadricForm::Cylinder { radius, z_min, z_max } => {
                ((p.z - z_min) / (z_max - z_min), radius, z_max - z_min)
            }
            QuadricForm::Disk { radius, inner, .. } => {
                let (r2, inner2) = (sqr(p.x) + sqr(p.y), sqr(inner));
                let y = (r2 - inner2) / (sqr(radius) - inner2);
                (y, 0.5 * (radius + inner), radius - inner)
            }
        };
        let at = Vec2::new(azimuth(p) / self.phi_max, y);
        (Vec2::new(at.x.clamp(0.0, 1.0), at.y.clamp(0.0, 1.0)), self.phi_max * width / height)
    }

    /// World area, by quadrature where the transform is not a similarity.
    pub fn area(&self) -> f32 {
        const N: usize = 32;
        let mut sum = 0.0;
        for i in 0..N * N {
            let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            sum += 1.0 / self.sample(u).1;
        }
        sum / (N * N) as f32
    }

    /// Centre and radius if this is a whole sphere under a similarity: it can then be sampled
    /// by the solid angle it fills.
    pub fn as_whole_sphere(&self) -> Option<(Vec3, f32)> {
        let QuadricForm::Sphere { radius, z_min, z_max } = self.form else { return None };
        if z_min > -radius || z_max < radius || self.phi_max < 2.0 * PI {
            return None;
        }
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|a| self.to_world.vector(a));
        let l = axes[0].length();
        let similar = axes.iter().all(|a| (a.length() - l).abs() < 1e-4 * l)
            && axes[0].dot(axes[1]).abs() < 1e-4 * l * l
            && axes[1].dot(axes[2]).abs() < 1e-4 * l * l
            && axes[2].dot(axes[0]).abs() < 1e-4 * l * l;
        similar.then(|| (self.to_world.point(Vec3::ZERO), radius * l))
    }

    /// Surface parameters of the world point `p` on it.
    pub fn uv_at(&self, p: Vec3) -> Vec2 {
        let q = self.to_world.inverse().point(p);
        self.parameters(q, azimuth(q)).0
    }

    /// ∂p/∂u and ∂p/∂v at the world point `p` on it.
    pub fn tangents_at(&self, p: Vec3) -> (Vec3, Vec3) {
        let q = self.to_world.inverse().point(p);
        let (_, dpdu, dpdv) = self.parameters(q, azimuth(q));
        (self.to_world.vector(dpdu), self.to_world.vector(dpdv))
    }
}

/// Azimuth of an own-space point in [0, 2π).
fn azimuth(p: Vec3) -> f32 {
    let phi = p.y.atan2(p.x);
    if phi < 0.0 { phi + 2.0 * PI } else { phi }
}

/// Roots of a t² + 2b t + c in rising order.
fn quadratic(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a == 0.0 {
        return None;
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (t0, t1) = (q / a, if q != 0.0 { c / q } else { 0.0 });
    Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quadric(form: QuadricForm, to_world: Transform) -> Quadric {
        Quadric {
            form,
            phi_max: 2.0 * PI,
            to_world,
            flip: false,
            from_outside: false,
            shape: 0,
            light: None,
        }
    }

    #[test]
    fn hits_lie_on_the_surface_and_rays_leave_it() {
        let t = Transform::translate(Vec3::new(100.0, -3.0, 7.0))
            * Transform::scale(Vec3::new(2.0, 1.0, 0.5)).unwrap();
        for form in [
            QuadricForm::Sphere { radius: 1.5, z_min: -1.5, z_max: 1.5 },
            QuadricForm::Cylinder { radius: 1.0, z_min: -2.0, z_max: 1.0 },
            QuadricForm::Disk { height: 0.3, radius: 2.0, inner: 0.5 },
        ] {
            let q = quadric(form, t);
            let mut hits = 0;
            for i in 0..2000 {
                let f = |k: usize| ((i * k) % 997) as f32 / 997.0;
                let o = t.point(warp::uniform_sphere(Vec2::new(f(7), f(13))) * 5.0);
                let (target, pdf) = q.sample(Vec2::new(f(31), f(57)));
                assert!(pdf > 0.0);
                let ray = Ray::new(o, (target.p - o).normalize());
                let Some(hit) = q.intersect(&ray, f32::INFINITY) else { continue };
                hits += 1;
                let s = q.surface(0, &hit, 0.0);
                assert!((s.p - ray.at(hit.t)).length() < 2e-4);
                assert!((s.uv - q.uv_at(s.p)).length() < 2e-2 || s.uv.x < 0.01 || s.uv.x > 0.99);
                // A ray leaving outward along the normal does not meet the same point again.
                let away = s.spawn(s.ng);
                assert!(q.intersect(&away, 0.05).is_none(), "{form:?} {i}");
            }
            assert!(hits > 1900, "{form:?} {hits}");
        }
    }

    #[test]
    fn areas_are_right() {
        let id = Transform::IDENTITY;
        let s = quadric(QuadricForm::Sphere { radius: 2.0, z_min: -1.0, z_max: 2.0 }, id);
        assert!((s.area() - 2.0 * PI * 2.0 * 3.0).abs() < 1e-3);
        // A disk stretched to an ellipse.
        let t = Transform::scale(Vec3::new(3.0, 0.5, 1.0)).unwrap();
        let d = quadric(QuadricForm::Disk { height: 0.0, radius: 1.0, inner: 0.0 }, t);
        assert!((d.area() - 1.5 * PI).abs() < 1e-3);
        // An ellipsoid with semi-axes 2, 1, 1 (prolate): 2π(1 + (2/e) asin e), e² = 3/4.
        let t = Transform::scale(Vec3::new(2.0, 1.0, 1.0)).unwrap();
        let e = 0.75f32.sqrt();
        let ellipsoid = quadric(QuadricForm::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0 }, t);
        assert!((ellipsoid.area() / (2.0 * PI * (1.0 + 2.0 / e * e.asin())) - 1.0).abs() < 2e-3);
        assert!(s.as_whole_sphere().is_none() && ellipsoid.as_whole_sphere().is_none());
    }
}
