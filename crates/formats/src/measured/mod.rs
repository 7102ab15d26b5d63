//! Measured materials: the `.bsdf` files of the RGL material database (Dupuy & Jakob 2018, "An
//! Adaptive Parameterization for Efficient Material Acquisition and Rendering"), spectral and RGB,
//! isotropic and anisotropic.

mod polarized;
mod tensor;
#[cfg(test)]
pub(crate) mod tests;

pub use polarized::parse_polarized;

use kaustika_scene::description::{MeasuredBrdf, MeasuredChannels, MeasuredMueller, SquareTable};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tensor::TensorFile;

/// Measured materials that were read, each once.
#[derive(Debug, Default)]
pub(crate) struct MeasuredFiles {
    known: HashMap<PathBuf, Arc<MeasuredBrdf>>,
    polarized: HashMap<PathBuf, Arc<MeasuredMueller>>,
}

impl MeasuredFiles {
    /// As [`read_measured`].
    pub(crate) fn read(&mut self, path: &Path) -> Result<Arc<MeasuredBrdf>, String> {
        if let Some(known) = self.known.get(path) {
            return Ok(known.clone());
        }
        let brdf = Arc::new(read_measured(path)?);
        self.known.insert(path.to_owned(), brdf.clone());
        Ok(brdf)
    }

    /// Reads a material that polarizes.
    ///
    /// # Errors
    /// A one-line cause: the file can't be read, or as [`parse_polarized`].
    pub(crate) fn read_polarized(&mut self, path: &Path) -> Result<Arc<MeasuredMueller>, String> {
        if let Some(known) = self.polarized.get(path) {
            return Ok(known.clone());
        }
        let made = Arc::new(parse_polarized(std::fs::read(path).map_err(|e| e.to_string())?)?);
        self.polarized.insert(path.to_owned(), made.clone());
        Ok(made)
    }
}

/// Reads a measured material.
///
/// # Errors
/// A one-line cause: the file can't be read, or lacks something, or sizes disagree.
pub fn read_measured(path: &Path) -> Result<MeasuredBrdf, String> {
    parse(std::fs::read(path).map_err(|e| e.to_string())?)
}

/// Reads a measured material from the bytes of its file.
///
/// # Errors
/// As [`read_measured`].
pub fn parse(bytes: Vec<u8>) -> Result<MeasuredBrdf, String> {
    let file = TensorFile::new(bytes)?;
    let (phi, [phis]) = file.floats("phi_i")?;
    let (theta, [thetas]) = file.floats("theta_i")?;
    increasing("phi_i", &phi)?;
    increasing("theta_i", &theta)?;
    let (reflectance, channels) = if file.has("wavelengths") {
        let (wavelengths, _) = file.floats::<1>("wavelengths")?;
        increasing("wavelengths", &wavelengths)?;
        ("spectra", MeasuredChannels::Wavelengths(wavelengths))
    } else {
        ("rgb", MeasuredChannels::Rgb)
    };
    let (values, shape) = file.floats::<5>(reflectance)?;
    let brdf = MeasuredBrdf {
        ndf: square("ndf", file.floats("ndf")?)?,
        sigma: square("sigma", file.floats("sigma")?)?,
        vndf: squares("vndf", file.floats("vndf")?, [phis, thetas])?,
        luminance: squares("luminance", file.floats("luminance")?, [phis, thetas])?,
        reflectance: {
            let [p, t, c, height, width] = shape;
            if c != channels.count() {
                let message = format!("has {c} channels, not {}", channels.count());
                return Err(format!("field `{reflectance}` {message}"));
            }
            squares(reflectance, (values, [p, t, height, width]), [phis, thetas])?
        },
        phi,
        theta,
        channels,
        jacobian: file.byte("jacobian")? != 0,
    };
    Ok(brdf)
}

fn increasing(name: &str, values: &[f32]) -> Result<(), String> {
    if values.is_empty() {
        return Err(format!("field `{name}` is empty"));
    }
    match values.windows(2).position(|w| w[0] >= w[1]) {
        Some(i) => Err(format!("number {} of field `{name}` is not above the one before", i + 1)),
        None => Ok(()),
    }
}

fn square(name: &str, (values, size): (Vec<f32>, [usize; 2])) -> Result<SquareTable, String> {
    let [height, width] = size;
    if width < 2 || height < 2 {
        return Err(format!("field `{name}` has {height} by {width} values, fewer than 2 by 2"));
    }
    Ok(SquareTable { width, height, values })
}

/// A table for each of `nodes`.
fn squares(
    name: &str,
    (values, shape): (Vec<f32>, [usize; 4]),
    nodes: [usize; 2],
) -> Result<SquareTable, String> {
    let [p, t, height, width] = shape;
    if [p, t] != nodes {
        let [phis, thetas] = nodes;
        let message = format!("{p} by {t} directions, `phi_i` and `theta_i` {phis} by {thetas}");
        return Err(format!("field `{name}` has {message}"));
    }
    square(name, (values, [height, width]))
}
