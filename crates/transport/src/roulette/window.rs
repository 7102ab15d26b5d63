//! Adjoint-driven roulette and splitting: a window for a path's weight (Vorba & Křivánek 2016,
//! "Adjoint-Driven Russian Roulette and Splitting in Light Transport Simulation").
//!
//! ```text
//! z = ν L/I                                                                             (1)
//! d₋ = 2/(1+s),  d₊ = s d₋,  s = 5                                                        (2)
//! q = z/d₊ if z > d₊,   z/d₋ if z < d₋,   else 1                                        (3)
//! ```
//!
//! ν is the weight with which a path arrives, L what is expected to be reflected back along it, I
//! the value of what is measured: z is the path's expected share of it. (1) alone, q = z, would
//! give each path on its way the weight I/L, and with it the same expected share; the window
//! about that weight lets pass what is near enough. Weight windows come from neutron transport;
//! there survivors go to a point inside, here to the nearer edge.

/// s of (2).
pub const SIZE: f32 = 5.0;

/// Lower edge of the window for z.
pub fn lower(size: f32) -> f32 {
    2.0 / (1.0 + size)
}

/// q by (3).
#[inline]
pub fn factor(z: f32, size: f32) -> f32 {
    let (least, most) = (lower(size), size * lower(size));
    if z > most {
        z / most
    } else if z < least {
        z / least
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_come_into_the_window() {
        // The window about C = I/L: δ₋ = 2C/(1+s), δ₊ = s δ₋, and C is its middle.
        for (l, i) in [(0.3f32, 2.0f32), (7.0, 0.01)] {
            let c = i / l;
            let (least, most) = (c * lower(SIZE), c * SIZE * lower(SIZE));
            assert!((0.5 * (least + most) / c - 1.0).abs() < 1e-6);
            for k in -20..20 {
                let nu = c * 1.5f32.powi(k);
                let q = factor(nu * l / i, SIZE);
                let after = nu / q;
                assert!(after >= least * 0.9999 && after <= most * 1.0001, "{nu} {q}");
                let expected = match () {
                    () if nu > most => most,
                    () if nu < least => least,
                    () => nu,
                };
                assert!((after / expected - 1.0).abs() < 1e-5, "{after} {expected}");
            }
        }
    }
}
