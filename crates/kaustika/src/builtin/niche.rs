//! A wall with an arched niche.

use super::grid::grid;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::TriMesh;
use std::f32::consts::PI;

/// A niche in the plane z = 0: jambs up to `spring`, a half circle on them.
#[derive(Clone, Copy, Debug)]
pub struct Niche {
    /// x of its middle.
    pub center: f32,
    /// Half its width: the radius of the arch.
    pub half_width: f32,
    /// Height at which the arch starts.
    pub spring: f32,
    /// How deep it reaches into the wall, towards -z.
    pub depth: f32,
}

/// Parts of the half circle.
const ARC: u32 = 48;

impl Niche {
    /// The wall around it, facing +z, from x = `x[0]` to `x[1]` and from 0 to `height`.
    pub fn wall(&self, x: [f32; 2], height: f32) -> TriMesh {
        let mut mesh = TriMesh::default();
        // Columns of the wall: each reaches from its lower ends to the ceiling.
        let mut column = |a: Vec2, b: Vec2| {
            let first = mesh.positions.len() as u32;
            for p in [a, b, Vec2::new(b.x, height), Vec2::new(a.x, height)] {
                mesh.positions.push(Vec3::new(p.x, p.y, 0.0));
                mesh.normals.push(Vec3::Z);
            }
            mesh.indices.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
        };
        let (left, right) = (self.center - self.half_width, self.center + self.half_width);
        column(Vec2::new(x[0], 0.0), Vec2::new(left, 0.0));
        let arc = |i: u32| {
            let (s, c) = (PI * (1.0 - i as f32 / ARC as f32)).sin_cos();
            Vec2::new(self.center + self.half_width * c, self.spring + self.half_width * s)
        };
        (0..ARC).for_each(|i| column(arc(i), arc(i + 1)));
        column(Vec2::new(right, 0.0), Vec2::new(x[1], 0.0));
        mesh
    }

    /// The inside of jambs and arch, facing the middle.
    pub fn reveal(&self) -> TriMesh {
        let bend = PI * self.half_width;
        let length = 2.0 * self.spring + bend;
        grid(ARC * 2, 1, |u, v| {
            let s = u * length;
            let z = (v - 1.0) * self.depth;
            let angle = ((s - self.spring) / bend).clamp(0.0, 1.0) * PI;
            let outward = Vec3::new(-angle.cos(), angle.sin(), 0.0);
            let below = (self.spring - s).max(s - self.spring - bend).max(0.0);
            let middle = Vec3::new(self.center, self.spring - below, z);
            (middle + outward * self.half_width, -outward)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::defects;
    use super::*;

    #[test]
    fn wall_and_niche_face_the_room() {
        let niche = Niche { center: 0.5, half_width: 0.6, spring: 1.2, depth: 0.3 };
        assert_eq!(defects(&niche.wall([-2.0, 2.0], 3.0)), Vec::<String>::new());
        assert_eq!(defects(&niche.reveal()), Vec::<String>::new());
        let area: f32 = niche
            .wall([-2.0, 2.0], 3.0)
            .indices
            .iter()
            .map(|t| {
                let mesh = niche.wall([-2.0, 2.0], 3.0);
                let [p, q, r] = t.map(|k| mesh.positions[k as usize]);
                0.5 * (q - p).cross(r - p).length()
            })
            .sum();
        let expected = 12.0 - 1.2 * 1.2 - 0.5 * PI * 0.36;
        assert!((area - expected).abs() < 2e-3, "area {area}, expected {expected}");
    }
}
