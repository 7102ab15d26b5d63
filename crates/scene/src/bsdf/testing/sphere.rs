//! The sphere of directions in cells: a partition that follows the density of some points, and
//! adaptive quadrature over its cells.
//!
//! Coordinates: hemisphere (up or down), v = 1 - |cos θ| in [0, 1], azimuth φ in [0,2π). The
//! solid angle is dω = dv dφ. v is computed from the sine, so that narrow lobes about the pole
//! keep their digits in `f32`.

use kaustika_math::Vec3;
use std::f64::consts::PI;

/// A rectangle of (v, φ) in one hemisphere.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub up: bool,
    pub v: [f64; 2],
    pub phi: [f64; 2],
}

/// (up, v, φ) of a unit direction.
fn coordinates(d: Vec3) -> (bool, f64, f64) {
    let (x, y, z) = (d.x as f64, d.y as f64, d.z as f64);
    let v = (x * x + y * y) / (1.0 + z.abs());
    let phi = y.atan2(x);
    (z > 0.0, v, if phi < 0.0 { phi + 2.0 * PI } else { phi })
}

/// The direction at the coordinates.
fn direction(up: bool, v: f64, phi: f64) -> Vec3 {
    let r = (v * (2.0 - v)).sqrt();
    let z = if up { 1.0 - v } else { v - 1.0 };
    Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32)
}

/// Nodes and weights of Gauss and Legendre's rule of three points on [0, 1].
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

impl Cell {
    fn split(self) -> [Cell; 4] {
        let (v, p) = (0.5 * (self.v[0] + self.v[1]), 0.5 * (self.phi[0] + self.phi[1]));
        [
            Cell { v: [self.v[0], v], phi: [self.phi[0], p], ..self },
            Cell { v: [v, self.v[1]], phi: [self.phi[0], p], ..self },
            Cell { v: [self.v[0], v], phi: [p, self.phi[1]], ..self },
            Cell { v: [v, self.v[1]], phi: [p, self.phi[1]], ..self },
        ]
    }

    /// Which part of [`Cell::split`] holds the point.
    fn child(&self, v: f64, phi: f64) -> usize {
        (v >= 0.5 * (self.v[0] + self.v[1])) as usize
            + 2 * (phi >= 0.5 * (self.phi[0] + self.phi[1])) as usize
    }

    fn gauss<const N: usize>(&self, f: &impl Fn(Vec3) -> [f64; N]) -> [f64; N] {
        let (dv, dp) = (self.v[1] - self.v[0], self.phi[1] - self.phi[0]);
        let mut sum = [0.0; N];
        for (a, wa) in GAUSS {
            for (b, wb) in GAUSS {
                let y = f(direction(self.up, self.v[0] + a * dv, self.phi[0] + b * dp));
                (0..N).for_each(|i| sum[i] += wa * wb * y[i]);
            }
        }
        sum.map(|s| s * dv * dp)
    }

    /// ∫ f dω over the cell; parts are split while that changes a component by more than
    /// `tolerance`, at most `depth` times; while the first component is zero, they are split `search` times.
    pub fn integrate<const N: usize>(
        &self,
        f: &impl Fn(Vec3) -> [f64; N],
        tolerance: f64,
        depth: u32,
        search: u32,
    ) -> [f64; N] {
        self.refine(f, self.gauss(f), tolerance, depth, search)
    }

    fn refine<const N: usize>(
        &self,
        f: &impl Fn(Vec3) -> [f64; N],
        coarse: [f64; N],
        tolerance: f64,
        depth: u32,
        search: u32,
    ) -> [f64; N] {
        let parts = self.split().map(|c| (c, c.gauss(f)));
        let mut fine = [0.0; N];
        parts.iter().for_each(|(_, p)| (0..N).for_each(|i| fine[i] += p[i]));
        let found = search == 0 || fine[0] != 0.0;
        if depth == 0 || found && (0..N).all(|i| (fine[i] - coarse[i]).abs() <= tolerance) {
            return fine;
        }
        let mut sum = [0.0; N];
        for (c, p) in parts {
            let y = c.refine(f, p, 0.5 * tolerance, depth - 1, search.saturating_sub(1));
            (0..N).for_each(|i| sum[i] += y[i]);
        }
        sum
    }
}

enum Node {
    Leaf(usize),
    Inner(Cell, [Box<Node>; 4]),
}

/// Points that a cell of quadrature may hold: so few that a lobe in one of its corners, which
/// the nodes would not see, holds next to nothing.
const FINEST: usize = 12;

