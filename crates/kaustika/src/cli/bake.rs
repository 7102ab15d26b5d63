//! `kaustika render --bake`: light on surfaces, written as a mesh.

use super::failure::Failure;
use super::picture::check_place;
use kaustika::formats::gltf::write_glb;
use kaustika::formats::mesh::write_ply;
use kaustika::scene::Scene;
use kaustika::transport::Method;
use std::path::Path;

/// Refuses what could not be written in the end.
///
/// # Errors
/// An unknown extension or a method that bakes nothing is wrong usage, a missing folder wrong input.
pub fn check(path: &Path, method: &dyn Method) -> Result<(), Failure> {
    if !matches!(extension(path).as_str(), "ply" | "glb") {
        let path = path.display();
        return Err(Failure::Usage(format!("--bake {path}: only ply and glb can be written")));
    }
    if !method.bakes() {
        let name = method.info().name;
        let message =
            format!("--bake: what `{name}` finds depends on the view; use `-m radiosity`");
        return Err(Failure::Usage(message));
    }
    check_place(path)
}

/// Writes what the method found.
///
/// # Errors
/// If it can't be written.
pub fn write(path: &Path, scene: &Scene, method: &dyn Method) -> Result<(), Failure> {
    let Some(mesh) = method.baked(scene) else { return Ok(()) };
    match extension(path).as_str() {
        "glb" => {
            write_glb(path, &mesh).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))
        }
        _ => write_ply(path, &mesh).map_err(Failure::input),
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
