//! Triangle soups and rays to test on.

use kaustika_math::{Ray, Vec3, mix_bits};

/// Numbers from a counter.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random(mix_bits(seed + 1))
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix_bits(self.0)
    }

    /// In [0, 1).
    pub(super) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In the cube of edge 2 about the origin.
    pub(super) fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - Vec3::splat(1.0)
    }

    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if v.length_squared() <= 1.0
                && let Some(d) = v.try_normalize()
            {
                return d;
            }
        }
    }
}

pub(super) struct Mesh {
    pub(super) name: &'static str,
    pub(super) positions: Vec<Vec3>,
    pub(super) indices: Vec<[u32; 3]>,
}

impl Mesh {
    fn soup(name: &'static str, triangles: Vec<[Vec3; 3]>) -> Mesh {
        let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { name, positions: triangles.into_flattened(), indices }
    }

    pub(super) fn corners(&self, prim: u32) -> [[f32; 3]; 3] {
        self.indices[prim as usize].map(|i| self.positions[i as usize].into())
    }

    pub(super) fn random(name: &'static str, n: usize, size: f32, scale: f32) -> Mesh {
        let mut r = Random::new(n as u64);
        let triangle = |_| {
            let c = r.cube();
            [0; 3].map(|_| (c + r.cube() * size) * scale)
        };
        Mesh::soup(name, (0..n).map(triangle).collect())
    }

    /// Long and thin, in all directions.
    pub(super) fn needles(n: usize) -> Mesh {
        let mut r = Random::new(77);
        let triangle = |_| {
            let (c, d) = (r.cube(), r.direction());
            [c - d, c + d, c + r.cube() * 1e-4]
        };
        Mesh::soup("needles", (0..n).map(triangle).collect())
    }

    /// Sheets of triangles in the same planes, each triangle three times with its corners in
    /// another order.
    pub(super) fn duplicates(n: usize) -> Mesh {
        let mut r = Random::new(5);
        let mut triangles = Vec::new();
        for i in 0..n {
            let mut t = [0; 3].map(|_| r.cube());
            for p in &mut t {
                p[i % 3] = (i % 5) as f32 * 0.25 - 0.5;
            }
            triangles.extend([t, [t[1], t[2], t[0]], [t[2], t[1], t[0]]]);
        }
        Mesh::soup("duplicates", triangles)
    }

    /// A grid of n x n quads with shared corners, slightly bumpy.
    pub(super) fn grid(n: u32) -> Mesh {
        let at = |i: u32, j: u32| {
            let (x, y) = (i as f32 / n as f32 * 2.0 - 1.0, j as f32 / n as f32 * 2.0 - 1.0);
            Vec3::new(x, y, 0.1 * (5.0 * x).sin() * (7.0 * y).cos())
        };
        let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j))).collect();
        let mut indices = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let a = i * (n + 1) + j;
                indices.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
            }
        }
        Mesh { name: "grid", positions, indices }
    }

    /// A sphere of 20·4^level triangles: an icosahedron, subdivided.
    pub(super) fn icosphere(level: usize) -> Mesh {
        let p = (1.0 + 5f32.sqrt()) / 2.0;
        let mut positions: Vec<Vec3> = Vec::new();
        for (a, b) in [(1.0, p), (-1.0, p), (1.0, -p), (-1.0, -p)] {
            positions.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
        }
        for v in &mut positions {
            *v = v.normalize();
        }
        // The faces: triples of corners at the length of an edge.
        let edge = |a: usize, b: usize| (positions[a] - positions[b]).length() < 1.1;
        let mut indices = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if edge(a, b) && edge(b, c) && edge(a, c) {
                        indices.push([a as u32, b as u32, c as u32]);
                    }
                }
            }
        }
        assert_eq!(indices.len(), 20);
        for _ in 0..level {
            let mut middles = std::collections::BTreeMap::new();
            let mut finer = Vec::new();
            for [a, b, c] in indices {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| {
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        let m = positions[a as usize] + positions[b as usize];
                        positions.push(m.normalize());
                        positions.len() as u32 - 1
                    })
                });
                finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            indices = finer;
        }
        Mesh { name: "icosphere", positions, indices }
    }

    /// A row whose steps double, over 40 binary orders of magnitude.
    pub(super) fn exponential() -> Mesh {
        let triangle = |i: i32| {
            let s = 2f32.powi(i - 20);
            [Vec3::new(s, 0.0, 0.0), Vec3::new(1.5 * s, s, 0.0), Vec3::new(1.5 * s, 0.0, s)]
        };
        Mesh::soup("exponential", (0..40).map(triangle).collect())
    }

    /// All that brute force is compared on.
    pub(super) fn all() -> Vec<Mesh> {
        vec![
            Mesh::random("one", 1, 0.8, 1.0),
            Mesh::random("few", 6, 0.5, 1.0),
            Mesh::random("thirty", 30, 0.4, 1.0),
            Mesh::random("soup", 1500, 0.1, 1.0),
            Mesh::random("large overlapping", 300, 1.0, 1.0),
            Mesh::random("huge", 500, 0.2, 1e15),
            Mesh::random("large", 500, 0.2, 1e9),
            Mesh::random("tiny", 500, 0.2, 1e-22),
            Mesh::random("small", 500, 0.2, 1e-9),
            Mesh::needles(700),
            Mesh::duplicates(150),
            Mesh::grid(25),
            Mesh::icosphere(3),
            Mesh::exponential(),
        ]
    }

    /// Rays of many kinds for this mesh: at random, along axes, at corners, edges and planes.
    pub(super) fn ray(&self, r: &mut Random) -> Ray {
        let size = self.positions.iter().fold(0f32, |m, p| m.max(p.abs().max_component()));
        let mut o = r.cube() * (1.5 * size);
        if r.below(8) == 0 {
            o *= 100.0;
        }
        let target = |r: &mut Random| {
            let i = self.indices[r.below(self.indices.len())];
            let [a, b, c] = i.map(|i| self.positions[i as usize]);
            match r.below(4) {
                0 => a,
                1 => (a + b) * 0.5,
                2 => (a + b + c) * (1.0 / 3.0),
                _ => a.lerp(b, r.unit()).lerp(c, r.unit()),
            }
        };
        let d = match r.below(8) {
            0 => r.direction(),
            1 => {
                // Along an axis, through a corner or in the plane of a box face.
                let axis = r.below(3);
                o = target(r);
                let mut d = Vec3::splat(if r.below(2) == 0 { 0.0 } else { -0.0 });
                d[axis] = if r.below(2) == 0 { 1.0 } else { -1.0 };
                o -= d * (size * r.unit());
                d
            }
            2 => {
                // In a plane of two axes.
                let axis = r.below(3);
                let mut d = r.direction();
                let t = target(r);
                o[axis] = t[axis];
                d[axis] = if r.below(2) == 0 { 0.0 } else { 1e-20 };
                d
            }
            _ => target(r) - o,
        };
        let length = match r.below(6) {
            0 => 1e-12,
            1 => 1e12,
            2 => r.unit() * 10.0 + 0.01,
            _ => 1.0,
        };
        Ray::new(o, d * length)
    }
}
