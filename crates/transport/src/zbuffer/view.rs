//! From the world to the picture, and back.
//!
//! ```text
//! (x w, y w, w, k) = M (p, 1)                                                       (1)
//! perspective:  w = z, k = 1,    κ = k/w = 1/z
//! parallel:     w = 1, k = -z,   κ = k/w = -z                                       (2)
//! ```
//!
//! x and y are pixels, z the depth in units of camera space. κ, the *nearness*, is linear in x and y
//! over a plane and grows toward the eye: it is what the buffer keeps. All in double precision.

use kaustika_math::{Transform, Vec3};
use kaustika_scene::FlatView;

/// A homogeneous point: (x w, y w, w, k) of (1).
pub type Projected = [f64; 4];

/// A picture plane.
#[derive(Clone, Debug)]
pub struct View {
    rows: [[f64; 4]; 4],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// False: a parallel projection.
    pub perspective: bool,
    /// Least and greatest κ that is seen, for the far and the near plane.
    pub nearness: [f64; 2],
    near: f64,
    /// Triangles are cut at this w to find where they show: the near plane, or just before the eye.
    pub cut: f64,
    /// The point that the pixel (0, 0) shows at z = 0, and what z, x z and y z add to it (perspective);
    /// or what z, x and y add.
    back: [[f64; 3]; 4],
    /// Size of a pixel, in units of the world at z = 1, or anywhere in a parallel projection.
    pub pixel: f32,
}

/// Shares of the scene's radius: how near the eye something may be seen where there is no near plane.
const NEAREST: f64 = 1e-7;

impl View {
    /// Through a camera: `origin` is the place on its film that has the picture's coordinates (0, 0).
    /// `None` if the camera's transform is singular.
    pub fn of_camera(
        camera: &FlatView,
        origin: [f64; 2],
        size: [u32; 2],
        radius: f32,
    ) -> Option<View> {
        let [x0, x1, y0, y1] = camera.window.map(f64::from);
        let [w, h] = camera.resolution.map(f64::from);
        // Pixels of the picture from the screen window: x = sx X + tx.
        let (sx, sy) = (w / (x1 - x0), -h / (y1 - y0));
        let (tx, ty) = (-x0 * sx - origin[0], -y1 * sy - origin[1]);
        let to_world = camera.to_world.m.map(|r| r.map(f64::from));
        let from_world = inverse(&to_world)?;
        let range = [f64::from(camera.near), f64::from(camera.far)];
        let mut view = View::new([sx, sy, tx, ty], from_world, to_world, camera.perspective);
        view.size = size;
        view.limit(range, f64::from(radius));
        Some(view)
    }

    /// A square of `size` pixels that shows the directions around `axes[2]`, up to 45° to each side, from
    /// `p`: a face of a cube.
    pub fn face(p: Vec3, axes: [Vec3; 3], size: u32, radius: f32) -> Option<View> {
        let frame = frame(p, axes)?;
        let camera = FlatView {
            to_world: frame,
            window: [-1.0, 1.0, -1.0, 1.0],
            resolution: [size as f32; 2],
            perspective: true,
            near: 0.0,
            far: f32::INFINITY,
        };
        View::of_camera(&camera, [0.5; 2], [size; 2], radius)
    }

    /// A parallel projection along `axes[2]` of a ball.
    pub fn of_ball(center: Vec3, radius: f32, axes: [Vec3; 3], size: u32) -> Option<View> {
        let camera = FlatView {
            to_world: frame(center, axes)?,
            window: [-radius, radius, -radius, radius],
            resolution: [size as f32; 2],
            perspective: false,
            near: -2.0 * radius,
            far: 2.0 * radius,
        };
        View::of_camera(&camera, [0.5; 2], [size; 2], radius)
    }

