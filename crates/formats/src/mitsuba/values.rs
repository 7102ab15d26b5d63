//! Numbers, lists, colours and spectra as attributes spell them.

use super::document::SpectrumValue;
use kaustika_spectra::SpectrumDesc;

/// Parts between spaces, commas and line breaks.
pub(super) fn tokens(text: &str) -> Vec<&str> {
    text.split(|c: char| c.is_whitespace() || c == ',').filter(|t| !t.is_empty()).collect()
}

/// A finite number, spaces around it allowed.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let trimmed = text.trim();
    // Rust also reads "inf" and "nan", which no parameter can use.
    match trimmed.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(format!("expected a number, found `{text}`")),
    }
}

/// An integer in decimal or `0x` hexadecimal.
pub(super) fn integer(text: &str) -> Result<i64, String> {
    let trimmed = text.trim();
    let (sign, digits) = match trimmed.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, trimmed.strip_prefix('+').unwrap_or(trimmed)),
    };
    let hex = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
    let value = match hex {
        Some(h) => i64::from_str_radix(h, 16).ok(),
        None if digits.starts_with(['+', '-']) => None,
        None => digits.parse::<i64>().ok(),
    };
    value.map(|v| sign * v).ok_or_else(|| format!("expected an integer, found `{text}`"))
}

/// `true` or `false` in any case.
pub(super) fn boolean(text: &str) -> Result<bool, String> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err(format!("expected `true` or `false`, found `{text}`")),
    }
}

/// Three numbers; with `spread`, one number stands for three.
pub(super) fn triple(text: &str, spread: bool) -> Result<[f64; 3], String> {
    let parts = tokens(text);
    match parts.as_slice() {
        [one] if spread => {
            let v = number(one)?;
            Ok([v, v, v])
        }
        [a, b, c] => Ok([number(a)?, number(b)?, number(c)?]),
        _ if spread => Err(format!("expected one or three numbers, found {}", parts.len())),
        _ => Err(format!("expected three numbers, found {}", parts.len())),
    }
}

/// A colour: one or three numbers, or `#rrggbb` (bytes over 255).
pub(super) fn color(text: &str) -> Result<[f32; 3], String> {
    if let Some(hex) = text.trim().strip_prefix('#') {
        let bits = u32::from_str_radix(hex, 16).ok().filter(|_| hex.len() == 6);
        let bits =
            bits.ok_or_else(|| format!("expected a colour like `#rrggbb`, found `{text}`"))?;
        return Ok([16, 8, 0].map(|shift| ((bits >> shift) & 0xff) as f32 / 255.0));
    }
    triple(text, true).map(|c| c.map(|v| v as f32))
}

/// One number, or `wavelength:value` pairs.
pub(super) fn spectrum(text: &str) -> Result<SpectrumValue, String> {
    let parts = tokens(text);
    if let [one] = parts.as_slice()
        && !one.contains(':')
    {
        return Ok(SpectrumValue::Uniform(number(one)? as f32));
    }
    let mut lambda = Vec::with_capacity(parts.len());
    let mut values = Vec::with_capacity(parts.len());
    for part in parts {
        let (l, v) = part
            .split_once(':')
            .ok_or_else(|| format!("expected `wavelength:value`, found `{part}`"))?;
        lambda.push(number(l)? as f32);
        values.push(number(v)? as f32);
    }
    table(&lambda, &values).map(SpectrumValue::Table)
}

/// A piecewise linear spectrum of at least two samples.
pub(super) fn table(lambda: &[f32], values: &[f32]) -> Result<SpectrumDesc, String> {
    if lambda.len() == 1 && values.len() == 1 {
        return Err("a spectrum needs at least two wavelengths".to_string());
    }
    SpectrumDesc::sampled(lambda, values).map_err(|e| e.to_string())
}
