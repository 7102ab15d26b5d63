//! The z-buffer sees what rays see, and lights it as path tracing does where the models are the same.

use crate::scenes::*;
use crate::stats::{Random, close};
use kaustika_film::FilterDesc;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_scene::{CameraRay, Scene, Segment, Surface};
use kaustika_spectra::Wavelengths;
use kaustika_transport::path::Integrator;
use kaustika_transport::zbuffer::{self, Model, Rasterizer, Seen, View, ZBufferParams};
use kaustika_transport::{Frame, PassStats};
use serde_json::json;

/// Where pixels are sampled.
const SAMPLE: Vec2 = Vec2::new(0.37, 0.61);
/// Relative error of depth that is allowed.
pub const DEPTH: f32 = 1e-5;
/// Distance from an edge, in pixels, within which a rival may be seen.
pub const EDGE: f64 = 1.0 / 256.0;

/// A scene, drawn.
pub struct Drawn {
    pub scene: Scene,
    size: [u32; 2],
    pub rasterizer: Rasterizer,
    pub view: View,
}

impl Drawn {
    pub fn new(stage: &Stage, params: &ZBufferParams) -> Drawn {
        let (scene, size) = (stage.build(), stage.resolution());
        let kind = SamplerKind::Independent;
        let config = SamplerConfig { kind, seed: 1, spp: 1, resolution: size };
        let frame = Frame::new(size, FilterDesc::BOX, config);
        zbuffer::can_draw(&scene, size).expect("a scene for it");
        let camera = zbuffer::flat_view(&scene).expect("a camera");
        let view = zbuffer::view(&scene, &camera, &frame, SAMPLE).expect("a view");
        let mut rasterizer = Rasterizer::new(&scene, params);
        rasterizer.draw(&scene, &view);
        Drawn { scene, size, rasterizer, view }
    }

    pub fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [w, h] = self.size;
        (0..w * h).map(move |i| [i % w, i / w])
    }

    pub fn seen(&self, [x, y]: [u32; 2]) -> Option<Seen> {
        self.rasterizer.seen(&self.view, x, y)
    }

    /// The camera's ray through a pixel's sample.
    fn camera_ray(&self, pixel: [u32; 2]) -> CameraRay {
        self.ray_beside(pixel, Vec2::ZERO)
    }

    /// The camera's ray a little beside it, in pixels.
    pub fn ray_beside(&self, [x, y]: [u32; 2], off: Vec2) -> CameraRay {
        let film = Vec2::new(x as f32, y as f32) + SAMPLE + off;
        self.scene.camera.sample_we(film, Vec2::new(0.5, 0.5), 0.0)
    }

    pub fn met(&self, pixel: [u32; 2]) -> Option<Surface> {
        let camera = self.camera_ray(pixel);
        self.scene.intersect(&camera.ray, camera.t_max)
    }

    /// Distance of a pixel's sample from the edges of a triangle, in pixels.
    fn to_edges(&self, corners: [Vec3; 3], [x, y]: [u32; 2]) -> f64 {
        let h = corners.map(|p| self.view.project(p));
        let mut least = f64::INFINITY;
        for i in 0..3 {
            let (a, b) = (h[i], h[(i + 1) % 3]);
            let e =
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let d = (e[0] * f64::from(x) + e[1] * f64::from(y) + e[2]) / e[0].hypot(e[1]);
            least = least.min(d.abs());
        }
        least
    }

    /// Fails unless rays see the same, but for what rounding may change. How many pixels show something.
    fn check_visibility(&self, what: &str) -> u32 {
        let mut count = 0;
        for pixel in self.pixels() {
            let (seen, met) = (self.seen(pixel), self.met(pixel));
            let context = || format!("{what}, pixel {pixel:?}: {seen:?} and {met:?}");
            let sources = &self.rasterizer.meshes().sources;
            let near_edge = |triangle: u32| {
                let corners = self.scene.geometry.triangles.corners(triangle);
                self.to_edges(corners, pixel) < EDGE
            };
            match (&seen, &met) {
                (None, None) => {}
                (Some(s), Some(m)) => {
                    count += 1;
                    let t = self.view.distance(s.p);
                    let of = sources[s.triangle as usize].triangle;
                    // Rays begin at the near plane.
                    if (t - m.t).abs() > DEPTH * m.t.max(s.depth.abs()) {
                        assert!(near_edge(of) || near_edge(m.triangle), "{}", context());
                    } else if of != m.triangle {
                        // Both are as near.
                        continue;
                    }
                }
                (Some(s), None) => {
                    assert!(near_edge(sources[s.triangle as usize].triangle), "{}", context());
                }
                (None, Some(m)) => assert!(near_edge(m.triangle), "{}", context()),
            }
        }
        count
    }
}

