//! The light around the scene, as `--environment` gives it.

use kaustika_film::{ImageError, read_bitmap};
use kaustika_math::Transform;
use kaustika_scene::description::{EnvironmentLayout, LightDesc, LightKind, SceneDescription};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

/// Light from all around.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same linear sRGB radiance from everywhere.
    Constant([f32; 3]),
    /// An image: a square one is taken as equal-area octahedral (pbrt), any other as
    /// latitude-longitude with +y up.
    Image(PathBuf),
}

impl FromStr for Environment {
    type Err = String;

    /// `R,G,B`, or the path of an image.
    fn from_str(text: &str) -> Result<Environment, String> {
        let numbers: Option<Vec<f32>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[r, g, b]) => {
                let rgb = [r, g, b];
                if rgb.iter().all(|v| v.is_finite() && *v >= 0.0) {
                    Ok(Environment::Constant(rgb))
                } else {
                    Err("radiance must be finite and not negative".into())
                }
            }
            Some(numbers) => {
                Err(format!("expected R,G,B or a file, found {} numbers", numbers.len()))
            }
            None => Ok(Environment::Image(text.into())),
        }
    }
}

impl Environment {
    /// Puts this light around the scene in place of the one the scene has, if any.
    ///
    /// # Errors
    /// If the image can't be read.
    pub fn replace_in(&self, description: &mut SceneDescription) -> Result<(), ImageError> {
        let (scale, illuminance) = (1.0, None);
        let kind = match self {
            Environment::Constant(rgb) => {
                let radiance = SpectrumDesc::Rgb { rgb: *rgb, space: ColorSpace::Srgb };
                LightKind::Constant { radiance, scale, illuminance }
            }
            Environment::Image(path) => {
                let bitmap = Arc::new(read_bitmap(path)?);
                let layout = match bitmap.width == bitmap.height {
                    true => EnvironmentLayout::EqualArea,
                    false => EnvironmentLayout::LatLong,
                };
                let space = ColorSpace::Srgb;
                LightKind::Image { bitmap, space, layout, scale, illuminance }
            }
        };
        description.lights.retain(|l| {
            !matches!(
                l.kind,
                LightKind::Constant { .. }
                    | LightKind::Image { .. }
                    | LightKind::Portal { .. }
                    | LightKind::Sky { .. }
                    | LightKind::Sun { .. }
            )
        });
        description.lights.push(LightDesc {
            name: "environment".into(),
            kind,
            transform: Transform::IDENTITY,
            medium: None,
            span: None,
        });
        Ok(())
    }
}
