//! JSON values that know where they stand: `materials[3].pbrMetallicRoughness`.

use kaustika_scene::description::Severity;
use serde_json::Value;

/// What is wrong with a value.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// Its path, or that of the value that lacks something.
    pub path: String,
    /// What is the matter.
    pub message: String,
    /// What to do.
    pub hint: Option<String>,
    /// Whether the scene can be rendered without it.
    pub severity: Severity,
}

impl Fault {
    /// Adds advice.
    pub fn hint(mut self, hint: impl Into<String>) -> Fault {
        self.hint = Some(hint.into());
        self
    }

    /// Makes it a warning.
    pub fn mild(mut self) -> Fault {
        self.severity = Severity::Warning;
        self
    }
}

/// A value and the way to it.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    value: &'a Value,
    /// Where it stands.
    pub path: String,
}

impl<'a> Json<'a> {
    /// The whole file.
    pub fn root(value: &'a Value) -> Json<'a> {
        Json { value, path: String::new() }
    }

    /// A fault at this value.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        let (path, message) = (self.path.clone(), message.into());
        Fault { path, message, hint: None, severity: Severity::Error }
    }

    /// `expected ..., found ...`.
    fn expected(&self, what: &str) -> Fault {
        let found = match self.value {
            Value::Null => "null".into(),
            Value::Bool(b) => b.to_string(),
            Value::Number(n) => n.to_string(),
            Value::String(s) => format!("\"{}\"", s.chars().take(40).collect::<String>()),
            Value::Array(list) => format!("a list of {}", list.len()),
            Value::Object(_) => "an object".into(),
        };
        self.fault(format!("expected {what}, found {found}"))
    }

    fn child(&self, key: &str) -> String {
        match self.path.as_str() {
            "" => key.into(),
            path => format!("{path}.{key}"),
        }
    }

    /// A member, if it is there.
    pub fn get(&self, key: &str) -> Option<Json<'a>> {
        let value = self.value.as_object()?.get(key)?;
        Some(Json { value, path: self.child(key) })
    }

    /// A member that has to be there.
    pub fn require(&self, key: &str) -> Result<Json<'a>, Fault> {
        self.get(key).ok_or_else(|| self.fault(format!("`{key}` is missing")))
    }

    /// An extension's object.
    pub fn extension(&self, name: &str) -> Option<Json<'a>> {
        self.get("extensions")?.get(name)
    }

    /// Items of a list; 0 of anything else.
    pub fn len(&self) -> usize {
        self.value.as_array().map_or(0, Vec::len)
    }

    fn items(&self) -> Result<Vec<Json<'a>>, Fault> {
        let Some(list) = self.value.as_array() else { return Err(self.expected("a list")) };
        let item = |(i, value)| Json { value, path: format!("{}[{i}]", self.path) };
        Ok(list.iter().enumerate().map(item).collect())
    }

    /// The items of a list, none where it is missing.
    pub fn list(&self, key: &str) -> Result<Vec<Json<'a>>, Fault> {
        self.get(key).map_or(Ok(Vec::new()), |v| v.items())
    }

    /// This value as text.
    pub fn text(&self) -> Option<&'a str> {
        self.value.as_str()
    }

    /// Text, if it is there.
    pub fn string(&self, key: &str) -> Result<Option<&'a str>, Fault> {
        match self.get(key) {
            None => Ok(None),
            Some(v) => v.text().map(Some).ok_or_else(|| v.expected("text")),
        }
    }

    /// The name of a thing, empty if it has none.
    pub fn name(&self) -> &'a str {
        self.get("name").and_then(|n| n.text()).unwrap_or("")
    }

    /// A truth value.
    pub fn truth(&self, key: &str, default: bool) -> Result<bool, Fault> {
        match self.get(key) {
            None => Ok(default),
            Some(v) => v.value.as_bool().ok_or_else(|| v.expected("true or false")),
        }
    }

    /// This value as a finite number.
    fn number(&self) -> Result<f32, Fault> {
        match self.value.as_f64().map(|v| v as f32) {
            Some(v) if v.is_finite() => Ok(v),
            _ => Err(self.expected("a number")),
        }
    }

    /// A number, if it is there.
    pub fn float_if(&self, key: &str) -> Result<Option<f32>, Fault> {
        self.get(key).map(|v| v.number()).transpose()
    }

    /// A number.
    pub fn float(&self, key: &str, default: f32) -> Result<f32, Fault> {
        Ok(self.float_if(key)?.unwrap_or(default))
    }

    /// A list of N numbers, if it is there.
    pub fn floats_if<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>, Fault> {
        let Some(list) = self.get(key) else { return Ok(None) };
        let items = list.items()?;
        if items.len() != N {
            return Err(list.expected(&format!("a list of {N} numbers")));
        }
        let mut out = [0.0; N];
        for (o, item) in out.iter_mut().zip(items) {
            *o = item.number()?;
        }
        Ok(Some(out))
    }

    /// A list of N numbers.
    pub fn floats<const N: usize>(&self, key: &str, default: [f32; N]) -> Result<[f32; N], Fault> {
        Ok(self.floats_if(key)?.unwrap_or(default))
    }

    /// This value as a whole number from 0.
    pub fn whole(&self) -> Result<usize, Fault> {
        let whole = self.value.as_u64().and_then(|v| usize::try_from(v).ok());
        // Some writers put a point behind whole numbers.
        let rounded = self.value.as_f64().filter(|v| v.fract() == 0.0 && (0.0..1e15).contains(v));
        whole.or(rounded.map(|v| v as usize)).ok_or_else(|| self.expected("a whole number from 0"))
    }

    /// A whole number from 0, if it is there.
    pub fn size_if(&self, key: &str) -> Result<Option<usize>, Fault> {
        self.get(key).map(|v| v.whole()).transpose()
    }

    /// A whole number from 0.
    pub fn size(&self, key: &str, default: usize) -> Result<usize, Fault> {
        Ok(self.size_if(key)?.unwrap_or(default))
    }

    /// The item of `list` that a member names by its number; `what` is what is in the list.
    pub fn refer<'b, T>(
        &self,
        key: &str,
        list: &'b [T],
        what: &str,
    ) -> Result<Option<(usize, &'b T)>, Fault> {
        let Some(v) = self.get(key) else { return Ok(None) };
        v.pick(list, what).map(Some)
    }

    /// The item of `list` whose number this value is.
    pub fn pick<'b, T>(&self, list: &'b [T], what: &str) -> Result<(usize, &'b T), Fault> {
        let i = self.whole()?;
        match list.get(i) {
            Some(item) => Ok((i, item)),
            None => Err(self.fault(format!(
                "there is no {what} {i}: the file has {}, counted from 0",
                list.len()
            ))),
        }
    }
}
