//! Displaced meshes.

use super::Gathered;
use crate::description::{DisplacedMesh, GeometryDesc, SceneDescription, ShapeDesc, TriMesh};
use crate::displace::displaced;
use crate::error::BuildError;
use crate::texture::{AttributeTable, TexturePoint, Textures};
use kaustika_spectra::{ColorMode, SpectrumRole};

impl Gathered {
    pub(super) fn displace(
        &self,
        desc: &ShapeDesc,
        of: &DisplacedMesh,
    ) -> Result<TriMesh, BuildError> {
        let height = |at: &TexturePoint| self.heights.float(of.height, at);
        displaced(&of.mesh, &desc.transform, of.edge_length, height).ok_or_else(|| {
            let message = format!(
                "edges shorter than {} make more than 2^25 triangles of a displaced mesh; allow longer \
                 ones",
                of.edge_length
            );
            BuildError::new(desc.span, message)
        })
    }
}

/// The textures as displaced meshes need them; none if there are no such meshes.
pub(super) fn heights(description: &SceneDescription) -> Textures {
    let mut shapes =
        description.shapes.iter().chain(description.groups.iter().flat_map(|g| &g.shapes));
    if !shapes.any(|s| matches!(s.geometry, GeometryDesc::Displaced(_))) {
        return Textures::default();
    }
    let role = |_| SpectrumRole::Unbounded;
    Textures::new(description, ColorMode::Rgb, role, |_| AttributeTable::default())
}
