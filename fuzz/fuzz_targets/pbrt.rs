//! pbrt scenes; the files that they name do not exist.
#![no_main]

use kaustika_formats::pbrt::read_pbrt_str;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    read_pbrt_str(text, Path::new("/nonexistent/scene.pbrt"));
});
