//! PLY files of ellipsoids, as programs for radiance fields of Gaussians write them (Kerbl et al.
//! 2023, "3D Gaussian splatting for real-time radiance field rendering").
//!
//! A record has `x y z`, `scale_0` to `scale_2` (natural logarithms), `rot_0` to `rot_3` (a
//! quaternion, w first), and perhaps `opacity` (its logit) or `opacities` (as they are). What
//! else it has is passed over.

use super::header::{self, Element, Encoding};
use super::values::{Ascii, BLOCK, Binary, Values};
use super::{attributes::Slots, check_count};
use crate::mesh::error::{Fault, MeshCause, MeshError, Place};
use crate::mesh::read_file;
use kaustika_math::Vec3;
use kaustika_scene::description::Ellipsoid;
use std::path::Path;

/// An ellipsoid as a file has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredEllipsoid {
    /// With the file's scales as radii, at least 10⁻⁶ as in Mitsuba.
    pub ellipsoid: Ellipsoid,
    /// In [0, 1] if the file has it.
    pub opacity: Option<f32>,
}

/// Reads the ellipsoids of a PLY file.
///
/// # Errors
///
/// The file cannot be read, lacks a property, or is damaged; a number is not finite; a quaternion
/// is zero.
pub fn read_ellipsoids(path: &Path) -> Result<Vec<StoredEllipsoid>, MeshError> {
    let parsed = read_file(path).and_then(|bytes| parse(&bytes));
    parsed.map_err(|fault| MeshError::new(path, fault))
}

pub(super) fn parse(bytes: &[u8]) -> Result<Vec<StoredEllipsoid>, Fault> {
    let header = header::parse(bytes)?;
    let body = &bytes[header.length..];
    let Some(element) = header.elements.first() else {
        return Err(header_fault("there are no elements".into()));
    };
    match header.encoding {
        Encoding::Ascii => read(Ascii::new(bytes, header.length), element),
        Encoding::LittleEndian => read(Binary::<false>::new(body), element),
        Encoding::BigEndian => read(Binary::<true>::new(body), element),
    }
}

fn read<V: Values>(mut values: V, element: &Element) -> Result<Vec<StoredEllipsoid>, Fault> {
    let mut slots = Slots::new(element);
    let mut claim = |names: &[&str]| slots.claim(element, names);
    let optional = [claim(&["opacity"]), claim(&["opacities"])];
    let mut needed = |names: &[&str]| {
        claim(names).ok_or_else(|| {
            let message = format!("element `{}` lacks `{}`", element.name, names.join(" "));
            header_fault(message)
        })
    };
    let center = needed(&["x", "y", "z"])?;
    let scale = needed(&["scale_0", "scale_1", "scale_2"])?;
    let rotation = needed(&["rot_1", "rot_2", "rot_3", "rot_0"])?;
    check_count(&values, element)?;

    let mut columns = vec![[0.0; BLOCK]; slots.columns];
    let mut all = Vec::with_capacity(element.count as usize);
    while (all.len() as u64) < element.count {
        let first = all.len() as u64;
        let n = (element.count - first).min(BLOCK as u64) as usize;
        values.block(element, &slots.of_property, &mut columns, first, n)?;
        for i in 0..n {
            let at = |slots: &[usize], k: usize| columns[slots[k]][i];
            let vector = |slots: &[usize]| Vec3::new(at(slots, 0), at(slots, 1), at(slots, 2));
            let radius = |k| at(&scale, k).exp().max(1e-6);
            let ellipsoid = Ellipsoid {
                center: vector(&center),
                radii: Vec3::new(radius(0), radius(1), radius(2)),
                rotation: [0, 1, 2, 3].map(|k| at(&rotation, k)),
            };
            let sound = ellipsoid.center.is_finite() && ellipsoid.radii.is_finite();
            if !sound || ellipsoid.place().is_none() {
                let what = if sound { "orientation" } else { "centre or scale" };
                let place = Place::entry(&element.name, first + i as u64);
                return Err(Fault::new(place, MeshCause::NotFinite(what)));
            }
            let logistic = |v: f32| 1.0 / (1.0 + (-v).exp());
            let opacity = match &optional {
                [Some(logit), _] => Some(logistic(at(logit, 0))),
                [None, Some(plain)] => Some(at(plain, 0)),
                [None, None] => None,
            };
            all.push(StoredEllipsoid { ellipsoid, opacity });
        }
    }
    Ok(all)
}

fn header_fault(message: String) -> Fault {
    Fault::new(Place::File, MeshCause::Header(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        property float f_dc_0\nproperty float opacity\nproperty float scale_0\n\
        property float scale_1\nproperty float scale_2\nproperty float rot_0\nproperty float rot_1\n\
        property float rot_2\nproperty float rot_3\nend_header\n";

    #[test]
    fn logarithms_logits_and_quaternions() {
        let body = "1 2 3 0 0 0 9 0 0 -1 -99 1 0 0 0\n0 0 0 0 0 0 9 40 0 0 0 0 0 0 2\n";
        let all = parse(format!("{HEADER}{body}").as_bytes()).expect("two ellipsoids");
        assert_eq!(all[0].ellipsoid.center, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(all[0].ellipsoid.radii, Vec3::new(1.0, (-1f32).exp(), 1e-6));
        assert_eq!(all[0].ellipsoid.rotation, [0.0, 0.0, 0.0, 1.0]);
        assert_eq!([all[0].opacity, all[1].opacity], [Some(0.5), Some(1.0)]);
        // Half a turn about z.
        let place = all[1].ellipsoid.place().expect("a placement");
        assert!((place.point(Vec3::X) + Vec3::X).length() < 1e-6);
    }

    #[test]
    fn faults_say_what_is_missing_and_where() {
        let fault = |text: String| {
            let fault = parse(text.as_bytes()).expect_err("must be refused");
            MeshError::new(Path::new("a.ply"), fault).to_string()
        };
        let whole = format!("{HEADER}0 0 0 0 0 0 0 0 0 0 0 1 0 0 0\n");
        assert!(fault(whole.clone()).starts_with("a.ply"), "{}", fault(whole.clone()));
        assert_eq!(
            fault(HEADER.replace("property float rot_2\n", "")),
            "a.ply: element `vertex` lacks `rot_1 rot_2 rot_3 rot_0`"
        );
        assert_eq!(
            fault(format!("{whole}0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n")),
            "a.ply, vertex 1: the orientation is not finite"
        );
        assert_eq!(
            fault(format!("{whole}nan 0 0 0 0 0 0 0 0 0 0 1 0 0 0\n")),
            "a.ply, vertex 1: the centre or scale is not finite"
        );
    }
}
