//! From XML to a [`Document`]: variables, includes, search paths, aliases, ids.

use super::convert::suggest;
use super::document::{Dialect, Document, Kind, Object, ObjectId, Value};
use super::upgrade;
use super::variables::Variables;
use kaustika_scene::description::{Diagnostics, SourceFile, SourceMap, Span};
use roxmltree::Node;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Elements deeper than this are refused, so that no file can exhaust the stack.
const MAX_DEPTH: usize = 100;

/// Tags that may stand inside an object.
const TAGS: &[&str] = &[
    "scene",
    "shape",
    "bsdf",
    "texture",
    "emitter",
    "sensor",
    "film",
    "rfilter",
    "sampler",
    "integrator",
    "medium",
    "phase",
    "volume",
    "subsurface",
    "boolean",
    "integer",
    "float",
    "string",
    "point",
    "vector",
    "spectrum",
    "rgb",
    "srgb",
    "blackbody",
    "transform",
    "animation",
    "ref",
    "include",
    "alias",
    "default",
    "path",
    "null",
];

/// What reading the XML yields.
pub(super) struct Parsed {
    pub document: Document,
    pub sources: SourceMap,
    pub diagnostics: Diagnostics,
    /// The scene, and the dialect of the main file, unless the file could not be read.
    pub root: Option<(ObjectId, Dialect)>,
}

/// Reads a scene file and the files it includes.
pub(super) fn parse(path: &Path, defines: &[(String, String)]) -> Parsed {
    let mut parser = Parser {
        document: Document::default(),
        sources: SourceMap::default(),
        diagnostics: Diagnostics::default(),
        variables: Variables::new(defines),
        open: Vec::new(),
        id_spans: HashMap::new(),
    };
    let root = parser.main_file(path);
    if root.is_some() {
        parser.report_unused_defines();
    }
    Parsed {
        document: parser.document,
        sources: parser.sources,
        diagnostics: parser.diagnostics,
        root,
    }
}

/// State while files are read.
pub(super) struct Parser {
    pub(super) document: Document,
    sources: SourceMap,
    pub(super) diagnostics: Diagnostics,
    pub(super) variables: Variables,
    /// Files being read, outermost first.
    open: Vec<PathBuf>,
    /// Where ids were given.
    id_spans: HashMap<String, Span>,
}

/// The file an element stands in.
#[derive(Clone, Copy)]
pub(super) struct FileContext {
    pub(super) file: u32,
    pub(super) dialect: Dialect,
}

impl FileContext {
    pub(super) fn span(&self, range: std::ops::Range<usize>) -> Span {
        Span { file: self.file, start: range.start as u32, end: range.end as u32 }
    }

    /// The opening `<tag` of an element.
    pub(super) fn tag_span(&self, node: Node) -> Span {
        let start = node.range().start;
        self.span(start..start + 1 + node.tag_name().name().len())
    }
}

impl Parser {
    fn main_file(&mut self, path: &Path) -> Option<(ObjectId, Dialect)> {
        let (file, text) = self.open_file(path, None)?;
        let xml = self.xml(file, &text)?;
        let node = xml.root_element();
        let dialect = self.dialect_of(file, node)?;
        let ctx = FileContext { file, dialect };
        if node.tag_name().name() != "scene" {
            self.diagnostics.error(
                ctx.tag_span(node),
                format!("expected `<scene>`, found `<{}>`", node.tag_name().name()),
            );
            return None;
        }
        let root = self.add_object(&ctx, node, Kind::Scene, "scene", String::new());
        self.children(&ctx, node, root, 0);
        self.open.pop();
        Some((root, dialect))
    }