/// Triangles of all sizes around the origin, in this order.
fn soup(order: impl Fn(usize) -> usize) -> GeometryDesc {
    let mut random = Random::new(17);
    let triangles: Vec<[Vec3; 3]> = (0..600)
        .map(|i| {
            let (c, size) = (random.v3() * 2.0, if i % 10 == 0 { 1.5 } else { 0.15 });
            [(); 3].map(|()| c + random.v3() * size)
        })
        .collect();
    let count = triangles.len();
    let positions: Vec<Vec3> = (0..count).flat_map(|i| triangles[order(i)]).collect();
    let indices: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(&positions, &indices)
}

fn soup_stage(order: impl Fn(usize) -> usize) -> Stage {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.8);
    stage.shape(soup(order), HERE, white);
    stage.camera(pinhole(70.0), look(v(0.3, -3.5, 1.1), v(0.0, 0.0, 0.0)), [200, 150]);
    stage
}

#[test]
fn rays_see_the_same() {
    let params = ZBufferParams::default();
    let mut stage = soup_stage(|i| i);
    assert!(Drawn::new(&stage, &params).check_visibility("from outside") > 10_000);
    // From among them: some are behind the eye, some on both sides of it.
    stage.camera(pinhole(100.0), look(v(0.1, 0.2, 0.0), v(1.0, 0.4, 0.3)), [200, 150]);
    assert!(Drawn::new(&stage, &params).check_visibility("from within") > 20_000);
    stage.camera(parallel(2.0, 0.0, 1.0), look(v(0.0, -5.0, 1.0), v(0.0, 0.0, 0.0)), [200, 150]);
    assert!(Drawn::new(&stage, &params).check_visibility("in parallel") > 10_000);
    // Cut by a near and a far plane.
    let mut cut = pinhole(70.0);
    if let CameraKind::Perspective { near_clip: n, far_clip: f, .. } = &mut cut {
        (*n, *f) = (2.9, 4.4);
    }
    stage.camera(cut, look(v(0.3, -3.5, 1.1), v(0.0, 0.0, 0.0)), [200, 150]);
    assert!(Drawn::new(&stage, &params).check_visibility("between planes") > 5000);
}

#[test]
fn the_order_of_triangles_changes_nothing() {
    let params = ZBufferParams::default();
    let one = Drawn::new(&soup_stage(|i| i), &params);
    // 7 and 600 have no common factor.
    let order = |i: usize| i * 7 % 600;
    let other = Drawn::new(&soup_stage(order), &params);
    for pixel in one.pixels() {
        let (a, b) = (one.seen(pixel), other.seen(pixel));
        assert_eq!(a.map(|s| s.depth.to_bits()), b.map(|s| s.depth.to_bits()), "{pixel:?}");
        assert_eq!(a.map(|s| s.triangle as usize), b.map(|s| order(s.triangle as usize)));
        assert_eq!(
            one.rasterizer.color(pixel[0], pixel[1]),
            other.rasterizer.color(pixel[0], pixel[1])
        );
    }
}

