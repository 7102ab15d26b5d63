//! Short words for putting a scene together.

use kaustika_math::Transform;
use kaustika_scene::description::{
    Distribution, GeometryDesc, MaterialId, MaterialModel, RoughnessDesc, SceneDescription,
    ShapeDesc, TriMesh,
};
use std::sync::Arc;

/// A scene in the making.
#[derive(Default)]
pub struct Stage {
    /// What is there so far.
    pub scene: SceneDescription,
}

impl Stage {
    /// Adds a Lambertian material of this linear sRGB albedo.
    pub fn diffuse(&mut self, name: impl Into<String>, albedo: [f32; 3]) -> MaterialId {
        let reflectance = self.scene.rgb(albedo);
        self.scene.add_material(name, MaterialModel::Diffuse { reflectance }, None)
    }

    /// GGX roughness along and across the first tangent.
    pub fn roughness(&mut self, alpha_u: f32, alpha_v: f32) -> RoughnessDesc {
        RoughnessDesc {
            distribution: Distribution::Ggx,
            alpha_u: self.scene.float(alpha_u),
            alpha_v: self.scene.float(alpha_v),
            remap: false,
        }
    }

    /// Adds a shape that does not emit, and returns it for further detail.
    pub fn shape(
        &mut self,
        name: &str,
        material: MaterialId,
        geometry: GeometryDesc,
        transform: Transform,
    ) -> &mut ShapeDesc {
        self.scene.shapes.push(ShapeDesc {
            name: name.to_string(),
            geometry,
            transform,
            flip_normals: false,
            material,
            emission: None,
            alpha: None,
            interior: None,
            exterior: None,
            span: None,
        });
        self.scene.shapes.last_mut().expect("one was just pushed")
    }

    /// Adds a mesh.
    pub fn mesh(&mut self, name: &str, material: MaterialId, mesh: TriMesh, place: Transform) {
        self.shape(name, material, GeometryDesc::Mesh(Arc::new(mesh)), place);
    }

    /// Adds a whole sphere.
    pub fn sphere(&mut self, name: &str, material: MaterialId, radius: f32, place: Transform) {
        let geometry =
            GeometryDesc::Sphere { radius, z_min: -radius, z_max: radius, phi_max: 360.0 };
        self.shape(name, material, geometry, place);
    }
}
