//! Least squares of a few unknowns.

/// Unknowns of a fit: a constant and the columns of a pixel.
pub const UNKNOWNS: usize = 8;

/// One row of numbers a fit knows of a pixel; the first is 1.
pub type Columns = [f32; UNKNOWNS];

/// Solves (G + λ) β = r for each of the right sides, λ on the diagonal but for the constant, by
/// Cholesky's decomposition. A column that says nothing has a coefficient of 0.
pub fn solve<const C: usize>(
    gram: &[Columns; UNKNOWNS],
    ridge: f32,
    right: &[Columns; C],
) -> [Columns; C] {
    let mut l = *gram;
    let mut inverse = [0.0; UNKNOWNS];
    for j in 0..UNKNOWNS {
        let mut d = l[j][j] + if j == 0 { 0.0 } else { ridge };
        for k in 0..j {
            d -= l[j][k] * l[j][k];
        }
        // What rounding leaves of a column that the earlier ones explain is nothing.
        let known = d > 1e-6 * gram[j][j] && d > 0.0;
        inverse[j] = if known { 1.0 / d.sqrt() } else { 0.0 };
        for i in j + 1..UNKNOWNS {
            let mut v = l[i][j];
            for k in 0..j {
                v -= l[i][k] * l[j][k];
            }
            l[i][j] = v * inverse[j];
        }
    }
    right.map(|r| {
        let mut beta = r;
        for i in 0..UNKNOWNS {
            for k in 0..i {
                beta[i] -= l[i][k] * beta[k];
            }
            beta[i] *= inverse[i];
        }
        for i in (0..UNKNOWNS).rev() {
            for k in i + 1..UNKNOWNS {
                beta[i] -= l[k][i] * beta[k];
            }
            beta[i] *= inverse[i];
        }
        beta
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of x xᵀ and x y over some pixels of pseudo-random columns, of which the last is a
    /// copy of the one before if `twice`.
    fn sums(truth: &Columns, twice: bool) -> ([Columns; UNKNOWNS], [Columns; 1]) {
        let (mut gram, mut right) = ([[0.0; UNKNOWNS]; UNKNOWNS], [[0.0; UNKNOWNS]]);
        for n in 0..200u64 {
            let mut x: Columns = std::array::from_fn(|j| {
                let bits = kaustika_math::mix_bits(n * 8 + j as u64);
                (bits % 1000) as f32 / 500.0 - 1.0
            });
            x[0] = 1.0;
            if twice {
                x[7] = x[6];
            }
            let y: f32 = x.iter().zip(truth).map(|(x, t)| x * t).sum();
            for i in 0..UNKNOWNS {
                for j in 0..UNKNOWNS {
                    gram[i][j] += x[i] * x[j];
                }
                right[0][i] += x[i] * y;
            }
        }
        (gram, right)
    }

    #[test]
    fn what_is_linear_is_found() {
        let truth = [2.0, 0.5, -1.0, 0.0, 3.0, 0.25, -0.5, 1.0];
        let (gram, right) = sums(&truth, false);
        let [beta] = solve(&gram, 0.0, &right);
        for (b, t) in beta.iter().zip(&truth) {
            assert!((b - t).abs() < 1e-4, "{beta:?}");
        }
        // A heavy ridge leaves the constant, which is near the mean of y.
        let [flat] = solve(&gram, 1e8, &right);
        assert!(flat[1..].iter().all(|b| b.abs() < 1e-4), "{flat:?}");
        assert!((flat[0] - right[0][0] / gram[0][0]).abs() < 1e-3);
    }

    #[test]
    fn columns_that_say_nothing_do_no_harm() {
        let truth = [2.0, 0.5, -1.0, 0.0, 3.0, 0.25, -0.5, 0.0];
        let (gram, right) = sums(&truth, true);
        let [beta] = solve(&gram, 0.0, &right);
        assert!(beta.iter().all(|b| b.is_finite() && b.abs() < 10.0), "{beta:?}");
        assert!((beta[6] + beta[7] + 0.5).abs() < 1e-2, "{beta:?}");
        assert_eq!(solve(&[[0.0; UNKNOWNS]; UNKNOWNS], 0.0, &[[0.0; UNKNOWNS]; 3]), [[0.0; 8]; 3]);
    }
}
