//! Heckbert's grammar (1990), as the lecture extends it, from the light to the eye.
//!
//! ```text
//! L light, E eye, D diffuse, S glossy or singular, S_M singular, S_G glossy, V volume, . anything
//! repeats  * + ? {n} {n,} {n,m};   x|x;   (x);   [x] what may be left out
//! ```

use super::ExpressionError;
use super::osl::Reader;
use super::regex::{CAMERA, LIGHTS, Regex, VOLUME, surfaces};

/// Reads an expression; the result goes from the camera.
pub(super) fn parse(text: &str) -> Result<Regex, ExpressionError> {
    let mut reader = Reader::new(text);
    let regex = reader.paths()?;
    match reader.peek() {
        None => Ok(regex.reversed()),
        Some(c) => Err(reader.error(format!("`{c}` closes nothing"))),
    }
}

impl Reader {
    fn paths(&mut self) -> Result<Regex, ExpressionError> {
        let mut parts = vec![self.path()?];
        while self.take('|') {
            parts.push(self.path()?);
        }
        Ok(Regex::Or(parts))
    }

    fn path(&mut self) -> Result<Regex, ExpressionError> {
        let mut parts = Vec::new();
        while let Some(c) = self.peek() {
            if matches!(c, '|' | ')' | ']') {
                break;
            }
            self.next();
            let part = match c {
                '(' | '[' => {
                    let inner = self.nested(Reader::paths)?;
                    self.expect(if c == '(' { ')' } else { ']' })?;
                    match c {
                        '(' => inner,
                        _ => Regex::Repeat(Box::new(inner), 0, Some(1)),
                    }
                }
                'L' => Regex::any(LIGHTS),
                'E' => Regex::any(CAMERA),
                'D' => Regex::any(surfaces(3, 1)),
                'S' if self.take('_') => match self.next() {
                    Some('M') => Regex::any(surfaces(3, 4)),
                    Some('G') => Regex::any(surfaces(3, 2)),
                    _ => return Err(self.error("expected `S_M` or `S_G`")),
                },
                'S' => Regex::any(surfaces(3, 6)),
                'V' => Regex::any(VOLUME),
                '.' => Regex::any(surfaces(3, 7) | VOLUME),
                _ => {
                    let message = format!("`{c}` is no letter of a path: L E D S S_M S_G V or `.`");
                    return Err(self.error(message));
                }
            };
            parts.push(self.repeated(part)?);
        }
        Ok(Regex::Cat(parts))
    }
}
