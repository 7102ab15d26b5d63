//! Fitting a sigmoid polynomial to a colour.
//!
//! Minimises |Lab(S) - Lab(rgb)|² + ε |c|² over the three coefficients, where Lab(S) is the CIELAB
//! colour of the reflectance S under the colour space's illuminant (Jakob and Hanika 2019,
//! section 3), by Gauss-Newton steps with Levenberg-Marquardt damping. The Jacobian is analytic:
//! dS/dx = 1 / (2 (1 + x²)^(3/2)). The small ε keeps the coefficients of colours no reflectance
//! has (saturated ones of wide gamuts) finite.

use std::sync::OnceLock;

use crate::cie::{NODES, matching, node_lambda};
use crate::sigmoid::{SigmoidPolynomial, sigmoid_t};
use crate::{ColorSpace, cie};

/// Weight of |c|², in squared Lab units.
const EPSILON: f64 = 1e-8;
/// Squared Lab distance at which a fit is done: a hundredth of the smallest visible difference.
const DONE: f64 = 1e-4;

type Vec3 = [f64; 3];
type Mat3 = [[f64; 3]; 3];

/// What is needed to fit colours of one colour space.
pub(crate) struct Fitter {
    chunks: Vec<Chunk>,
    white: Vec3,
    rgb_to_xyz: Mat3,
}

/// Four wavelengths: their t, and their weights in X, Y and Z (illuminant and quadrature within).
#[derive(Clone, Copy, Default)]
struct Chunk {
    t: [f64; 4],
    weight: [[f64; 4]; 3],
}

