//! Small scenes, built in code, and the ways to measure them.

use kaustika_film::FilterDesc;
use kaustika_math::{Ray, Transform, Vec2, Vec3};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_scene::{CameraRay, LightSelection, LightSelectionKind, Scene, SceneOptions};
use kaustika_spectra::{ColorMode, ColorSpace, SpectrumDesc, Wavelengths};
use kaustika_transport::path::{Integrator, PathParams};
use kaustika_transport::{Frame, PassStats};
use serde_json::Value;
use std::sync::Arc;

/// A scene under construction.
#[derive(Clone, Default)]
pub struct Stage {
    pub d: SceneDescription,
    pub selection: Option<LightSelectionKind>,
}

/// No transform.
pub const HERE: Transform = Transform::IDENTITY;

/// A point or vector.
pub fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A translation.
pub fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::translate(v(x, y, z))
}

/// A scaling.
pub fn scale(x: f32, y: f32, z: f32) -> Transform {
    Transform::scale(v(x, y, z)).expect("not singular")
}

/// A rotation in degrees.
pub fn rotate(degrees: f32, axis: Vec3) -> Transform {
    Transform::rotate(degrees, axis).expect("an axis")
}

/// +z turned to -z about x.
pub fn down() -> Transform {
    rotate(180.0, Vec3::X)
}

/// A whole sphere.
pub fn sphere(radius: f32) -> GeometryDesc {
    GeometryDesc::Sphere { radius, z_min: -radius, z_max: radius, phi_max: 360.0 }
}

/// A whole disk in z = 0.
pub fn disk(radius: f32) -> GeometryDesc {
    GeometryDesc::Disk { height: 0.0, radius, inner_radius: 0.0, phi_max: 360.0 }
}

/// A mesh without normals.
pub fn mesh(positions: &[Vec3], indices: &[[u32; 3]]) -> GeometryDesc {
    GeometryDesc::Mesh(Arc::new(TriMesh {
        positions: positions.to_vec(),
        indices: indices.to_vec(),
        ..TriMesh::default()
    }))
}

/// Grey light: the same number in every lane of RGB mode.
pub fn grey(c: f32) -> SpectrumDesc {
    SpectrumDesc::Constant(c)
}

