//! Media from NanoVDB files (pbrt-v4, media.cpp).

use super::build::Builder;
use super::entity::Entity;
use super::media::Parts;
use crate::nanovdb::{DenseGrid, NanoVdbFile};
use kaustika_math::{Bounds3, Transform};
use kaustika_scene::description::{
    DensityDesc, GlowDesc, GlowSource, GridDesc, GridFilter, GridLayout,
};
use std::sync::Arc;

impl Builder {
    /// `nanovdb`
    pub(super) fn nanovdb(&mut self, e: &mut Entity, to_world: &Transform) -> Option<Parts> {
        let coefficients = self.coefficients(e);
        let diag = &mut self.desc.diagnostics;
        let mut name = |name, default: &str| {
            e.params.string(diag, name).map_or_else(|| default.to_owned(), |t| t.text)
        };
        let (density_name, temperature_name) =
            (name("gridname", "density"), name("temperaturename", "temperature"));
        let cutoff = e.params.float(diag, "temperaturecutoff", 0.0);
        let offset = e.params.float(diag, "temperatureoffset", cutoff);
        let factor = e.params.float(diag, "temperaturescale", 1.0);
        let scale = e.params.float(diag, "Lescale", 1.0);
        let Some(filename) = e.params.string(diag, "filename") else {
            if !e.params.has("filename") {
                diag.error(e.span, "medium `nanovdb` needs `filename`");
            }
            return None;
        };
        let path = self.file(&filename, "volume")?;
        let read = NanoVdbFile::read(&path).and_then(|file| {
            let Some(density) = file.grid(&density_name)? else {
                let names = file.names().join("`, `");
                return Err(format!("no grid is called `{density_name}` (there are: `{names}`)"));
            };
            Ok((density, file.grid(&temperature_name)?))
        });
        let (density, temperature) = match read {
            Ok(grids) => grids,
            Err(cause) => {
                let message = format!("can't read the volume `{}`: {cause}", path.display());
                self.desc.diagnostics.error(filename.span, message);
                return None;
            }
        };
        let own = bounds(&density).union(temperature.as_ref().map_or(Bounds3::EMPTY, bounds));
        let Some(size) = Transform::scale(own.diagonal()) else {
            let message = format!("the volume `{}` has no extent", path.display());
            self.desc.diagnostics.error(filename.span, message);
            return None;
        };
        let glow = temperature.filter(|_| scale > 0.0).map(|t| {
            let grid = described(t, to_world);
            GlowDesc { source: GlowSource::Temperature { grid, offset, factor }, scale, grid: None }
        });
        let density = Some(DensityDesc::Grid(described(density, to_world)));
        let extent = Some(*to_world * Transform::translate(own.min) * size);
        Some(Parts { coefficients, density, extent, glow })
    }
}

/// Where a grid is, in its own space.
fn bounds(grid: &DenseGrid) -> Bounds3 {
    let [min, max] = grid.index_box();
    grid.to_world.bounds(&Bounds3::new(min, max))
}

/// A grid in a medium's space. Its samples lie on whole indices, the description's in the middle
/// of cells.
fn described(grid: DenseGrid, to_world: &Transform) -> Arc<GridDesc> {
    let [min, max] = grid.index_box();
    let half = kaustika_math::Vec3::splat(0.5);
    // Resolutions are at least 1: nothing is flat.
    let size = Transform::scale(max - min).unwrap_or_default();
    let cells = Transform::translate(min - half) * size;
    Arc::new(GridDesc {
        resolution: grid.resolution,
        channels: 1,
        values: grid.values,
        to_world: *to_world * grid.to_world * cells,
        layout: GridLayout::CellsFading,
        filter: GridFilter::Trilinear,
    })
}
