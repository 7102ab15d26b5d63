//! A camera and a light for files that have none.

use super::Reader;
use super::cameras::{ASPECT, camera};
use kaustika_math::{Bounds3, Transform, Vec3};
use kaustika_scene::description::{
    CameraKind, EmissionDesc, FovAxis, GeometryDesc, LightDesc, LightKind, ShapeDesc, TextureNode,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

/// Field of view of the camera, degrees of the picture's height.
const FOV: f32 = 40.0;
/// How steeply it looks down: the height of its place over the distance along z.
const SLOPE: f32 = 0.25;

fn bounds(shapes: &[ShapeDesc]) -> Bounds3 {
    let mut all = Bounds3::EMPTY;
    for s in shapes {
        if let GeometryDesc::Mesh(mesh) = &s.geometry {
            let used = mesh.indices.iter().flatten();
            all =
                used.fold(all, |b, i| b.with_point(s.transform.point(mesh.positions[*i as usize])));
        }
    }
    all
}

impl Reader<'_> {
    /// Adds what is missing, with a note.
    pub(super) fn defaults(&mut self) {
        if self.out.cameras.is_empty() {
            self.default_camera();
        }
        let groups = self.out.groups.iter().flat_map(|g| &g.shapes);
        let shapes = self.out.shapes.iter().chain(groups);
        if !self.unlit.is_empty() && shapes.clone().all(|s| self.unlit.contains(&s.material)) {
            return;
        }
        let emissions = shapes.filter_map(|s| s.emission.as_ref());
        // Textures of strength 1 are signs and dials, which light nothing.
        let textures = &self.out.textures;
        let textured = |e: &EmissionDesc| {
            matches!(textures[e.radiance.0 as usize].node, TextureNode::Scale { .. })
        };
        let shines = emissions.clone().any(|e| e.scale > 1.0 || !textured(e));
        if self.out.lights.is_empty() && !shines {
            let but = if emissions.count() > 0 { " but emissive textures" } else { "" };
            self.out.diagnostics.note(
                None,
                format!(
                    "the file has no light{but}: a white sky of radiance 1 is around it \
                     (`--environment` puts another one there)"
                ),
            );
            let radiance = SpectrumDesc::Rgb { rgb: [1.0; 3], space: ColorSpace::Srgb };
            self.out.lights.push(LightDesc {
                name: "sky".into(),
                kind: LightKind::Constant { radiance, scale: 1.0, illuminance: None },
                transform: Transform::IDENTITY,
                medium: None,
                span: None,
            });
        }
    }

    /// Looks down -z, slightly from above, at the sphere around everything.
    fn default_camera(&mut self) {
        let mut all = bounds(&self.out.shapes);
        for i in &self.out.instances {
            all =
                all.union(i.transform.bounds(&bounds(&self.out.groups[i.group.0 as usize].shapes)));
        }
        let (center, radius) = all.bounding_sphere();
        let (center, radius) = match radius > 0.0 && radius.is_finite() {
            true => (center, radius),
            false => (Vec3::ZERO, 1.0),
        };
        let distance = radius / (0.5 * FOV).to_radians().sin();
        let eye = center + Vec3::new(0.0, SLOPE, 1.0).normalize() * distance;
        // +x is right where the direction times up is.
        let forward = (center - eye).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let up = right.cross(forward);
        let row = |i: usize| [right[i], up[i], forward[i], eye[i]];
        let place = Transform::from_rows([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]);
        let kind = CameraKind::Perspective {
            fov: FOV,
            fov_axis: FovAxis::Y,
            principal_point: [0.0; 2],
            screen_window: None,
            lens_radius: 0.0,
            focus_distance: 1.0,
            near_clip: 1e-3 * radius,
            far_clip: f32::INFINITY,
        };
        let place = place.unwrap_or(Transform::IDENTITY);
        self.out.cameras.push(camera("default", kind, ASPECT, place, None));
        self.out.diagnostics.note(
            None,
            format!(
                "the file has no camera: one at ({:.3}, {:.3}, {:.3}) looks down -z at the sphere \
                 around everything",
                eye.x, eye.y, eye.z
            ),
        );
    }
}
