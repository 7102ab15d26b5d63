//! Images of every format: the first byte says which.
#![no_main]

use kaustika_film::files::{read_bitmap, read_picture};
use libfuzzer_sys::fuzz_target;

mod on_disk;

const EXTENSIONS: [&str; 7] = ["exr", "png", "jpg", "tga", "hdr", "pfm", "jpeg"];

fuzz_target!(|bytes: &[u8]| {
    on_disk::catch_panics();
    let Some((&kind, bytes)) = bytes.split_first() else { return };
    let extension = EXTENSIONS[usize::from(kind) % EXTENSIONS.len()];
    on_disk::with(bytes, extension, |path| {
        let _ = read_bitmap(path);
        let _ = read_picture(path);
    });
});
