//! What a path asks of a scene besides its rays: scattering, textures, lights.
//!
//! `cargo bench -p kaustika-scene`. The rate is queries a second.

use divan::Bencher;
use divan::counter::ItemsCount;
use kaustika_math::{Affine2, Transform, Vec2, Vec3, mix_bits};
use kaustika_scene::bsdf::{
    Coat, CoatedDiffuse, Conductor, ConductorFresnel, Dielectric, Diffuse, Lobes, Microfacet, Mode,
    Model, Plastic, PlasticCoat, Scatter,
};
use kaustika_scene::description::{
    Bitmap, BitmapChannels, BitmapFilter, BitmapTexture, CameraDesc, CameraKind, Distribution,
    EmissionDesc, Encoding, FilmDesc, FilterChoice, FovAxis, GeometryDesc, MaterialModel,
    SceneDescription, ShapeDesc, Texels, TextureId, TextureMapping, TextureNode, Wrap,
};
use kaustika_scene::{LightSelectionKind, Scene, SceneOptions, TexturePoint};
use kaustika_spectra::{ColorMode, ColorSpace, Spectrum, Wavelengths};
use std::sync::Arc;

fn main() {
    divan::main();
}

/// Queries a run makes.
const QUERIES: usize = 256;

/// The `i`th of a fixed list of numbers uniform in [0, 1).
fn number(i: usize) -> f32 {
    (mix_bits(i as u64 + 1) >> 40) as f32 / (1u64 << 24) as f32
}

/// Numbers uniform in [0, 1), `each` a query.
fn numbers(each: usize) -> Vec<f32> {
    (0..each * QUERIES).map(number).collect()
}

/// Directions above the surface, none of them grazing.
fn directions(salt: usize) -> Vec<Vec3> {
    (0..QUERIES)
        .map(|i| {
            let at = 3 * (i + salt * QUERIES);
            let side = |k| 2.0 * number(at + k) - 1.0;
            Vec3::new(side(0), side(1), 0.1 + number(at + 2)).normalize()
        })
        .collect()
}

const MODELS: [&str; 5] =
    ["diffuse", "plastic", "rough conductor", "rough glass", "coated diffuse"];

fn model(name: &str) -> Model<'static> {
    let grey = Spectrum::splat(0.5);
    let rough = Microfacet::new(Distribution::Ggx, 0.3, 0.3);
    match name {
        "diffuse" => Model::Diffuse(Diffuse { reflectance: grey }),
        "plastic" => {
            Model::Plastic(Plastic::new(PlasticCoat::new(1.5), grey, Spectrum::ONE, false))
        }
        "rough conductor" => Model::Conductor(Conductor {
            fresnel: ConductorFresnel::EtaK { eta: Spectrum::splat(0.2), k: Spectrum::splat(3.9) },
            tint: Spectrum::ONE,
            surface: rough,
        }),
        "rough glass" => Model::Dielectric(Dielectric {
            eta: 1.5,
            reflectance: Spectrum::ONE,
            transmittance: Spectrum::ONE,
            surface: rough,
        }),
        _ => Model::CoatedDiffuse(CoatedDiffuse::new(
            grey,
            Coat {
                ior: 1.5,
                surface: rough,
                thickness: 0.01,
                albedo: Spectrum::ZERO,
                g: 0.0,
                max_depth: 10,
                samples: 1,
                salt: 1,
            },
        )),
    }
}

#[divan::bench(args = MODELS, min_time = 0.2, max_time = 1)]
fn bsdf_sample(bencher: Bencher, name: &str) {
    let (model, wo, u) = (model(name), directions(0), numbers(3));
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        let draw = |(&wo, u): (&Vec3, &[f32])| {
            model.sample(wo, u[0], Vec2::new(u[1], u[2]), Mode::Radiance, Lobes::ALL)
        };
        wo.iter().zip(u.chunks(3)).filter_map(draw).map(|s| s.pdf).sum::<f32>()
    });
}

#[divan::bench(args = MODELS, min_time = 0.2, max_time = 1)]
fn bsdf_eval(bencher: Bencher, name: &str) {
    let (model, wo, wi) = (model(name), directions(0), directions(1));
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        let eval = |(&wo, &wi)| model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        wo.iter().zip(&wi).map(eval).fold(Spectrum::ZERO, |a, b| a + b)
    });
}

#[divan::bench(args = MODELS, min_time = 0.2, max_time = 1)]
fn bsdf_pdf(bencher: Bencher, name: &str) {
    let (model, wo, wi) = (model(name), directions(0), directions(1));
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        let pdf = |(&wo, &wi)| model.pdf(wo, wi, Mode::Radiance, Lobes::ALL).0;
        wo.iter().zip(&wi).map(pdf).sum::<f32>()
    });
}

