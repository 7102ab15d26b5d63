//! Elements that give an object a parameter, and attributes with their variables replaced.

use super::document::{Dialect, ObjectId, Parameter, SpectrumValue, Value};
use super::parse::{FileContext, Parser};
use super::values;
use kaustika_scene::description::{Span, nearest_name};
use roxmltree::Node;
use std::cell::Cell;

/// An attribute with its variables replaced.
pub(super) struct Attribute {
    name: String,
    pub(super) value: String,
    pub(super) span: Span,
}

/// The attributes of an element.
pub(super) struct Attributes {
    list: Vec<Attribute>,
}

impl Attributes {
    pub(super) fn get(&self, name: &str) -> Option<&Attribute> {
        self.list.iter().find(|a| a.name == name)
    }

    pub(super) fn text(&self, name: &str) -> String {
        self.get(name).map(|a| a.value.clone()).unwrap_or_default()
    }
}

impl Parser {
    pub(super) fn simple_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let tag = node.tag_name().name();
        let Some(a) = self.attributes(ctx, node, &["name", "value"], &["intent"]) else { return };
        let text = a.text("value");
        let value = match tag {
            "boolean" => values::boolean(&text).map(Value::Boolean),
            "integer" => values::integer(&text).map(Value::Integer),
            "float" => values::number(&text).map(Value::Float),
            "rgb" => values::color(&text).map(Value::Rgb),
            "srgb" => {
                values::color(&text).map(|c| Value::Rgb(c.map(kaustika_spectra::srgb_to_linear)))
            }
            _ => Ok(Value::String(text)),
        };
        self.set(ctx, node, parent, &a, value);
    }

    pub(super) fn vector_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let Some(a) = self.attributes(ctx, node, &["name"], &["value", "x", "y", "z"]) else {
            return;
        };
        let value = if a.get("value").is_some() {
            values::triple(&a.text("value"), true)
        } else {
            match ["x", "y", "z"].iter().find(|c| a.get(c).is_none()) {
                Some(missing) => Err(format!("missing attribute `{missing}`")),
                None => ["x", "y", "z"]
                    .iter()
                    .map(|c| values::number(&a.text(c)))
                    .collect::<Result<Vec<_>, _>>()
                    .map(|v| [v[0], v[1], v[2]]),
            }
        };
        self.set(ctx, node, parent, &a, value.map(Value::Vector));
    }

    pub(super) fn spectrum_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let optional = ["value", "filename", "intent"];
        let Some(a) = self.attributes(ctx, node, &["name"], &optional) else { return };
        let value = match (a.get("value"), a.get("filename")) {
            (Some(v), None) => self.inline_spectrum(ctx, &v.value),
            (None, Some(f)) => {
                let found = self.document_file(ctx.file, &f.value);
                let text = found
                    .ok_or_else(|| format!("can't find the spectrum file `{}`", f.value))
                    .and_then(|path| {
                        std::fs::read_to_string(&path)
                            .map_err(|e| format!("can't read `{}`: {e}", path.display()))
                    });
                text.and_then(|t| {
                    kaustika_spectra::parse_spd(&t).map_err(|e| format!("`{}`, {e}", f.value))
                })
                .map(|desc| Value::Spectrum(SpectrumValue::Table(desc)))
            }
            _ => Err("a spectrum needs either `value` or `filename`".to_string()),
        };
        self.set(ctx, node, parent, &a, value);
    }

    /// One number, pairs, or three numbers: 0.6 was mostly built with three spectral samples,
    /// which are then linear RGB.
    fn inline_spectrum(&self, ctx: &FileContext, text: &str) -> Result<Value, String> {
        let count = values::tokens(text).len();
        if ctx.dialect == Dialect::V06 && count == 3 && !text.contains(':') {
            return values::color(text).map(Value::Rgb);
        }
        values::spectrum(text).map(Value::Spectrum)
    }

    pub(super) fn blackbody_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let Some(a) = self.attributes(ctx, node, &["name", "temperature"], &["scale"]) else {
            return;
        };
        let text = a.text("temperature");
        let kelvin = values::number(text.trim().trim_end_matches(['K', 'k']));
        let scale = a.get("scale").map_or(Ok(1.0), |s| values::number(&s.value));
        let value = kelvin.and_then(|kelvin| {
            scale.map(|scale| Value::Blackbody { kelvin: kelvin as f32, scale: scale as f32 })
        });
        self.set(ctx, node, parent, &a, value);
    }

    pub(super) fn reference(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let Some(a) = self.attributes(ctx, node, &["id"], &["name"]) else { return };
        let value = Value::Reference(a.text("id"));
        let value_span = a.get("id").map(|id| id.span);
        self.add(parent, &a.text("name"), value, ctx.tag_span(node), value_span);
    }

    /// Adds the value, or reports why there is none, at the attribute it came from.
    pub(super) fn set(
        &mut self,
        ctx: &FileContext,
        node: Node,
        parent: ObjectId,
        attributes: &Attributes,
        value: Result<Value, String>,
    ) {
        let of = ["value", "filename", "temperature"];
        let at = of.iter().find_map(|n| attributes.get(n)).map(|a| a.span);
        match value {
            Ok(value) => {
                let name = attributes.text("name");
                self.warn_if_given(parent, &name, ctx.tag_span(node));
                self.add(parent, &name, value, ctx.tag_span(node), at);
            }
            Err(message) => {
                self.diagnostics.error(at.unwrap_or(ctx.tag_span(node)), message);
            }
        }
    }

    fn warn_if_given(&mut self, parent: ObjectId, name: &str, span: Span) {
        if self.document.object(parent).has(name) {
            self.diagnostics
                .warning(span, format!("parameter `{name}` is given twice"))
                .label("this one counts");
        }
    }

    pub(super) fn add(
        &mut self,
        parent: ObjectId,
        name: &str,
        value: Value,
        span: Span,
        value_span: Option<Span>,
    ) {
        self.document.objects[parent.0].parameters.push(Parameter {
            name: name.to_string(),
            written: name.to_string(),
            value,
            span,
            value_span: value_span.unwrap_or(span),
            used: Cell::new(false),
        });
    }

    /// The attributes of an element with variables replaced; `None` if a required one is missing
    /// or a variable is not defined.
    pub(super) fn attributes(
        &mut self,
        ctx: &FileContext,
        node: Node,
        required: &[&str],
        optional: &[&str],
    ) -> Option<Attributes> {
        let tag = node.tag_name().name();
        let mut list = Vec::new();
        let mut complete = true;
        for attribute in node.attributes() {
            let span = ctx.span(attribute.range_value());
            let name = attribute.name();
            // Roots of included files have a version, whatever they are.
            if name == "version" && node.parent().is_some_and(|p| p.is_root()) {
                continue;
            }
            if !required.contains(&name) && !optional.contains(&name) {
                let known: Vec<&str> = required.iter().chain(optional).copied().collect();
                self.diagnostics
                    .warning(
                        ctx.span(attribute.range_qname()),
                        format!("`<{tag}>` has no attribute `{name}`"),
                    )
                    .nearest(name, &known);
                continue;
            }
            match self.variables.substitute(attribute.value()) {
                Ok(value) => list.push(Attribute { name: name.to_string(), value, span }),
                Err(variable) => {
                    let known = self.variables.names();
                    let hint = match nearest_name(&variable, &known) {
                        Some(near) => format!("did you mean `${near}`?"),
                        None => format!("pass `-D {variable}=...` or add a `<default>` above"),
                    };
                    self.diagnostics
                        .error(span, format!("undefined parameter `${variable}`"))
                        .hint(hint);
                    complete = false;
                }
            }
        }
        for name in required {
            if !node.has_attribute(*name) {
                self.diagnostics
                    .error(ctx.tag_span(node), format!("missing attribute `{name}` in `<{tag}>`"));
                complete = false;
            }
        }
        complete.then_some(Attributes { list })
    }
}
