//! Records in an octree, and irradiance between them.
//!
//! ```text
//! ε_i = |x - x_i|/R_i + √(1 - n·n_i),   w_i = 1/ε_i - 1/a  where ε_i < a                   (10)
//! E   ≈ Σ w_i (E_i + (n_i × n)·∇_r E_i + (x - x_i)·∇_t E_i) / Σ w_i                        (11)
//! R_i ≤ R_j + |x_i - x_j|   for all neighbours (Křivánek, Bouatouch, Pattanaik & Žára 2006)  (12)
//! ```
//!
//! a is the allowed error; the weights end at 0, so that no border shows (Tabellion & Lamorlette
//! 2004). A record that lies in front of the place may not see what that sees, and is left out.

use super::record::Record;
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

/// How far in front a record may lie, in its radius.
const IN_FRONT: f32 = 0.05;
/// Deepest node.
const DEEPEST: u32 = 24;

/// The cache.
#[derive(Debug)]
pub(in super::super) struct Cache {
    records: Vec<Record>,
    nodes: Vec<Node>,
    center: Vec3,
    half: f32,
    /// a of (10).
    error: f32,
}

#[derive(Debug, Default)]
struct Node {
    /// Places of the children; 0 for none.
    children: [u32; 8],
    /// Records that reach into the node, of a size that suits it.
    records: Vec<u32>,
}

/// The octant of `p` about `center`, and its centre.
fn octant(p: Vec3, center: Vec3, half: f32) -> (usize, Vec3) {
    let high = |k: usize| usize::from(p[k] >= center[k]);
    let i = high(0) | high(1) << 1 | high(2) << 2;
    (i, child(i, center, half))
}

fn child(i: usize, center: Vec3, half: f32) -> Vec3 {
    let side = |k: usize| if i >> k & 1 == 1 { 0.5 * half } else { -0.5 * half };
    center + Vec3::new(side(0), side(1), side(2))
}

impl Cache {
    /// Empty, for the cube around the sphere of that centre and radius.
    pub(super) fn new(center: Vec3, radius: f32, error: f32) -> Cache {
        let nodes = vec![Node::default()];
        Cache { records: Vec::new(), nodes, center, half: radius, error }
    }

    /// Adds a record; it and its neighbours are kept to (12).
    pub(super) fn insert(&mut self, mut record: Record) {
        let mut near = Vec::new();
        self.visit(record.p, |i, _| near.push(i));
        let distance = |r: &Record| (r.p - record.p).length();
        let least = near.iter().map(|&i| &self.records[i as usize]).map(|r| r.radius + distance(r));
        record.radius = least.fold(record.radius, f32::min);
        for i in near {
            let neighbour = &mut self.records[i as usize];
            let most = record.radius + (neighbour.p - record.p).length();
            neighbour.radius = neighbour.radius.min(most);
        }
        let (id, reach, p) = (self.records.len() as u32, self.error * record.radius, record.p);
        self.records.push(record);
        self.place(0, (self.center, self.half, 0), (id, reach, p));
    }

    fn place(
        &mut self,
        node: usize,
        (center, half, depth): (Vec3, f32, u32),
        record: (u32, f32, Vec3),
    ) {
        let (id, reach, p) = record;
        if half < 2.0 * reach || depth == DEEPEST {
            self.nodes[node].records.push(id);
            return;
        }
        for i in 0..8 {
            let c = child(i, center, half);
            let d = (p - c).abs();
            if d.max_component() > 0.5 * half + reach {
                continue;
            }
            let mut next = self.nodes[node].children[i] as usize;
            if next == 0 {
                next = self.nodes.len();
                self.nodes.push(Node::default());
                self.nodes[node].children[i] = next as u32;
            }
            self.place(next, (c, 0.5 * half, depth + 1), record);
        }
    }

    /// Calls `each` with the records that may reach `p`.
    fn visit(&self, p: Vec3, mut each: impl FnMut(u32, &Record)) {
        let (mut node, mut center, mut half) = (&self.nodes[0], self.center, self.half);
        loop {
            node.records.iter().for_each(|&i| each(i, &self.records[i as usize]));
            let (i, c) = octant(p, center, half);
            match node.children[i] {
                0 => return,
                next => (node, center, half) = (&self.nodes[next as usize], c, 0.5 * half),
            }
        }
    }

    /// (11), if any record is near enough.
    pub(in super::super) fn irradiance(&self, p: Vec3, n: Vec3) -> Option<Spectrum> {
        let (mut sum, mut weights) = (Spectrum::ZERO, 0.0);
        self.visit(p, |_, r| {
            let turned = (1.0 - n.dot(r.n)).max(0.0).sqrt();
            let error = (p - r.p).length() / r.radius + turned;
            let front = (r.p - p).dot(n + r.n) * 0.5;
            if error < self.error && front < IN_FRONT * r.radius {
                let w = (1.0 / error.max(1e-6)) - 1.0 / self.error; // (10)
                sum += r.extrapolate(p, n) * w;
                weights += w;
            }
        });
        (weights > 0.0).then(|| sum / weights)
    }
}
