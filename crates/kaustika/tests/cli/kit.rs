//! A folder, a scene in it, and the program.

use kaustika::film::{Picture, read_picture};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A lit sphere on a floor, with a second light behind: everything noisy.
pub const SCENE: &str = r#"
LookAt 0 1 -4  0 0.6 0  0 1 0
Camera "perspective" "float fov" 45
Film "rgb" "integer xresolution" 24 "integer yresolution" 18 "string filename" "ball.exr"
Sampler "zsobol" "integer pixelsamples" 8
Integrator "volpath" "integer maxdepth" 3
WorldBegin
AttributeBegin
  Translate 0 3 -1
  AreaLightSource "diffuse" "rgb L" [6 5 4]
  Shape "sphere" "float radius" 0.4
AttributeEnd
LightSource "infinite" "rgb L" [0.2 0.3 0.4]
AttributeBegin
  Material "diffuse" "rgb reflectance" [0.7 0.4 0.2]
  Translate 0 0.7 0
  Shape "sphere" "float radius" 0.7
AttributeEnd
Material "conductor" "float roughness" 0.3
Shape "trianglemesh" "point3 P" [-5 0 -5  5 0 -5  5 0 5  -5 0 5] "integer indices" [0 1 2 0 2 3]
"#;

/// A temporary folder with the scene `ball.pbrt`.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Place {
        let place = Place { folder: TempDir::new().unwrap() };
        place.write("ball.pbrt", SCENE);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program in the folder with these words.
    pub fn run(&self, args: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_kaustika"))
            .args(args.split_whitespace())
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    /// Runs it and expects exit code 0; returns what it wrote to stdout.
    pub fn ok(&self, args: &str) -> String {
        let out = self.run(args);
        assert!(out.status.success(), "{args}: {}", String::from_utf8_lossy(&out.stderr));
        String::from_utf8(out.stdout).unwrap()
    }

    /// Runs it and expects this exit code; returns what it wrote to stderr.
    pub fn fails(&self, code: i32, args: &str) -> String {
        let out = self.run(args);
        let text = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(code), "{args}: {text}");
        assert!(!text.contains("panicked"), "{args}: {text}");
        text
    }

    pub fn picture(&self, name: &str) -> Picture {
        read_picture(self.path(name)).unwrap()
    }

    pub fn has(&self, name: &str) -> bool {
        Path::exists(&self.path(name))
    }
}

/// All channels have the same bits; also those of variance and features.
pub fn assert_same_bits(a: &Picture, b: &Picture) {
    let names = |p: &Picture| p.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    assert_eq!((a.width, a.height, names(a)), (b.width, b.height, names(b)));
    for (x, y) in a.channels.iter().zip(&b.channels) {
        let differing = x.data.iter().zip(&y.data).filter(|(x, y)| x.to_bits() != y.to_bits());
        assert_eq!(differing.count(), 0, "values of {} differ", x.name);
    }
}

/// How many values of the colour differ.
pub fn differing_values(a: &Picture, b: &Picture) -> usize {
    let values = |p: &Picture| p.rgb().unwrap().pixels().flatten().collect::<Vec<f32>>();
    values(a).iter().zip(values(b)).filter(|(x, y)| **x != *y).count()
}
