//! A distribution of directions as a quadtree over the sphere (Müller, Gross & Novák 2017, sec. 3.2).
//!
//! ```text
//! p(ω) = d(x, y) / (4 s³),   s = |ωₓ| + |ω_y| + |ω_z|                                       (1)
//! ```
//!
//! The sphere is laid out on the unit square as an octahedron unfolded, for which (1) makes a
//! density d on the square ([`super::Square`]) one per solid angle, without a transcendental
//! function (the paper's cylinder keeps areas, and needs two).

use super::square::{Square, Tree};
use super::{Directions, LightRecord, LocalDirections, octahedron};
use crate::saved::saved;
use kaustika_math::{Vec2, Vec3};

/// Energy by direction.
#[derive(Clone, Debug, Default)]
pub struct Quadtree {
    square: Square,
}

saved!(Quadtree { square });

impl Directions for Quadtree {
    type Local<'a> = &'a Tree;

    fn at(&self, _: Vec3) -> Option<&Tree> {
        self.square.known()
    }

    fn learn(&mut self, records: &[LightRecord]) {
        for r in records {
            self.square.learn(octahedron::to_square(r.w), r.radiance / r.pdf);
        }
    }

    fn refine(&mut self) {
        self.square.refine();
    }
}

impl LocalDirections for &Tree {
    fn sample(&self, u: Vec2) -> (Vec3, f32) {
        let (p, density) = Tree::sample(self, u);
        let w = octahedron::from_square(p);
        (w, density * octahedron::density(w)) // (1)
    }

    fn pdf(&self, w: Vec3) -> f32 {
        self.density(octahedron::to_square(w)) * octahedron::density(w) // (1)
    }

    fn radiance(&self, w: Vec3) -> f32 {
        // Energy over records is ∫ L̄ᵢ dω.
        self.pdf(w) * self.mean()
    }

    fn irradiance(&self, n: Vec3) -> f32 {
        let mut sum = 0.0;
        self.leaves(|corner, size, energy| {
            // The cosine's mean by four points of the leaf.
            let at = |x, y| octahedron::from_square(corner + Vec2::new(x, y) * size);
            let cos = [at(0.25, 0.25), at(0.75, 0.25), at(0.25, 0.75), at(0.75, 0.75)];
            sum += energy * cos.map(|w| w.dot(n).max(0.0)).iter().sum::<f32>() * 0.25;
        });
        sum * (self.mean() / self.total())
    }
}
