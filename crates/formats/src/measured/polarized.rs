//! Polarizing materials as measured by Baek et al. 2020, "Image-Based Acquisition and Modeling of
//! Polarimetric Reflectance": the `.pbsdf` files of the KAIST pBRDF dataset.
//!
//! Fields `phi_d`, `theta_d`, `theta_h` (1 x n, radians), `wvls` (nm), and `M` (φ_d x θ_d x θ_h x
//! wavelength x 4 x 4), in the container of [`super::tensor`].

use super::increasing;
use super::tensor::TensorFile;
use kaustika_scene::description::MeasuredMueller;

/// Reads a polarizing material from the bytes of its file.
///
/// # Errors
/// A one-line cause: it lacks something, or sizes disagree.
pub fn parse_polarized(bytes: Vec<u8>) -> Result<MeasuredMueller, String> {
    let file = TensorFile::new(bytes)?;
    let axis = |name: &str| {
        let (values, [rows, _]) = file.floats::<2>(name)?;
        if rows != 1 {
            return Err(format!("field `{name}` has {rows} rows, not one"));
        }
        increasing(name, &values)?;
        Ok(values)
    };
    let wavelengths: Vec<f32> = file.shorts("wvls")?.into_iter().map(f32::from).collect();
    increasing("wvls", &wavelengths)?;
    // NaN stands for what was not measured.
    let (values, shape) = file.floats_or_nan::<6>("M")?;
    let out = MeasuredMueller {
        phi_d: axis("phi_d")?,
        theta_d: axis("theta_d")?,
        theta_h: axis("theta_h")?,
        wavelengths,
        values,
    };
    let lengths = [&out.phi_d, &out.theta_d, &out.theta_h, &out.wavelengths].map(Vec::len);
    let [p, d, h, l] = lengths;
    if shape != [p, d, h, l, 4, 4] {
        let found = shape.map(|n| n.to_string()).join(" x ");
        return Err(format!("field `M` is {found}, not {p} x {d} x {h} x {l} x 4 x 4"));
    }
    Ok(out)
}
