//! Reads files and runs their directives on the graphics state.

use super::entity::{Entities, GraphicsState, Place};
use super::files;
use super::lexer::{Lexer, Token, TokenKind, Unterminated};
use super::notes::Notes;
use super::param::Text;
use kaustika_math::Transform;
use kaustika_scene::description::{Diagnostics, Severity, SourceFile, Span};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Errors after which the rest of the input is not worth reading.
const MAX_ERRORS: usize = 50;
/// Files that may be open within one another.
const MAX_DEPTH: usize = 64;

/// A directive was given up; its error is reported.
#[derive(Debug)]
pub(super) struct GivenUp;

/// `AttributeBegin` or `ObjectBegin` that waits for its end.
#[derive(Clone, Debug)]
pub(super) struct Open {
    pub state: GraphicsState,
    pub object: bool,
    pub span: Span,
}

/// The state of reading.
pub(super) struct Reader {
    pub files: Vec<SourceFile>,
    pub diag: Diagnostics,
    pub notes: Notes,
    pub scene: Entities,
    pub state: GraphicsState,
    pub stack: Vec<Open>,
    /// Named coordinate systems.
    pub systems: HashMap<String, [Transform; 2]>,
    /// `TransformTimes`.
    pub times: [f32; 2],
    /// After `WorldBegin`.
    pub in_world: bool,
    /// Something that only pbrt-v3 knows was found.
    pub v3: bool,
    /// Number of the object that is being defined.
    pub object: Option<usize>,
    /// Directives read so far.
    pub order: u32,
    /// Names defined twice: an error unless the files are pbrt-v3's.
    pub redefined: Vec<(Text, &'static str)>,
    /// Folder of the main file.
    pub main: PathBuf,
    open_files: Vec<PathBuf>,
    gave_up: bool,
}

impl Reader {
    /// A reader for a main file in the folder `main`.
    pub fn new(main: PathBuf) -> Self {
        Reader {
            files: Vec::new(),
            diag: Diagnostics::default(),
            notes: Notes::default(),
            scene: Entities::default(),
            state: GraphicsState { active: [true; 2], ..GraphicsState::default() },
            stack: Vec::new(),
            systems: HashMap::new(),
            times: [0.0, 1.0],
            in_world: false,
            v3: false,
            object: None,
            order: 0,
            redefined: Vec::new(),
            main,
            open_files: Vec::new(),
            gave_up: false,
        }
    }

    /// Reads a file that the main program or the directive at `from` names.
    pub fn read_file(&mut self, path: &Path, from: Option<Span>) {
        let real = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if self.open_files.contains(&real) {
            let message = format!("`{}` includes itself", path.display());
            self.diag.error(from, message);
            return;
        }
        if self.open_files.len() >= MAX_DEPTH {
            self.diag.error(from, format!("more than {MAX_DEPTH} files include one another"));
            return;
        }
        match files::read_text(path) {
            Ok(text) => {
                self.open_files.push(real);
                self.read_text(text, path);
                self.open_files.pop();
            }
            Err(cause) => {
                self.diag.error(from, format!("can't read `{}`: {cause}", path.display()));
            }
        }
    }

    /// Reads a text; `path` is for messages and for relative file names.
    pub fn read_text(&mut self, text: String, path: &Path) {
        let number = self.files.len();
        self.files.push(SourceFile { path: path.to_path_buf(), text: String::new() });
        let mut lexer = Lexer::new(&text, number as u32);
        while !self.gave_up {
            let start = lexer.pos;
            match self.next(&mut lexer) {
                Ok(None) => break,
                Ok(Some(token)) => {
                    if self.directive(&mut lexer, token).is_err() {
                        if lexer.pos == start {
                            lexer.pos = token.span.end as usize;
                        }
                        self.recover(&mut lexer);
                    }
                }
                Err(GivenUp) => self.recover(&mut lexer),
            }
            if self.diag.count(Severity::Error) >= MAX_ERRORS && !self.gave_up {
                self.gave_up = true;
                self.diag.error(None, format!("stopped reading after {MAX_ERRORS} errors"));
            }
        }
        self.files[number].text = text;
    }

    /// Passes over everything up to the next word that is a directive.
    fn recover(&mut self, lexer: &mut Lexer) {
        loop {
            let before = lexer.pos;
            match lexer.next() {
                Ok(None) => return,
                Ok(Some(t)) if t.kind == TokenKind::Word => {
                    if super::directive::DIRECTIVES.contains(&lexer.slice(t.span)) {
                        lexer.pos = before;
                        return;
                    }
                }
                Ok(Some(_)) | Err(Unterminated(_)) => {}
            }
        }
    }

    /// The next token; an unterminated string is reported.
    pub fn next(&mut self, lexer: &mut Lexer) -> Result<Option<Token>, GivenUp> {
        lexer.next().map_err(|Unterminated(span)| {
            self.diag.error(span, "the string does not end on its line").hint("add a closing `\"`");
            GivenUp
        })
    }

    /// The next token, which must be there.
    pub fn required(&mut self, lexer: &mut Lexer, expected: &str) -> Result<Token, GivenUp> {
        match self.next(lexer)? {
            Some(token) => Ok(token),
            None => {
                let end = lexer.bytes().len();
                let message = format!("the file ends where {expected} is expected");
                self.diag.error(lexer.span(end, end), message);
                Err(GivenUp)
            }
        }
    }

    /// A string that must come next.
    pub fn string(&mut self, lexer: &mut Lexer, expected: &str) -> Result<Text, GivenUp> {
        let before = lexer.pos;
        let token = self.required(lexer, expected)?;
        if token.kind != TokenKind::String {
            lexer.pos = before;
            let found = lexer.slice(token.span);
            self.diag.error(token.span, format!("expected {expected} in quotes, found `{found}`"));
            return Err(GivenUp);
        }
        self.unquote(lexer, token)
    }

    /// The contents of a string token.
    pub fn unquote(&mut self, lexer: &Lexer, token: Token) -> Result<Text, GivenUp> {
        match lexer.unquote(token) {
            Ok(text) => Ok(Text { text: text.into_owned(), span: token.span }),
            Err(c) => {
                self.diag.error(token.span, format!("unknown escape `\\{c}` in a string"));
                Err(GivenUp)
            }
        }
    }

    /// The current transforms. Those that have no way between them are warned of, and the first
    /// stands for both.
    pub fn place(&mut self, span: Span) -> Place {
        let place = Place { transforms: self.state.ctm, times: self.times };
        if !place.turns_over() {
            return place;
        }
        let message =
            "the transform at the end mirrors what that at the start does not, using the start";
        self.notes.warning(span, message);
        Place { transforms: [place.transforms[0]; 2], ..place }
    }

    /// Folder of a file, by its number.
    pub fn folder(&self, file: u32) -> &Path {
        self.files.get(file as usize).and_then(|f| f.path.parent()).unwrap_or(Path::new(""))
    }
}
