//! The steps inside a `<transform>`, as 4x4 matrices in double precision.
//!
//! Each step applies after those before it: the matrix of a new step is multiplied from the left.

/// Rows of a 4x4 matrix.
pub(super) type Matrix = [[f64; 4]; 4];

/// Leaves everything as it is.
pub(super) const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// a · b.
pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Translation.
pub(super) fn translate(d: [f64; 3]) -> Matrix {
    let mut m = IDENTITY;
    for i in 0..3 {
        m[i][3] = d[i];
    }
    m
}

/// Scaling along the axes.
pub(super) fn scale(s: [f64; 3]) -> Matrix {
    let mut m = IDENTITY;
    for i in 0..3 {
        m[i][i] = s[i];
    }
    m
}

/// Right-handed rotation by `degrees` about `axis`; `None` if the axis is zero.
pub(super) fn rotate(degrees: f64, axis: [f64; 3]) -> Option<Matrix> {
    let [x, y, z] = normalize(axis)?;
    let (s, c) = degrees.to_radians().sin_cos();
    let k = 1.0 - c;
    Some([
        [x * x * k + c, x * y * k - z * s, x * z * k + y * s, 0.0],
        [x * y * k + z * s, y * y * k + c, y * z * k - x * s, 0.0],
        [x * z * k - y * s, y * z * k + x * s, z * z * k + c, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ])
}

/// Mitsuba's camera frame: +z towards `target`, +x = up x z (left in the picture), +y near `up`.
/// A zero `up` is chosen. `None` if the three do not span a frame.
pub(super) fn look_at(origin: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Option<Matrix> {
    let dir = normalize([target[0] - origin[0], target[1] - origin[1], target[2] - origin[2]])?;
    let up = if up == [0.0; 3] { perpendicular(dir).0 } else { up };
    let left = normalize(cross(up, dir))?;
    let new_up = cross(dir, left);
    let row = |i: usize| [left[i], new_up[i], dir[i], origin[i]];
    Some([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
}

/// The frame with +z along `dir` (unit) and the axes of [`perpendicular`].
pub(super) fn to_frame(dir: [f64; 3]) -> Matrix {
    let (s, t) = perpendicular(dir);
    let row = |i: usize| [s[i], t[i], dir[i], 0.0];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`: Duff et al. 2017,
/// "Building an Orthonormal Basis, Revisited", JCGT 6(1).
fn perpendicular(n: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let sign = 1.0f64.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    ([1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]])
}

/// Unit length; `None` for a zero vector.
pub(super) fn normalize(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
