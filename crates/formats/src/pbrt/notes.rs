//! Messages that would repeat: each kind is told once, with how often it arose.

use kaustika_scene::description::{Diagnostics, Severity, Span};

/// Messages collected by their text.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    entries: Vec<Note>,
}

#[derive(Clone, Debug)]
struct Note {
    severity: Severity,
    message: String,
    span: Span,
    count: usize,
}

impl Notes {
    /// Adds a note.
    pub fn note(&mut self, span: Span, message: impl Into<String>) {
        self.add(Severity::Note, span, message.into());
    }

    /// Adds a warning.
    pub fn warning(&mut self, span: Span, message: impl Into<String>) {
        self.add(Severity::Warning, span, message.into());
    }

    fn add(&mut self, severity: Severity, span: Span, message: String) {
        match self.entries.iter_mut().find(|n| n.message == message) {
            Some(n) => n.count += 1,
            None => self.entries.push(Note { severity, message, span, count: 1 }),
        }
    }

    /// Moves everything into the diagnostics, each at the place where it arose first.
    pub fn tell(self, diag: &mut Diagnostics) {
        for n in self.entries {
            let d = match n.severity {
                Severity::Note => diag.note(n.span, n.message),
                _ => diag.warning(n.span, n.message),
            };
            if n.count > 1 {
                d.label(format!("the first of {}", n.count));
            }
        }
    }
}
