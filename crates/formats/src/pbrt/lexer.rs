//! Splits a scene file into words, strings and brackets.

use super::number::is_delimiter;
use kaustika_scene::description::Span;
use std::borrow::Cow;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    /// A directive, number, `true` or `false`.
    Word,
    /// A quoted string, quotes included.
    String,
    /// `[`.
    Open,
    /// `]`.
    Close,
}

/// A token of one file, by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub span: Span,
}

/// A string that does not end on its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unterminated(pub Span);

/// Reads tokens from a text; comments and white space are passed over.
pub(super) struct Lexer<'a> {
    text: &'a str,
    file: u32,
    /// Byte that is read next.
    pub pos: usize,
}

impl<'a> Lexer<'a> {
    /// A lexer at the start of the text of file number `file`.
    pub fn new(text: &'a str, file: u32) -> Self {
        // A byte order mark is no part of the scene.
        let pos = if text.starts_with('\u{feff}') { 3 } else { 0 };
        Lexer { text, file, pos }
    }

    /// The text as bytes.
    pub fn bytes(&self) -> &'a [u8] {
        self.text.as_bytes()
    }

    /// A stretch of this file.
    pub fn span(&self, start: usize, end: usize) -> Span {
        Span { file: self.file, start: start as u32, end: end as u32 }
    }

    /// The text of a span of this file.
    pub fn slice(&self, span: Span) -> &'a str {
        &self.text[span.start as usize..span.end as usize]
    }

    /// Passes over white space and comments.
    #[inline]
    pub fn skip_blank(&mut self) {
        let bytes = self.bytes();
        while let Some(&b) = bytes.get(self.pos) {
            match b {
                b' ' | b'\n' | b'\t' | b'\r' => self.pos += 1,
                b'#' => {
                    let rest = &bytes[self.pos..];
                    self.pos += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                }
                _ => break,
            }
        }
    }

    /// The next token, `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Token>, Unterminated> {
        self.skip_blank();
        let (bytes, start) = (self.bytes(), self.pos);
        let Some(&first) = bytes.get(start) else { return Ok(None) };
        let kind = match first {
            b'[' | b']' => {
                self.pos += 1;
                if first == b'[' { TokenKind::Open } else { TokenKind::Close }
            }
            b'"' => {
                self.pos = self.string_end(start)?;
                TokenKind::String
            }
            _ => {
                let rest = &bytes[start..];
                let length = rest.iter().position(|&b| is_delimiter(b)).unwrap_or(rest.len());
                self.pos = start + length;
                TokenKind::Word
            }
        };
        Ok(Some(Token { kind, span: self.span(start, self.pos) }))
    }

    /// Position behind the quote that closes the string opened at `start`.
    fn string_end(&mut self, start: usize) -> Result<usize, Unterminated> {
        let bytes = self.bytes();
        let mut i = start + 1;
        while let Some(&b) = bytes.get(i) {
            match b {
                b'"' => return Ok(i + 1),
                b'\\' => i += 2,
                b'\n' => break,
                _ => i += 1,
            }
        }
        let end = i.min(bytes.len());
        self.pos = end;
        Err(Unterminated(self.span(start, end)))
    }

    /// The contents of a string token, escapes resolved; `Err` holds an unknown escape.
    pub fn unquote(&self, token: Token) -> Result<Cow<'a, str>, char> {
        let text = self.slice(token.span);
        let inner = &text[1..text.len() - 1];
        if !inner.contains('\\') {
            return Ok(Cow::Borrowed(inner));
        }
        let mut out = String::with_capacity(inner.len());
        let mut chars = inner.chars();
        while let Some(c) = chars.next() {
            out.push(match c {
                '\\' => match chars.next() {
                    Some('b') => '\u{8}',
                    Some('f') => '\u{c}',
                    Some('n') => '\n',
                    Some('r') => '\r',
                    Some('t') => '\t',
                    Some(c @ ('\\' | '\'' | '"')) => c,
                    other => return Err(other.unwrap_or('\\')),
                },
                c => c,
            });
        }
        Ok(Cow::Owned(out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<&str> {
        let mut lexer = Lexer::new(text, 0);
        let mut out = Vec::new();
        while let Ok(Some(t)) = lexer.next() {
            out.push(lexer.slice(t.span));
        }
        out
    }

    #[test]
    fn tokens_need_no_spaces_where_brackets_or_quotes_part_them() {
        assert_eq!(
            words("\u{feff}Shape\"sphere\"\"float radius\"[1.5]# to the end\r\nScale 1 2 -3#x"),
            ["Shape", "\"sphere\"", "\"float radius\"", "[", "1.5", "]", "Scale", "1", "2", "-3"]
        );
    }

    #[test]
    fn escapes_are_resolved() {
        let mut lexer = Lexer::new(r#""a\"b\\c\n" "\q""#, 0);
        let token = lexer.next().unwrap().unwrap();
        assert_eq!(lexer.unquote(token).unwrap(), "a\"b\\c\n");
        let token = lexer.next().unwrap().unwrap();
        assert_eq!(lexer.unquote(token), Err('q'));
    }

    #[test]
    fn a_string_ends_on_its_line() {
        let mut lexer = Lexer::new("\"open\nnext", 0);
        assert_eq!(lexer.next(), Err(Unterminated(Span { file: 0, start: 0, end: 5 })));
        assert_eq!(words("\"x\\"), Vec::<&str>::new());
    }
}
