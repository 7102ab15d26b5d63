//! What vectors of any width have in common.

use std::ops::{Add, Div, Mul, Sub};

/// Some `f32` side by side. Operations go lane by lane, masks have one bit a lane from the lowest.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// All lanes.
    const ALL: u32;
    /// The lanes in memory.
    type Array: Copy + AsRef<[f32]> + AsMut<[f32]>;

    fn splat(v: f32) -> Self;

    fn load(a: &Self::Array) -> Self;

    fn to_array(self) -> Self::Array;

    /// `self * b + c`, rounded once.
    fn mul_add(self, b: Self, c: Self) -> Self;

    /// `self * b - c`, rounded once.
    fn mul_sub(self, b: Self, c: Self) -> Self;

    /// `c - self * b`, rounded once.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;

    /// The lesser; `o` where either is NaN.
    fn min(self, o: Self) -> Self;

    /// The greater; `o` where either is NaN.
    fn max(self, o: Self) -> Self;

    fn abs(self) -> Self;

    /// `o` in the lanes of `mask`.
    fn select(self, mask: u32, o: Self) -> Self;

    /// `self <= o`.
    fn le(self, o: Self) -> u32;

    /// `self < o`.
    fn lt(self, o: Self) -> u32;

    /// The sign bits of the three are not all the same.
    fn differing_signs(self, b: Self, c: Self) -> u32;
}
