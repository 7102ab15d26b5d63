//! glTF scenes: binary if they begin as such.
#![no_main]

use kaustika_formats::gltf::read_gltf;
use libfuzzer_sys::fuzz_target;

mod on_disk;

fuzz_target!(|bytes: &[u8]| {
    let extension = if bytes.starts_with(b"glTF") { "glb" } else { "gltf" };
    on_disk::with(bytes, extension, |path| drop(read_gltf(path)));
});
