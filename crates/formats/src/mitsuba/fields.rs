//! Shapes from sampled fields: signed distance grids and sets of ellipsoids.

use super::convert::Converter;
use super::document::Object;
use crate::mesh::ply::{StoredEllipsoid, read_ellipsoids};
use crate::vol;
use kaustika_scene::description::{Ellipsoid, GeometryDesc, SdfGrid, SdfNormals};
use std::sync::Arc;

/// Opacity below which a Gaussian is not seen, where ellipsoids end if their extent adapts
/// (Mitsuba 3, ellipsoids.h).
const FAINT: f32 = 0.01;

impl<'a> Converter<'a> {
    /// `sdfgrid`
    pub(super) fn sdf_grid(&mut self, object: &'a Object) -> Option<GeometryDesc> {
        let known = [("smooth", SdfNormals::Smooth), ("analytic", SdfNormals::Analytic)];
        let normals = self.choice(object, "normals", &known, SdfNormals::Smooth);
        let (path, span) = self.file(object, "filename")?;
        let mut fault = |cause: &str| {
            let message = format!("can't read the distance grid `{}`: {cause}", path.display());
            self.out.diagnostics.error(span, message);
            None
        };
        let file = match vol::read(&path, vol::Samples::Distances) {
            Ok(file) => file,
            Err(cause) => return fault(&cause),
        };
        if file.channels != 1 {
            return fault(&format!("it has {} channels, expected 1", file.channels));
        }
        if file.resolution.contains(&1) {
            let [x, y, z] = file.resolution;
            return fault(&format!("{x} x {y} x {z} samples enclose no cells"));
        }
        let grid = SdfGrid { resolution: file.resolution, values: file.values, normals };
        if grid.crossed_cells().next().is_none() {
            return fault("its distances are all of one sign: there is no surface");
        }
        Some(GeometryDesc::SdfGrid(Arc::new(grid)))
    }

    /// `ellipsoids`
    pub(super) fn ellipsoids(&mut self, object: &'a Object) -> Option<GeometryDesc> {
        let factor = self.positive(object, "scale_factor", 1.0);
        let extent = self.positive(object, "extent", 3.0);
        let mut adapts = self.boolean(object, "extent_adaptive_clamping", false);
        let (path, span) = self.file(object, "filename")?;
        let stored = match read_ellipsoids(&path) {
            Ok(stored) => stored,
            Err(cause) => {
                self.out.diagnostics.error(span, format!("can't read ellipsoids {cause}"));
                return None;
            }
        };
        if adapts && stored.iter().any(|s| s.opacity.is_none()) {
            let message = "without opacities in its file the extent of ellipsoids can't adapt";
            self.out.diagnostics.warning(span, message).label("it is the same for all");
            adapts = false;
        }
        let grown = |s: &StoredEllipsoid| {
            let extent = match s.opacity.filter(|_| adapts) {
                Some(opacity) => extent / 3.0 * (2.0 * (opacity / FAINT).ln()).sqrt(),
                None => extent,
            };
            // What is fainter than faint has no extent.
            let radii = s.ellipsoid.radii * (factor * extent);
            (extent > 0.0).then_some(Ellipsoid { radii, ..s.ellipsoid })
        };
        Some(GeometryDesc::Ellipsoids(Arc::new(stored.iter().filter_map(grown).collect())))
    }
}
