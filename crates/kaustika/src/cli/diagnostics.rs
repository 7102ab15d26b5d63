//! What there is to say about a scene's files, with the lines in question.

use ariadne::{Cache, CharSet, Config, IndexType, Label, Report, ReportKind, Source};
use kaustika::scene::BuildError;
use kaustika::scene::description::{Diagnostic, Diagnostics, Severity, SourceMap, Span};
use std::collections::{BTreeMap, HashMap};
use std::fmt::{Debug, Display};
use std::io::{self, IsTerminal, Write, stderr};
use std::ops::Range;

/// Lines longer than this are not shown: machines wrote them.
const LONGEST_LINE: usize = 240;
/// Messages longer than this lose their middle: a file without blanks is one long word.
const LONGEST_MESSAGE: usize = 600;

/// Shows everything on stderr; if `quiet`, errors alone.
pub fn show(sources: &SourceMap, diagnostics: &Diagnostics, quiet: bool) {
    let least = if quiet { Severity::Error } else { Severity::Note };
    // A closed stderr leaves nobody to tell.
    let _ = write(&mut stderr().lock(), sources, diagnostics, least, stderr().is_terminal());
}

/// Shows why a scene could not be built.
pub fn show_build_error(sources: &SourceMap, error: &BuildError) {
    let mut diagnostics = Diagnostics::default();
    diagnostics.error(error.span, error.message.clone());
    show(sources, &diagnostics, false);
}

/// Writes what is at least as grave as `least`: the same message once with a count, errors last,
/// and with errors a line that sums up.
fn write(
    out: &mut dyn Write,
    sources: &SourceMap,
    diagnostics: &Diagnostics,
    least: Severity,
    color: bool,
) -> io::Result<()> {
    let mut groups: Vec<(&Diagnostic, usize)> = Vec::new();
    let mut known: BTreeMap<(Severity, &str), usize> = BTreeMap::new();
    for d in diagnostics.entries.iter().filter(|d| d.severity >= least) {
        let at = *known.entry((d.severity, &d.message)).or_insert(groups.len());
        match groups.get_mut(at) {
            Some((_, count)) => *count += 1,
            None => groups.push((d, 1)),
        }
    }
    groups.sort_by_key(|(d, _)| d.severity);
    let mut texts = Texts { sources, read: HashMap::new() };
    for (d, count) in groups {
        write_one(out, &mut texts, d, count, color)?;
    }
    if diagnostics.has_errors() {
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let errors = diagnostics.count(Severity::Error);
        let warnings = diagnostics.count(Severity::Warning);
        let (e, w) = (plural(errors), plural(warnings));
        writeln!(out, "{errors} error{e}, {warnings} warning{w}")?;
    }
    Ok(())
}

fn write_one(
    out: &mut dyn Write,
    texts: &mut Texts,
    d: &Diagnostic,
    count: usize,
    color: bool,
) -> io::Result<()> {
    let (word, kind) = match d.severity {
        Severity::Note => ("note", ReportKind::Custom("Note", ariadne::Color::Blue)),
        Severity::Warning => ("warning", ReportKind::Warning),
        Severity::Error => ("error", ReportKind::Error),
    };
    let mut message = d.message.clone();
    if count > 1 {
        let places = if count == 2 { "place" } else { "places" };
        message += &format!(" (here and in {} more {places})", count - 1);
    }
    let message = printable(&message);
    let range = d.span.and_then(|s| texts.range(s)).filter(|_| d.severity > Severity::Note);
    let (Some(span), Some(range)) = (d.span, range) else {
        let place = d.span.map_or(String::new(), |s| texts.sources.location(s) + ": ");
        writeln!(out, "{word}: {place}{message}")?;
        if let Some(hint) = &d.hint {
            writeln!(out, "  help: {hint}")?;
        }
        return Ok(());
    };
    let at = (span.file, range);
    let label = match d.label.as_str() {
        "" => "here",
        label => label,
    };
    let charset = if color { CharSet::Unicode } else { CharSet::Ascii };
    let config = Config::default()
        .with_index_type(IndexType::Byte)
        .with_color(color)
        .with_char_set(charset)
        .with_tab_width(4);
    let mut report = Report::build(kind, at.clone())
        .with_config(config)
        .with_message(message)
        .with_label(Label::new(at).with_message(label));
    if let Some(hint) = &d.hint {
        report.set_help(hint);
    }
    report.finish().write(texts, out)
}

/// True for what a terminal would obey or hide.
fn is_unprintable(c: char) -> bool {
    c.is_control() && c != '\t'
}

