//! NanoVDB volumes, as a pbrt scene names them.
#![no_main]

use kaustika_formats::pbrt::read_pbrt_str;
use libfuzzer_sys::fuzz_target;

mod on_disk;

fuzz_target!(|bytes: &[u8]| {
    on_disk::with(bytes, "nvdb", |volume| {
        let text = format!(
            "WorldBegin MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"{}\"",
            volume.display()
        );
        read_pbrt_str(&text, &volume.with_extension("pbrt"));
    });
});
