//! Scalars: constants, safe roots, rounding-error bounds, hashing.

/// 1/π.
pub const INV_PI: f32 = std::f32::consts::FRAC_1_PI;
/// 1/(2π).
pub const INV_TWO_PI: f32 = 0.5 * std::f32::consts::FRAC_1_PI;
/// The largest `f32` below one: random numbers are at most this.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;
/// The rounding error of one operation, half a unit in the last place (Higham's u).
pub const EPS: f32 = f32::EPSILON * 0.5;

/// γₙ = nu/(1-nu): bound of the relative error of `n` rounded operations (Higham 2002, ch. 3).
#[inline]
pub const fn gamma(n: i32) -> f32 {
    (n as f32 * EPS) / (1.0 - n as f32 * EPS)
}

/// x².
#[inline]
pub fn sqr(x: f32) -> f32 {
    x * x
}

/// √max(x, 0).
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// arccos of `x` clamped to [-1, 1].
#[inline]
pub fn safe_acos(x: f32) -> f32 {
    x.clamp(-1.0, 1.0).acos()
}

/// (1-t)a + tb.
#[inline]
pub fn lerp(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

/// ab - cd without catastrophic cancellation (Kahan; error within 1.5 ulp).
#[inline]
pub fn diff_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let cd = c * d;
    let difference = a.mul_add(b, -cd);
    let error = (-c).mul_add(d, cd);
    difference + error
}

/// A 64-bit finaliser with good avalanche (Stafford's Mix13 of splitmix64).
#[inline]
pub const fn mix_bits(mut v: u64) -> u64 {
    v ^= v >> 30;
    v = v.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    v ^= v >> 27;
    v = v.wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ (v >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_of_products_survives_cancellation() {
        let (a, b, c, d) = (33962.035f32, -30438.8, 41563.4, -24871.969);
        let exact = a as f64 * b as f64 - c as f64 * d as f64;
        let got = diff_of_products(a, b, c, d) as f64;
        assert!((got - exact).abs() <= exact.abs() * 2e-7, "{got} {exact}");
    }
}
