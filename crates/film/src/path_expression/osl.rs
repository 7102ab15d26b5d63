//! OSL's grammar, from the camera to the light.
//!
//! ```text
//! event    . | letter | 'light' | <type scattering 'light'> | [event…] | [^event…]
//! type     C camera, R reflection, T transmission, V volume, L light, O what emits, B background
//! scattering  D diffuse, G glossy, S singular, s straight through (which never happens)
//! repeats  * + ? {n} {n,} {n,m};   e|e;   (e)
//! ```
//!
//! A letter alone is a type of any scattering or a scattering of any type.

use super::regex::{ALL, CAMERA, LIGHTS, Regex, Symbols, VOLUME, light_symbol, surfaces};
use super::{ExpressionError, Source};

/// Reads an expression.
pub(super) fn parse(text: &str) -> Result<Regex, ExpressionError> {
    let mut reader = Reader::new(text);
    let regex = reader.alternatives()?;
    match reader.peek() {
        None => Ok(regex),
        Some(c) => Err(reader.error(format!("`{c}` closes nothing"))),
    }
}

/// Most repetitions that are counted.
const MOST: u32 = 64;
/// Deepest nesting.
const DEEPEST: u32 = 32;

/// The text and the place in it; both grammars read with it.
pub(super) struct Reader {
    text: Vec<char>,
    at: usize,
    depth: u32,
}

impl Reader {
    pub(super) fn new(text: &str) -> Reader {
        Reader { text: text.chars().collect(), at: 0, depth: 0 }
    }

    pub(super) fn error(&self, message: impl Into<String>) -> ExpressionError {
        ExpressionError { message: message.into(), text: self.text.iter().collect(), at: self.at }
    }

    /// The next character that is not a space.
    pub(super) fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    pub(super) fn next(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.at += 1;
        Some(c)
    }

    pub(super) fn take(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        self.at += usize::from(found);
        found
    }

    pub(super) fn expect(&mut self, c: char) -> Result<(), ExpressionError> {
        match self.take(c) {
            true => Ok(()),
            false => Err(self.error(format!("expected `{c}`"))),
        }
    }

