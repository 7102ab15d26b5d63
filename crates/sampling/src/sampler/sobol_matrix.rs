//! Generator matrices of the digital sequences, acting on bits in the order that scrambling
//! wants.
//!
//! A digital sequence in base 2 is x = C·i over GF(2): bit 0 of the index i is the first
//! column, the first row gives the most significant bit of x. All functions here return x with
//! its bits reversed, so bit 0 is the most significant digit. The first Sobol dimension, the
//! van der Corput sequence, needs no function: its reversed value is the index itself.

/// The second Sobol dimension, whose matrix is Pascal's triangle modulo 2, bits reversed.
///
/// Pascal's matrix is the Kronecker power of (1 1; 0 1), so five butterflies do it.
#[inline]
pub(super) const fn pascal_reversed(mut i: u32) -> u32 {
    i ^= (i >> 1) & 0x5555_5555;
    i ^= (i >> 2) & 0x3333_3333;
    i ^= (i >> 4) & 0x0f0f_0f0f;
    i ^= (i >> 8) & 0x00ff_00ff;
    i ^ (i >> 16)
}

/// The first 32 digits of the second Sobol dimension for a 64-bit index, bits reversed.
#[inline]
pub(super) const fn pascal_reversed_64(mut i: u64) -> u32 {
    i ^= (i >> 1) & 0x5555_5555_5555_5555;
    i ^= (i >> 2) & 0x3333_3333_3333_3333;
    i ^= (i >> 4) & 0x0f0f_0f0f_0f0f_0f0f;
    i ^= (i >> 8) & 0x00ff_00ff_00ff_00ff;
    i ^= (i >> 16) & 0x0000_ffff_0000_ffff;
    (i ^ (i >> 32)) as u32
}

/// The third and fourth Sobol dimensions, bits reversed.
#[inline]
pub(super) fn pair_reversed(i: u32) -> (u32, u32) {
    let mut both = 0;
    for (k, row) in PAIR.iter().enumerate() {
        both ^= row[(i >> (4 * k) & 15) as usize];
    }
    (both as u32, (both >> 32) as u32)
}

/// The columns of the third and fourth dimension's matrices, bits reversed.
pub(super) static PAIR_COLUMNS: [(u32, u32); 32] = {
    let mut columns = [(0, 0); 32];
    let mut bit = 0;
    while bit < 32 {
        let both = PAIR[bit / 4][1 << (bit % 4)];
        columns[bit] = (both as u32, (both >> 32) as u32);
        bit += 1;
    }
    columns
};

/// For each 4 bits of the index their contribution to the third (low half) and fourth
/// (high half) dimension; 1 KB.
static PAIR: [[u64; 16]; 8] = {
    // Joe & Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM
    // J. Sci. Comput. 30, 2008, table new-joe-kuo-6: dimensions 3 and 4.
    let third = directions_reversed(2, 1, [1, 3, 0]);
    let fourth = directions_reversed(3, 1, [1, 3, 1]);
    let mut table = [[0; 16]; 8];
    let mut k = 0;
    while k < 8 {
        let mut v = 0;
        while v < 16 {
            let mut bit = 0;
            while bit < 4 {
                if v >> bit & 1 == 1 {
                    let column = 4 * k + bit;
                    table[k][v] ^= third[column] as u64 | (fourth[column] as u64) << 32;
                }
                bit += 1;
            }
            v += 1;
        }
        k += 1;
    }
    table
};

/// The columns of a Sobol matrix, bits reversed, from the degree `s` of its primitive
/// polynomial, the polynomial's inner coefficients `a` and the initial numbers `m`: with
/// m_k = 2a₁m_{k-1} ⊕ 4a₂m_{k-2} ⊕ … ⊕ 2ˢm_{k-s} ⊕ m_{k-s} (Bratley & Fox 1988, eq. 2), column
/// k is m_k / 2ᵏ⁺¹.
const fn directions_reversed(s: usize, a: u64, m: [u64; 3]) -> [u32; 32] {
    let mut numbers = [0u64; 32];
    let mut columns = [0; 32];
    let mut k = 0;
    while k < 32 {
        if k < s {
            numbers[k] = m[k];
        } else {
            numbers[k] = numbers[k - s] ^ (numbers[k - s] << s);
            let mut i = 1;
            while i < s {
                numbers[k] ^= (a >> (s - 1 - i) & 1) * (numbers[k - i] << i);
                i += 1;
            }
        }
        columns[k] = ((numbers[k] as u32) << (31 - k)).reverse_bits();
        k += 1;
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_equal_their_recurrences() {
        let second = directions_reversed(1, 0, [1, 0, 0]);
        let mut i = 1u32;
        for _ in 0..1000 {
            i = i.wrapping_mul(0x915f_77f5).wrapping_add(1);
            let expected = (0..32).filter(|b| i >> b & 1 == 1).fold(0, |x, b| x ^ second[b]);
            assert_eq!(pascal_reversed(i), expected);
            assert_eq!(pascal_reversed_64(u64::from(i)), expected);
            // Sobol points with a 64-bit index: rows beyond the 32nd are cut off.
            let wide = u64::from(i) << 32 | u64::from(i.rotate_left(7));
            let expected = (0..64).filter(|b| wide >> b & 1 == 1).fold(0u32, |x, b: u32| {
                // Column b holds binomial(b, row) mod 2, which is 1 where row's bits are in b.
                x ^ (0..32).filter(|row| row & !b == 0).fold(0, |c, row| c | 1 << row)
            });
            assert_eq!(pascal_reversed_64(wide), expected);
        }
    }

    #[test]
    fn published_points() {
        // The points with indices 1..=7 of Joe & Kuo's third and fourth dimensions, in eighths.
        let third = [4, 6, 2, 3, 7, 5, 1];
        let fourth = [4, 6, 2, 1, 5, 7, 3];
        for i in 1..8u32 {
            let (x, y) = pair_reversed(i);
            assert_eq!(x.reverse_bits() >> 29, third[i as usize - 1], "{i}");
            assert_eq!(y.reverse_bits() >> 29, fourth[i as usize - 1], "{i}");
        }
    }
}
