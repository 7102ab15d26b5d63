//! Chains of mirrors and clear interfaces between two points: how their vertices move with the ends
//! (Jakob & Marschner 2012, sec. 4).
//!
//! ```text
//! x_0, S_1 … S_m, x_{m+1}            h_i = η₋ ω₋ + η₊ ω₊     at S_i, toward x_{i-1} and x_{i+1}
//! c_i = (t₁ · h_i, t₂ · h_i) = 0     t₁, t₂ ⊥ n: the law of reflection or refraction             (1)
//! ∂c_i = A_i ∂x_{i-1} + B_i ∂x_i + C_i ∂x_{i+1}                                          (2)
//! ∂c_i/∂… = t · ∂h - (n · h) (t · ∂n)                                                    (3)
//! G_i = -(B_i + A_i G_{i-1})⁻¹ C_i,   G_0 = 0:    ∂x_i = G_i ∂x_{i+1}                          (4)
//! ∂x_1/∂x_{m+1} = G_1 G_2 … G_m      x_0 kept                                             (5)
//! ```
//!
//! Displacements are in tangent planes of the geometry, normals those that shade.

use super::path::Node;
use kaustika_math::Vec3;
use kaustika_scene::Geometry;

/// A 2 x 2 matrix, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matrix([[f64; 2]; 2]);

impl Matrix {
    const ONE: Matrix = Matrix([[1.0, 0.0], [0.0, 1.0]]);

    pub(super) fn det(&self) -> f64 {
        let [[a, b], [c, d]] = self.0;
        a * d - b * c
    }

    fn inverse(&self) -> Option<Matrix> {
        let ([[a, b], [c, d]], k) = (self.0, 1.0 / self.det());
        k.is_finite().then_some(Matrix([[d * k, -b * k], [-c * k, a * k]]))
    }

    fn times(&self, o: &Matrix) -> Matrix {
        let entry = |i: usize, j: usize| self.0[i][0] * o.0[0][j] + self.0[i][1] * o.0[1][j];
        Matrix([[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]])
    }

    fn map(&self, mut f: impl FnMut(usize, usize, f64) -> f64) -> Matrix {
        let m = &self.0;
        Matrix([[f(0, 0, m[0][0]), f(0, 1, m[0][1])], [f(1, 0, m[1][0]), f(1, 1, m[1][1])]])
    }

    /// The matrix times a vector.
    pub(super) fn of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.0.map(|[a, b]| a * x + b * y)
    }
}

/// A point with the plane in which it moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) p: Vec3,
    /// Orthonormal tangents.
    pub(super) tangents: [Vec3; 2],
}

impl Place {
    /// A point of a surface with this normal.
    pub(super) fn new(p: Vec3, n: Vec3) -> Place {
        let (s, t) = n.coordinate_system();
        Place { p, tangents: [s, t] }
    }

    /// What `d` is in the plane.
    pub(super) fn local(&self, d: Vec3) -> [f64; 2] {
        self.tangents.map(|t| f64::from(t.dot(d)))
    }
}

/// A vertex of a chain, and the indices of refraction on the sides of the one before and the one after it.
pub(super) type Interface<'n, 'a> = (&'n Node<'a>, [f32; 2]);

/// h of (1) may be off the normal by this: where a texture bends normals, (3) does not know them.
const ALIGNED: f32 = 1e-2;

/// (5); `None` where it does not exist.
pub(super) fn first_by_last(
    geometry: &Geometry,
    first: Place,
    chain: &[Interface],
    last: Place,
) -> Option<Matrix> {
    let place = |(node, _): &Interface| Place::new(node.p(), node.surface.ng);
    let mut g = Matrix([[0.0; 2]; 2]);
    let mut product = Matrix::ONE;
    for (i, interface) in chain.iter().enumerate() {
        let before = i.checked_sub(1).map_or(first, |i| place(&chain[i]));
        let after = chain.get(i + 1).map_or(last, place);
        let [a, b, c] = blocks(geometry, &before, interface, &after)?;
        let ag = a.times(&g);
        let sum = b.map(|i, j, x| x + ag.0[i][j]);
        g = sum.inverse()?.times(&c).map(|_, _, x| -x); // (4)
        product = product.times(&g);
    }
    Some(product)
}

/// A, B and C of (2).
fn blocks(
    geometry: &Geometry,
    before: &Place,
    &(node, [eta_before, eta_after]): &Interface,
    after: &Place,
) -> Option<[Matrix; 3]> {
    let (x, n) = (node.p(), node.surface.ns);
    let to = |q: Vec3| {
        let d = q - x;
        let length = d.length();
        (d / length, length)
    };
    let ((w1, d1), (w2, d2)) = (to(before.p), to(after.p));
    let h = w1 * eta_before + w2 * eta_after;
    let along = n.dot(h);
    if (h - n * along).length() > ALIGNED * h.length() {
        return None;
    }
    let here = Place::new(x, node.surface.ng);
    let (s, t) = n.coordinate_system();
    // ∂ω where its end moves by v.
    let turns = |w: Vec3, d: f32, v: Vec3| (v - w * w.dot(v)) / d;
    let column = |dh: Vec3, dn: Vec3| {
        [s, t].map(|t| f64::from(t.dot(dh)) - f64::from(along) * f64::from(t.dot(dn)))
    };
    let matrix = |columns: [[f64; 2]; 2]| {
        Matrix([[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]])
    };
    let a = before.tangents.map(|v| column(turns(w1, d1, v) * eta_before, Vec3::ZERO));
    let c = after.tangents.map(|v| column(turns(w2, d2, v) * eta_after, Vec3::ZERO));
    let mut b = [[0.0; 2]; 2];
    for (k, v) in here.tangents.into_iter().enumerate() {
        let dn = geometry.normal_along(&node.surface, v)?;
        let dh = turns(w1, d1, -v) * eta_before + turns(w2, d2, -v) * eta_after;
        b[k] = column(dh, dn);
    }
    Some([matrix(a), matrix(b), matrix(c)])
}