impl Fitter {
    /// The fitter of full accuracy (1 nm), made once.
    pub fn exact(space: ColorSpace) -> &'static Fitter {
        static FITTERS: [OnceLock<Fitter>; 4] = [const { OnceLock::new() }; 4];
        FITTERS[space as usize].get_or_init(|| Fitter::new(space, 1))
    }

    /// Nodes every `step` nm, a divisor of 470; the weights integrate piecewise linear
    /// reflectances over the 1 nm illuminant and observer.
    pub fn new(space: ColorSpace, step: usize) -> Fitter {
        let count = (NODES - 1) / step + 1;
        let mut chunks = vec![Chunk::default(); count.div_ceil(4)];
        for i in 0..count {
            chunks[i / 4].t[i % 4] = sigmoid_t(node_lambda(i * step)) as f64;
        }
        let illuminant = space.illuminant();
        let mut white = [0.0; 3];
        for i in 0..NODES {
            let trapezoid = if i == 0 || i == NODES - 1 { 0.5 } else { 1.0 };
            let scale = trapezoid * illuminant.node(i) as f64 / cie::Y_INTEGRAL as f64;
            let row = matching(node_lambda(i));
            let (node, t) = (i / step, (i % step) as f64 / step as f64);
            for k in 0..3 {
                let w = scale * row[k] as f64;
                white[k] += w;
                chunks[node / 4].weight[k][node % 4] += (1.0 - t) * w;
                if t > 0.0 {
                    chunks[(node + 1) / 4].weight[k][(node + 1) % 4] += t * w;
                }
            }
        }
        Fitter { chunks, white, rgb_to_xyz: space.to_xyz().0.map(|r| r.map(f64::from)) }
    }

    /// The smooth reflectance whose colour under the space's illuminant is `rgb` (clamped to
    /// [0, 1]). Greys are exact.
    pub fn fit(&self, rgb: [f32; 3]) -> SigmoidPolynomial {
        let rgb = rgb.map(|v| v.clamp(0.0, 1.0));
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return SigmoidPolynomial::constant(rgb[0]);
        }
        let y: f64 = (0..3).map(|k| self.rgb_to_xyz[1][k] * rgb[k] as f64).sum();
        let grey = SigmoidPolynomial::constant(y.clamp(0.01, 0.99) as f32).c;
        let (c, _) = self.fit_from(rgb.map(f64::from), grey.map(f64::from), 100);
        SigmoidPolynomial { c: c.map(|v| v as f32) }
    }

    /// As `fit`, from a first guess, unclamped, of at most `limit` steps. Also gives the squared
    /// Lab distance that remains.
    pub fn fit_from(&self, rgb: Vec3, start: Vec3, limit: usize) -> (Vec3, f64) {
        // Lab is linear near black: keep the relative accuracy of dark colours.
        let brightest = rgb[0].max(rgb[1]).max(rgb[2]);
        let done = DONE * (100.0 * brightest).powi(2).min(1.0);
        let target = self.lab(mul(&self.rgb_to_xyz, rgb)).0;
        // Residual, its Jacobian and the objective.
        let evaluate = |c: &Vec3| {
            let (xyz, dxyz) = self.forward(c);
            let (lab, slope) = self.lab(xyz);
            let r: Vec3 = std::array::from_fn(|k| lab[k] - target[k]);
            // Lab = (116 fy - 16, 500 (fx - fy), 200 (fy - fz)).
            let df: Mat3 = std::array::from_fn(|k| dxyz[k].map(|d| d * slope[k]));
            let jacobian: Mat3 = [
                std::array::from_fn(|j| 116.0 * df[1][j]),
                std::array::from_fn(|j| 500.0 * (df[0][j] - df[1][j])),
                std::array::from_fn(|j| 200.0 * (df[1][j] - df[2][j])),
            ];
            (r, jacobian, dot(&r, &r), dot(&r, &r) + EPSILON * dot(c, c))
        };
        let mut c = start;
        let (mut r, mut jacobian, mut distance, mut objective) = evaluate(&c);
        let mut damping = 1e-3;
        for _ in 0..limit {
            if distance < done {
                break;
            }
            let mut normal: Mat3 = std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..3).map(|k| jacobian[k][i] * jacobian[k][j]).sum())
            });
            let gradient: Vec3 = std::array::from_fn(|i| {
                (0..3).map(|k| jacobian[k][i] * r[k]).sum::<f64>() + EPSILON * c[i]
            });
            for (i, row) in normal.iter_mut().enumerate() {
                row[i] = (row[i] + EPSILON) * (1.0 + damping);
            }
            let Some(step) = solve(&normal, &gradient) else { break };
            let next: Vec3 = std::array::from_fn(|k| c[k] - step[k]);
            let new = evaluate(&next);
            if new.3 < objective {
                let gain = objective - new.3;
                c = next;
                (r, jacobian, distance, objective) = new;
                damping = (damping * 0.1).max(1e-12);
                if gain < 1e-7 * objective {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        (c, distance)
    }

    /// XYZ of the sigmoid under the illuminant, and its derivatives by the coefficients.
    fn forward(&self, c: &Vec3) -> (Vec3, Mat3) {
        let mut value = [[0.0f64; 4]; 3];
        let mut slope = [[[0.0f64; 4]; 3]; 3];
        for chunk in &self.chunks {
            let mut s = [0.0; 4];
            let mut ds = [0.0; 4];
            for i in 0..4 {
                let t = chunk.t[i];
                let x = (c[0] * t + c[1]) * t + c[2];
                let inverse = 1.0 / (1.0 + x * x).sqrt();
                s[i] = 0.5 + 0.5 * x * inverse;
                ds[i] = 0.5 * inverse * inverse * inverse;
            }
            for k in 0..3 {
                for i in 0..4 {
                    value[k][i] += chunk.weight[k][i] * s[i];
                    let d = chunk.weight[k][i] * ds[i];
                    let dt = d * chunk.t[i];
                    slope[k][0][i] += dt * chunk.t[i];
                    slope[k][1][i] += dt;
                    slope[k][2][i] += d;
                }
            }
        }
        let sum = |v: [f64; 4]| v[0] + v[1] + v[2] + v[3];
        (value.map(sum), slope.map(|row| row.map(sum)))
    }

    /// CIELAB (CIE 1976) relative to the illuminant, and the derivatives df/dX, df/dY, df/dZ of
    /// its three cube roots.
    fn lab(&self, xyz: Vec3) -> (Vec3, Vec3) {
        const DELTA: f64 = 6.0 / 29.0;
        let mut f = [0.0; 3];
        let mut slope = [0.0; 3];
        for k in 0..3 {
            let t = xyz[k] / self.white[k];
            if t > DELTA * DELTA * DELTA {
                f[k] = t.cbrt();
                slope[k] = f[k] / (3.0 * t * self.white[k]);
            } else {
                f[k] = t / (3.0 * DELTA * DELTA) + 4.0 / 29.0;
                slope[k] = 1.0 / (3.0 * DELTA * DELTA * self.white[k]);
            }
        }
        ([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])], slope)
    }
}

