//! `kaustika render --bake`: light on surfaces, written as a mesh or as a light map.

use super::failure::Failure;
use super::picture::check_place;
use kaustika::film::Picture;
use kaustika::film::files::{self, WriteOptions};
use kaustika::formats::gltf::write_glb;
use kaustika::formats::mesh::write_ply;
use kaustika::scene::Scene;
use kaustika::transport::Method;
use std::path::{Path, PathBuf};

/// Refuses what could not be written in the end.
///
/// # Errors
/// An unknown extension or a method that bakes nothing is wrong usage, a missing folder wrong input.
pub fn check(path: &Path, method: &dyn Method) -> Result<(), Failure> {
    if !matches!(extension(path).as_str(), "ply" | "glb" | "exr") {
        let path = path.display();
        return Err(Failure::Usage(format!("--bake {path}: only ply, glb and exr can be written")));
    }
    if !method.bakes() {
        let name = method.info().name;
        let message =
            format!("--bake: what `{name}` finds depends on the view; use `-m radiosity`");
        return Err(Failure::Usage(message));
    }
    check_place(path)
}

/// Writes what the method found; the files.
///
/// # Errors
/// If they can't be written.
pub fn write(path: &Path, scene: &Scene, method: &dyn Method) -> Result<Vec<PathBuf>, Failure> {
    match extension(path).as_str() {
        "exr" => return write_map(path, scene, method),
        "glb" => {
            let Some(mesh) = method.baked(scene) else { return Ok(Vec::new()) };
            let told = |e| Failure::Input(format!("{}: {e}", path.display()));
            write_glb(path, &mesh).map_err(told)?;
        }
        _ => {
            let Some(mesh) = method.baked(scene) else { return Ok(Vec::new()) };
            write_ply(path, &mesh).map_err(Failure::input)?;
        }
    }
    Ok(vec![path.into()])
}

/// A light map, and beside it the mesh that it belongs on.
fn write_map(path: &Path, scene: &Scene, method: &dyn Method) -> Result<Vec<PathBuf>, Failure> {
    let Some(map) = method.light_map(scene) else {
        let message = format!(
            "--bake {}: the light map would be larger than 16384 x 16384; set fewer `patches`, or \
             bake a mesh (.ply, .glb)",
            path.display()
        );
        return Err(Failure::Input(message));
    };
    let [w, h] = map.size;
    let mut picture = Picture::from_rgb(w, h, &map.radiance);
    for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
        let values = map.irradiance.iter().map(|h| h[k]).collect();
        picture.push(format!("Irradiance.{name}"), values);
    }
    files::write_picture(path, &picture, &WriteOptions::default()).map_err(Failure::input)?;
    let mesh = path.with_extension("uv.ply");
    write_ply(&mesh, &map.mesh).map_err(Failure::input)?;
    Ok(vec![path.into(), mesh])
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