#[test]
fn neighbours_leave_no_gaps() {
    // A fan of thin triangles that fills the picture: every pixel shows one of them.
    let mut positions = vec![v(0.013, 0.027, 1.0)];
    positions.extend((0..500).map(|i| {
        let phi = f32::to_radians(360.0 * i as f32 / 500.0);
        v(4.0 * phi.cos(), 4.0 * phi.sin(), 1.0 + 0.2 * (i % 3) as f32)
    }));
    let indices: Vec<[u32; 3]> = (0..500).map(|i| [0, 1 + i, 1 + (i + 1) % 500]).collect();
    let mut stage = Stage::new();
    let white = stage.diffuse(0.8);
    stage.shape(mesh(&positions, &indices), HERE, white);
    stage.camera(pinhole(80.0), HERE, [256, 256]);
    let drawn = Drawn::new(&stage, &ZBufferParams::default());
    assert!(drawn.pixels().all(|p| drawn.seen(p).is_some()));
}

/// Matte and glossy things on a floor, in view of an eye above.
fn things() -> Stage {
    let mut stage = Stage::new();
    let (d, s, n) = (stage.d.float(0.5), stage.d.float(0.3), stage.d.float(20.0));
    let phong = stage.material(MaterialModel::Phong {
        diffuse_reflectance: d,
        specular_reflectance: s,
        exponent: n,
    });
    let (phong, white) = (stage.two_sided(phong), stage.diffuse(0.7));
    let white = stage.two_sided(white);
    stage.shape(GeometryDesc::Rectangle, scale(3.0, 3.0, 1.0), white);
    stage.shape(GeometryDesc::Cube, at(-0.6, 0.0, 0.4) * scale(0.3, 0.3, 0.4), white);
    stage.shape(
        GeometryDesc::Rectangle,
        at(0.7, 0.3, 0.6) * rotate(50.0, v(1.0, 0.3, 0.2)) * scale(0.5, 0.4, 1.0),
        phong,
    );
    stage.camera(pinhole(50.0), look(v(0.2, -3.0, 2.0), v(0.0, 0.0, 0.3)), [160, 120]);
    stage
}

/// Adds a lamp to a stage.
type AddLamp = Box<dyn Fn(&mut Stage)>;

#[test]
fn light_and_shadows_are_those_of_rays() {
    let lamp = v(0.9, -0.4, 2.3);
    let spot = LightKind::Spot {
        intensity: grey(6.0),
        scale: 1.0,
        power: None,
        cutoff: 40.0,
        beam_width: 25.0,
        falloff: SpotFalloff::LinearAngle,
        texture: None,
    };
    let kinds: [(&str, AddLamp); 3] = [
        ("point", Box::new(move |s| s.point_light(lamp, 6.0))),
        ("spot", Box::new(move |s| s.light(spot.clone(), look(lamp, Vec3::ZERO)))),
        (
            "direction",
            Box::new(move |s| {
                let kind =
                    LightKind::Directional { irradiance: grey(2.0), scale: 1.0, illuminance: None };
                s.light(kind, look(lamp, Vec3::ZERO));
            }),
        ),
    ];
    const TEXELS: u32 = 512;
    for (what, add) in kinds {
        let mut stage = things();
        add(&mut stage);
        let params = ZBufferParams { shadow_map: TEXELS, ambient: 0.0, ..ZBufferParams::default() };
        let drawn = Drawn::new(&stage, &params);
        let kind = SamplerKind::Independent;
        let config = SamplerConfig { kind, seed: 1, spp: 1, resolution: drawn.size };
        let frame = Frame::new(drawn.size, FilterDesc::BOX, config);
        let path = params_of_direct_light();
        let integrator = Integrator::new(&drawn.scene, &frame, &path);
        let (mut lit, mut shadowed, mut edges) = (0, 0, 0);
        for pixel in drawn.pixels() {
            let sampler = frame.sampler.start(pixel, 0);
            let camera = drawn.camera_ray(pixel);
            let truth = integrator
                .li(&camera, Wavelengths::rgb(), sampler, &mut PassStats::default())
                .radiance[0];
            let color = drawn.rasterizer.color(pixel[0], pixel[1])[0];
            if (color - truth).abs() <= 1e-3 * truth.max(1e-3) {
                *(if truth > 0.0 { &mut lit } else { &mut shadowed }) += 1;
                continue;
            }
            edges += 1;
            let Some(surface) = drawn.met(pixel) else { panic!("{what} {pixel:?}: nothing there") };
            let context = format!("{what}, pixel {pixel:?} {:?}: {color}, not {truth}", surface.p);
            assert!(near_shadow_edge(&drawn.scene, &surface, TEXELS), "{context}");
        }
        assert!(lit > 5000 && shadowed > 400 && edges < 1500, "{what}: {lit} {shadowed} {edges}");
    }
}

