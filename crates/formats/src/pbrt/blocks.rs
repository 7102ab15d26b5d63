//! Directives that open, close and place parts of a scene.

use super::entity::{ATTRIBUTE_TARGETS, InstanceEntity, NameRef, ObjectEntity};
use super::files;
use super::lexer::Lexer;
use super::reader::{GivenUp, Open, Reader};
use kaustika_math::Transform;
use kaustika_scene::description::Span;
use std::rc::Rc;

impl Reader {
    /// `AttributeBegin`, `TransformBegin`.
    pub fn attribute_begin(&mut self, name: &str, span: Span) {
        if name == "TransformBegin" {
            let message = "`TransformBegin` is deprecated and read as `AttributeBegin`";
            self.notes.warning(span, message);
        }
        self.stack.push(Open { state: self.state.clone(), object: false, span });
    }

    /// `AttributeEnd`, `TransformEnd`.
    pub fn attribute_end(&mut self, name: &str, span: Span) {
        match self.stack.pop() {
            Some(open) if !open.object => self.state = open.state,
            Some(open) => {
                let message = format!("`{name}` inside an object; `ObjectEnd` is missing");
                self.diag.error(span, message);
                self.stack.push(open);
            }
            None => {
                let begin =
                    if name == "AttributeEnd" { "AttributeBegin" } else { "TransformBegin" };
                self.diag.error(span, format!("`{name}` without `{begin}`"));
            }
        }
    }

    /// `Attribute`.
    pub fn attribute(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let target = self.string(lexer, "a target such as `shape`")?;
        let params = self.params(lexer)?;
        match ATTRIBUTE_TARGETS.iter().position(|t| *t == target.text) {
            Some(i) => Rc::make_mut(&mut self.state.attributes[i]).extend(params),
            None => {
                self.diag
                    .error(target.span, format!("unknown attribute target `{}`", target.text))
                    .nearest(&target.text, &ATTRIBUTE_TARGETS);
            }
        }
        Ok(())
    }

    /// `Include`, `Import`.
    pub fn include(&mut self, lexer: &mut Lexer, import: bool) -> Result<(), GivenUp> {
        let name = self.string(lexer, "a file name")?;
        let current = self.folder(name.span.file).to_path_buf();
        let Some(path) = files::resolve(&name.text, &self.main, &current) else {
            let error = self.diag.error(name.span, format!("no file `{}`", name.text));
            error.hint(match files::nearest_file(&name.text, &self.main) {
                Some(near) => format!("did you mean `{near}`?"),
                None => files::WHERE_LOOKED.into(),
            });
            return Ok(());
        };
        if !import {
            self.read_file(&path, Some(name.span));
            return Ok(());
        }
        // An import has its own copy of the state and leaves ours alone.
        let (state, depth) = (self.state.clone(), self.stack.len());
        self.read_file(&path, Some(name.span));
        while self.stack.len() > depth {
            let open = self.stack.pop();
            self.report_open(open);
        }
        self.state = state;
        Ok(())
    }

    /// Reports a block that was not closed.
    pub fn report_open(&mut self, open: Option<Open>) {
        if let Some(open) = open {
            let name = if open.object { "ObjectBegin" } else { "AttributeBegin" };
            self.diag.error(open.span, format!("this `{name}` is never closed"));
        }
    }

    /// `WorldBegin`.
    pub fn world_begin(&mut self, span: Span) {
        if self.in_world {
            self.diag.error(span, "second `WorldBegin`");
            return;
        }
        self.in_world = true;
        self.state.ctm = [Transform::IDENTITY; 2];
        self.state.active = [true; 2];
        self.systems.insert("world".into(), self.state.ctm);
    }

    /// `ObjectBegin`.
    pub fn object_begin(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of an object")?;
        if self.object.is_some() {
            self.diag.error(span, "`ObjectBegin` inside an object");
            return Ok(());
        }
        let number = self.scene.objects.len();
        if self.scene.object_names.insert(&name.text, number, self.order) {
            self.redefined.push((name.clone(), "object"));
        }
        self.stack.push(Open { state: self.state.clone(), object: true, span });
        self.object = Some(number);
        self.scene.objects.push(ObjectEntity { name, shapes: Vec::new() });
        Ok(())
    }

    /// `ObjectEnd`.
    pub fn object_end(&mut self, span: Span) {
        if self.object.take().is_none() {
            self.diag.error(span, "`ObjectEnd` without `ObjectBegin`");
            return;
        }
        while let Some(open) = self.stack.pop() {
            if open.object {
                self.state = open.state;
                return;
            }
            self.report_open(Some(open));
        }
    }

    /// `ObjectInstance`.
    pub fn object_instance(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of an object")?;
        if self.object.is_some() {
            self.diag.error(span, "`ObjectInstance` inside an object");
            return Ok(());
        }
        let object = NameRef { name, order: self.order };
        let place = self.place(span);
        self.scene.instances.push(InstanceEntity { object, place, span });
        Ok(())
    }
}
