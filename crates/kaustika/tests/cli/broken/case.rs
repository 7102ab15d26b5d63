//! One broken input and what the program says about it.

use crate::kit::Place;
use std::path::PathBuf;

/// Films of the scenes are this small, in case one is rendered.
const CAMERA: &str = "Camera \"perspective\"\nFilm \"rgb\" \"integer xresolution\" 8 \
                      \"integer yresolution\" 6\nSampler \"zsobol\" \"integer pixelsamples\" 1\n";
const SENSOR: &str = "<sensor type=\"perspective\"><film type=\"hdrfilm\">\
                      <integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"6\"/>\
                      </film></sensor>\n";

/// What the program is given, and how it must end.
pub struct Case {
    /// Also of the file with the expected text.
    pub name: &'static str,
    args: String,
    code: i32,
    files: Vec<(&'static str, Vec<u8>)>,
    prepare: fn(&Place),
}

impl Case {
    /// The program run with these words; it must end with 1.
    pub fn new(name: &'static str, args: &str) -> Case {
        Case { name, args: args.into(), code: 1, files: Vec::new(), prepare: |_| {} }
    }

    /// A pbrt scene of exactly these bytes, rendered.
    pub fn pbrt_file(name: &'static str, bytes: impl AsRef<[u8]>) -> Case {
        Case::new(name, "render s.pbrt -o a.exr").file("s.pbrt", bytes)
    }

    /// A pbrt scene with a camera, the world from line 5 on, rendered.
    pub fn pbrt(name: &'static str, world: &str) -> Case {
        Case::pbrt_file(name, format!("{CAMERA}WorldBegin\n{world}\n"))
    }

    /// A Mitsuba scene of exactly these bytes, rendered.
    pub fn xml_file(name: &'static str, bytes: impl AsRef<[u8]>) -> Case {
        Case::new(name, "render s.xml -o a.exr").file("s.xml", bytes)
    }

    /// A scene of Mitsuba 3 with a camera, the rest from line 3 on, rendered.
    pub fn mitsuba(name: &'static str, rest: &str) -> Case {
        Case::xml_file(name, format!("<scene version=\"3.0.0\">\n{SENSOR}{rest}\n</scene>\n"))
    }

    /// A scene of Mitsuba 0.6 with a camera, the rest from line 3 on, rendered.
    pub fn mitsuba_06(name: &'static str, rest: &str) -> Case {
        Case::xml_file(name, format!("<scene version=\"0.6.0\">\n{SENSOR}{rest}\n</scene>\n"))
    }

    /// With one more file.
    pub fn file(mut self, name: &'static str, bytes: impl AsRef<[u8]>) -> Case {
        self.files.push((name, bytes.as_ref().to_vec()));
        self
    }

    /// With other words.
    pub fn args(mut self, args: &str) -> Case {
        self.args = args.into();
        self
    }

    /// With something done in the folder before, once the files are there.
    pub fn prepared(mut self, prepare: fn(&Place)) -> Case {
        self.prepare = prepare;
        self
    }

    /// The command line is at fault, not the input.
    pub fn wrong_usage(mut self) -> Case {
        self.code = 2;
        self
    }

    /// It is odd, but good enough.
    pub fn accepted(mut self) -> Case {
        self.code = 0;
        self
    }

    /// Runs it; says what is not as expected.
    pub fn fault(&self) -> Option<String> {
        let place = Place::new();
        for (name, bytes) in &self.files {
            std::fs::write(place.path(name), bytes).unwrap();
        }
        (self.prepare)(&place);
        let folder = place.path("");
        let folder = folder.to_str().unwrap().trim_end_matches('/');
        let out = place.run(&self.args.replace("<dir>", folder));
        let said = String::from_utf8_lossy(&out.stderr).replace(folder, "<dir>");
        let said = without_error_numbers(&said);
        let name = self.name;
        if out.status.code() != Some(self.code) || said.contains("panicked") {
            return Some(format!(
                "{name}: expected exit code {}, {}\n{said}",
                self.code, out.status
            ));
        }
        if self.code != 0 && place.has("a.exr") {
            return Some(format!("{name}: it failed, and left a picture\n{said}"));
        }
        let said = without_progress(&said);
        let path = expected_folder().join(format!("{name}.txt"));
        if blesses() {
            std::fs::write(path, said).unwrap();
            return None;
        }
        let expected = std::fs::read_to_string(path).unwrap_or_else(|e| format!("{e}\n"));
        (said != expected)
            .then(|| format!("{name}: expected\n{expected}--- but it says\n{said}---"))
    }
}

/// True if the expected texts are to be written anew.
pub fn blesses() -> bool {
    std::env::var_os("KAUSTIKA_BLESS").is_some()
}

/// Where the expected texts lie.
pub fn expected_folder() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "cli", "broken", "expected"].iter().collect()
}

/// The system's errors by their words only: numbers differ from one Unix to the next.
fn without_error_numbers(said: &str) -> String {
    let mut parts = said.split(" (os error ");
    let first = parts.next().unwrap_or_default().to_string();
    let after = |p: &str| p.split_once(')').map_or(p.to_string(), |(_, rest)| rest.to_string());
    parts.fold(first, |out, p| out + &after(p))
}

/// Up to what a good render says in the end, which has its time in it. Blanks at the ends of lines
/// are left out.
fn without_progress(said: &str) -> String {
    let lines = said.lines().take_while(|l| !l.starts_with("rendered "));
    lines.map(|l| format!("{}\n", l.trim_end())).collect()
}
