//! `<transform>` and `<animation>` elements.

use super::document::{ObjectId, Value};
use super::matrix::{self, Matrix};
use super::parse::{FileContext, Parser};
use super::properties::Attributes;
use super::values;
use kaustika_scene::description::Span;
use roxmltree::Node;

/// Elements inside a transform.
const STEPS: &[&str] = &["translate", "rotate", "scale", "lookat", "matrix"];

impl Parser {
    pub(super) fn transform_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let Some(a) = self.attributes(ctx, node, &["name"], &[]) else { return };
        if let Some(matrix) = self.steps(ctx, node) {
            self.set(ctx, node, parent, &a, Ok(Value::Transform(matrix)));
        }
    }

    /// Mitsuba 0.6's moving transforms.
    pub(super) fn animation_value(&mut self, ctx: &FileContext, node: Node, parent: ObjectId) {
        let Some(a) = self.attributes(ctx, node, &["name"], &[]) else { return };
        let keys: Vec<Node> = node.children().filter(Node::is_element).collect();
        if keys.is_empty() {
            self.diagnostics.error(ctx.tag_span(node), "an animation needs a `<transform>`");
            return;
        }
        let made: Option<Vec<_>> = keys.iter().map(|key| self.key(ctx, *key)).collect();
        let Some(mut made) = made else { return };
        made.sort_by(|a, b| a.0.total_cmp(&b.0));
        let value = match made[..] {
            [(_, matrix)] => Value::Transform(matrix),
            _ => Value::Motion(made),
        };
        self.set(ctx, node, parent, &a, Ok(value));
    }

    /// A transform and its time.
    fn key(&mut self, ctx: &FileContext, node: Node) -> Option<(f64, Matrix)> {
        let a = self.attributes(ctx, node, &["time"], &[])?;
        let time = a.get("time")?;
        Some((self.check(values::number(&time.value), time.span)?, self.steps(ctx, node)?))
    }

    fn steps(&mut self, ctx: &FileContext, node: Node) -> Option<Matrix> {
        let mut matrix = matrix::IDENTITY;
        let mut complete = true;
        for step in node.children().filter(Node::is_element) {
            match self.step(ctx, step) {
                Some(m) => matrix = matrix::product(&m, &matrix),
                None => complete = false,
            }
        }
        complete.then_some(matrix)
    }

    fn step(&mut self, ctx: &FileContext, node: Node) -> Option<Matrix> {
        let tag = node.tag_name().name();
        let span = ctx.tag_span(node);
        match tag {
            "translate" => {
                let a = self.attributes(ctx, node, &[], &["x", "y", "z", "value"])?;
                self.components(&a, 0.0, span).map(matrix::translate)
            }
            "scale" => {
                let a = self.attributes(ctx, node, &[], &["x", "y", "z", "value"])?;
                self.components(&a, 1.0, span).map(matrix::scale)
            }
            "rotate" => {
                let a = self.attributes(ctx, node, &["angle"], &["x", "y", "z", "value"])?;
                let axis = self.components(&a, 0.0, span)?;
                let angle =
                    self.check(values::number(&a.get("angle")?.value), a.get("angle")?.span)?;
                let matrix = matrix::rotate(angle, axis).ok_or("the rotation axis is zero");
                self.check(matrix, span)
            }
            "lookat" | "lookAt" => {
                let a = self.attributes(ctx, node, &["origin", "target"], &["up"])?;
                let mut point = |name: &str| match a.get(name) {
                    Some(p) => self.check(values::triple(&p.value, false), p.span),
                    None => Some([0.0; 3]),
                };
                let (origin, target, up) = (point("origin")?, point("target")?, point("up")?);
                let matrix = matrix::look_at(origin, target, up)
                    .ok_or("`origin`, `target` and `up` do not span a frame: `target` must differ from `origin`, and `up` from the direction between them");
                self.check(matrix, span)
            }
            "matrix" => {
                let a = self.attributes(ctx, node, &["value"], &[])?;
                let value = a.get("value")?;
                self.check(matrix_value(&value.value), value.span)
            }
            _ => {
                self.diagnostics
                    .error(span, format!("unknown element `<{tag}>` in a transform"))
                    .nearest(tag, STEPS);
                None
            }
        }
    }

    /// `value` (one or three numbers) or x, y, z.
    fn components(&mut self, a: &Attributes, missing: f64, span: Span) -> Option<[f64; 3]> {
        let separate = ["x", "y", "z"].map(|c| a.get(c));
        if let Some(value) = a.get("value") {
            if separate.iter().any(Option::is_some) {
                self.diagnostics.error(span, "`value` and `x`, `y`, `z` exclude each other");
                return None;
            }
            return self.check(values::triple(&value.value, true), value.span);
        }
        let mut out = [missing; 3];
        for (o, attribute) in out.iter_mut().zip(separate) {
            if let Some(attribute) = attribute {
                *o = self.check(values::number(&attribute.value), attribute.span)?;
            }
        }
        Some(out)
    }

    fn check<T>(&mut self, value: Result<T, impl Into<String>>, span: Span) -> Option<T> {
        value.map_err(|e| self.diagnostics.error(span, e)).ok()
    }
}

/// 16 numbers by rows, or the 9 of the upper left 3x3 block.
fn matrix_value(text: &str) -> Result<Matrix, String> {
    let parts = values::tokens(text);
    let n = match parts.len() {
        16 => 4,
        9 => 3,
        count => return Err(format!("expected 16 or 9 numbers, found {count}")),
    };
    let mut m = matrix::IDENTITY;
    for i in 0..n {
        for j in 0..n {
            m[i][j] = values::number(parts[i * n + j])?;
        }
    }
    Ok(m)
}