/// The sphere cut into parts, each with at most a given number of the points it was built from.
pub struct Partition {
    roots: Vec<Node>,
    /// Of each part the cells for quadrature, and whether points lie in them.
    parts: Vec<Vec<(Cell, bool)>>,
}

impl Partition {
    /// Splits the parts that hold more than `most` of `points`.
    pub fn new(points: &[Vec3], most: usize) -> Partition {
        let mut parts = Vec::new();
        let points: Vec<_> = points.iter().map(|&d| coordinates(d)).collect();
        let mut roots = Vec::new();
        for up in [true, false] {
            let cell = Cell { up, v: [0.0, 1.0], phi: [0.0, 2.0 * PI] };
            let inside = points.iter().filter(|p| p.0 == up).map(|p| (p.1, p.2)).collect();
            roots.push(grow(cell, inside, most, 0, &mut parts));
        }
        Partition { roots, parts }
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Index of the part that holds a direction.
    pub fn find(&self, d: Vec3) -> usize {
        let (up, v, phi) = coordinates(d);
        let mut node = &self.roots[!up as usize];
        loop {
            match node {
                Node::Leaf(i) => return *i,
                Node::Inner(cell, parts) => node = &parts[cell.child(v, phi)],
            }
        }
    }

    /// ∫ f dω over each part, to about `tolerance`.
    pub fn integrate<const N: usize>(
        &self,
        f: &impl Fn(Vec3) -> [f64; N],
        tolerance: f64,
    ) -> Vec<[f64; N]> {
        let integral = |cells: &Vec<(Cell, bool)>| {
            let mut sum = [0.0; N];
            let tolerance = tolerance / cells.len() as f64;
            for &(cell, hit) in cells {
                let y = cell.integrate(f, tolerance, 6, if hit { 4 } else { 2 });
                (0..N).for_each(|i| sum[i] += y[i]);
            }
            sum
        };
        self.parts.iter().map(integral).collect()
    }
}

type Points = Vec<(f64, f64)>;

fn scatter(cell: Cell, points: Points) -> [(Cell, Points); 4] {
    let mut inside = cell.split().map(|c| (c, Vec::new()));
    points.into_iter().for_each(|p| inside[cell.child(p.0, p.1)].1.push(p));
    inside
}

/// The tree over a cell. It is split at least twice: quadrature then sees every octant.
fn grow(
    cell: Cell,
    points: Points,
    most: usize,
    depth: u32,
    out: &mut Vec<Vec<(Cell, bool)>>,
) -> Node {
    if depth >= 2 && (points.len() <= most || depth == 20) {
        let mut cells = Vec::new();
        cut(cell, points, depth, &mut cells);
        out.push(cells);
        return Node::Leaf(out.len() - 1);
    }
    let parts = scatter(cell, points);
    Node::Inner(cell, parts.map(|(c, p)| Box::new(grow(c, p, most, depth + 1, out))))
}

/// The cells for quadrature in a cell.
fn cut(cell: Cell, points: Points, depth: u32, out: &mut Vec<(Cell, bool)>) {
    if points.len() <= FINEST || depth == 24 {
        out.push((cell, !points.is_empty()));
        return;
    }
    scatter(cell, points).into_iter().for_each(|(c, p)| cut(c, p, depth + 1, out));
}

#[test]
fn partition_covers_the_sphere_and_finds_its_cells() {
    let points: Vec<_> = (0..5000)
        .map(|i| {
            direction(i % 3 == 0, ((i * 7) % 4999) as f64 / 4999.0, i as f64 * 0.9 % (2.0 * PI))
        })
        .collect();
    let partition = Partition::new(&points, 40);
    let sums = partition.integrate(&|d| [1.0, (d.z * d.z) as f64], 1e-9);
    let area: f64 = sums.iter().map(|s| s[0]).sum();
    assert!((area - 4.0 * PI).abs() < 1e-9, "{area}");
    let z2: f64 = sums.iter().map(|s| s[1]).sum();
    assert!((z2 - 4.0 / 3.0 * PI).abs() < 1e-6, "{z2}");
    for p in points {
        let (up, v, phi) = coordinates(p);
        let holds = |(c, _): &(Cell, bool)| {
            c.up == up && c.v[0] <= v && v <= c.v[1] && c.phi[0] <= phi && phi <= c.phi[1]
        };
        assert!(partition.parts[partition.find(p)].iter().any(holds));
    }
}
