//! Mitsuba scenes; the files that they name do not exist.
#![no_main]

use kaustika_formats::mitsuba::read_mitsuba;
use libfuzzer_sys::fuzz_target;

mod on_disk;

fuzz_target!(|bytes: &[u8]| {
    on_disk::with(bytes, "xml", |path| drop(read_mitsuba(path, &[])));
});
