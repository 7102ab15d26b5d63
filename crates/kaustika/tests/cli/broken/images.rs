//! Broken images and spectra, in scenes that are good otherwise.

use super::case::Case;
use crate::kit::Place;

/// A pbrt scene with a texture from this file.
fn texture(name: &'static str, file: &'static str) -> Case {
    let world = format!(
        "LightSource \"infinite\"\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\""
    );
    Case::pbrt(name, &world)
}

/// A Mitsuba scene with light from this file.
fn sky(name: &'static str, file: &'static str) -> Case {
    let emitter = format!(
        "<emitter type=\"envmap\">\n  <string name=\"filename\" value=\"{file}\"/>\n</emitter>"
    );
    Case::mitsuba(name, &emitter)
}

/// A picture in the folder, all but its last third.
fn cut_picture(place: &Place, name: &str) {
    place.ok(&format!("render ball.pbrt -q --spp 1 -o {name}"));
    let bytes = std::fs::read(place.path(name)).unwrap();
    std::fs::write(place.path(name), &bytes[..bytes.len() * 2 / 3]).unwrap();
}

pub fn cases() -> Vec<Case> {
    vec![
        texture("image-missing", "wood.png"),
        sky("image-missing-sky", "sky.exr"),
        texture("image-is-text", "wood.png").file("wood.png", "a picture of wood\n"),
        texture("image-is-empty", "wood.png").file("wood.png", ""),
        texture("image-of-unknown-kind", "wood.doc").file("wood.doc", "wood"),
        texture("image-is-a-folder", "wood.png")
            .prepared(|p| std::fs::create_dir(p.path("wood.png")).unwrap()),
        texture("image-png-cut", "cut.png").prepared(|p| cut_picture(p, "cut.png")),
        texture("image-jpg-cut", "cut.jpg").prepared(|p| cut_picture(p, "cut.jpg")),
        texture("image-exr-cut", "cut.exr").prepared(|p| cut_picture(p, "cut.exr")),
        sky("image-hdr-cut", "cut.hdr").prepared(|p| cut_picture(p, "cut.hdr")),
        sky("image-exr-is-text", "sky.exr").file("sky.exr", "v/1\x01 but nothing more"),
        sky("image-pfm-too-short", "sky.pfm").file("sky.pfm", "PF\n4 4\n-1.0\n0123456789"),
        sky("image-pfm-absurd-size", "sky.pfm").file("sky.pfm", "PF\n900000000 900000000\n-1.0\n"),
        sky("image-pfm-no-size", "sky.pfm").file("sky.pfm", "PF\nwide\n-1.0\n"),
        sky("image-pfm-negative-size", "sky.pfm").file("sky.pfm", "PF\n-4 4\n-1.0\n"),
        Case::new("image-environment-missing", "render ball.pbrt --environment sky.hdr -o a.exr"),
        Case::pbrt("spd-garbage", "LightSource \"point\" \"spectrum I\" \"lamp.spd\"")
            .file("lamp.spd", "# wavelength power\n400 1.0\n500 plenty\n600 1.0\n"),
        Case::pbrt("spd-out-of-order", "LightSource \"point\" \"spectrum I\" \"lamp.spd\"")
            .file("lamp.spd", "500 1.0\n400 1.0\n"),
        Case::pbrt("spd-odd", "LightSource \"point\" \"spectrum I\" \"lamp.spd\"")
            .file("lamp.spd", "400 1.0\n500\n"),
        Case::pbrt("spd-empty", "LightSource \"point\" \"spectrum I\" \"lamp.spd\"").file("lamp.spd", ""),
        Case::pbrt("spd-missing", "LightSource \"point\" \"spectrum I\" \"lamp.spd\""),
        Case::mitsuba("spd-garbage-in-xml", "<emitter type=\"point\">\n  <spectrum name=\"intensity\" filename=\"lamp.spd\"/>\n</emitter>")
            .file("lamp.spd", "# wavelength power\n400 1.0\n500 plenty\n600 1.0\n"),
        Case::mitsuba("spd-missing-in-xml", "<emitter type=\"point\">\n  <spectrum name=\"intensity\" filename=\"lamp.spd\"/>\n</emitter>"),
    ]
}
