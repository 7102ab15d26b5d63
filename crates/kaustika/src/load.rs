//! From a path to a description, by the kind of file.

use kaustika_formats::{gltf, mitsuba, pbrt};
use kaustika_scene::description::SceneDescription;
use std::path::Path;

/// Reads a scene file: `.pbrt`, `.pbrt.gz`, Mitsuba's `.xml`, `.gltf` or `.glb`. `defines` are values for
/// Mitsuba's `$name`. What is wrong with it stands in the description's diagnostics.
pub fn load(path: &Path, defines: &[(String, String)]) -> SceneDescription {
    let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
    if name.ends_with(".pbrt") || name.ends_with(".pbrt.gz") {
        pbrt::read_pbrt(path)
    } else if name.ends_with(".xml") {
        mitsuba::read_mitsuba(path, defines)
    } else if name.ends_with(".gltf") || name.ends_with(".glb") {
        gltf::read_gltf(path)
    } else {
        let mut description = SceneDescription::default();
        description
            .diagnostics
            .error(None, format!("{}: not a scene file that I know", path.display()))
            .hint("scene files end in .pbrt, .pbrt.gz, .xml (Mitsuba), .gltf or .glb");
        description
    }
}