/// The message without control characters, which a broken file may have put into it, and without
/// the middle of what is too long to be read.
fn printable(message: &str) -> String {
    let escape = |c: char| match is_unprintable(c) {
        true => c.escape_default().collect::<String>(),
        false => c.to_string(),
    };
    let count = message.chars().count();
    if count <= LONGEST_MESSAGE {
        return message.chars().map(escape).collect();
    }
    let part = LONGEST_MESSAGE / 3;
    let start: String = message.chars().take(part).map(escape).collect();
    let end: String = message.chars().skip(count - part).map(escape).collect();
    format!("{start} [...] {end}")
}

/// The files as ariadne wants them, cut into lines when first needed.
struct Texts<'a> {
    sources: &'a SourceMap,
    read: HashMap<u32, Source<&'a str>>,
}

impl Texts<'_> {
    /// The bytes of a span, if they can be shown: of a text file, on a line of sane length.
    fn range(&self, span: Span) -> Option<Range<usize>> {
        let text = &self.sources.files.get(span.file as usize)?.text;
        let (start, end) = (span.start as usize, span.end as usize);
        if start >= text.len() || !text.is_char_boundary(start) {
            return None;
        }
        // Only the first line: what follows is rarely the point.
        let line_start = text[..start].rfind('\n').map_or(0, |n| n + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |n| start + n);
        let end = end.clamp(start, line_end);
        let fits = line_end - line_start <= LONGEST_LINE && text.is_char_boundary(end);
        let fits = fits && !text[line_start..line_end].trim_end().contains(is_unprintable);
        fits.then_some(start..end.max(start))
    }
}

impl<'a> Cache<u32> for &mut Texts<'a> {
    type Storage = &'a str;

    fn fetch(&mut self, id: &u32) -> Result<&Source<&'a str>, impl Debug> {
        let Some(file) = self.sources.files.get(*id as usize) else {
            return Err("no such file");
        };
        Ok(self.read.entry(*id).or_insert_with(|| Source::from(file.text.as_str())))
    }

    fn display<'b>(&self, id: &'b u32) -> Option<impl Display + 'b> {
        let file = self.sources.files.get(*id as usize)?;
        Some(file.path.display().to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika::scene::description::SourceFile;

    fn shown(diagnostics: &Diagnostics) -> String {
        let text = "Film \"rgb\"\nShape \"sphär\" \"float radius\" 1\n".into();
        let sources = SourceMap { files: vec![SourceFile { path: "a.pbrt".into(), text }] };
        let mut out = Vec::new();
        write(&mut out, &sources, diagnostics, Severity::Note, false).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn errors_show_the_line_and_the_place() {
        let mut d = Diagnostics::default();
        let span = Span { file: 0, start: 17, end: 25 };
        d.error(span, "no such shape").label("unknown").hint("did you mean `sphere`?");
        let text = shown(&d);
        for part in ["a.pbrt:2:7", "no such shape", "\"sphär\"", "unknown", "`sphere`"] {
            assert!(text.contains(part), "{part} in\n{text}");
        }
        assert!(text.ends_with("1 error, 0 warnings\n"), "{text}");
        assert!(!text.contains('\u{1b}'), "{text}");
    }

    #[test]
    fn the_same_warning_is_shown_once() {
        let mut d = Diagnostics::default();
        for start in 0..3 {
            d.warning(Span { file: 0, start, end: start + 1 }, "not supported");
        }
        d.warning(None, "something else");
        let text = shown(&d);
        assert_eq!(text.matches("not supported").count(), 1, "{text}");
        assert!(text.contains("in 2 more places") && text.contains("something else"), "{text}");
        assert!(!text.contains("error"), "{text}");
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let text = "Shape \u{1b}[2J\n".to_string();
        let sources = SourceMap { files: vec![SourceFile { path: "a.pbrt".into(), text }] };
        let mut d = Diagnostics::default();
        d.error(Span { file: 0, start: 6, end: 10 }, "unknown shape `\u{1b}[2J`");
        d.error(None, "long".repeat(1000));
        let mut out = Vec::new();
        write(&mut out, &sources, &d, Severity::Note, false).unwrap();
        let shown = String::from_utf8(out).unwrap();
        assert!(shown.contains("a.pbrt:1:7: unknown shape `\\u{1b}[2J`"), "{shown}");
        assert!(!shown.contains('\u{1b}') && shown.len() < 800, "{shown}");
    }

    #[test]
    fn places_beyond_the_text_are_no_trouble() {
        let mut d = Diagnostics::default();
        d.error(Span { file: 0, start: 900, end: 901 }, "past the end");
        d.error(Span { file: 7, start: 0, end: 1 }, "in no file");
        d.error(Span { file: 0, start: 0, end: 900 }, "too long");
        let text = shown(&d);
        assert!(text.contains("past the end") && text.contains("in no file"), "{text}");
        assert!(text.ends_with("3 errors, 0 warnings\n"), "{text}");
    }
}
