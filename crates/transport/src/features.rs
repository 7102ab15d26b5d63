//! What the first surface of a camera path is like, for the layers that people ask for.

use kaustika_film::accumulate::PixelRecord;
use kaustika_math::Vec3;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::Wavelengths;

/// Features of the first surface.
pub fn describe(
    scene: &Scene,
    s: &Surface,
    bsdf: &Bsdf,
    wo: Vec3,
    lambda: &Wavelengths,
    record: &mut PixelRecord,
) {
    record.albedo = match s.light {
        Some(_) => [1.0; 3],
        None => kaustika_spectra::Sensor::default()
            .rgb(bsdf.albedo(wo), lambda)
            .map(|v| v.clamp(0.0, 1.0)),
    };
    record.normal = s.ng.into();
    record.shading_normal = bsdf.shading_normal().into();
    record.depth = s.t;
    record.position = s.p.into();
    record.uv = [s.uv.x, s.uv.y];
    record.shape = s.shape + 1;
    record.material = scene.material_of(s).0 + 1;
}
