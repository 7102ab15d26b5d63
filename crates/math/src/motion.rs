//! Transforms that change with time (Shoemake & Duff 1992, "Matrix Animation and Polar
//! Decomposition").
//!
//! ```text
//! M = T R S:  T a translation, R a rotation, S symmetric                            (1)
//! R: the limit of Q ← (Q + Q⁻ᵀ)/2 from M's linear part                              (2)
//! between keys: T and S evenly, R along the arc between unit quaternions             (3)
//! p(t) = T + R S x:  |p''| ≤ θ²|S||x| + 2θ|S₁-S₀||x|,                               (4)
//! a point strays from the line between two times h apart by no more than h²/8 max |p''|
//! ```

use crate::{Bounds3, Transform, Vec3};

/// A transform at every time; before the first key and after the last one it stands still.
#[derive(Clone, Debug)]
pub struct Motion {
    keys: Vec<Key>,
}

/// One key: (1).
#[derive(Clone, Debug)]
struct Key {
    time: f64,
    translation: [f64; 3],
    /// w, x, y, z.
    rotation: [f64; 4],
    stretch: Matrix,
}

type Matrix = [[f64; 3]; 3];

/// Steps between two keys for which [`Motion::bounds`] looks at all corners.
const STEPS: u32 = 32;

impl Motion {
    /// From transforms at rising times. `None` if there are none, or if one key mirrors and
    /// another does not: between them everything would be flat.
    pub fn new(keys: &[(f32, Transform)]) -> Option<Motion> {
        let mirrored = keys.first()?.1.swaps_handedness();
        if keys.iter().any(|k| k.1.swaps_handedness() != mirrored) {
            return None;
        }
        let mut made: Vec<Key> = Vec::with_capacity(keys.len());
        for (time, transform) in keys {
            let mut key = Key::new(f64::from(*time), transform)?;
            // The shorter of both arcs.
            if let Some(before) = made.last()
                && dot4(before.rotation, key.rotation) < 0.0
            {
                key.rotation = key.rotation.map(|v| -v);
            }
            made.push(key);
        }
        Some(Motion { keys: made })
    }

    /// The transform at a time.
    pub fn at(&self, time: f32) -> Transform {
        let t = f64::from(time);
        let next = self.keys.partition_point(|k| k.time <= t);
        let (Some(a), b) = (next.checked_sub(1).map(|i| &self.keys[i]), self.keys.get(next)) else {
            return self.keys[0].transform();
        };
        match b {
            Some(b) => a.toward(b, (t - a.time) / (b.time - a.time)).transform(),
            None => a.transform(),
        }
    }

    /// A box around all that `b` passes through in times from 0 to 1.
    pub fn bounds(&self, b: &Bounds3) -> Bounds3 {
        if b.is_empty() {
            return *b;
        }
        let far = f64::from(b.min.abs().max(b.max.abs()).length());
        let (first, last) = (self.at(0.0).bounds(b), self.at(1.0).bounds(b));
        let mut all = first.union(last);
        for pair in self.keys.windows(2) {
            let (from, to) = (pair[0].time.max(0.0), pair[1].time.min(1.0));
            if from >= to {
                continue;
            }
            for i in 0..=STEPS {
                let t = from + (to - from) * f64::from(i) / f64::from(STEPS);
                let x = (t - pair[0].time) / (pair[1].time - pair[0].time);
                all = all.union(pair[0].toward(&pair[1], x).transform().bounds(b));
            }
            // (4), with time in units of the distance between the keys.
            let angle = 2.0 * dot4(pair[0].rotation, pair[1].rotation).abs().min(1.0).acos();
            let (s0, s1) = (&pair[0].stretch, &pair[1].stretch);
            let change: Matrix = from_fn(|i, j| s1[i][j] - s0[i][j]);
            let most = norm(s0).max(norm(s1));
            let h = (to - from) / (pair[1].time - pair[0].time) / f64::from(STEPS);
            let curved = (angle * angle * most + 2.0 * angle * norm(&change)) * far;
            let more = Vec3::splat((h * h / 8.0 * curved * 1.000_001) as f32);
            all = Bounds3 { min: all.min - more, max: all.max + more };
        }
        // What rounding adds.
        let more = Vec3::splat(all.min.abs().max(all.max.abs()).max_component() * 4e-7);
        Bounds3 { min: all.min - more, max: all.max + more }
    }
}

