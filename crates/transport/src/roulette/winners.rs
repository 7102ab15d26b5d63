//! Go with the winners: splitting by albedo and roughness (Szirmay-Kalos & Antal 2005; the
//! lecture's slide says 2001).
//!
//! ```text
//! q = ν ρ √( V_r + V_v / (n+1)² ),   V_r = 1,   V_v = m² - 1,   n ≈ 2/α² - 2                (1)
//! ```
//!
//! ν is the path's weight, ρ the albedo, n the exponent of the lobe, α the roughness: where the
//! next direction may be anything, paths are split m-fold, where a mirror knows it, once. The form
//! is the one that Rath et al. 2022 compare with.

/// m of (1): copies where a matte, white surface is met first.
pub const COPIES: f32 = 4.0;

/// q by (1).
pub fn factor(nu: f32, albedo: f32, roughness: f32) -> f32 {
    let alpha2 = (roughness * roughness).clamp(1e-4, 1.0);
    let exponent = 2.0 / alpha2 - 2.0;
    nu * albedo * (1.0 + (COPIES * COPIES - 1.0) / (exponent + 1.0).powi(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_surfaces_split_and_mirrors_do_not() {
        assert!((factor(1.0, 0.5, 1.0) - 2.0).abs() < 1e-6);
        assert!((factor(1.0, 0.5, 0.01) - 0.5).abs() < 1e-3);
        // After a split at a matte surface the next one only survives by its albedo.
        let q = factor(1.0, 0.8, 1.0);
        assert!((factor(0.8 / q, 0.8, 1.0) - 0.8).abs() < 1e-6);
    }
}