fn params_of_direct_light() -> kaustika_transport::path::PathParams {
    params(json!({"max_depth": 1}))
}

/// True if the light is hidden from some but not from all points within about one texel.
fn near_shadow_edge(scene: &Scene, s: &Surface, texels: u32) -> bool {
    let lambda = Wavelengths::rgb();
    let light = &scene.lights[0];
    let Some(l) = light.sample_li(scene, s.p, Vec2::ZERO, &lambda) else { return false };
    let width = match light.is_infinite() {
        true => 2.0 * scene.radius / texels as f32,
        false => 2.0 * (l.p - s.p).abs().max_component() / texels as f32,
    };
    // Across the light, and down onto the surface's plane.
    let (x, y) = l.wi.coordinate_system();
    let hidden = |i: i32, j: i32| {
        let off = (x * (i as f32 * 0.5) + y * (j as f32 * 0.5)) * width;
        let p = s.p + off - l.wi * (off.dot(s.ng) / l.wi.dot(s.ng)) + l.wi * 1e-3;
        let ray = Ray::new(p, l.wi);
        let t_max = if light.is_infinite() { f32::INFINITY } else { (l.p - p).length() };
        scene.occluded(&Segment { ray, t_max })
    };
    let all: Vec<bool> =
        (-3..=3).flat_map(|i| (-3..=3).map(move |j| (i, j))).map(|(i, j)| hidden(i, j)).collect();
    all.iter().any(|&h| h) && all.iter().any(|&h| !h)
}

#[test]
fn facets_have_one_value_and_the_dark_side_is_ambient() {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    stage.shape(GeometryDesc::Cube, rotate(30.0, v(0.2, 0.4, 1.0)), white);
    stage.point_light(v(4.0, 0.0, 1.0), 40.0);
    stage.camera(pinhole(50.0), look(v(0.0, -4.0, 2.0), Vec3::ZERO), [120, 90]);
    let p = ZBufferParams { model: Model::Bouknight, ambient: 0.25, ..ZBufferParams::default() };
    let drawn = Drawn::new(&stage, &p);
    let mut values = std::collections::BTreeMap::new();
    for pixel in drawn.pixels() {
        let Some(seen) = drawn.seen(pixel) else { continue };
        let color = drawn.rasterizer.color(pixel[0], pixel[1])[0];
        let known = *values.entry(seen.triangle).or_insert(color);
        close("the facet's value", f64::from(color), f64::from(known), 1e-5);
    }
    let dark = values.values().filter(|&&c| (c - 0.25 * 0.6).abs() < 1e-6).count();
    assert!(dark >= 1 && values.values().any(|&c| c > 0.16), "{values:?}");
}

