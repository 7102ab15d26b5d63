//! The four-lane spectral value that all transport code computes with.

use std::ops::{Add, AddAssign, Div, DivAssign, Index, Mul, MulAssign, Neg, Sub};

/// Four lanes, one SIMD register. In RGB mode they are r, g, b and 0; in spectral mode the
/// values at the path's four wavelengths. Transport code must not ask which.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub struct Spectrum(pub [f32; 4]);

impl Spectrum {
    /// No light.
    pub const ZERO: Spectrum = Spectrum([0.0; 4]);
    /// One in every lane.
    pub const ONE: Spectrum = Spectrum([1.0; 4]);

    /// The same value in every lane.
    #[inline]
    pub const fn splat(v: f32) -> Spectrum {
        Spectrum([v; 4])
    }

    /// Lanes r, g, b, 0.
    #[inline]
    pub const fn from_rgb(rgb: [f32; 3]) -> Spectrum {
        Spectrum([rgb[0], rgb[1], rgb[2], 0.0])
    }

    /// The first three lanes.
    #[inline]
    pub const fn rgb(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// `f` of every lane.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Spectrum {
        Spectrum(self.0.map(f))
    }

    /// `f` of every pair of lanes.
    #[inline]
    pub fn zip(self, o: Spectrum, f: impl Fn(f32, f32) -> f32) -> Spectrum {
        Spectrum(std::array::from_fn(|i| f(self.0[i], o.0[i])))
    }

    /// True if every lane is exactly zero.
    #[inline]
    pub fn is_black(&self) -> bool {
        self.0 == [0.0; 4]
    }

    /// True if no lane is NaN or infinite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }

    /// Largest lane.
    #[inline]
    pub fn max_component(&self) -> f32 {
        self.0[0].max(self.0[1]).max(self.0[2].max(self.0[3]))
    }

    /// Mean of the four lanes. In RGB mode the last lane is zero: use it only for ratios.
    #[inline]
    pub fn average(&self) -> f32 {
        0.25 * (self.0[0] + self.0[1] + self.0[2] + self.0[3])
    }

    /// Negative lanes become zero.
    #[inline]
    pub fn clamp_zero(self) -> Spectrum {
        self.map(|v| v.max(0.0))
    }

    /// Every lane within [lo, hi].
    #[inline]
    pub fn clamp(self, lo: f32, hi: f32) -> Spectrum {
        self.map(|v| v.clamp(lo, hi))
    }

    /// Square root of every lane, negative ones taken as zero.
    #[inline]
    pub fn sqrt(self) -> Spectrum {
        self.map(|v| v.max(0.0).sqrt())
    }

    /// e to every lane.
    #[inline]
    pub fn exp(self) -> Spectrum {
        self.map(f32::exp)
    }

    /// (1-t)·self + t·o.
    #[inline]
    pub fn lerp(self, o: Spectrum, t: f32) -> Spectrum {
        self * (1.0 - t) + o * t
    }

    /// Lane by lane quotient, 0 where the divisor is 0.
    #[inline]
    pub fn safe_div(self, o: Spectrum) -> Spectrum {
        self.zip(o, |a, b| if b == 0.0 { 0.0 } else { a / b })
    }
}

macro_rules! lanewise {
    ($Op:ident $op:ident $sym:tt) => {
        impl $Op for Spectrum {
            type Output = Spectrum;
            #[inline]
            fn $op(self, o: Spectrum) -> Spectrum {
                Spectrum(std::array::from_fn(|i| self.0[i] $sym o.0[i]))
            }
        }
    };
}
lanewise!(Add add +);
lanewise!(Sub sub -);
lanewise!(Mul mul *);
lanewise!(Div div /);

impl Mul<f32> for Spectrum {
    type Output = Spectrum;
    #[inline]
    fn mul(self, s: f32) -> Spectrum {
        Spectrum(self.0.map(|v| v * s))
    }
}
impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    #[inline]
    fn mul(self, v: Spectrum) -> Spectrum {
        v * self
    }
}
impl Div<f32> for Spectrum {
    type Output = Spectrum;
    #[inline]
    fn div(self, s: f32) -> Spectrum {
        self * (1.0 / s)
    }
}
impl Neg for Spectrum {
    type Output = Spectrum;
    #[inline]
    fn neg(self) -> Spectrum {
        self * -1.0
    }
}
impl AddAssign for Spectrum {
    #[inline]
    fn add_assign(&mut self, o: Spectrum) {
        *self = *self + o;
    }
}
impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, o: Spectrum) {
        *self = *self * o;
    }
}
impl MulAssign<f32> for Spectrum {
    #[inline]
    fn mul_assign(&mut self, s: f32) {
        *self = *self * s;
    }
}
impl DivAssign<f32> for Spectrum {
    #[inline]
    fn div_assign(&mut self, s: f32) {
        *self = *self / s;
    }
}
impl Index<usize> for Spectrum {
    type Output = f32;
    #[inline]
    fn index(&self, i: usize) -> &f32 {
        &self.0[i]
    }
}
