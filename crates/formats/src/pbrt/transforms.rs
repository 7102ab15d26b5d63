//! Directives that change the current transform.

use super::directive::DIRECTIVES;
use super::lexer::{Lexer, TokenKind};
use super::number::scan_f32;
use super::reader::{GivenUp, Reader};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::Span;

impl Reader {
    /// `Identity`, `Translate`, `Scale`, `Rotate`, `LookAt`, `Transform`, `ConcatTransform`.
    pub fn transform(&mut self, lexer: &mut Lexer, name: &str, span: Span) -> Result<(), GivenUp> {
        let vec = |v: &[f32]| Vec3::new(v[0], v[1], v[2]);
        let change = match name {
            "Identity" => Some(Transform::IDENTITY),
            "Translate" => Some(Transform::translate(vec(&self.numbers::<3>(lexer)?))),
            "Scale" => {
                let v = self.numbers::<3>(lexer)?;
                let scale = Transform::scale(vec(&v));
                if scale.is_none() {
                    self.diag
                        .error(span, format!("`Scale {} {} {}` is singular", v[0], v[1], v[2]))
                        .hint("no factor may be 0; a very small one flattens too");
                }
                scale
            }
            "Rotate" => {
                let v = self.numbers::<4>(lexer)?;
                let rotation = Transform::rotate(v[0], vec(&v[1..]));
                if rotation.is_none() {
                    self.diag.error(span, "the axis of `Rotate` is zero");
                }
                rotation
            }
            "LookAt" => {
                let v = self.numbers::<9>(lexer)?;
                let frame = Transform::look_at(vec(&v), vec(&v[3..]), vec(&v[6..]));
                if frame.is_none() {
                    let same = v[..3] == v[3..6];
                    let what = if same {
                        "eye and target are the same point"
                    } else {
                        "the up vector lies along the viewing direction"
                    };
                    self.diag.error(span, format!("`LookAt` is singular: {what}"));
                }
                frame.map(|t| t.inverse())
            }
            _ => {
                let v = self.matrix(lexer)?;
                // Columns come first in the file.
                let rows = std::array::from_fn(|i| std::array::from_fn(|j| v[4 * j + i]));
                let t = Transform::from_rows(rows);
                if t.is_none() {
                    self.diag.error(span, format!("the matrix of `{name}` is singular"));
                }
                t
            }
        };
        let Some(change) = change else { return Ok(()) };
        for (ctm, active) in self.state.ctm.iter_mut().zip(self.state.active) {
            if active {
                *ctm = match name {
                    "Identity" | "Transform" => change,
                    _ => *ctm * change,
                };
            }
        }
        Ok(())
    }

    /// Sixteen numbers in brackets.
    fn matrix(&mut self, lexer: &mut Lexer) -> Result<[f32; 16], GivenUp> {
        self.bracket(lexer, TokenKind::Open, "`[`")?;
        let m = self.numbers::<16>(lexer)?;
        self.bracket(lexer, TokenKind::Close, "`]`")?;
        Ok(m)
    }

    fn bracket(
        &mut self,
        lexer: &mut Lexer,
        kind: TokenKind,
        expected: &str,
    ) -> Result<(), GivenUp> {
        let before = lexer.pos;
        let token = self.required(lexer, expected)?;
        if token.kind == kind {
            return Ok(());
        }
        let found = lexer.slice(token.span);
        self.diag.error(token.span, format!("expected {expected}, found `{found}`"));
        lexer.pos = before;
        Err(GivenUp)
    }

    /// `N` numbers without brackets.
    pub fn numbers<const N: usize>(&mut self, lexer: &mut Lexer) -> Result<[f32; N], GivenUp> {
        let mut out = [0.0; N];
        for (i, v) in out.iter_mut().enumerate() {
            lexer.skip_blank();
            match scan_f32(lexer.bytes(), lexer.pos) {
                Some((value, end)) if value.is_finite() => {
                    *v = value;
                    lexer.pos = end;
                }
                scanned => {
                    let before = lexer.pos;
                    let token = self.required(lexer, "a number")?;
                    let found = lexer.slice(token.span);
                    let message = match scanned {
                        Some((v, _)) if v.is_infinite() => {
                            format!("number {} of {N}, `{found}`, is too large", i + 1)
                        }
                        _ => format!("expected number {} of {N}, found `{found}`", i + 1),
                    };
                    self.diag.error(token.span, message);
                    lexer.pos = before;
                    return Err(GivenUp);
                }
            }
        }
        Ok(out)
    }

    /// `TransformTimes`.
    pub fn transform_times(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let [start, end] = self.numbers::<2>(lexer)?;
        match start < end {
            true => self.times = [start, end],
            false => {
                let message =
                    format!("`TransformTimes {start} {end}` does not end after it starts");
                self.diag.error(span, message);
            }
        }
        Ok(())
    }

    /// `ActiveTransform`.
    pub fn active_transform(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let before = lexer.pos;
        let token = self.required(lexer, "`All`, `StartTime` or `EndTime`")?;
        let word = lexer.slice(token.span);
        self.state.active = match word {
            "All" => [true, true],
            "StartTime" => [true, false],
            "EndTime" => [false, true],
            _ => {
                let known = ["All", "StartTime", "EndTime"];
                let message = format!("expected `All`, `StartTime` or `EndTime`, found `{word}`");
                self.diag.error(token.span, message).nearest(word, &known);
                if DIRECTIVES.contains(&word) {
                    lexer.pos = before;
                }
                return Ok(());
            }
        };
        Ok(())
    }

    /// `CoordSysTransform`.
    pub fn coord_sys_transform(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of a coordinate system")?;
        if let Some(ctm) = self.systems.get(&name.text) {
            self.state.ctm = *ctm;
            return Ok(());
        }
        let known: Vec<&str> = self.systems.keys().map(String::as_str).collect();
        let message = format!("no coordinate system is called `{}`, nothing is changed", name.text);
        let warning = self.diag.warning(name.span, message);
        if let Some(near) = super::nearest_name(&name.text, &known) {
            warning.hint(format!("did you mean `{near}`?"));
        }
        Ok(())
    }
}
