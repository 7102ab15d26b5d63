//! Rays of sixteen film positions: the twin of [`Projective::sample_we`].

use super::Projective;
use crate::camera::CameraRays;
use kaustika_math::lanes::{Lanes, Vec3s, disk};

impl Projective {
    /// The rays through film positions and lens samples. `None` for a camera whose transform is
    /// itself a projection.
    #[inline(always)]
    pub fn sample_we_lanes(&self, film: [Lanes; 2], lens: [Lanes; 2]) -> Option<CameraRays> {
        let m = &self.to_world.m;
        if m[3] != [0.0, 0.0, 0.0, 1.0] {
            return None;
        }
        let vector = |v: Vec3s| {
            let row = |i: usize| {
                let [x, y, z] = [m[i][0], m[i][1], m[i][2]].map(Lanes::splat);
                x.mul_add(v.x, y.mul_add(v.y, z * v.z))
            };
            Vec3s { x: row(0), y: row(1), z: row(2) }
        };
        let (zero, one) = (Lanes::splat(0.0), Lanes::splat(1.0));
        let [x0, x1, y0, y1] = self.window;
        let per_pixel = [(x1 - x0) / self.resolution[0], (y0 - y1) / self.resolution[1]];
        let x = film[0].mul_add(Lanes::splat(per_pixel[0]), Lanes::splat(x0));
        let y = film[1].mul_add(Lanes::splat(per_pixel[1]), Lanes::splat(y1));
        let at = Vec3s { x, y, z: if self.perspective { one } else { zero } };
        let (mut o, mut d) = if self.perspective {
            (Vec3s { x: zero, y: zero, z: zero }, at) // (1)
        } else {
            (at, Vec3s { x: zero, y: zero, z: one })
        };
        let mut depth = 1.0;
        if self.lens_radius > 0.0 {
            depth = self.focus_distance;
            let focus = o.plus(d, Lanes::splat(depth));
            let p = disk(lens).map(|v| v * Lanes::splat(self.lens_radius));
            o = o + Vec3s { x: p[0], y: p[1], z: zero };
            d = focus - o;
        }
        // d.z is 1 or the focus distance: the near plane is reached at this parameter.
        let o = vector(o.plus(d, Lanes::splat(self.near / depth)));
        let [x, y, z] = [m[0][3], m[1][3], m[2][3]].map(Lanes::splat);
        let d = vector(d);
        let length = d.dot(d).sqrt();
        let pixel = per_pixel[0];
        Some(CameraRays {
            o: o + Vec3s { x, y, z },
            d: d * (one / length),
            t_max: length * Lanes::splat((self.far - self.near) / depth),
            spread: if self.perspective { pixel } else { 0.0 },
            width: if self.perspective { 0.0 } else { pixel * self.scale },
        })
    }
}