/// A picture of floats.
pub fn bitmap(width: u32, height: u32, f: impl Fn(f32, f32) -> [f32; 3]) -> Arc<Bitmap> {
    let texels = (0..width * height)
        .flat_map(|i| {
            let (x, y) = (i % width, i / width);
            f((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32)
        })
        .collect();
    let encoding = Encoding::Linear;
    Arc::new(Bitmap { width, height, channels: 3, texels: Texels::F32(texels), encoding })
}

impl Stage {
    /// Empty, with a camera at the origin that looks along +z.
    pub fn new() -> Stage {
        let mut stage = Stage::default();
        stage.camera(pinhole(90.0), HERE, [1, 1]);
        stage
    }

    /// Replaces the camera.
    pub fn camera(&mut self, kind: CameraKind, transform: Transform, resolution: [u32; 2]) {
        let film = FilmDesc::new(resolution, FilterChoice::Box { radius: [0.5; 2] });
        self.d.cameras = vec![CameraDesc::new(kind, transform, film)];
    }

    pub fn material(&mut self, model: MaterialModel) -> MaterialId {
        self.d.add_material("", model, None)
    }

    pub fn diffuse(&mut self, rho: f32) -> MaterialId {
        let reflectance = self.d.float(rho);
        self.material(MaterialModel::Diffuse { reflectance })
    }

    pub fn rough(&mut self, alpha: f32) -> RoughnessDesc {
        let a = self.d.float(alpha);
        RoughnessDesc { distribution: Distribution::Ggx, alpha_u: a, alpha_v: a, remap: false }
    }

    /// A lossless mirror, rough or not.
    pub fn metal(&mut self, alpha: f32) -> MaterialId {
        let (roughness, one) = (self.rough(alpha), self.d.float(1.0));
        let color = ConductorColor::Mirror;
        self.material(MaterialModel::Conductor { color, specular_reflectance: one, roughness })
    }

    pub fn glass(&mut self, ior: f32, alpha: f32) -> MaterialId {
        let (roughness, one) = (self.rough(alpha), self.d.float(1.0));
        self.material(MaterialModel::Dielectric {
            ior: IorDesc::Constant(ior),
            specular_reflectance: one,
            specular_transmittance: one,
            roughness,
        })
    }

    pub fn two_sided(&mut self, m: MaterialId) -> MaterialId {
        self.material(MaterialModel::TwoSided { front: m, back: m })
    }

    pub fn emission(&mut self, radiance: f32) -> EmissionDesc {
        let radiance = self.d.float(radiance);
        EmissionDesc {
            radiance,
            scale: 1.0,
            power: None,
            two_sided: false,
            along_normal: false,
            span: None,
        }
    }

    /// A shape that reflects.
    pub fn shape(&mut self, g: GeometryDesc, t: Transform, m: MaterialId) -> &mut ShapeDesc {
        self.d.shapes.push(shape(g, t, m));
        self.d.shapes.last_mut().expect("just pushed")
    }

    /// A black shape that emits.
    pub fn lamp(&mut self, g: GeometryDesc, t: Transform, radiance: f32) -> &mut ShapeDesc {
        let (black, emission) = (self.diffuse(0.0), self.emission(radiance));
        let s = self.shape(g, t, black);
        s.emission = Some(emission);
        s
    }

    pub fn light(&mut self, kind: LightKind, transform: Transform) {
        let name = String::new();
        self.d.lights.push(LightDesc { name, kind, transform, medium: None, span: None });
    }

    pub fn point_light(&mut self, p: Vec3, intensity: f32) {
        let kind = LightKind::Point { intensity: grey(intensity), scale: 1.0, power: None };
        self.light(kind, Transform::translate(p));
    }

    pub fn sky(&mut self, radiance: f32) {
        let radiance = grey(radiance);
        self.light(LightKind::Constant { radiance, scale: 1.0, illuminance: None }, HERE);
    }

    pub fn build_in(&self, mode: ColorMode) -> Scene {
        let selection = self.selection;
        let options =
            SceneOptions { mode, camera: 0, resolution: None, light_selection: selection };
        Scene::build(&self.d, &options).expect("a sound description")
    }

    pub fn build(&self) -> Scene {
        self.build_in(ColorMode::Rgb)
    }

    pub fn resolution(&self) -> [u32; 2] {
        self.d.cameras[0].film.resolution
    }

    /// Renders the picture: mean of the colour components of each pixel.
    pub fn render(&self, p: Value, spp: u64, seed: u64) -> Picture {
        render(&self.build(), self.resolution(), p, spp, seed, SamplerKind::Independent)
    }

    /// Radiance along one ray.
    pub fn probe(&self, o: Vec3, d: Vec3, p: Value, n: u64) -> RunningMean {
        probe(&self.build(), o, d, p, n).0
    }
}

/// A shape that reflects.
pub fn shape(geometry: GeometryDesc, transform: Transform, material: MaterialId) -> ShapeDesc {
    ShapeDesc {
        name: String::new(),
        geometry,
        transform,
        flip_normals: false,
        material,
        emission: None,
        alpha: None,
        interior: None,
        exterior: None,
        span: None,
    }
}

/// A pinhole camera; the field of view in degrees spans the width.
pub fn pinhole(fov: f32) -> CameraKind {
    CameraKind::pinhole(fov, FovAxis::X)
}

/// A camera with a lens.
pub fn thin_lens(fov: f32, lens_radius: f32, focus_distance: f32) -> CameraKind {
    CameraKind::Perspective {
        fov,
        fov_axis: FovAxis::X,
        principal_point: [0.0; 2],
        screen_window: None,
        lens_radius,
        focus_distance,
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    }
}

/// A parallel projection of the window [-size, size]².
pub fn parallel(size: f32, lens_radius: f32, focus_distance: f32) -> CameraKind {
    CameraKind::Orthographic {
        screen_window: Some([-size, size, -size, size]),
        unit_axis: FovAxis::X,
        lens_radius,
        focus_distance,
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    }
}

/// From `o` toward `target`.
pub fn look(o: Vec3, target: Vec3) -> Transform {
    let up = if (target - o).normalize().z.abs() > 0.99 { Vec3::Y } else { Vec3::Z };
    Transform::look_at(o, target, up).expect("two points")
}

/// The path tracer's parameters from JSON.
pub fn params(p: Value) -> PathParams {
    serde_json::from_value(p).expect("known parameters")
}

/// A picture with error bars.
pub struct Picture {
    pub size: [u32; 2],
    /// Mean over r, g, b, pixel by pixel.
    pub pixels: Vec<RunningMean>,
    /// Rays to the nearest surface.
    pub rays: u64,
}

impl Picture {
    pub fn at(&self, x: u32, y: u32) -> &RunningMean {
        &self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The mean of all pixels.
    pub fn mean(&self) -> RunningMean {
        let n = self.pixels.len() as f64;
        let mean = self.pixels.iter().map(RunningMean::mean).sum::<f64>() / n;
        let variance: f64 = self.pixels.iter().map(|p| p.standard_error().powi(2)).sum();
        with_error(mean, variance.sqrt() / n)
    }
}

/// Renders with any sampler; its samples count as independent.
pub fn render(
    scene: &Scene,
    resolution: [u32; 2],
    p: Value,
    spp: u64,
    seed: u64,
    kind: SamplerKind,
) -> Picture {
    let frame =
        Frame::new(resolution, FilterDesc::BOX, SamplerConfig { kind, seed, spp, resolution });
    render_with(scene, &scene.light_selection, &frame, p)
}

/// As [`render`], with lights chosen in another way.
pub fn render_with(scene: &Scene, lights: &LightSelection, frame: &Frame, p: Value) -> Picture {
    let (resolution, spp) = (frame.resolution, frame.sampler.config().spp);
    let p = params(p);
    let integrator = Integrator::new(scene, frame, &p).with_lights(lights);
    let mut stats = PassStats::default();
    let mut pixels = Vec::new();
    for i in 0..resolution[0] * resolution[1] {
        let mut pixel = RunningMean::new();
        for index in 0..spp {
            let at = [i % resolution[0], i / resolution[0]];
            let [r, g, b] = integrator.pixel(at, index, &mut stats).rgb;
            pixel.push((r as f64 + g as f64 + b as f64) / 3.0);
        }
        pixels.push(pixel);
    }
    assert_eq!(stats.bad_samples, 0);
    Picture { size: resolution, pixels, rays: stats.closest_rays }
}

/// Radiance from `o` along `d`: the mean of the first lane, and the rays traced.
pub fn probe(scene: &Scene, o: Vec3, d: Vec3, p: Value, n: u64) -> (RunningMean, u64) {
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 7, spp: n, resolution: [1, 1] };
    let frame = Frame::new([1, 1], FilterDesc::BOX, config);
    let p = params(p);
    let integrator = Integrator::new(scene, &frame, &p);
    let ray = Ray::new(o, d.normalize());
    let ray = CameraRay {
        ray,
        t_max: f32::INFINITY,
        spread: 0.0,
        width: 0.0,
        weight: 1.0,
        receiver: None,
    };
    let mut stats = PassStats::default();
    let mut mean = RunningMean::new();
    for index in 0..n {
        let sampler = frame.sampler.start([0, 0], index);
        let sample = integrator.li(&ray, Wavelengths::rgb(), sampler, &mut stats);
        mean.push(sample.radiance.0[0] as f64);
    }
    (mean, stats.closest_rays)
}

/// A texture of rgb values.
pub fn texture(stage: &mut Stage, bitmap: Arc<Bitmap>, filter: BitmapFilter) -> TextureId {
    stage.d.add_texture(
        TextureNode::Bitmap(BitmapTexture {
            bitmap,
            channels: BitmapChannels::Color,
            filter,
            wrap: [Wrap::Clamp; 2],
            mapping: TextureMapping::default(),
            scale: 1.0,
            invert: false,
            raw: false,
            space: ColorSpace::Srgb,
        }),
        None,
    )
}

/// A white floor z = 0 of half width 4 that reflects half of the light upward.
pub fn floor(stage: &mut Stage) {
    let m = stage.diffuse(0.5);
    stage.shape(GeometryDesc::Rectangle, scale(4.0, 4.0, 1.0), m);
}

/// Irradiance of a floor of albedo 0.5 at (x, y, 0), seen from the side.
pub fn irradiance(scene: &Scene, x: f32, y: f32, p: Value, n: u64) -> RunningMean {
    let (radiance, _) = probe(scene, v(x, y - 1.0, 0.05), v(0.0, 1.0, -0.05), p, n);
    scaled(&radiance, std::f64::consts::PI / 0.5)
}

/// `k` times an estimate.
pub fn scaled(m: &RunningMean, k: f64) -> RunningMean {
    with_error(k * m.mean(), k * m.standard_error())
}

/// An estimate with this mean and standard error: two values stand for all.
pub fn with_error(mean: f64, error: f64) -> RunningMean {
    [mean - error, mean + error].into_iter().collect()
}

/// Shorthand.
pub fn v2(x: f32, y: f32) -> Vec2 {
    Vec2::new(x, y)
}

/// Corners of a window of 1 by 0.8 whose outside is up.
pub fn window(corner: Vec3) -> [Vec3; 4] {
    let [x, y] = [v(1.0, 0.0, 0.0), v(0.0, 0.8, 0.0)];
    [corner, corner + y, corner + x + y, corner + x]
}
