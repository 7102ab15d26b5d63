//! Bounding volume hierarchies: what a ray hits first, and whether it hits anything.
//!
//! [`TriangleBvh`] holds one triangle soup and tests its own triangles, eight at a time.
//! It takes one ray, or slices of [`Segment`]s, which is up to three times as fast: in small trees
//! rays are sorted by their directions and go together by sixteen; in large ones rays of nearly one
//! way go together, others take turns.
//! [`BoxBvh`] holds any primitives known by their bounds (analytic shapes, instances, lights)
//! and hands the ones a ray may hit to a closure.
//!
//! What both promise:
//! - **No hit is lost.** Box tests are rounded outward (Ize 2013, "Robust BVH Ray Traversal")
//!   by enough to hold the rounding of the triangle test too; the module `ray` has the proof.
//! - **Watertight.** The triangle test (Woop, Benthin & Wald 2013, "Watertight Ray/Triangle
//!   Intersection", JCGT 2(1)) takes the sign of each edge function exactly.
//! - **One answer.** A query returns what testing every primitive in turn would return, bit for
//!   bit; of hits at the same `t` the lowest primitive wins. The tree does not depend on the
//!   number of threads that built it.
//!
//! The tree is eight wide, built top-down by binned SAH (Wald 2007) as a binary tree that a
//! dynamic program then cuts into wide nodes and leaves of least expected cost (Ylitie, Karras &
//! Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", sec. 3).
//!
//! ```
//! use kaustika_accel::{BuildOptions, TriangleBvh};
//! use kaustika_math::{Ray, Vec3};
//!
//! let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
//! let bvh = TriangleBvh::build(&corners, &[[0, 1, 2]], &BuildOptions::default());
//! let ray = Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z);
//! let hit = bvh.intersect(&ray, f32::INFINITY).unwrap();
//! assert_eq!((hit.t, hit.prim), (2.0, 0));
//! assert!(!bvh.occluded(&ray, 2.0)); // t_max itself is excluded
//! ```

mod accept;
mod batch;
mod box_bvh;
mod builder;
mod classes;
mod crowd;
mod edges;
mod node;
mod packet;
mod pages;
mod ray;
mod simd;
mod stream;
mod traverse;
mod triangle;
mod triangle_bvh;

#[cfg(test)]
mod tests;

pub use box_bvh::BoxBvh;
pub use builder::BuildOptions;
pub use node::TreeStats;
pub use stream::Segment;
pub use triangle_bvh::{TriangleBvh, TriangleHit};
