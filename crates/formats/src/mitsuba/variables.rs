//! `$name` in attributes: defines from outside, `<default>` elements, substitution.

/// A define and whether it was used.
#[derive(Clone, Debug)]
struct Variable {
    name: String,
    value: String,
    used: bool,
}

/// What `$names` stand for.
#[derive(Clone, Debug, Default)]
pub(super) struct Variables {
    /// Longest names first, so that `$width2` is not read as `$width` and a 2.
    entries: Vec<Variable>,
}

impl Variables {
    /// Values given from outside.
    pub(super) fn new(defines: &[(String, String)]) -> Variables {
        let mut variables = Variables::default();
        for (name, value) in defines {
            variables.entries.retain(|v| v.name != *name);
            variables.insert(name, value, false);
        }
        variables
    }

    /// A `<default>`: holds unless the name is defined already.
    pub(super) fn set_default(&mut self, name: &str, value: &str) {
        if !self.entries.iter().any(|v| v.name == name) {
            // Defaults that nothing uses are harmless: they count as used.
            self.insert(name, value, true);
        }
    }

    /// The text with every `$name` replaced, `\$` standing for `$`; the error is the name that
    /// is not defined.
    pub(super) fn substitute(&mut self, text: &str) -> Result<String, String> {
        let mut out = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            let (before, after) = (&rest[..at], &rest[at + 1..]);
            if let Some(kept) = before.strip_suffix('\\') {
                out.push_str(kept);
                out.push('$');
                rest = after;
                continue;
            }
            out.push_str(before);
            let found = self.entries.iter_mut().find(|v| after.starts_with(v.name.as_str()));
            let Some(variable) = found else {
                let end = after.find(|c: char| !c.is_alphanumeric() && c != '_');
                return Err(after[..end.unwrap_or(after.len())].to_string());
            };
            variable.used = true;
            out.push_str(&variable.value);
            rest = &after[variable.name.len()..];
        }
        out.push_str(rest);
        Ok(out)
    }

    /// Names from outside that nothing used.
    pub(super) fn unused(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().filter(|v| !v.used).map(|v| v.name.as_str())
    }

    /// All names.
    pub(super) fn names(&self) -> Vec<&str> {
        self.entries.iter().map(|v| v.name.as_str()).collect()
    }

    fn insert(&mut self, name: &str, value: &str, used: bool) {
        if name.is_empty() {
            return;
        }
        let at = self.entries.partition_point(|v| v.name.len() > name.len());
        let variable = Variable { name: name.to_string(), value: value.to_string(), used };
        self.entries.insert(at, variable);
    }
}