/// A floor under 64 small lamps, with a bitmap's texture for each filter, in `FILTERS`' order.
fn scene(selection: LightSelectionKind) -> (Scene, Vec<TextureId>) {
    let mut d = SceneDescription { cameras: vec![camera()], ..SceneDescription::default() };
    let bitmap = Arc::new(Bitmap {
        width: 1024,
        height: 1024,
        channels: 3,
        texels: Texels::U8((0..3 << 20).map(|i| (255.0 * number(i)) as u8).collect()),
        encoding: Encoding::Srgb,
    });
    let textures: Vec<TextureId> = FILTERS
        .iter()
        .map(|&(_, filter)| {
            d.add_texture(TextureNode::Bitmap(texture(bitmap.clone(), filter)), None)
        })
        .collect();
    let floor = MaterialModel::Diffuse { reflectance: textures[1] };
    let floor = d.add_material("floor", floor, None);
    let radiance = d.rgb([3.0, 2.0, 1.0]);
    let square = |place: Transform, emission: Option<EmissionDesc>| ShapeDesc {
        name: String::new(),
        geometry: GeometryDesc::Rectangle,
        transform: place,
        flip_normals: emission.is_some(),
        material: floor,
        emission,
        alpha: None,
        interior: None,
        exterior: None,
        span: None,
    };
    let scaled = |s: f32| Transform::scale(Vec3::new(s, s, s)).expect("no factor is zero");
    d.shapes.push(square(scaled(10.0), None));
    for lamp in 0..64 {
        let side = |k| 18.0 * number(3 * lamp + k) - 9.0;
        let place = Transform::translate(Vec3::new(side(0), side(1), 2.0 + number(3 * lamp + 2)));
        let emission = EmissionDesc {
            radiance,
            scale: 1.0,
            power: None,
            two_sided: false,
            along_normal: false,
            span: None,
        };
        d.shapes.push(square(place * scaled(0.1), Some(emission)));
    }
    let options = SceneOptions {
        mode: ColorMode::Rgb,
        camera: 0,
        resolution: None,
        light_selection: Some(selection),
    };
    (Scene::build(&d, &options).expect("the description is whole"), textures)
}

fn camera() -> CameraDesc {
    let film = FilmDesc::new([64, 64], FilterChoice::Box { radius: [0.5; 2] });
    CameraDesc::new(CameraKind::pinhole(45.0, FovAxis::X), Transform::IDENTITY, film)
}

fn texture(bitmap: Arc<Bitmap>, filter: BitmapFilter) -> BitmapTexture {
    BitmapTexture {
        bitmap,
        channels: BitmapChannels::Color,
        filter,
        wrap: [Wrap::Repeat; 2],
        mapping: TextureMapping::Uv(Affine2::IDENTITY),
        scale: 1.0,
        invert: false,
        raw: false,
        space: ColorSpace::Srgb,
    }
}

const FILTERS: [(&str, BitmapFilter); 4] = [
    ("nearest", BitmapFilter::Nearest),
    ("bilinear", BitmapFilter::Bilinear),
    ("trilinear", BitmapFilter::Trilinear),
    ("ewa", BitmapFilter::Ewa),
];

#[divan::bench(args = FILTERS.map(|(name, _)| name), min_time = 0.2, max_time = 1)]
fn texture_lookup(bencher: Bencher, filter: &str) {
    let (scene, textures) = scene(LightSelectionKind::Power);
    let which = FILTERS.iter().position(|(name, _)| *name == filter).expect("it is in the list");
    let at = |u: &[f32]| TexturePoint {
        p: Vec3::ZERO,
        n: Vec3::Z,
        uv: Vec2::new(u[0], u[1]),
        uv_width: 0.003,
        triangle: u32::MAX,
        barycentrics: Vec2::new(0.0, 0.0),
    };
    let points: Vec<TexturePoint> = numbers(2).chunks(2).map(at).collect();
    let lambda = Wavelengths::rgb();
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        let lookup = |at| scene.textures.spectrum(textures[which], at, &lambda);
        points.iter().map(lookup).fold(Spectrum::ZERO, |a, b| a + b)
    });
}

/// Choosing a lamp, and a point of it.
#[divan::bench(args = ["uniform", "power", "bvh"], min_time = 0.2, max_time = 1)]
fn light_sample(bencher: Bencher, selection: &str) {
    let selection = selection.parse().unwrap_or_else(|_| panic!("{selection} is not a selection"));
    let (scene, _) = scene(selection);
    let (lambda, u) = (Wavelengths::rgb(), numbers(5));
    bencher.counter(ItemsCount::new(QUERIES)).bench_local(|| {
        let sample = |u: &[f32]| {
            let p = Vec3::new(18.0 * u[0] - 9.0, 18.0 * u[1] - 9.0, 0.0);
            let u2 = Vec2::new(u[3], u[4]);
            let c = scene.light_selection.sample(p, Vec3::Z, u[2], u2)?;
            let sample = scene.light(c.light).sample_li(&scene, p, c.u, &lambda)?;
            Some(c.p * sample.pdf_w)
        };
        u.chunks(5).filter_map(sample).sum::<f32>()
    });
}