fn dot(a: &Vec3, b: &Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn mul(m: &Mat3, v: Vec3) -> Vec3 {
    m.map(|r| dot(&r, &v))
}

/// Cramer's rule; `None` if singular.
fn solve(m: &Mat3, v: &Vec3) -> Option<Vec3> {
    let determinant = |m: &Mat3| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let det = determinant(m);
    let x = std::array::from_fn(|j| {
        let mut replaced = *m;
        for i in 0..3 {
            replaced[i][j] = v[i];
        }
        determinant(&replaced) / det
    });
    x.iter().all(|v: &f64| v.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DenseSpectrum;
    use crate::testing::Pcg;

    /// Largest component of rgb(S) - rgb.
    fn error(space: ColorSpace, s: SigmoidPolynomial, rgb: [f32; 3]) -> f32 {
        let light = space.illuminant();
        let seen = DenseSpectrum::from_fn(|l| s.at(l) * light.at(l)).xyz();
        let back = space.from_xyz().apply(seen);
        (0..3).map(|k| (back[k] - rgb[k]).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn colours_of_srgb_round_trip() {
        let fitter = Fitter::exact(ColorSpace::Srgb);
        let mut rng = Pcg(7);
        let (mut worst, mut sum, mut at) = (0.0f32, 0.0, [0.0; 3]);
        let n = 2000;
        for _ in 0..n {
            let rgb = rng.rgb();
            let e = error(ColorSpace::Srgb, fitter.fit(rgb), rgb);
            sum += e;
            if e > worst {
                (worst, at) = (e, rgb);
            }
        }
        assert!(worst < 0.001, "{worst} at {at:?}, mean {}", sum / n as f32);
    }

    #[test]
    fn corners_and_edges_of_the_srgb_cube() {
        let fitter = Fitter::exact(ColorSpace::Srgb);
        for i in 0..125 {
            let rgb = [i / 25, i / 5 % 5, i % 5].map(|v| [0.0, 1e-3, 0.5, 0.999, 1.0][v]);
            let s = fitter.fit(rgb);
            assert!(s.c.iter().all(|c| c.is_finite()), "{rgb:?} {s:?}");
            let e = error(ColorSpace::Srgb, s, rgb);
            assert!(e < 0.001, "{rgb:?} {e} {s:?}");
        }
    }

    #[test]
    fn wide_gamuts_stay_finite_and_moderate_colours_fit() {
        for space in ColorSpace::ALL {
            let fitter = Fitter::exact(space);
            let mut rng = Pcg(3);
            for _ in 0..200 {
                let s = fitter.fit(rng.rgb());
                assert!(s.c.iter().all(|c| c.is_finite()), "{space:?}");
                // Towards grey all spaces' colours exist.
                let rgb = rng.rgb().map(|v| 0.35 + 0.3 * v);
                let e = error(space, fitter.fit(rgb), rgb);
                assert!(e < 0.003, "{space:?} {rgb:?} {e}");
            }
        }
    }
}
