//! Triangles made ready for a picture: edge functions.
//!
//! ```text
//! e₀ = h₁ × h₂,  e₁ = h₂ × h₀,  e₂ = h₀ × h₁,   hᵢ = (x w, y w, w) of the corners        (1)
//! inside:       eᵢ · (x, y, 1) ≥ 0 for all i, if D = h₀ · e₀ > 0                      (2)
//! barycentric:  bᵢ = eᵢ·(x, y, 1) / Σⱼ eⱼ·(x, y, 1)                                   (3)
//! nearness:     κ = Σᵢ kᵢ eᵢ·(x, y, 1) / D                                            (4)
//! ```
//!
//! Olano & Greer 1997 ("Triangle scan conversion using 2D homogeneous coordinates"): nothing need be clipped at the eye's
//! plane, where w changes its sign: points behind it satisfy (2) nowhere. Only where a triangle shows
//! at all is found by cutting it at the near plane. Pixels beyond near and far are left out one by one.
//!
//! The functions of an edge that two triangles share are each other's negatives, bit for bit: no
//! sample falls between them. (3) is perspective-correct, as it comes from homogeneous points.

use super::view::{Projected, View};

/// A triangle of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// eᵢ of (1), their signs such that (2) holds.
    pub edges: [[f64; 3]; 3],
    /// κ of (4): factors of x and y, and the constant.
    pub nearness: [f64; 3],
    /// Columns and rows where it may show: x0, y0, x1, y1, end exclusive.
    pub bounds: [u16; 4],
    /// Its number.
    pub id: u32,
}

/// What rounding may move a corner by, in pixels.
const SLACK: f64 = 1e-4;

fn cross(a: &Projected, b: &Projected) -> [f64; 3] {
    // In this order, so that b × a is the negative, bit for bit.
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The value of a linear function of x and y.
#[inline]
pub fn at([a, b, c]: &[f64; 3], x: f64, y: f64) -> f64 {
    a * x + (b * y + c)
}

/// True if all points lie beyond one side of the picture.
pub fn outside<const N: usize>(points: &[Projected; N], view: &View) -> bool {
    let [w, h] = view.size.map(f64::from);
    let all = |f: &dyn Fn(&Projected) -> bool| points.iter().all(f);
    all(&|p| p[0] < 0.0) && all(&|p| p[2] > 0.0)
        || all(&|p| p[0] > w * p[2]) && all(&|p| p[2] > 0.0)
        || all(&|p| p[1] < 0.0) && all(&|p| p[2] > 0.0)
        || all(&|p| p[1] > h * p[2]) && all(&|p| p[2] > 0.0)
        || all(&|p| p[2] < view.cut)
}

impl Triangle {
    /// The triangle `id` with these corners; `None` where it covers no sample. Pixel (i, j) is sampled at
    /// x = i, y = j.
    #[inline]
    pub fn new(corners: [Projected; 3], view: &View, id: u32) -> Option<Triangle> {
        let bounds = bounds(&corners, view)?;
        let [h0, h1, h2] = &corners;
        let mut edges = [cross(h1, h2), cross(h2, h0), cross(h0, h1)]; // (1)
        let mut det = h0[0] * edges[0][0] + h0[1] * edges[0][1] + h0[2] * edges[0][2];
        if !(det != 0.0 && det.is_finite()) {
            return None;
        }
        if det < 0.0 {
            edges = edges.map(|e| e.map(|v| -v));
            det = -det;
        }
        let k = [h0[3], h1[3], h2[3]];
        let nearness =
            std::array::from_fn(|c| (0..3).map(|i| k[i] * edges[i][c]).sum::<f64>() / det); // (4)
        Some(Triangle { edges, nearness, bounds, id })
    }

    /// (3).
    #[inline]
    pub fn barycentric(&self, x: f64, y: f64) -> [f32; 3] {
        let e = self.edges.map(|e| at(&e, x, y));
        let inv = 1.0 / (e[0] + e[1] + e[2]);
        e.map(|e| (e * inv) as f32)
    }
}

/// Columns and rows of the samples that a triangle may cover.
#[inline]
fn bounds(corners: &[Projected; 3], view: &View) -> Option<[u16; 4]> {
    let mut lo = [f64::INFINITY; 2];
    let mut hi = [f64::NEG_INFINITY; 2];
    let mut see = |u: f64, v: f64, w: f64| {
        let inv = 1.0 / w;
        for (i, c) in [u * inv, v * inv].into_iter().enumerate() {
            lo[i] = lo[i].min(c);
            hi[i] = hi[i].max(c);
        }
    };
    let cut = view.cut;
    for i in 0..3 {
        let (a, b) = (&corners[i], &corners[(i + 1) % 3]);
        if a[2] >= cut {
            see(a[0], a[1], a[2]);
        }
        if (a[2] >= cut) != (b[2] >= cut) {
            let t = (cut - a[2]) / (b[2] - a[2]);
            see(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), cut);
        }
    }
    let mut found = [0; 4];
    for i in 0..2 {
        let n = f64::from(view.size[i]);
        // Samples at whole numbers.
        let (from, to) = ((lo[i] - SLACK).ceil().max(0.0), ((hi[i] + SLACK).floor() + 1.0).min(n));
        if from.is_nan() || to.is_nan() || from >= to {
            return None;
        }
        (found[i], found[i + 2]) = (from as u16, to as u16);
    }
    Some(found)
}
