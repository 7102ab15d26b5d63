//! Batches of incoherent rays in rooms of few to many triangles.
//!
//! `cargo bench -p kaustika-accel --bench rooms`. The rate is rays a second, on one thread.

use divan::Bencher;
use divan::counter::ItemsCount;
use kaustika_accel::{BuildOptions, Segment, TriangleBvh};
use kaustika_math::{Ray, Vec3, mix_bits};
use std::f32::consts::{PI, TAU};

fn main() {
    divan::main();
}

/// So many that branch predictors do not learn what each of them does.
const RAYS: usize = 1 << 17;
const BATCH: usize = 2048;

/// Rooms by their number of triangles.
const ROOMS: [usize; 4] = [36, 1000, 10_000, 70_000];

/// The room [-1, 1]³ with a lamp, y up, and in it two boxes, or balls until there are enough
/// triangles.
struct Room {
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    numbers: Numbers,
}

impl Room {
    fn new(triangles: usize) -> Room {
        let mut room = Room { positions: vec![], indices: vec![], numbers: Numbers(1) };
        let half = Vec3::splat(1.0);
        room.cuboid(Vec3::ZERO, half, 5);
        room.cuboid(Vec3::new(0.0, 0.99, 0.0), LAMP, 1);
        if triangles < 100 {
            room.cuboid(Vec3::new(-0.35, -0.4, -0.3), Vec3::new(0.3, 0.6, 0.3), 6);
            room.cuboid(Vec3::new(0.35, -0.7, 0.3), Vec3::new(0.3, 0.3, 0.3), 6);
        }
        let steps = if triangles < 5000 { 12 } else { 24 };
        while room.indices.len() + 2 * (steps * steps / 2) as usize <= triangles {
            let radius = 0.05 + 0.25 * room.numbers.next().powi(4);
            let centre = room.numbers.inside() * (0.98 - radius);
            room.ball(centre, radius, steps);
        }
        room
    }

    /// The first `faces` of the six sides of a box.
    fn cuboid(&mut self, centre: Vec3, half: Vec3, faces: usize) {
        for face in 0..faces {
            let (axis, side) = ((face + 1) % 3, if face < 3 { 1.0 } else { -1.0 });
            let corner = |u: f32, v: f32| {
                let mut p = Vec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                Vec3::new(p.x * half.x, p.y * half.y, p.z * half.z) + centre
            };
            self.grid(1, 1, |u, v| corner(2.0 * u - 1.0, 2.0 * v - 1.0));
        }
    }

    fn ball(&mut self, centre: Vec3, radius: f32, steps: u32) {
        self.grid(steps, steps / 2, |u, v| centre + on_sphere(u, v) * radius);
    }

    /// `nu` by `nv` cells of two triangles over (u, v) in [0, 1]².
    fn grid(&mut self, nu: u32, nv: u32, surface: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len() as u32;
        for j in 0..=nv {
            for i in 0..=nu {
                self.positions.push(surface(i as f32 / nu as f32, j as f32 / nv as f32));
            }
        }
        for cell in 0..nu * nv {
            let a = first + cell / nu * (nu + 1) + cell % nu;
            let [b, c, d] = [a + 1, a + nu + 2, a + nu + 1];
            self.indices.extend([[a, b, c], [a, c, d]]);
        }
    }

    fn tree(&self) -> TriangleBvh {
        TriangleBvh::build(&self.positions, &self.indices, &BuildOptions::default())
    }

    /// Points just before surfaces.
    fn points(&mut self, tree: &TriangleBvh) -> Vec<Vec3> {
        let mut points = Vec::new();
        while points.len() < RAYS {
            let ray = Ray::new(self.numbers.inside(), self.numbers.direction());
            if let Some(hit) = tree.intersect(&ray, f32::INFINITY) {
                points.push(ray.at(0.999 * hit.t));
            }
        }
        points
    }

    /// Rays in all directions from points just before surfaces.
    fn bounces(&mut self, tree: &TriangleBvh) -> Vec<Segment> {
        let points = self.points(tree);
        let ray = |o| Segment { ray: Ray::new(o, self.numbers.direction()), t_max: f32::INFINITY };
        points.into_iter().map(ray).collect()
    }

    /// Rays from points just before surfaces to points of the lamp.
    fn shadows(&mut self, tree: &TriangleBvh) -> Vec<Segment> {
        let points = self.points(tree);
        let mut ray = |o| {
            let p = self.numbers.inside();
            let d = Vec3::new(LAMP.x * p.x, 0.98, LAMP.z * p.z) - o;
            Segment { ray: Ray::new(o, d), t_max: 0.999 }
        };
        points.into_iter().map(&mut ray).collect()
    }
}

/// Half its sides.
const LAMP: Vec3 = Vec3::new(0.25, 0.001, 0.2);

/// The direction of azimuth 2πu and polar angle πv.
fn on_sphere(u: f32, v: f32) -> Vec3 {
    let ((s, c), (r, y)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
    Vec3::new(r * c, y, r * s)
}

/// A fixed list of numbers.
struct Numbers(u64);

impl Numbers {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f32 {
        self.0 += 1;
        (mix_bits(self.0) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// In the room.
    fn inside(&mut self) -> Vec3 {
        (Vec3::new(self.next(), self.next(), self.next()) * 2.0 - Vec3::splat(1.0)) * 0.97
    }

    fn direction(&mut self) -> Vec3 {
        on_sphere(self.next(), (1.0 - 2.0 * self.next()).acos() / PI)
    }
}

#[divan::bench(args = ROOMS, min_time = 0.2, max_time = 1)]
fn closest(bencher: Bencher, triangles: usize) {
    let mut room = Room::new(triangles);
    let tree = room.tree();
    let segments = room.bounces(&tree);
    let mut hits = vec![None; RAYS];
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        for (segments, hits) in segments.chunks(BATCH).zip(hits.chunks_mut(BATCH)) {
            tree.intersect_all(segments, hits);
        }
    });
}

#[divan::bench(args = ROOMS, min_time = 0.2, max_time = 1)]
fn shadow(bencher: Bencher, triangles: usize) {
    let mut room = Room::new(triangles);
    let tree = room.tree();
    let segments = room.shadows(&tree);
    let mut occluded = vec![false; RAYS];
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        for (segments, occluded) in segments.chunks(BATCH).zip(occluded.chunks_mut(BATCH)) {
            tree.occluded_all(segments, occluded);
        }
    });
}