impl Key {
    fn new(time: f64, transform: &Transform) -> Option<Key> {
        let m: Matrix = from_fn(|i, j| f64::from(transform.m[i][j]));
        let mut q = m;
        for _ in 0..100 {
            let inverse = inverse(&q)?;
            let next: Matrix = from_fn(|i, j| 0.5 * (q[i][j] + inverse[j][i])); // (2)
            let change: Matrix = from_fn(|i, j| next[i][j] - q[i][j]);
            q = next;
            if norm(&change) < 1e-14 {
                break;
            }
        }
        // A mirror belongs to the stretch: R must be a rotation.
        if determinant(&q) < 0.0 {
            q = q.map(|row| row.map(|v| -v));
        }
        let stretch = product(&from_fn(|i, j| q[j][i]), &m);
        let translation = [0, 1, 2].map(|i| f64::from(transform.m[i][3]));
        Some(Key { time, translation, rotation: quaternion(&q), stretch })
    }

    /// (3)
    fn toward(&self, other: &Key, x: f64) -> Key {
        let lerp = |a: f64, b: f64| a + (b - a) * x;
        let angle = dot4(self.rotation, other.rotation).clamp(-1.0, 1.0).acos();
        let sin = angle.sin();
        let (wa, wb) = match sin > 1e-9 {
            true => (((1.0 - x) * angle).sin() / sin, (x * angle).sin() / sin),
            false => (1.0 - x, x),
        };
        let q: [f64; 4] = std::array::from_fn(|i| wa * self.rotation[i] + wb * other.rotation[i]);
        let length = dot4(q, q).sqrt();
        Key {
            time: lerp(self.time, other.time),
            translation: [0, 1, 2].map(|i| lerp(self.translation[i], other.translation[i])),
            rotation: q.map(|v| v / length),
            stretch: from_fn(|i, j| lerp(self.stretch[i][j], other.stretch[i][j])),
        }
    }

    /// (1), and its inverse S⁻¹ Rᵀ T⁻¹.
    fn transform(&self) -> Transform {
        let r = rotation(self.rotation);
        let m = product(&r, &self.stretch);
        // Definite matrices of one sign have none between them that is singular.
        let s = inverse(&self.stretch).unwrap_or(from_fn(|i, j| f64::from(u8::from(i == j))));
        let back = product(&s, &from_fn(|i, j| r[j][i]));
        let t = self.translation;
        let mut out = Transform::IDENTITY;
        for i in 0..3 {
            for j in 0..3 {
                out.m[i][j] = m[i][j] as f32;
                out.inv[i][j] = back[i][j] as f32;
            }
            out.m[i][3] = t[i] as f32;
            out.inv[i][3] = -(back[i][0] * t[0] + back[i][1] * t[1] + back[i][2] * t[2]) as f32;
        }
        out
    }
}

fn from_fn(f: impl Fn(usize, usize) -> f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| f(i, j)))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|i, j| (0..3).map(|k| a[i][k] * b[k][j]).sum())
}

/// Frobenius norm: no vector grows by more.
fn norm(m: &Matrix) -> f64 {
    m.iter().flatten().map(|v| v * v).sum::<f64>().sqrt()
}

fn cofactor(m: &Matrix, i: usize, j: usize) -> f64 {
    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
    let (c, d) = ((j + 1) % 3, (j + 2) % 3);
    m[a][c] * m[b][d] - m[a][d] * m[b][c]
}

fn determinant(m: &Matrix) -> f64 {
    (0..3).map(|j| m[0][j] * cofactor(m, 0, j)).sum()
}

fn inverse(m: &Matrix) -> Option<Matrix> {
    let d = determinant(m);
    let inverse = from_fn(|i, j| cofactor(m, j, i) / d);
    inverse.iter().flatten().all(|v| v.is_finite()).then_some(inverse)
}

fn dot4(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|i| a[i] * b[i]).sum()
}

