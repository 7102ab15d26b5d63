//! Durations as people write and read them.

use std::time::Duration;

/// Reads `60`, `60s`, `5m`, `1h`, `1.5m`.
///
/// # Errors
/// If it is something else, or not positive.
pub fn parse(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let (number, unit) = match text.char_indices().last() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let expected = || "expected a duration such as 60, 60s, 5m, 1.5h".to_string();
    let seconds: f64 = number.trim().parse().map_err(|_| expected())?;
    if seconds.is_nan() || seconds <= 0.0 {
        return Err(format!("{}, greater than 0", expected()));
    }
    Duration::try_from_secs_f64(seconds * unit).map_err(|_| expected())
}

/// `5.2 s`, `1 min 05 s`, `2 h 03 min`.
pub fn show(d: Duration) -> String {
    let s = d.as_secs();
    match s {
        0..60 => format!("{:.1} s", d.as_secs_f64()),
        60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        _ => format!("{} h {:02} min", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_fractions_are_read() {
        let read = [("60", 60.0), ("60s", 60.0), ("5m", 300.0), ("1h", 3600.0), ("1.5m", 90.0)];
        for (text, seconds) in read.into_iter().chain([("0.25", 0.25), (" 2 s ", 2.0)]) {
            assert_eq!(parse(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for text in ["", "s", "5x", "-1", "0", "nan", "inf", "1e300h", "1m30"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn durations_are_shown_in_fitting_units() {
        let shown = [(5.23, "5.2 s"), (65.9, "1 min 05 s"), (7385.0, "2 h 03 min")];
        for (seconds, text) in shown {
            assert_eq!(show(Duration::from_secs_f64(seconds)), text);
        }
    }
}
