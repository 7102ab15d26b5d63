//! The lens of a `realistic` camera.

use super::build::Builder;
use super::entity::Entity;
use kaustika_scene::description::{ApertureShape, LensDesc, LensSurface};
use std::sync::Arc;

impl Builder {
    /// The lens file holds four numbers a surface, in millimetres, from the scene to the film:
    /// radius of curvature, thickness, index of refraction and diameter; a radius of 0 is the stop.
    pub fn lens(&mut self, e: &mut Entity, film_diagonal: f32) -> Option<LensDesc> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let diameter = p.float(diag, "aperturediameter", 1.0);
        let focus_distance = p.float(diag, "focusdistance", 10.0);
        let aperture = p.string(diag, "aperture");
        let Some(name) = p.string(diag, "lensfile") else {
            if !p.has("lensfile") {
                let message = "camera `realistic` needs \"string lensfile\"";
                diag.error(e.kind.span, message);
            }
            return None;
        };
        let path = self.file(&name, "lens file")?;
        let numbers = std::fs::read_to_string(&path).map_err(|e| e.to_string());
        let mut surfaces = match numbers.and_then(|text| surfaces(&text)) {
            Ok(surfaces) => surfaces,
            Err(cause) => {
                let message = format!("can't read the lens file `{}`: {cause}", name.text);
                self.desc.diagnostics.error(name.span, message);
                return None;
            }
        };
        for stop in surfaces.iter_mut().filter(|s| s.radius == 0.0) {
            let radius = 0.5e-3 * diameter;
            if radius > stop.aperture_radius {
                let message = format!(
                    "the aperture is {diameter} mm wide, the stop of the lens {} mm",
                    2e3 * stop.aperture_radius
                );
                let place = e.params.place("aperturediameter");
                self.desc.diagnostics.warning(place, message).label("as wide as the stop");
            } else {
                stop.aperture_radius = radius;
            }
        }
        let aperture = match aperture {
            None => None,
            Some(shape) => match shape.text.as_str() {
                "" => None,
                "gaussian" => Some(ApertureShape::Gaussian),
                "square" => Some(ApertureShape::Square),
                "pentagon" => Some(ApertureShape::Pentagon),
                "star" => Some(ApertureShape::Star),
                _ => {
                    let path = self.file(&shape, "aperture image")?;
                    match kaustika_film::read_bitmap(&path) {
                        Ok(bitmap) => Some(ApertureShape::Image(Arc::new(bitmap))),
                        Err(cause) => {
                            let message = format!("can't read image {cause}");
                            self.desc.diagnostics.error(shape.span, message);
                            return None;
                        }
                    }
                }
            },
        };
        Some(LensDesc { surfaces, focus_distance, film_diagonal, aperture })
    }
}

/// An error is a one-line cause.
fn surfaces(text: &str) -> Result<Vec<LensSurface>, String> {
    let mut numbers = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        for word in content.split_whitespace() {
            match word.parse::<f32>() {
                Ok(v) if v.is_finite() => numbers.push(v),
                _ => return Err(format!("line {}: expected a number, found `{word}`", i + 1)),
            }
        }
    }
    if numbers.is_empty() || numbers.len() % 4 != 0 {
        let count = numbers.len();
        return Err(format!("expected four numbers for each surface, found {count} in all"));
    }
    let surface = |v: &[f32]| LensSurface {
        radius: 1e-3 * v[0],
        thickness: 1e-3 * v[1],
        ior: v[2],
        aperture_radius: 0.5e-3 * v[3],
    };
    let made: Vec<LensSurface> = numbers.chunks(4).map(surface).collect();
    match made.iter().position(|s| s.ior < 0.0 || s.aperture_radius <= 0.0) {
        Some(i) => Err(format!("surface {} has a negative index or no diameter", i + 1)),
        None => Ok(made),
    }
}
