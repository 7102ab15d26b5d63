//! Reads parameter lists.

use super::lexer::{Lexer, Token, TokenKind};
use super::number::{BadInteger, scan_f32, scan_i32};
use super::param::{Param, ParamType, TYPES, Text, Values};
use super::reader::{GivenUp, Reader};

/// Types of pbrt-v3 and what they are called now.
const OLD_TYPES: [(&str, ParamType); 5] = [
    ("color", ParamType::Rgb),
    ("point", ParamType::Point3),
    ("vector", ParamType::Vector3),
    ("xyz", ParamType::Rgb),
    ("normal3", ParamType::Normal),
];

impl Reader {
    /// Parameters up to the next token that is no string.
    pub fn params(&mut self, lexer: &mut Lexer) -> Result<Vec<Param>, GivenUp> {
        let mut params = Vec::new();
        loop {
            let before = lexer.pos;
            match self.next(lexer)? {
                Some(token) if token.kind == TokenKind::String => {
                    if let Some(p) = self.param(lexer, token)? {
                        params.push(p);
                    }
                }
                Some(_) => {
                    lexer.pos = before;
                    return Ok(params);
                }
                None => return Ok(params),
            }
        }
    }

    /// The parameter declared by `token`; `None` if it is unusable, which is reported.
    fn param(&mut self, lexer: &mut Lexer, token: Token) -> Result<Option<Param>, GivenUp> {
        let declaration = self.unquote(lexer, token)?.text;
        let mut words = declaration.split([' ', '\t']).filter(|w| !w.is_empty());
        let (Some(ty), Some(name)) = (words.next(), words.next()) else {
            self.diag
                .error(token.span, format!("`{declaration}` is no parameter declaration"))
                .hint("a parameter is written \"type name\", such as \"float radius\"");
            return Err(GivenUp);
        };
        let mut known = TYPES.iter().find(|(n, _)| *n == ty).map(|(_, t)| *t);
        if known.is_none()
            && let Some((old, new)) = OLD_TYPES.iter().find(|(n, _)| *n == ty)
        {
            self.v3 = true;
            let message = format!("pbrt-v3 type `{old}` is read as `{}`", new.name());
            self.notes.note(token.span, message);
            known = Some(*new);
        }
        let Some(known) = known else {
            let names: Vec<&str> = TYPES.iter().map(|(n, _)| *n).collect();
            self.diag
                .error(token.span, format!("unknown parameter type `{ty}`"))
                .nearest(ty, &names);
            self.skip_values(lexer)?;
            return Ok(None);
        };
        let values = self.values(lexer, known, name)?;
        let mut p = Param {
            ty: known,
            name: name.to_string(),
            span: token.span,
            bad: values.is_none(),
            values: values.unwrap_or(Values::Floats(Vec::new())),
            space: self.state.space,
            used: false,
        };
        if ty == "xyz" {
            xyz_to_rgb(&mut p);
        }
        if p.bad {
            p.used = true;
        }
        Ok(Some(p))
    }

    /// Values of a parameter of type `ty`; `None` if they are wrong, which is reported.
    fn values(
        &mut self,
        lexer: &mut Lexer,
        ty: ParamType,
        name: &str,
    ) -> Result<Option<Values>, GivenUp> {
        let first = self.required(lexer, "a value")?;
        let list = first.kind == TokenKind::Open;
        if first.kind == TokenKind::Close {
            self.diag.error(first.span, format!("parameter `{name}` has no value"));
            return Err(GivenUp);
        }
        if !list {
            lexer.pos = first.span.start as usize;
        } else {
            lexer.skip_blank();
        }
        let start = lexer.pos;
        let strings = lexer.bytes().get(start) == Some(&b'"');
        let values = match ty {
            ParamType::Integer => self.ints(lexer, list, name)?.map(Values::Ints),
            ParamType::Bool => self.bools(lexer, list, name)?.map(Values::Bools),
            ParamType::String | ParamType::Texture => {
                self.strings(lexer, list, name)?.map(Values::Strings)
            }
            ParamType::Spectrum if strings => self.strings(lexer, list, name)?.map(Values::Strings),
            _ => self.floats(lexer, list, name)?.map(Values::Floats),
        };
        if let Some(v) = &values
            && v.len() == 0
        {
            let span = lexer.span(start, lexer.pos);
            self.diag.error(span, format!("parameter `{name}` has no values"));
            return Ok(None);
        }
        Ok(values)
    }

    /// Numbers up to the closing bracket, or a single one.
    fn floats(
        &mut self,
        lexer: &mut Lexer,
        list: bool,
        name: &str,
    ) -> Result<Option<Vec<f32>>, GivenUp> {
        let mut out = Vec::new();
        loop {
            lexer.skip_blank();
            if let Some((value, end)) = scan_f32(lexer.bytes(), lexer.pos) {
                if !value.is_finite() {
                    let span = lexer.span(lexer.pos, end);
                    self.diag.error(span, format!("the number is too large for `{name}`"));
                    lexer.pos = end;
                    self.skip_rest(lexer, list)?;
                    return Ok(None);
                }
                lexer.pos = end;
                out.push(value);
                if list {
                    continue;
                }
                return Ok(Some(out));
            }
            if self.list_ends(lexer, list, name, "a number")? {
                return Ok(Some(out));
            }
            return Ok(None);
        }
    }