/// Rotation of a unit quaternion (Shoemake 1985).
fn rotation([w, x, y, z]: [f64; 4]) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Unit quaternion of a rotation, from its largest component (Shepperd 1978).
fn quaternion(r: &Matrix) -> [f64; 4] {
    let trace = r[0][0] + r[1][1] + r[2][2];
    let most = (0..3).max_by(|&i, &j| r[i][i].total_cmp(&r[j][j])).unwrap_or(0);
    let mut q = [0.0; 4];
    if trace >= r[most][most] {
        q[0] = 1.0 + trace;
        q[1] = r[2][1] - r[1][2];
        q[2] = r[0][2] - r[2][0];
        q[3] = r[1][0] - r[0][1];
    } else {
        let (i, j, k) = (most, (most + 1) % 3, (most + 2) % 3);
        q[0] = r[k][j] - r[j][k];
        q[1 + i] = 1.0 + r[i][i] - r[j][j] - r[k][k];
        q[1 + j] = r[j][i] + r[i][j];
        q[1 + k] = r[k][i] + r[i][k];
    }
    let length = dot4(q, q).sqrt();
    q.map(|v| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &Transform, b: &Transform, by: f32) -> bool {
        let all = |m: &Transform| m.m.into_iter().chain(m.inv).flatten().collect::<Vec<_>>();
        all(a).iter().zip(all(b)).all(|(a, b)| (a - b).abs() <= by * b.abs().max(1.0))
    }

    fn some(i: usize) -> Transform {
        let f = i as f32;
        Transform::translate(Vec3::new(f, -2.0 * f, 1.0))
            * Transform::rotate(40.0 * f, Vec3::new(1.0, f, 0.5)).unwrap()
            * Transform::scale(Vec3::new(1.0 + f, 0.5, 2.0)).unwrap()
            * Transform::rotate(25.0, Vec3::new(f, 1.0, 0.0)).unwrap()
    }

    #[test]
    fn keys_are_met_exactly_and_time_stands_still_beyond() {
        let keys = [(0.25, some(1)), (0.5, some(2)), (1.5, some(3))];
        let motion = Motion::new(&keys).unwrap();
        for (t, transform) in &keys {
            assert!(near(&motion.at(*t), transform, 1e-5), "{t}");
        }
        assert!(near(&motion.at(-3.0), &some(1), 1e-5) && near(&motion.at(9.0), &some(3), 1e-5));
        let half = motion.at(0.7);
        assert!(near(&(half * half.inverse()), &Transform::IDENTITY, 1e-5));
    }

    #[test]
    fn rotations_turn_evenly_the_shorter_way() {
        let turn = |degrees| Transform::rotate(degrees, Vec3::Z).unwrap();
        let motion = Motion::new(&[(0.0, turn(0.0)), (1.0, turn(90.0))]).unwrap();
        assert!(near(&motion.at(1.0 / 3.0), &turn(30.0), 1e-6));
        let back = Motion::new(&[(0.0, turn(0.0)), (1.0, turn(270.0))]).unwrap();
        assert!(near(&back.at(0.5), &turn(-45.0), 1e-6));
        // A mirror stays one.
        let mirror = Transform::scale(Vec3::new(-1.0, 1.0, 1.0)).unwrap();
        let both = Motion::new(&[(0.0, mirror), (1.0, turn(90.0) * mirror)]).unwrap();
        assert!(near(&both.at(0.5), &(turn(45.0) * mirror), 1e-6));
        assert!(Motion::new(&[(0.0, mirror), (1.0, turn(0.0))]).is_none());
        assert!(Motion::new(&[]).is_none());
    }

    #[test]
    fn boxes_hold_all_that_moves() {
        for (a, b) in [(0, 1), (1, 2), (0, 3), (2, 3)] {
            let motion = Motion::new(&[(0.0, some(a)), (0.6, some(b)), (2.0, some(a))]).unwrap();
            let b = Bounds3::new(Vec3::new(-1.0, 0.5, 3.0), Vec3::new(2.0, 1.0, 4.0));
            let all = motion.bounds(&b);
            let mut reached = Bounds3::EMPTY;
            for i in 0..=1000 {
                let t = motion.at(i as f32 / 1000.0);
                for c in 0..8 {
                    let p = t.point(b.corner(c));
                    reached = reached.with_point(p);
                    assert!(all.min.min(p) == all.min && all.max.max(p) == all.max, "{a} {i}");
                }
            }
            // And little more.
            let loose = all.diagonal().max_component() / reached.diagonal().max_component();
            assert!(loose < 1.03, "{loose}");
        }
    }
}
