//! Spectra as text: the `.spd` files of pbrt and Mitsuba.

use std::fmt;

use crate::SpectrumDesc;

/// Reads wavelength (nm) and value pairs separated by white space; `#` starts a comment that
/// runs to the end of the line. Pairs may stand several on a line or be split between lines.
///
/// # Errors
/// At the first thing that is not a finite number, a negative wavelength, one that is not greater
/// than the one before, a wavelength without its value, or if there is no pair at all.
pub fn parse_spd(text: &str) -> Result<SpectrumDesc, SpdError> {
    let (mut lambda, mut values) = (Vec::<f32>::new(), Vec::new());
    let mut last_line = 1;
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or("");
        for token in content.split_whitespace() {
            last_line = line;
            let error = |kind| SpdError { line, kind };
            let number: f32 = token
                .parse()
                .ok()
                .filter(|v: &f32| v.is_finite())
                .ok_or_else(|| error(SpdErrorKind::NotANumber(token.to_owned())))?;
            if lambda.len() > values.len() {
                values.push(number);
            } else if number < 0.0 {
                return Err(error(SpdErrorKind::NegativeWavelength(number)));
            } else if let Some(&before) = lambda.last()
                && number <= before
            {
                return Err(error(SpdErrorKind::NotIncreasing { before, found: number }));
            } else {
                lambda.push(number);
            }
        }
    }
    let error = |kind| Err(SpdError { line: last_line, kind });
    match lambda.last() {
        None => error(SpdErrorKind::Empty),
        Some(&l) if lambda.len() > values.len() => error(SpdErrorKind::MissingValue(l)),
        Some(_) => Ok(SpectrumDesc::Sampled { lambda: lambda.into(), values: values.into() }),
    }
}

/// What is wrong with the text of a spectrum, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct SpdError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong there.
    pub kind: SpdErrorKind,
}

/// Kinds of [`SpdError`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SpdErrorKind {
    /// This text is not a finite number.
    NotANumber(String),
    /// A wavelength below zero, nm.
    NegativeWavelength(f32),
    /// Wavelengths (nm) that do not increase.
    NotIncreasing {
        /// The one before.
        before: f32,
        /// The offending one.
        found: f32,
    },
    /// The text ends after this wavelength, nm.
    MissingValue(f32),
    /// No pairs.
    Empty,
}

impl fmt::Display for SpdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: ", self.line)?;
        match &self.kind {
            SpdErrorKind::NotANumber(t) => write!(f, "expected a finite number, found '{t}'"),
            SpdErrorKind::NegativeWavelength(l) => write!(f, "negative wavelength {l}"),
            SpdErrorKind::NotIncreasing { before, found } => {
                write!(f, "wavelengths must increase, but {found} follows {before}")
            }
            SpdErrorKind::MissingValue(l) => write!(f, "no value after wavelength {l}"),
            SpdErrorKind::Empty => write!(f, "no wavelength and value pairs"),
        }
    }
}

impl std::error::Error for SpdError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_and_comments() {
        let desc = parse_spd("# a\r\n400 0.5 # b\r\n\r\n  500\t1e-1\n600 -2").expect("valid");
        let want = SpectrumDesc::sampled(&[400.0, 500.0, 600.0], &[0.5, 0.1, -2.0]);
        assert_eq!(Ok(desc), want);
    }

    #[test]
    fn errors_say_the_line() {
        for (text, message) in [
            ("400 1\n500 nan", "line 2: expected a finite number, found 'nan'"),
            ("400 1\n# x\n500 1x", "line 3: expected a finite number, found '1x'"),
            ("400 1\n400 1", "line 2: wavelengths must increase, but 400 follows 400"),
            ("-5 1", "line 1: negative wavelength -5"),
            ("400 1\n500\n\n", "line 2: no value after wavelength 500"),
            ("# nothing\n", "line 1: no wavelength and value pairs"),
            ("400 1e999", "line 1: expected a finite number, found '1e999'"),
        ] {
            assert_eq!(parse_spd(text).map_err(|e| e.to_string()), Err(message.to_owned()));
        }
    }
}
