//! Analytic shapes: quadrics, ellipsoids, signed distance grids.

use super::Gathered;
use super::emitter::Emitter;
use crate::description::{Ellipsoid, SdfGrid, ShapeDesc};
use crate::error::BuildError;
use crate::light::AreaShape;
use crate::shape::{Quadric, QuadricForm};
use crate::surface::LightId;
use std::f32::consts::PI;
use std::sync::Arc;

impl Quadric {
    /// A quadric of shape number `shape`, without light; `phi_max` in degrees.
    pub(super) fn of(desc: &ShapeDesc, form: QuadricForm, phi_max: f32, shape: u32) -> Quadric {
        Quadric {
            form,
            phi_max: phi_max.to_radians().min(2.0 * PI),
            to_world: desc.transform,
            flip: desc.flip_normals,
            from_outside: false,
            shape,
            light: None,
        }
    }
}

impl Gathered {
    pub(super) fn add_quadric(&mut self, mut quadric: Quadric, emission: Option<Emitter>) {
        let number = self.quadrics.len() as u32;
        if let Some(e) = emission {
            quadric.light = Some(LightId(self.lights.len() as u32));
            let shape = match quadric.as_whole_sphere() {
                Some((center, radius)) => AreaShape::Sphere(number, center, radius),
                None => AreaShape::Quadric(number),
            };
            self.lights.push(e.light(shape));
        }
        self.quadrics.push(quadric);
    }

    pub(super) fn add_ellipsoids(
        &mut self,
        desc: &ShapeDesc,
        all: &[Ellipsoid],
        shape: u32,
        emission: Option<Emitter>,
    ) -> Result<(), BuildError> {
        for (i, ellipsoid) in all.iter().enumerate() {
            let place = ellipsoid.place().ok_or_else(|| {
                let message = format!("ellipsoid {i} is flat or has no orientation");
                BuildError::new(desc.span, message)
            })?;
            let form = QuadricForm::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0 };
            let quadric = Quadric {
                to_world: desc.transform * place,
                from_outside: true,
                ..Quadric::of(desc, form, 360.0, shape)
            };
            self.add_quadric(quadric, emission);
        }
        Ok(())
    }

    /// Distance grids do not shine.
    pub(super) fn add_sdf(
        &mut self,
        desc: &ShapeDesc,
        grid: &Arc<SdfGrid>,
        shape: u32,
    ) -> Result<(), BuildError> {
        let count = grid.resolution.iter().map(|n| u64::from(*n)).product::<u64>();
        if grid.resolution.iter().any(|n| *n < 2) || count != grid.values.len() as u64 {
            let message =
                "a distance grid needs 2 samples or more along each axis, and all of them";
            return Err(BuildError::new(desc.span, message));
        }
        if count > u64::from(u32::MAX) {
            return Err(BuildError::new(desc.span, "a distance grid has more than 2^32 samples"));
        }
        self.sdfs.add(grid, desc.transform, shape, desc.flip_normals);
        Ok(())
    }
}
