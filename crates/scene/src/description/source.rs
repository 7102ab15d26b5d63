//! Where in which file something stands, and what is to be said about it.

use std::path::PathBuf;

/// A file that took part in describing the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceFile {
    /// Path as it was opened.
    pub path: PathBuf,
    /// Its text (decompressed), for snippets in messages; empty for binary files.
    pub text: String,
}

/// All files read, main file first. A [`Span`] points into it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceMap {
    /// The files, in the order they were opened.
    pub files: Vec<SourceFile>,
}

/// A stretch of bytes of one file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Index into [`SourceMap::files`].
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl SourceMap {
    /// Line and column (both from 1, columns in characters) of a span's start.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let Some(file) = self.files.get(span.file as usize) else { return (0, 0) };
        let at = floor_boundary(&file.text, span.start as usize);
        let before = &file.text[..at];
        let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
        (line, column)
    }

    /// `file:line:column` of a span.
    pub fn location(&self, span: Span) -> String {
        let (line, column) = self.line_column(span);
        match self.files.get(span.file as usize) {
            Some(f) => format!("{}:{line}:{column}", f.path.display()),
            None => "<built-in>".to_string(),
        }
    }
}

fn floor_boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// How grave a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Something worth knowing: a v3 file was upgraded, a default was taken.
    Note,
    /// The picture will differ from what the file asks; the message says what was used instead.
    Warning,
    /// The picture would be wrong: nothing is rendered.
    Error,
}

/// One message about the scene's source.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How grave.
    pub severity: Severity,
    /// What is the matter: lower case, no full stop.
    pub message: String,
    /// Where.
    pub span: Option<Span>,
    /// What stands there, shown under the snippet; may be empty.
    pub label: String,
    /// What to do, such as the nearest known name.
    pub hint: Option<String>,
}

/// Messages in the order they arose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// The messages.
    pub entries: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Adds an error and returns it for further detail.
    pub fn error(
        &mut self,
        span: impl Into<Option<Span>>,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        self.push(Severity::Error, span.into(), message.into())
    }

    /// Adds a warning and returns it for further detail.
    pub fn warning(
        &mut self,
        span: impl Into<Option<Span>>,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        self.push(Severity::Warning, span.into(), message.into())
    }

    /// Adds a note and returns it for further detail.
    pub fn note(
        &mut self,
        span: impl Into<Option<Span>>,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        self.push(Severity::Note, span.into(), message.into())
    }

    /// True if the scene can't be rendered.
    pub fn has_errors(&self) -> bool {
        self.count(Severity::Error) > 0
    }

    /// How many messages are of this severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.entries.iter().filter(|d| d.severity == severity).count()
    }

    fn push(&mut self, severity: Severity, span: Option<Span>, message: String) -> &mut Diagnostic {
        let d = Diagnostic { severity, message, span, label: String::new(), hint: None };
        self.entries.push(d);
        self.entries.last_mut().expect("one was just pushed")
    }
}

impl Diagnostic {
    /// Sets the text under the snippet.
    pub fn label(&mut self, label: impl Into<String>) -> &mut Self {
        self.label = label.into();
        self
    }

    /// Sets the advice.
    pub fn hint(&mut self, hint: impl Into<String>) -> &mut Self {
        self.hint = Some(hint.into());
        self
    }

    /// Gives the advice of [`known_names`].
    pub fn nearest(&mut self, found: &str, known: &[&str]) -> &mut Self {
        self.hint(known_names(found, known))
    }
}

/// Advice for who wrote `found`: the known name nearest to it, if one is near; else all of them.
pub fn known_names(found: &str, known: &[&str]) -> String {
    match nearest_name(found, known) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("known: {}", known.join(", ")),
    }
}

/// The known name with the smallest edit distance to `found`, if at most a third of it differs.
pub fn nearest_name<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let found = found.to_lowercase();
    known
        .iter()
        .map(|k| (edit_distance(&found, &k.to_lowercase()), *k))
        .min_by_key(|(d, _)| *d)
        .filter(|(d, _)| *d <= 1.max(found.chars().count() / 3))
        .map(|(_, k)| k)
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_guessed() {
        let known = ["diffuse", "dielectric", "conductor"];
        assert_eq!(nearest_name("difuse", &known), Some("diffuse"));
        assert_eq!(nearest_name("Dielectrik", &known), Some("dielectric"));
        assert_eq!(nearest_name("hair", &known), None);
    }

    #[test]
    fn lines_are_counted() {
        let file = SourceFile { path: "a.pbrt".into(), text: "one\ntwö three\n".into() };
        let map = SourceMap { files: vec![file] };
        assert_eq!(map.location(Span { file: 0, start: 9, end: 10 }), "a.pbrt:2:5");
        assert_eq!(map.line_column(Span { file: 0, start: 999, end: 999 }), (3, 1));
    }
}
