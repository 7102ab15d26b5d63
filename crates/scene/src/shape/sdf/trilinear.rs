//! A function that is trilinear in a cell, and where a ray meets its zeros.
//!
//! ```text
//! f(x, y, z) = a₀ + a₁x + a₂y + a₃xy + a₄z + a₅xz + a₆yz + a₇xyz           (1)
//! f(o + s d) = c₀ + c₁s + c₂s² + c₃s³                                      (2)
//! c₀ = f(o),  c₁ = ∇f(o)·d,
//! c₂ = a₃d_xd_y + a₅d_xd_z + a₆d_yd_z + a₇(o_xd_yd_z + d_xo_yd_z + d_xd_yo_z),
//! c₃ = a₇d_xd_yd_z
//! ```
//!
//! H. Hansson-Söderlund, A. Evans, T. Akenine-Möller, "Ray tracing of signed distance function
//! grids", JCGT 11(3), 2022, sec. 3. The cubic is cut where it turns; a part whose ends differ in
//! sign holds one zero (Marmitt et al. 2004), which Newton's steps between bounds find.

/// The coefficients a₀ to a₇ of (1).
#[derive(Clone, Copy, Debug)]
pub(super) struct Trilinear([f64; 8]);

impl Trilinear {
    /// From the values at the corners of the unit cube, x fastest.
    pub(super) fn from_corners(corners: [f32; 8]) -> Trilinear {
        let mut a = corners.map(f64::from);
        for bit in [1, 2, 4] {
            for i in (0..8).filter(|i| i & bit != 0) {
                a[i] -= a[i ^ bit];
            }
        }
        Trilinear(a)
    }

    /// (1)
    pub(super) fn value(&self, [x, y, z]: [f64; 3]) -> f64 {
        let a = &self.0;
        let at = |k: usize| a[k] + a[k + 1] * x + (a[k + 2] + a[k + 3] * x) * y;
        at(0) + at(4) * z
    }

    /// ∇f.
    pub(super) fn gradient(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let a = &self.0;
        [
            a[1] + a[3] * y + (a[5] + a[7] * y) * z,
            a[2] + a[3] * x + (a[6] + a[7] * x) * z,
            a[4] + a[5] * x + (a[6] + a[7] * x) * y,
        ]
    }

    /// (2)
    fn along(&self, o: [f64; 3], d: [f64; 3]) -> Cubic {
        let a = &self.0;
        let g = self.gradient(o);
        let pairs = [d[1] * d[2], d[0] * d[2], d[0] * d[1]];
        Cubic([
            self.value(o),
            g[0] * d[0] + g[1] * d[1] + g[2] * d[2],
            a[3] * pairs[2]
                + a[5] * pairs[1]
                + a[6] * pairs[0]
                + a[7] * (o[0] * pairs[0] + o[1] * pairs[1] + o[2] * pairs[2]),
            a[7] * d[0] * pairs[0],
        ])
    }

    /// The first s in [0, length] at which f(o + s d) changes its sign.
    pub(super) fn first_crossing(&self, o: [f64; 3], d: [f64; 3], length: f64) -> Option<f64> {
        let f = self.along(o, d);
        let (mut a, mut fa) = (0.0, f.at(0.0));
        for b in f.turns().into_iter().filter(|s| *s > 0.0 && *s < length).chain([length]) {
            let fb = f.at(b);
            if (fa > 0.0) != (fb > 0.0) {
                return Some(f.zero_between((a, fa > 0.0), b));
            }
            (a, fa) = (b, fb);
        }
        None
    }
}

/// c₀ + c₁s + c₂s² + c₃s³.
struct Cubic([f64; 4]);

impl Cubic {
    fn at(&self, s: f64) -> f64 {
        let [c0, c1, c2, c3] = self.0;
        ((c3 * s + c2) * s + c1) * s + c0
    }

    fn slope(&self, s: f64) -> f64 {
        let [_, c1, c2, c3] = self.0;
        (3.0 * c3 * s + 2.0 * c2) * s + c1
    }

    /// Where the slope is zero, in rising order; infinite where it is not.
    fn turns(&self) -> [f64; 2] {
        let [_, c1, c2, c3] = self.0;
        let discriminant = c2 * c2 - 3.0 * c3 * c1;
        if discriminant < 0.0 {
            return [f64::INFINITY; 2];
        }
        let q = -(c2 + discriminant.sqrt().copysign(c2));
        let root = |n: f64, d: f64| if d == 0.0 { f64::INFINITY } else { n / d };
        let (s, t) = (root(q, 3.0 * c3), root(c1, q));
        if s < t { [s, t] } else { [t, s] }
    }

    /// The zero between `a`, where f is positive or not as told, and `b`, where it is not so.
    fn zero_between(&self, (mut a, positive): (f64, bool), mut b: f64) -> f64 {
        let mut s = 0.5 * (a + b);
        // Halving alone would reach the last bit in about as many steps.
        for _ in 0..64 {
            let f = self.at(s);
            if (f > 0.0) == positive {
                a = s;
            } else {
                b = s;
            }
            let newton = s - f / self.slope(s);
            let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
            if (next - s).abs() <= 1e-15 * s.abs() {
                return next;
            }
            s = next;
        }
        s
    }
}
