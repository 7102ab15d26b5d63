//! Broken input: the program refuses it with an exit code and a message that helps.
//!
//! A [`Case`] is a few files, the words the program is run with in their folder, and its exit
//! code. What it then writes to stderr stands in `expected/NAME.txt`, word for word; the folder
//! itself is written `<dir>`. `KAUSTIKA_BLESS=1 cargo test -p kaustika --test cli broken` writes
//! these texts anew. Read what has changed: a message names the file, the line and the cause, and
//! where there is something to do about it, that too.

mod case;
mod command_line;
mod gltf;
mod images;
mod meshes;
mod mitsuba;
mod pbrt;

use case::{Case, expected_folder};
use std::collections::BTreeSet;

/// Runs all cases, and tells of all that differ.
fn check(cases: Vec<Case>) {
    let faults: Vec<String> = cases.iter().filter_map(|c| c.fault()).collect();
    assert!(faults.is_empty(), "{} differ\n\n{}", faults.len(), faults.join("\n\n"));
}

#[test]
fn pbrt_scenes() {
    check(pbrt::cases());
}

#[test]
fn gltf_scenes() {
    check(gltf::cases());
}

#[test]
fn mitsuba_scenes() {
    check(mitsuba::cases());
}

#[test]
fn mesh_files() {
    check(meshes::cases());
}

#[test]
fn images_and_spectra() {
    check(images::cases());
}

#[test]
fn command_lines() {
    check(command_line::cases());
}

/// No name stands for two cases, and no text is left of a case that is gone.
#[test]
fn cases_and_expected_texts_belong_together() {
    let lists = [pbrt::cases(), gltf::cases(), mitsuba::cases(), meshes::cases(), images::cases()];
    let cases = lists.into_iter().flatten().chain(command_line::cases());
    let mut names = BTreeSet::new();
    for case in cases {
        let file = format!("{}.txt", case.name);
        assert!(names.insert(file), "two cases are called {}", case.name);
    }
    let files: BTreeSet<String> = std::fs::read_dir(expected_folder())
        .unwrap()
        .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    // New texts are not there yet while others write them.
    let missing = names.difference(&files).next().filter(|_| !case::blesses());
    assert_eq!(missing, None, "a case has no expected text");
    assert_eq!(files.difference(&names).next(), None, "an expected text has no case");
}
