//! Cubic Bézier curves of points with a radius, in double precision.

/// x, y, z and radius.
pub(super) type Point = [f64; 4];

pub(super) fn mix(a: Point, b: Point, t: f64) -> Point {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

pub(super) fn sub(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Dot product in space.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product in space.
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Unit vector; `None` without direction.
pub(super) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let l = dot(a, a).sqrt();
    (l > 0.0 && l.is_finite()).then(|| a.map(|v| v / l))
}

/// The place in space.
pub(super) fn xyz(p: Point) -> [f64; 3] {
    [p[0], p[1], p[2]]
}

/// Point, first and second derivative at `w`.
pub(super) fn jet(p: &[Point; 4], w: f64) -> [Point; 3] {
    let [a, b, c] = [mix(p[0], p[1], w), mix(p[1], p[2], w), mix(p[2], p[3], w)];
    let (d, e) = (mix(a, b, w), mix(b, c, w));
    let bend = |i: usize| 6.0 * ((c[i] - b[i]) - (b[i] - a[i]));
    [mix(d, e, w), sub(e, d).map(|v| 3.0 * v), std::array::from_fn(bend)]
}

/// The part between `w0` and `w1`, by blossoming (Ramshaw 1989).
pub(super) fn part(p: &[Point; 4], w0: f64, w1: f64) -> [Point; 4] {
    let blossom = |s: f64, t: f64, u: f64| {
        let [a, b, c] = [mix(p[0], p[1], s), mix(p[1], p[2], s), mix(p[2], p[3], s)];
        mix(mix(a, b, t), mix(b, c, t), u)
    };
    [blossom(w0, w0, w0), blossom(w0, w0, w1), blossom(w0, w1, w1), blossom(w1, w1, w1)]
}

/// Both halves (de Casteljau).
pub(super) fn halves(p: &[Point; 4]) -> [[Point; 4]; 2] {
    let [a, b, c] = [mix(p[0], p[1], 0.5), mix(p[1], p[2], 0.5), mix(p[2], p[3], 0.5)];
    let (d, e) = (mix(a, b, 0.5), mix(b, c, 0.5));
    let m = mix(d, e, 0.5);
    [[p[0], a, d, m], [m, e, c, p[3]]]
}

/// Largest of the control radii: no radius between is larger.
pub(super) fn widest(p: &[Point; 4]) -> f64 {
    p.iter().map(|q| q[3]).fold(0.0, f64::max)
}
