//! What a camera path meets first is like, for the layers that people ask for.

use crate::frame::Frame;
use crate::path_space::Vertex;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

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
    let (n, ns) = (s.ng, bsdf.shading_normal());
    let (n, ns) = match scene.shows_facing_normals() {
        true => (n.face_forward(wo), ns.face_forward(wo)),
        // Materials turn their frame over on the back.
        false => (n, ns.face_forward(n)),
    };
    record.normal = n.into();
    record.shading_normal = ns.into();
    record.depth = s.t;
    record.position = s.p.into();
    record.uv = [s.uv.x, s.uv.y];
    record.shape = s.shape + 1;
    record.material = scene.material_of(s).0 + 1;
}

/// Features of the first surface that a camera ray meets, for methods whose paths begin elsewhere.
pub fn first_seen(scene: &Scene, frame: &Frame, pixel: [u32; 2], index: u64) -> PixelRecord {
    let mut sampler = frame.sampler.start(pixel, index);
    let u = sampler.get_vertex();
    let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
    let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
    let mut lambda = Wavelengths::sample_for(scene.mode, u[5]);
    let mut record = PixelRecord::default();
    let wo = -camera.ray.d;
    if let Some(surface) = scene.intersect(&camera.ray, camera.t_max)
        && let Some(bsdf) = scene.bsdf(&surface, wo, &mut lambda)
    {
        describe(scene, &surface, &bsdf, wo, &lambda, &mut record);
    }
    record
}

/// Features of a point in a medium, at distance `t`: those that it has.
pub fn describe_matter(
    albedo: Spectrum,
    lambda: &Wavelengths,
    (p, t): (Vec3, f32),
    record: &mut PixelRecord,
) {
    let albedo = kaustika_spectra::Sensor::default().rgb(albedo, lambda);
    record.albedo = albedo.map(|v| v.clamp(0.0, 1.0));
    record.depth = t;
    record.position = p.into();
}

/// Features of the first vertex of an eye's subpath.
pub fn describe_vertex(scene: &Scene, v: &Vertex, record: &mut PixelRecord) {
    let s = &v.surface;
    match v.medium.filter(|_| v.inside.is_some()) {
        None => describe(scene, s, &v.bsdf, v.wo, &v.lambda, record),
        Some(medium) => {
            let c = scene.medium(medium).at(s.p, v.wo, &v.lambda);
            let albedo = c.sigma_s.safe_div(c.sigma_t);
            describe_matter(albedo, &v.lambda, (s.p, s.t), record);
        }
    }
}
