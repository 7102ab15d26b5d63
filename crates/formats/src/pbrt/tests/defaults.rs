//! Camera, film, filter, sampler and integrator.

use super::{messages, read};
use kaustika_scene::description::{
    ApertureShape, BandsDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, GBufferSpace,
    SceneDescription, SourceFormat,
};

fn quiet(text: &str) -> SceneDescription {
    let scene = read(&format!("{text} WorldBegin"));
    assert_eq!(messages(&scene), "", "{text}");
    scene
}

fn film(text: &str) -> FilmDesc {
    quiet(text).cameras[0].film.clone()
}

#[test]
fn an_empty_world_has_the_defaults_of_pbrt() {
    let s = quiet("");
    assert_eq!(s.format, SourceFormat::Pbrt);
    let c = &s.cameras[0];
    let expected = CameraKind::Perspective {
        fov: 90.0,
        fov_axis: FovAxis::Smaller,
        principal_point: [0.0; 2],
        screen_window: None,
        lens_radius: 0.0,
        focus_distance: 1e6,
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    };
    assert_eq!(c.kind, expected);
    assert!(c.transform.is_identity());
    assert_eq!(c.film.resolution, [1280, 720]);
    assert_eq!((c.film.crop, c.film.filename.clone()), (None, None));
    assert_eq!((c.film.imaging_ratio, c.film.white_balance), (1.0, None));
    assert_eq!(c.film.filter, FilterChoice::Gaussian { radius: [1.5; 2], sigma: 0.5 });
    assert_eq!((c.sampler.as_deref(), c.spp, c.seed), (Some("zsobol"), Some(16), 0));
    assert_eq!((s.integrator.name.as_str(), s.integrator.max_depth), ("volpath", Some(5)));
}

#[test]
fn filters_have_their_own_radii() {
    let filter = |name: &str| film(&format!("PixelFilter \"{name}\"")).filter;
    assert_eq!(filter("box"), FilterChoice::Box { radius: [0.5; 2] });
    assert_eq!(filter("triangle"), FilterChoice::Triangle { radius: [2.0; 2] });
    let third = 1.0 / 3.0;
    assert_eq!(filter("mitchell"), FilterChoice::Mitchell { radius: [2.0; 2], b: third, c: third });
    assert_eq!(filter("sinc"), FilterChoice::LanczosSinc { radius: [4.0; 2], tau: 3.0 });
    let text = "PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" [3]";
    assert_eq!(film(text).filter, FilterChoice::Triangle { radius: [1.0, 3.0] });
}

#[test]
fn crop_windows_round_up_and_bounds_are_x_first() {
    let size = "\"integer xresolution\" 101 \"integer yresolution\" 50";
    let crop = |text: &str| film(&format!("Film \"rgb\" {size} {text}")).crop;
    assert_eq!(crop("\"float cropwindow\" [ .5 0 .25 1 ]"), Some([0, 13, 51, 50]));
    assert_eq!(crop("\"integer pixelbounds\" [ 10 20 30 40 ]"), Some([10, 30, 20, 40]));
    assert_eq!(crop("\"float cropwindow\" [ 0 1 0 1 ]"), None);
}

#[test]
fn exposure_is_shutter_times_iso() {
    let text = "Camera \"perspective\" \"float shutterclose\" .5
        Film \"rgb\" \"float iso\" 400 \"float whitebalance\" 5000 \"float maxcomponentvalue\" 9
        \"string filename\" \"a.exr\" \"float diagonal\" 20 \"bool savefp16\" false";
    let f = film(text);
    assert_eq!((f.imaging_ratio, f.white_balance), (2.0, Some(5000.0)));
    assert_eq!((f.max_component, f.filename.as_deref()), (Some(9.0), Some("a.exr")));
    assert_eq!(film("Film \"rgb\" \"float exposuretime\" .1").imaging_ratio, 0.1);
}

#[test]
fn the_gbuffer_asks_for_layers() {
    let f = film("Film \"gbuffer\" \"string coordinatesystem\" \"world\"");
    assert!(
        ["albedo", "normal", "sh_normal", "depth", "position", "uv"]
            .iter()
            .all(|n| f.aovs.contains(&n.to_string()))
    );
    assert_eq!(f.gbuffer, Some(GBufferSpace::World));
    assert_eq!(film("Film \"gbuffer\"").gbuffer, Some(GBufferSpace::Camera));
    assert_eq!(film("Film \"rgb\"").gbuffer, None);
}

#[test]
fn spectral_films_have_bins() {
    let bins = |text: &str| film(&format!("Film \"spectral\" {text}")).bands;
    assert_eq!(bins(""), Some(BandsDesc::Bins { count: 16, range: [360.0, 830.0] }));
    let some = bins("\"integer nbuckets\" 3 \"float lambdamin\" 400 \"float lambdamax\" 700");
    assert_eq!(some, Some(BandsDesc::Bins { count: 3, range: [400.0, 700.0] }));
    let s = read("Film \"spectral\" \"integer nbuckets\" 0 WorldBegin");
    let message = "error 1:17 <\"integer nbuckets\"> `nbuckets` must lie between 1 and 940\n";
    assert_eq!(messages(&s), message);
    let s = read("Film \"spectral\" \"float lambdamax\" 300 WorldBegin");
    let message =
        "error 1:17 <\"float lambdamax\"> wavelengths must rise, and lie between 360 and 830 nm\n";
    assert_eq!(messages(&s), message);
}