    /// One level deeper.
    pub(super) fn nested<T>(
        &mut self,
        f: impl FnOnce(&mut Reader) -> Result<T, ExpressionError>,
    ) -> Result<T, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error("too many parentheses within each other"));
        }
        let result = f(self);
        self.depth -= 1;
        result
    }

    /// `regex` with the repeats that follow it.
    pub(super) fn repeated(&mut self, mut regex: Regex) -> Result<Regex, ExpressionError> {
        loop {
            let (from, to) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => {
                    self.at += 1;
                    let counts = self.counts()?;
                    regex = Regex::Repeat(Box::new(regex), counts.0, counts.1);
                    continue;
                }
                _ => return Ok(regex),
            };
            self.at += 1;
            regex = Regex::Repeat(Box::new(regex), from, to);
        }
    }

    /// `n}`, `n,}` or `n,m}`.
    fn counts(&mut self) -> Result<(u32, Option<u32>), ExpressionError> {
        let from = self.count()?;
        if self.take('}') {
            return Ok((from, Some(from)));
        }
        self.expect(',')?;
        if self.take('}') {
            return Ok((from, None));
        }
        let to = self.count()?;
        if to < from {
            return Err(self.error(format!("{to} is less than {from}")));
        }
        self.expect('}')?;
        Ok((from, Some(to)))
    }

    fn count(&mut self) -> Result<u32, ExpressionError> {
        let mut digits = String::new();
        while let Some(c) = self.peek().filter(char::is_ascii_digit) {
            digits.push(c);
            self.at += 1;
        }
        match digits.parse() {
            Ok(n) if n <= MOST => Ok(n),
            _ => Err(self.error(format!("expected a number of times, at most {MOST}"))),
        }
    }

    fn alternatives(&mut self) -> Result<Regex, ExpressionError> {
        let mut parts = vec![self.sequence()?];
        while self.take('|') {
            parts.push(self.sequence()?);
        }
        Ok(Regex::Or(parts))
    }

    fn sequence(&mut self) -> Result<Regex, ExpressionError> {
        let mut parts = Vec::new();
        while let Some(c) = self.peek() {
            if matches!(c, '|' | ')') {
                break;
            }
            let part = match c {
                '(' => {
                    self.at += 1;
                    let inner = self.nested(Reader::alternatives)?;
                    self.expect(')')?;
                    inner
                }
                '[' => {
                    self.at += 1;
                    self.choice()?
                }
                _ => Regex::One { sets: vec![self.event()?], not: false },
            };
            parts.push(self.repeated(part)?);
        }
        Ok(Regex::Cat(parts))
    }

    /// What stands in brackets.
    fn choice(&mut self) -> Result<Regex, ExpressionError> {
        let not = self.take('^');
        let mut sets = Vec::new();
        while !self.take(']') {
            if self.peek().is_none() {
                return Err(self.error("expected `]`"));
            }
            sets.push(self.event()?);
        }
        Ok(Regex::One { sets, not })
    }

    /// One event without repeats.
    fn event(&mut self) -> Result<Symbols, ExpressionError> {
        let at = self.at;
        let whole = |bits| Ok(Symbols { bits, label: None });
        match self.next() {
            Some('<') => self.group(),
            Some('\'') => Ok(Symbols { bits: LIGHTS, label: Some(self.label()?) }),
            Some('.') => whole(ALL),
            Some('V') => whole(VOLUME),
            Some(c) => match (type_of(c), kind_of(c)) {
                (Some(t), _) => whole(bits(t, ANY)),
                (_, Some(k)) => whole(surfaces(3, k)),
                _ => {
                    self.at = at;
                    Err(self.error(format!(
                        "`{c}` is no event; events are C R T V L O B, D G S, `.`, <…>, […]"
                    )))
                }
            },
            None => Err(self.error("expected an event")),
        }
    }

    /// What stands in angles.
    fn group(&mut self) -> Result<Symbols, ExpressionError> {
        let types = self.letters(type_of, ANY_TYPE, "a type: C R T V L O B or `.`")?;
        let kinds = match self.peek() {
            Some('>' | '\'') => ANY,
            _ => self.letters(kind_of, ANY, "a scattering: D G S or `.`")?,
        };
        let mut label = None;
        while !self.take('>') {
            match self.next() {
                Some('\'') => label = Some(self.label()?),
                Some('.') => {}
                _ => return Err(self.error("expected `>`")),
            }
        }
        let bits = bits(types, kinds);
        match label {
            Some(_) if bits & LIGHTS == 0 => Err(self.error("only lights have names: <L.'name'>")),
            Some(_) => Ok(Symbols { bits: bits & LIGHTS, label }),
            None => Ok(Symbols { bits, label }),
        }
    }

    /// One letter, `.` for `any`, or letters in brackets.
    fn letters(
        &mut self,
        of: fn(char) -> Option<u32>,
        any: u32,
        what: &str,
    ) -> Result<u32, ExpressionError> {
        let one = |r: &mut Reader| match r.peek() {
            Some('.') => {
                r.at += 1;
                Ok(any)
            }
            c => match c.and_then(of) {
                Some(bits) => {
                    r.at += 1;
                    Ok(bits)
                }
                None => Err(r.error(format!("expected {what}"))),
            },
        };
        if !self.take('[') {
            return one(self);
        }
        let not = self.take('^');
        let mut bits = 0;
        while !self.take(']') {
            bits |= one(self)?;
        }
        Ok(if not { any & !bits } else { bits })
    }

    /// The rest of a name in quotes.
    fn label(&mut self) -> Result<String, ExpressionError> {
        let rest = &self.text[self.at..];
        let Some(length) = rest.iter().position(|c| *c == '\'') else {
            return Err(self.error("a name in quotes does not end"));
        };
        let label = rest[..length].iter().collect();
        self.at += length + 1;
        Ok(label)
    }
}

/// Any scattering, straight through included.
const ANY: u32 = 0b1111;
/// Any type.
const ANY_TYPE: u32 = 0b111_1111;

fn type_of(c: char) -> Option<u32> {
    "RTVLOBC".find(c).map(|i| 1 << i)
}

fn kind_of(c: char) -> Option<u32> {
    "DGSs".find(c).map(|i| 1 << i)
}

/// The symbols of these types and scatterings.
fn bits(types: u32, kinds: u32) -> u32 {
    let mut bits = surfaces(types & 3, kinds & 7);
    // The others do not scatter as surfaces do.
    if kinds == ANY {
        let light = |source| 1 << light_symbol(source);
        let emits = light(Source::Surface) | light(Source::Medium);
        let of = [VOLUME, LIGHTS, emits, light(Source::Background), CAMERA];
        bits |= (0..5).filter(|i| types & (4 << i) != 0).fold(0, |b, i| b | of[i]);
    }
    bits
}