    /// Reads a file into the source map and makes it the innermost open one.
    fn open_file(&mut self, path: &Path, from: Option<Span>) -> Option<(u32, String)> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(e) => {
                self.diagnostics.error(from, format!("can't read `{}`: {e}", path.display()));
                return None;
            }
        };
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            // Every byte is a character of Latin-1, the other encoding old exporters wrote.
            Err(e) => e.as_bytes().iter().map(|&b| b as char).collect(),
        };
        let text = text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text);
        let file = self.sources.files.len() as u32;
        self.sources.files.push(SourceFile { path: path.to_path_buf(), text: text.clone() });
        self.document.paths.push(Vec::new());
        self.open.push(canonical(path));
        Some((file, text))
    }

    fn xml<'t>(&mut self, file: u32, text: &'t str) -> Option<roxmltree::Document<'t>> {
        match roxmltree::Document::parse(text) {
            Ok(xml) => Some(xml),
            Err(e) => {
                // roxmltree gives the end of the text no position of its own.
                let at = match e {
                    roxmltree::Error::UnexpectedEndOfStream => text.trim_end().len(),
                    _ => byte_offset(text, e.pos().row, e.pos().col),
                };
                let span = Span { file, start: at as u32, end: at as u32 };
                // roxmltree ends its messages with "at row:col"; the span says that already.
                let message = e.to_string();
                let cause = message.rsplit_once(" at ").map_or(message.as_str(), |(m, _)| m);
                let cause = match text.trim().is_empty() {
                    true => "the file is empty",
                    false => cause,
                };
                let error = self.diagnostics.error(span, format!("malformed XML: {cause}"));
                match e {
                    roxmltree::Error::UnexpectedCloseTag(open, _, _) => {
                        error.hint(format!("`<{open}>` is still open here: add `</{open}>`"));
                    }
                    roxmltree::Error::UnexpectedEndOfStream => {
                        error.hint("something is not closed; is the file cut short?");
                    }
                    roxmltree::Error::UnknownToken(_) => {
                        error.hint("a scene file begins with `<scene version=\"3.0.0\">`");
                    }
                    _ => {}
                }
                None
            }
        }
    }

    /// Reads the `version` attribute of a root element.
    fn dialect_of(&mut self, file: u32, node: Node) -> Option<Dialect> {
        let ctx = FileContext { file, dialect: Dialect::V3 };
        let Some(version) = node.attribute_node("version") else {
            self.diagnostics
                .error(
                    ctx.tag_span(node),
                    format!("missing attribute `version` in `<{}>`", node.tag_name().name()),
                )
                .hint("the version decides how the file is read: add `version=\"3.0.0\"`");
            return None;
        };
        let mut parts = version.value().trim().split('.');
        let major = parts.next().and_then(|p| p.parse::<u32>().ok());
        let well_formed = parts.all(|p| p.parse::<u32>().is_ok());
        match major {
            Some(major) if well_formed => Some(if major >= 2 { Dialect::V3 } else { Dialect::V06 }),
            _ => {
                self.diagnostics
                    .error(
                        ctx.span(version.range_value()),
                        format!("expected a version number, found `{}`", version.value()),
                    )
                    .hint("versions look like `3.0.0` or `0.6.0`");
                None
            }
        }
    }

    fn children(&mut self, ctx: &FileContext, node: Node, parent: ObjectId, depth: usize) {
        for child in node.children().filter(Node::is_element) {
            self.element(ctx, child, parent, depth);
        }
    }

    fn element(&mut self, ctx: &FileContext, node: Node, parent: ObjectId, depth: usize) {
        let tag = node.tag_name().name();
        let span = ctx.tag_span(node);
        if depth > MAX_DEPTH {
            self.diagnostics.error(span, format!("elements nest deeper than {MAX_DEPTH}"));
            return;
        }
        // `<spectrum type="...">` is a texture.
        let kind = match Kind::of_tag(tag) {
            None if tag == "spectrum" && node.has_attribute("type") => Some(Kind::Texture),
            kind => kind,
        };
        if let Some(kind) = kind {
            self.object_element(ctx, node, kind, parent, depth);
            return;
        }
        match tag {
            "boolean" | "integer" | "float" | "string" | "rgb" | "srgb" => {
                self.simple_value(ctx, node, parent);
            }
            "point" | "vector" => self.vector_value(ctx, node, parent),
            "spectrum" => self.spectrum_value(ctx, node, parent),
            "blackbody" => self.blackbody_value(ctx, node, parent),
            "transform" => self.transform_value(ctx, node, parent),
            "animation" => self.animation_value(ctx, node, parent),
            "ref" => self.reference(ctx, node, parent),
            "include" => self.include(ctx, node, parent, depth),
            "alias" => self.alias(ctx, node),
            "default" => self.default(ctx, node),
            "path" => self.path(ctx, node),
            "null" => {}
            "translate" | "rotate" | "scale" | "lookat" | "lookAt" | "matrix" => {
                self.diagnostics
                    .error(span, format!("`<{tag}>` can only stand inside a `<transform>`"));
            }
            _ => {
                self.diagnostics
                    .error(span, format!("unknown element `<{tag}>`"))
                    .nearest(tag, TAGS);
            }
        }
    }

    fn object_element(
        &mut self,
        ctx: &FileContext,
        node: Node,
        kind: Kind,
        parent: ObjectId,
        depth: usize,
    ) {
        let Some(attributes) = self.attributes(ctx, node, &["type"], &["id", "name"]) else {
            return;
        };
        let plugin = attributes.text("type").to_ascii_lowercase();
        let id = self.add_object(ctx, node, kind, &plugin, attributes.text("id"));
        if let Some(a) = attributes.get("type") {
            self.document.objects[id.0].type_span = a.span;
        }
        if let Some(a) = attributes.get("id") {
            self.register(&a.value, id, a.span);
        }
        self.add(parent, &attributes.text("name"), Value::Object(id), ctx.tag_span(node), None);
        self.children(ctx, node, id, depth + 1);
        if ctx.dialect == Dialect::V06 {
            upgrade::parameter_names(&mut self.document.objects[id.0]);
        }
    }

    fn alias(&mut self, ctx: &FileContext, node: Node) {
        let Some(a) = self.attributes(ctx, node, &["id", "as"], &[]) else { return };
        let (Some(id), Some(name)) = (a.get("id"), a.get("as")) else { return };
        match self.document.ids.get(&id.value).copied() {
            Some(target) => self.register(&name.value, target, name.span),
            None => {
                let message = format!("no object with the id `{}` stands above", id.value);
                let error = self.diagnostics.error(id.span, message);
                suggest(error, &id.value, &known_ids(&self.document));
            }
        }
    }

    fn default(&mut self, ctx: &FileContext, node: Node) {
        if let Some(a) = self.attributes(ctx, node, &["name", "value"], &[]) {
            self.variables.set_default(&a.text("name"), &a.text("value"));
        }
    }

    fn path(&mut self, ctx: &FileContext, node: Node) {
        let Some(a) = self.attributes(ctx, node, &["value"], &[]) else { return };
        let Some(value) = a.get("value") else { return };
        match self.document_file(ctx.file, &value.value).filter(|p| p.is_dir()) {
            Some(folder) => self.document.paths[ctx.file as usize].insert(0, folder),
            None => {
                self.diagnostics
                    .error(value.span, format!("can't find the folder `{}`", value.value));
            }
        }
    }

    fn include(&mut self, ctx: &FileContext, node: Node, parent: ObjectId, depth: usize) {
        let Some(a) = self.attributes(ctx, node, &["filename"], &["name"]) else { return };
        let Some(name) = a.get("filename") else { return };
        let Some(path) = self.document_file(ctx.file, &name.value) else {
            self.diagnostics
                .error(name.span, format!("can't find the included file `{}`", name.value))
                .hint(super::find::WHERE_LOOKED);
            return;
        };
        if self.open.contains(&canonical(&path)) {
            self.diagnostics
                .error(name.span, format!("`{}` includes itself", name.value))
                .label("a file that is being read");
            return;
        }
        let Some((file, text)) = self.open_file(&path, Some(name.span)) else { return };
        self.document.paths[file as usize] = self.document.paths[ctx.file as usize].clone();
        if let Some(xml) = self.xml(file, &text) {
            let root = xml.root_element();
            if let Some(dialect) = self.dialect_of(file, root) {
                let inner = FileContext { file, dialect };
                if root.tag_name().name() == "scene" {
                    self.children(&inner, root, parent, depth + 1);
                } else {
                    self.element(&inner, root, parent, depth + 1);
                }
            }
        }
        self.open.pop();
    }

    /// A file or folder as an element of file `file` names it.
    pub(super) fn document_file(&self, file: u32, name: &str) -> Option<PathBuf> {
        super::find::find(&self.document, &self.sources, file, name)
    }

    fn add_object(
        &mut self,
        ctx: &FileContext,
        node: Node,
        kind: Kind,
        plugin: &str,
        id: String,
    ) -> ObjectId {
        let span = ctx.tag_span(node);
        self.document.objects.push(Object {
            kind,
            plugin: plugin.to_string(),
            id,
            dialect: ctx.dialect,
            span,
            type_span: span,
            parameters: Vec::new(),
            asked: RefCell::new(Vec::new()),
        });
        ObjectId(self.document.objects.len() - 1)
    }

    fn register(&mut self, id: &str, object: ObjectId, span: Span) {
        if let Some(previous) = self.id_spans.get(id) {
            let hint = format!("previously defined at {}", self.sources.location(*previous));
            self.diagnostics.error(span, format!("the id `{id}` is given twice")).hint(hint);
            return;
        }
        self.id_spans.insert(id.to_string(), span);
        self.document.ids.insert(id.to_string(), object);
    }

    fn report_unused_defines(&mut self) {
        let names = self.variables.names();
        for unused in self.variables.unused() {
            let known: Vec<&str> = names.iter().copied().filter(|n| *n != unused).collect();
            let message = format!("the parameter `{unused}` is defined but never used");
            suggest(self.diagnostics.warning(None, message), unused, &known);
        }
    }
}

/// Ids in alphabetical order, for messages.
pub(super) fn known_ids(document: &Document) -> Vec<&str> {
    let mut ids: Vec<&str> = document.ids.keys().map(String::as_str).collect();
    ids.sort_unstable();
    ids
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The byte of a line and column, both from 1, columns in characters.
fn byte_offset(text: &str, row: u32, col: u32) -> usize {
    let line_start: usize =
        text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum();
    let rest = &text[line_start..];
    let in_line =
        rest.char_indices().nth(col.saturating_sub(1) as usize).map_or(rest.len(), |c| c.0);
    line_start + in_line
}
