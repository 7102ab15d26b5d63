//! Boxes as the builder wants them: one register, grown by one instruction.

use bytemuck::{Pod, Zeroable};
use kaustika_math::{Bounds3, Vec3};

use crate::ray::MAX_COORDINATE;
use crate::simd::{F32x8, Lanes};

/// The lower corner in lanes 0..3, the upper corner negated in lanes 4..7, so that a box grows by
/// the lesser of each lane. Lanes 3 and 7 are of no meaning.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct Box8([f32; 8]);

impl Box8 {
    pub(super) const EMPTY: Box8 = Box8([f32::INFINITY; 8]);

    #[inline(always)]
    pub(super) fn grow(&mut self, o: &Box8) {
        // Written with arrays this becomes a masked store, which the next load has to wait for.
        self.0 = F32x8::load(&self.0).min(F32x8::load(&o.0)).to_array();
    }

    #[inline(always)]
    pub(super) fn union(mut self, o: Box8) -> Box8 {
        self.grow(&o);
        self
    }

    /// Half the surface area of the box times `scale²`.
    #[inline(always)]
    pub(super) fn half_area(&self, scale: f32) -> f32 {
        // Negative lengths: the signs cancel.
        let b = &self.0;
        let (x, y, z) = ((b[0] + b[4]) * scale, (b[1] + b[5]) * scale, (b[2] + b[6]) * scale);
        (x + z) * y + z * x
    }

    /// The lower corner; the last lane is of no meaning.
    #[inline(always)]
    pub(super) fn lower(&self) -> [f32; 4] {
        [self.0[0], self.0[1], self.0[2], self.0[3]]
    }

    /// Extent along an axis.
    #[inline(always)]
    pub(super) fn extent(&self, axis: usize) -> f32 {
        -self.0[4 + axis % 3] - self.0[axis % 3]
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let b = &self.0;
        Bounds3 { min: Vec3::new(b[0], b[1], b[2]), max: -Vec3::new(b[4], b[5], b[6]) }
    }
}

/// The bounds of a primitive and its number, in one register.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct PrimRef {
    /// The bits of lane 3 are the primitive's number.
    bounds: Box8,
}

impl PrimRef {
    /// Marks a primitive that is left out.
    pub(super) const NONE: PrimRef = PrimRef { bounds: Box8::EMPTY };

    pub(super) fn is_none(&self) -> bool {
        self.bounds.0[0] == f32::INFINITY
    }

    /// `None` if the bounds are empty, not finite or beyond what the tree can hold.
    #[inline(always)]
    pub(crate) fn new(prim: u32, bounds: &Bounds3) -> Option<PrimRef> {
        let (lo, hi) = (bounds.min, bounds.max);
        // Written so that NaN fails.
        let valid =
            (0..3).all(|a| lo[a] <= hi[a] && lo[a] >= -MAX_COORDINATE && hi[a] <= MAX_COORDINATE);
        valid.then(|| PrimRef {
            bounds: Box8([lo.x, lo.y, lo.z, f32::from_bits(prim), -hi.x, -hi.y, -hi.z, 0.0]),
        })
    }

    #[inline(always)]
    pub(crate) fn prim(&self) -> u32 {
        self.bounds.0[3].to_bits()
    }

    #[inline(always)]
    pub(super) fn box8(&self) -> &Box8 {
        &self.bounds
    }

    /// Twice the centre along an axis.
    #[inline(always)]
    pub(super) fn center(&self, axis: usize) -> f32 {
        self.bounds.0[axis % 3] - self.bounds.0[4 + axis % 3]
    }

    /// Twice the centre; the last lane is of no meaning.
    #[inline(always)]
    pub(super) fn centers(&self) -> [f32; 4] {
        std::array::from_fn(|i| self.bounds.0[i] - self.bounds.0[4 + i])
    }

    /// A box around nothing but the doubled centre.
    #[inline(always)]
    pub(super) fn center_box(&self) -> Box8 {
        let b = &self.bounds.0;
        Box8(std::array::from_fn(|i| b[i] - b[i ^ 4]))
    }
}

/// The box of some primitives, and that of their doubled centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: Box8,
    pub(super) centers: Box8,
}

impl Extent {
    pub(super) const EMPTY: Extent = Extent { bounds: Box8::EMPTY, centers: Box8::EMPTY };

    pub(super) fn of(refs: &[PrimRef]) -> Extent {
        refs.iter().fold(Extent::EMPTY, |e, r| Extent {
            bounds: e.bounds.union(r.bounds),
            centers: e.centers.union(r.center_box()),
        })
    }

    pub(super) fn union(self, o: Extent) -> Extent {
        Extent { bounds: self.bounds.union(o.bounds), centers: self.centers.union(o.centers) }
    }
}
