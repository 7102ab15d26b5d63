//! Meshes: `.serialized`.
#![no_main]

use kaustika_formats::mesh::{MeshFormat, MeshOptions, parse_mesh};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let format = MeshFormat::Serialized;
    let _ = parse_mesh(bytes, format, &MeshOptions::mitsuba(format), &mut Vec::new());
});
