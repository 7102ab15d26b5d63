//! The CIE 1931 2° standard observer.

mod table_1931;

use table_1931::MATCHING_1931;

/// Shortest wavelength considered, nm.
pub const LAMBDA_MIN: f32 = 360.0;
/// Longest wavelength considered, nm.
pub const LAMBDA_MAX: f32 = 830.0;
/// Nodes of a table of 1 nm steps over the whole range, both ends included.
pub const NODES: usize = 471;
/// ∫ ȳ dλ over 360..830 nm by the trapezoid rule on the 1 nm table.
pub const Y_INTEGRAL: f32 = 106.856_915;

/// x̄, ȳ, z̄ and 0 at `lambda` nm, linear between the standard's 1 nm values (error below 2e-5
/// of the peak). Wavelengths outside 360..=830 count as the nearest end, where the functions are
/// nearly zero.
#[inline]
pub fn matching(lambda: f32) -> [f32; 4] {
    let x = (lambda - LAMBDA_MIN).clamp(0.0, LAMBDA_MAX - LAMBDA_MIN);
    // Through i32, which the machine converts faster.
    let i = (x as i32 as usize).min(NODES - 1);
    let t = x - i as f32;
    let (a, b) = (&MATCHING_1931[i], &MATCHING_1931[i + 1]);
    std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
}

/// XYZ = ∫ f(λ) (x̄, ȳ, z̄) dλ / ∫ ȳ dλ of a function given at 360, 361, ..., 830 nm, by the
/// trapezoid rule.
pub(crate) fn xyz_of_nodes(f: impl Fn(usize) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for (i, row) in MATCHING_1931[..NODES].iter().enumerate() {
        let w = if i == 0 || i == NODES - 1 { 0.5 } else { 1.0 };
        let v = w * f(i);
        for k in 0..3 {
            xyz[k] += v * row[k] as f64;
        }
    }
    xyz.map(|s| s / Y_INTEGRAL as f64)
}

/// Wavelength of node `i` of a 1 nm table, nm.
#[inline]
pub(crate) fn node_lambda(i: usize) -> f32 {
    LAMBDA_MIN + i as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integral_of_y_bar() {
        let y: f64 = MATCHING_1931[..NODES].iter().map(|r| r[1] as f64).sum::<f64>()
            - 0.5 * (MATCHING_1931[0][1] + MATCHING_1931[NODES - 1][1]) as f64;
        assert!((y / 106.8569 - 1.0).abs() < 1e-6, "{y}");
        assert!((y / Y_INTEGRAL as f64 - 1.0).abs() < 1e-7, "{y}");
        // The equal-energy spectrum is white by the observer's definition, within its rounding.
        let [x, yy, z] = xyz_of_nodes(|_| 1.0);
        assert!((yy - 1.0).abs() < 1e-6 && (x - 1.0).abs() < 1e-3 && (z - 1.0).abs() < 1e-3);
    }

    #[test]
    fn known_values() {
        // CIE 018:2019: ȳ peaks with 1 at 555 nm; x̄ is 1.0622 at 600 nm, z̄ 1.7826 at 445 nm.
        assert_eq!(matching(555.0)[1], 1.0);
        assert!((matching(600.0)[0] - 1.0622).abs() < 1e-6);
        assert!((matching(445.0)[2] - 1.7826).abs() < 1e-6);
        let mid = matching(600.5)[0];
        assert!((mid - 0.5 * (matching(600.0)[0] + matching(601.0)[0])).abs() < 1e-6);
        assert_eq!(matching(1000.0), matching(830.0));
    }
}