#[test]
fn gouraud_interpolates_what_phong_computes() {
    // One triangle across the eye's axis: Gouraud's value is linear in the picture, and a highlight
    // in its middle is missed.
    let build = |model| {
        let mut stage = Stage::new();
        let (d, s, n) = (stage.d.float(0.3), stage.d.float(0.5), stage.d.float(50.0));
        let phong = stage.material(MaterialModel::Phong {
            diffuse_reflectance: d,
            specular_reflectance: s,
            exponent: n,
        });
        let corners = [v(-2.0, -2.0, 3.0), v(0.0, 2.5, 3.0), v(2.0, -2.0, 3.0)];
        stage.shape(mesh(&corners, &[[0, 1, 2]]), HERE, phong);
        stage.point_light(v(0.0, 0.0, 0.1), 3.0);
        stage.camera(parallel(1.0, 0.0, 1.0), HERE, [64, 64]);
        Drawn::new(&stage, &ZBufferParams { model, ..ZBufferParams::default() })
    };
    let (gouraud, phong) = (build(Model::Gouraud), build(Model::Phong));
    let value = |d: &Drawn, x: u32, y: u32| d.rasterizer.color(x, y)[0];
    for (x, y) in [(20, 40), (30, 30), (33, 50), (40, 35)] {
        let middle = 0.5 * (value(&gouraud, x - 2, y - 1) + value(&gouraud, x + 2, y + 1));
        close("linear", f64::from(value(&gouraud, x, y)), f64::from(middle), 1e-4);
    }
    assert!(value(&phong, 32, 32) > 3.0 * value(&gouraud, 32, 32));
}

#[test]
fn distant_textures_fade_to_their_mean() {
    // A floor of squares of 0.05, up to the horizon: pixels much wider than a square see grey.
    let mut stage = Stage::new();
    let squares = bitmap(64, 64, |x, y| {
        let odd = ((x * 8.0) as u32 + (y * 8.0) as u32) % 2;
        [if odd == 1 { 1.0 } else { 0.0 }; 3]
    });
    let reflectance = texture(&mut stage, squares, BitmapFilter::Bilinear);
    if let Some(TextureNode::Bitmap(t)) = stage.d.textures.last_mut().map(|t| &mut t.node) {
        t.wrap = [Wrap::Repeat; 2];
        t.mapping = TextureMapping::Uv(kaustika_math::Affine2::scale_shift(100.0, 100.0, 0.0, 0.0));
    }
    let m = stage.material(MaterialModel::Diffuse { reflectance });
    stage.shape(GeometryDesc::Rectangle, scale(20.0, 20.0, 1.0), m);
    stage.camera(pinhole(60.0), look(v(0.0, -15.0, 0.5), v(0.0, 0.0, 0.3)), [120, 90]);
    let p = ZBufferParams { ambient: 1.0, headlight: 0.0, ..ZBufferParams::default() };
    let drawn = Drawn::new(&stage, &p);
    let (mut near, mut far) = (0.0f32, 0);
    for pixel in drawn.pixels() {
        let Some(seen) = drawn.seen(pixel) else { continue };
        let color = drawn.rasterizer.color(pixel[0], pixel[1])[0];
        if seen.depth > 12.0 {
            assert!((color - 0.5).abs() < 0.05, "{pixel:?} at {}: {color}", seen.depth);
            far += 1;
        } else if seen.depth < 1.5 {
            near = near.max((color - 0.5).abs());
        }
    }
    assert!(far > 300 && near > 0.3, "{far} pixels, {near} nearby");
}

/// Of many equal lamps the first are kept, and every one that is kept shines.
#[test]
fn equal_lamps_are_kept_up_to_a_number() {
    let brightness = |count: u32, lamps: u32| {
        let mut stage = things();
        (0..count).for_each(|_| stage.point_light(v(0.9, -0.4, 2.3), 1.0));
        let p = ZBufferParams { lamps, ambient: 0.0, shadows: false, ..ZBufferParams::default() };
        let drawn = Drawn::new(&stage, &p);
        drawn.pixels().map(|[x, y]| f64::from(drawn.rasterizer.color(x, y)[0])).sum::<f64>()
    };
    let one = brightness(1, 8);
    close("all of three", brightness(3, 8), 3.0 * one, 1e-4);
    close("two of five", brightness(5, 2), 2.0 * one, 1e-4);
}
