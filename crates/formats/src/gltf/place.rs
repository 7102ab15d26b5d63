//! Where in the text of a JSON file a value stands, for messages.

/// Byte of a line and column, both from 1 and columns in bytes.
pub(super) fn of_line_column(text: &str, line: usize, column: usize) -> u32 {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (before + column.saturating_sub(1)).min(text.len()) as u32
}

/// First byte and end of the value at `path`, as [`super::json::Json`] writes it. The text is
/// JSON that was parsed before.
pub(super) fn find(text: &str, path: &str) -> Option<(usize, usize)> {
    let mut scan = Scan { text: text.as_bytes(), at: 0 };
    scan.blank();
    for step in path.split(['.', '[']).filter(|s| !s.is_empty()) {
        match step.strip_suffix(']') {
            Some(index) => scan.enter_list(index.parse().ok()?)?,
            None => scan.enter_object(step)?,
        }
    }
    let start = scan.at;
    scan.skip_value()?;
    Some((start, scan.at))
}

struct Scan<'a> {
    text: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn blank(&mut self) {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// Passes one byte and the blanks after it.
    fn take(&mut self, byte: u8) -> Option<()> {
        (self.text.get(self.at) == Some(&byte)).then(|| self.at += 1)?;
        self.blank();
        Some(())
    }

    fn string(&mut self) -> Option<&[u8]> {
        let start = self.at + 1;
        self.at = start;
        loop {
            match self.text.get(self.at)? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        let end = self.at - 1;
        self.blank();
        self.text.get(start..end)
    }

    /// To the value of a member.
    fn enter_object(&mut self, key: &str) -> Option<()> {
        self.take(b'{')?;
        loop {
            let found = self.string()? == key.as_bytes();
            self.take(b':')?;
            if found {
                return Some(());
            }
            self.skip_value()?;
            self.blank();
            self.take(b',')?;
        }
    }

    /// To an item of a list.
    fn enter_list(&mut self, index: usize) -> Option<()> {
        self.take(b'[')?;
        for _ in 0..index {
            self.skip_value()?;
            self.blank();
            self.take(b',')?;
        }
        Some(())
    }

    /// To the end of the value here.
    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0usize;
        loop {
            match self.text.get(self.at)? {
                b'"' => {
                    let end = {
                        self.string()?;
                        self.at
                    };
                    // Blanks belong to what follows.
                    self.at = self.text[..end].iter().rposition(|b| *b == b'"')? + 1;
                }
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' if depth == 0 => return None,
                b',' | b':' => self.at += 1,
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => {
                    let stops = b",:]} \t\r\n";
                    while self.text.get(self.at).is_some_and(|b| !stops.contains(b)) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found() {
        let text = r#"{ "a": [1, {"b\"": [], "c": "x,}" }, true], "d" : {"e": -1.5e3 } }"#;
        let at = |path| find(text, path).map(|(s, e)| &text[s..e]);
        assert_eq!(at("a[0]"), Some("1"));
        assert_eq!(at("a[1].c"), Some("\"x,}\""));
        assert_eq!(at("a[2]"), Some("true"));
        assert_eq!(at("d.e"), Some("-1.5e3"));
        assert_eq!(at("d"), Some("{\"e\": -1.5e3 }"));
        assert_eq!(at(""), Some(text));
        for missing in ["a[3]", "b", "d.e.f", "a.b"] {
            assert_eq!(at(missing), None, "{missing}");
        }
        assert_eq!(of_line_column("ab\ncd", 2, 2), 4);
    }
}