    /// Integers up to the closing bracket, or a single one.
    fn ints(
        &mut self,
        lexer: &mut Lexer,
        list: bool,
        name: &str,
    ) -> Result<Option<Vec<i32>>, GivenUp> {
        let mut out = Vec::new();
        loop {
            lexer.skip_blank();
            match scan_i32(lexer.bytes(), lexer.pos) {
                Ok((value, end)) => {
                    lexer.pos = end;
                    out.push(value);
                    if !list {
                        return Ok(Some(out));
                    }
                }
                Err(BadInteger::TooLarge) => {
                    let token = self.required(lexer, "an integer")?;
                    let message = format!("the integer does not fit into 32 bits in `{name}`");
                    self.diag.error(token.span, message);
                    self.skip_rest(lexer, list)?;
                    return Ok(None);
                }
                Err(BadInteger::NotOne) => {
                    let ended = self.list_ends(lexer, list, name, "an integer")?;
                    return Ok(ended.then_some(out));
                }
            }
        }
    }

    /// Strings up to the closing bracket, or a single one.
    fn strings(
        &mut self,
        lexer: &mut Lexer,
        list: bool,
        name: &str,
    ) -> Result<Option<Vec<Text>>, GivenUp> {
        let mut out = Vec::new();
        loop {
            lexer.skip_blank();
            if lexer.bytes().get(lexer.pos) != Some(&b'"') {
                let ended = self.list_ends(lexer, list, name, "a string in quotes")?;
                return Ok(ended.then_some(out));
            }
            let token = self.required(lexer, "a string")?;
            out.push(self.unquote(lexer, token)?);
            if !list {
                return Ok(Some(out));
            }
        }
    }

    /// Truth values up to the closing bracket, or a single one; pbrt-v3 writes them in quotes.
    fn bools(
        &mut self,
        lexer: &mut Lexer,
        list: bool,
        name: &str,
    ) -> Result<Option<Vec<bool>>, GivenUp> {
        let mut out = Vec::new();
        loop {
            let before = lexer.pos;
            let token = self.required(lexer, "`true` or `false`")?;
            let text = lexer.slice(token.span);
            let value = match text.trim_matches('"') {
                "true" => true,
                "false" => false,
                _ => {
                    lexer.pos = before;
                    let ended = self.list_ends(lexer, list, name, "`true` or `false`")?;
                    return Ok(ended.then_some(out));
                }
            };
            if token.kind == TokenKind::String {
                self.v3 = true;
                self.notes.note(token.span, "pbrt-v3 writes truth values in quotes");
            }
            out.push(value);
            if !list {
                return Ok(Some(out));
            }
        }
    }

    /// True if the list's closing bracket comes next. Else what stands there is an error, and
    /// the list is passed over.
    fn list_ends(
        &mut self,
        lexer: &mut Lexer,
        list: bool,
        name: &str,
        expected: &str,
    ) -> Result<bool, GivenUp> {
        let before = lexer.pos;
        let Ok(token) = self.required(lexer, expected) else {
            if let (true, Some(error)) = (list, self.diag.entries.last_mut()) {
                error.hint("a `]` seems to be missing");
            }
            return Err(GivenUp);
        };
        if list && token.kind == TokenKind::Close {
            return Ok(true);
        }
        let found = lexer.slice(token.span);
        let message = format!("expected {expected} for `{name}`, found `{found}`");
        let error = self.diag.error(token.span, message);
        if list && super::directive::DIRECTIVES.contains(&found) {
            error.hint("a `]` seems to be missing before it");
            lexer.pos = before;
            return Err(GivenUp);
        }
        self.skip_rest(lexer, list)?;
        Ok(false)
    }

    /// Passes over the rest of a list.
    fn skip_rest(&mut self, lexer: &mut Lexer, list: bool) -> Result<(), GivenUp> {
        if !list {
            return Ok(());
        }
        loop {
            let before = lexer.pos;
            let token = self.required(lexer, "`]`")?;
            if token.kind == TokenKind::Close {
                return Ok(());
            }
            if super::directive::DIRECTIVES.contains(&lexer.slice(token.span)) {
                lexer.pos = before;
                return Err(GivenUp);
            }
        }
    }

    /// Passes over the values of a parameter.
    fn skip_values(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let first = self.required(lexer, "a value")?;
        self.skip_rest(lexer, first.kind == TokenKind::Open)
    }
}

/// CIE XYZ to linear sRGB (IEC 61966-2-1), negative components cut.
fn xyz_to_rgb(p: &mut Param) {
    if let Values::Floats(v) = &mut p.values {
        for c in v.chunks_exact_mut(3) {
            let (x, y, z) = (c[0], c[1], c[2]);
            c[0] = (3.240_97 * x - 1.537_383 * y - 0.498_611 * z).max(0.0);
            c[1] = (-0.969_244 * x + 1.875_968 * y + 0.041_555 * z).max(0.0);
            c[2] = (0.055_630 * x - 0.203_977 * y + 1.056_972 * z).max(0.0);
        }
    }
}