    fn new(
        [sx, sy, tx, ty]: [f64; 4],
        from_world: [[f64; 4]; 4],
        to_world: [[f64; 4]; 4],
        perspective: bool,
    ) -> View {
        let [cx, cy, cz, _] = from_world;
        let one = [0.0, 0.0, 0.0, 1.0];
        let w = if perspective { cz } else { one };
        let add =
            |a: [f64; 4], k: f64, b: [f64; 4], l: f64| std::array::from_fn(|i| a[i] * k + b[i] * l);
        let k = if perspective { one } else { cz.map(|v| -v) };
        let rows = [add(cx, sx, w, tx), add(cy, sy, w, ty), w, k];
        let axis = |i: usize| [to_world[0][i], to_world[1][i], to_world[2][i]];
        let (dx, dy) = (axis(0).map(|v| v / sx), axis(1).map(|v| v / sy));
        // Where the pixel (0, 0) is: X = -tx/sx, Y = -ty/sy.
        let corner: [f64; 3] = std::array::from_fn(|i| -tx * dx[i] - ty * dy[i]);
        let (o, z) = (axis(3), axis(2));
        let sum = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + b[i]);
        let back = match perspective {
            true => [o, sum(z, corner), dx, dy],
            false => [sum(o, corner), z, dx, dy],
        };
        let pixel = dx.iter().map(|v| v * v).sum::<f64>().sqrt() as f32;
        let (nearness, cut) = ([0.0, f64::INFINITY], 0.0);
        View { rows, size: [0; 2], perspective, nearness, near: 0.0, cut, back, pixel }
    }

    fn limit(&mut self, [near, far]: [f64; 2], radius: f64) {
        self.near = near;
        (self.nearness, self.cut) = match self.perspective {
            true => ([1.0 / far, 1.0 / near.max(0.0)], near.max(NEAREST * radius)),
            false => ([-far, -near], 0.5),
        };
    }

    /// (1).
    #[inline]
    pub fn project(&self, p: Vec3) -> Projected {
        let (x, y, z) = (f64::from(p.x), f64::from(p.y), f64::from(p.z));
        self.rows.map(|r| r[0] * x + (r[1] * y + (r[2] * z + r[3])))
    }

    /// (2): depth at a nearness.
    #[inline]
    pub fn depth(&self, kappa: f64) -> f64 {
        if self.perspective { 1.0 / kappa } else { -kappa }
    }

    /// The point of the world at pixel coordinates x, y and a depth.
    #[inline]
    pub fn point(&self, x: f64, y: f64, z: f64) -> Vec3 {
        let [o, a, dx, dy] = &self.back;
        let k = if self.perspective { z } else { 1.0 };
        let c = |i: usize| (o[i] + a[i] * z + (dx[i] * x + dy[i] * y) * k) as f32;
        Vec3::new(c(0), c(1), c(2))
    }

    /// [`View::point`] as numbers: p = o + (a + dx x + dy y) z, or o + a z + dx x + dy y.
    pub fn back(&self) -> [Vec3; 4] {
        self.back.map(|v| Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32))
    }

    /// How far a point is from where its ray begins, the near plane.
    pub fn distance(&self, p: Vec3) -> f32 {
        let [_, _, w, k] = self.project(p);
        let [o, a, ..] = self.back();
        match self.perspective {
            true => (o - p).length() * (1.0 - self.near / w) as f32,
            false => a.length() * (-k - self.near) as f32,
        }
    }

    /// Unit direction to the eye from a point.
    #[inline]
    pub fn toward_eye(&self, p: Vec3) -> Vec3 {
        let [o, a, ..] = self.back();
        if self.perspective { (o - p).normalize() } else { -a.normalize() }
    }
}

fn frame(p: Vec3, [x, y, z]: [Vec3; 3]) -> Option<Transform> {
    let row = |i: usize| [x[i], y[i], z[i], p[i]];
    Transform::from_rows([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
}

/// Of an affine matrix.
fn inverse(m: &[[f64; 4]; 4]) -> Option<[[f64; 4]; 4]> {
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let det: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    if !(det.is_finite() && det != 0.0) {
        return None;
    }
    let mut inv = [[0.0; 4]; 4];
    for i in 0..3 {
        for j in 0..3 {
            inv[i][j] = cofactor(j, i) / det;
        }
        inv[i][3] = -(0..3).map(|j| inv[i][j] * m[j][3]).sum::<f64>();
    }
    inv[3][3] = 1.0;
    Some(inv)
}
