//! Numbers in scene files, read without allocating.

/// Powers of ten that an `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// True for the bytes that end a word or a number.
#[inline]
pub(super) fn is_delimiter(b: u8) -> bool {
    matches!(b, b' ' | b'\n' | b'\t' | b'\r' | b'"' | b'[' | b']' | b'#')
}

/// Reads the decimal number that starts at `start` and ends before a delimiter; gives it,
/// correctly rounded, with the position behind it. `None` if no such number stands there.
/// Too large numbers come out infinite.
///
/// The fast path (Clinger 1990): a mantissa below 2⁵³ times or over an exact power of ten is
/// rounded once to `f64`; that rounding can only mislead the second one, to `f32`, if its result
/// lies half-way between two `f32`, and then the standard library decides.
#[inline]
pub(super) fn scan_f32(bytes: &[u8], start: usize) -> Option<(f32, usize)> {
    let mut i = start;
    let negative = match bytes.get(i)? {
        b'-' => {
            i += 1;
            true
        }
        b'+' => {
            i += 1;
            false
        }
        _ => false,
    };
    let (mut mantissa, mut exponent, mut exact) = (0u64, 0i32, true);
    let first = i;
    let mut digits = 0usize;
    while let Some(d) = digit(bytes, i) {
        if mantissa < 100_000_000_000_000_000 {
            mantissa = mantissa * 10 + d;
        } else {
            exact &= d == 0;
            exponent = exponent.saturating_add(1);
        }
        i += 1;
    }
    digits += i - first;
    if bytes.get(i) == Some(&b'.') {
        i += 1;
        let first = i;
        while let Some(d) = digit(bytes, i) {
            if mantissa < 100_000_000_000_000_000 {
                mantissa = mantissa * 10 + d;
                exponent = exponent.saturating_sub(1);
            } else {
                exact &= d == 0;
            }
            i += 1;
        }
        digits += i - first;
    }
    if digits == 0 {
        return None;
    }
    if matches!(bytes.get(i), Some(b'e' | b'E')) {
        i += 1;
        let minus = match bytes.get(i) {
            Some(b'-') => {
                i += 1;
                true
            }
            Some(b'+') => {
                i += 1;
                false
            }
            _ => false,
        };
        let first = i;
        let mut e = 0i32;
        while let Some(d) = digit(bytes, i) {
            e = e.saturating_mul(10).saturating_add(d as i32);
            i += 1;
        }
        if i == first {
            return None;
        }
        exponent = exponent.saturating_add(if minus { -e } else { e });
    }
    if bytes.get(i).is_some_and(|&b| !is_delimiter(b)) {
        return None;
    }
    if exact && mantissa < 1 << 53 && exponent.unsigned_abs() <= 22 {
        let power = POWERS[exponent.unsigned_abs() as usize];
        let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
        let halfway = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
        let subnormal = value != 0.0 && value < f32::MIN_POSITIVE as f64;
        if !halfway && !subnormal {
            let value = value as f32;
            return Some((if negative { -value } else { value }, i));
        }
    }
    let text = std::str::from_utf8(&bytes[start..i]).ok()?;
    Some((text.parse().ok()?, i))
}

/// Why a word is no integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BadInteger {
    /// It is something else.
    NotOne,
    /// It does not fit into 32 bits.
    TooLarge,
}

/// Reads the integer that starts at `start` and ends before a delimiter.
#[inline]
pub(super) fn scan_i32(bytes: &[u8], start: usize) -> Result<(i32, usize), BadInteger> {
    let mut i = start;
    let negative = bytes.get(i) == Some(&b'-');
    if matches!(bytes.get(i), Some(b'-' | b'+')) {
        i += 1;
    }
    let first = i;
    let mut value = 0i64;
    while let Some(d) = digit(bytes, i) {
        value = value.saturating_mul(10).saturating_add(d as i64);
        i += 1;
    }
    if i == first || bytes.get(i).is_some_and(|&b| !is_delimiter(b)) {
        return Err(BadInteger::NotOne);
    }
    let value = if negative { -value } else { value };
    i32::try_from(value).map(|v| (v, i)).map_err(|_| BadInteger::TooLarge)
}

#[inline]
fn digit(bytes: &[u8], i: usize) -> Option<u64> {
    let d = bytes.get(i)?.wrapping_sub(b'0');
    (d < 10).then_some(d as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_as_the_standard_library_does() {
        let fixed = [
            "0",
            "-0",
            "1",
            ".5",
            "5.",
            "-1e-3",
            "+2.5E+4",
            "1e38",
            "1e39",
            "1e-45",
            "1e-50",
            "16777217",
            "8388608.5",
            "0.1",
            "3.4028235e38",
            "123456789012345678901234567890",
            "0.000000000000000000000000000001234",
            "1.17549435e-38",
            "7.0064923216240854e-46",
            "9007199254740993",
            "0000000000000000000000000000001.5",
            "4.37113e-8",
        ];
        let mut state = 1u64;
        let random = (0..20_000).map(|_| {
            state = kaustika_math::mix_bits(state.wrapping_add(0x9e37_79b9_7f4a_7c15));
            let value = f32::from_bits(state as u32);
            let value = if value.is_finite() { value } else { 1.5 };
            match state >> 62 {
                0 => format!("{value}"),
                1 => format!("{value:e}"),
                2 => format!("{:.4}", value % 1e4),
                _ => format!("{}", value as f64 * (1.0 + 1e-9)),
            }
        });
        for text in fixed.iter().map(|s| s.to_string()).chain(random) {
            let expected: f32 = text.parse().unwrap();
            let (value, end) = scan_f32(text.as_bytes(), 0).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value} for {expected}");
            assert_eq!(end, text.len());
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "-", ".", "e5", "1e", "1e+", "1x", "inf", "nan", "0x10", "--1", "1.2.3"] {
            assert_eq!(scan_f32(text.as_bytes(), 0), None, "{text}");
        }
        assert_eq!(scan_f32(b"1.5]", 0), Some((1.5, 3)));
        assert_eq!(scan_i32(b"12 13", 3), Ok((13, 5)));
        assert_eq!(scan_i32(b"-2147483648", 0), Ok((i32::MIN, 11)));
        assert_eq!(scan_i32(b"2147483648", 0), Err(BadInteger::TooLarge));
        assert_eq!(scan_i32(b"99999999999999999999999", 0), Err(BadInteger::TooLarge));
        assert_eq!(scan_i32(b"1.5", 0), Err(BadInteger::NotOne));
    }
}