#[test]
fn cameras_of_all_kinds() {
    let kind = |text: &str| quiet(text).cameras[0].kind.clone();
    let text = "Camera \"perspective\" \"float fov\" 30 \"float lensradius\" .1
        \"float focaldistance\" 7 \"float screenwindow\" [ -1 2 -3 4 ]";
    let CameraKind::Perspective { fov, screen_window, lens_radius, focus_distance, .. } =
        kind(text)
    else {
        panic!()
    };
    assert_eq!((fov, lens_radius, focus_distance), (30.0, 0.1, 7.0));
    assert_eq!(screen_window, Some([-1.0, 2.0, -3.0, 4.0]));
    let ortho = kind("Camera \"orthographic\" \"float frameaspectratio\" .5");
    let CameraKind::Orthographic { screen_window, unit_axis, .. } = ortho else { panic!() };
    assert_eq!((screen_window, unit_axis), (Some([-1.0, 1.0, -2.0, 2.0]), FovAxis::Smaller));
    assert_eq!(kind("Camera \"spherical\""), CameraKind::Spherical { equal_area: true });
    let text = "Camera \"spherical\" \"string mapping\" \"equirectangular\"";
    assert_eq!(kind(text), CameraKind::Spherical { equal_area: false });
}

#[test]
fn lenses_of_many_surfaces() {
    let with_file = |lens: &str, more: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("files can be written");
        };
        write("a.dat", lens);
        let camera = format!("Camera \"realistic\" \"string lensfile\" \"a.dat\" {more}");
        write("a.pbrt", &format!("{camera} Film \"rgb\" \"float diagonal\" 40 WorldBegin"));
        super::super::read_pbrt(&folder.path().join("a.pbrt"))
    };
    let lens = "# front to back\n50 4 1.5 20\n0 2 0 16 # the stop\n-50 3 1 20";
    let s = with_file(lens, "\"float aperturediameter\" 8 \"string aperture\" \"star\"");
    assert_eq!(messages(&s), "");
    let CameraKind::Realistic(lens) = &s.cameras[0].kind else { panic!() };
    assert_eq!((lens.film_diagonal, lens.focus_distance), (1e-3 * 40.0, 10.0));
    assert_eq!(lens.aperture, Some(ApertureShape::Star));
    let stop = lens.surfaces[1];
    assert_eq!((lens.surfaces.len(), stop.radius, stop.aperture_radius), (3, 0.0, 0.004));
    assert_eq!((lens.surfaces[0].radius, lens.surfaces[2].thickness), (0.05, 0.003));
    let why = |lens: &str| messages(&with_file(lens, ""));
    assert!(why("1 2 3").contains("expected four numbers for each surface, found 3 in all"));
    assert!(why("1 2\n3 x").contains("line 2: expected a number, found `x`"));
    assert!(why("1 1 1 0").contains("surface 1 has a negative index or no diameter"));
    let s = read("Camera \"realistic\" WorldBegin");
    assert!(messages(&s).contains("camera `realistic` needs \"string lensfile\""));
}

#[test]
fn samplers_seeds_and_integrators() {
    let text = "Option \"seed\" 7 Sampler \"stratified\" \"integer xsamples\" 3
        Integrator \"path\" \"integer maxdepth\" 12 \"string lightsampler\" \"power\"
        Accelerator \"bvh\"";
    let s = quiet(text);
    let c = &s.cameras[0];
    assert_eq!((c.sampler.as_deref(), c.spp, c.seed), (Some("stratified"), Some(12), 7));
    let i = &s.integrator;
    assert_eq!((i.name.as_str(), i.max_depth), ("path", Some(12)));
    assert_eq!(i.light_sampler.as_deref(), Some("power"));
    let s = quiet("Sampler \"independent\" \"integer seed\" 3 Option \"seed\" 7");
    assert_eq!((s.cameras[0].spp, s.cameras[0].seed), (Some(4), 3));
}

#[test]
fn what_is_unknown_but_harmless_is_replaced() {
    let text = "Sampler \"zsobo\" Integrator \"pathh\" \"integer maxdepth\" 3 \"float x\" 1
        Accelerator \"embree\" Film \"spectral\"
        Integrator \"path\" \"bool regularize\" true \"string lightsampler\" \"uni\" WorldBegin";
    let s = read(text);
    assert_eq!(
        messages(&s),
        "warning 2:21 <\"embree\"> unknown accelerator `embree`, ignored; known: bvh, kdtree\n\
         warning 3:72 <\"uni\"> unknown light sampler `uni`, using `bvh`; known: uniform, power, \
         bvh, exhaustive\n\
         warning 3:27 <\"bool regularize\"> `regularize` makes pictures wrong in favour of less \
         noise, ignored\n\
         warning 1:9 <\"zsobo\"> unknown sampler `zsobo`, using `zsobol`; did you mean `zsobol`?\n"
    );
    let s = read("Integrator \"pathh\" \"integer maxdepth\" 3 \"float x\" 1 WorldBegin");
    assert_eq!(
        messages(&s),
        "warning 1:12 <\"pathh\"> unknown integrator `pathh`, using `volpath`; did you mean \
         `path`?\n"
    );
    assert_eq!((s.integrator.name.as_str(), s.integrator.max_depth), ("volpath", Some(3)));
}
