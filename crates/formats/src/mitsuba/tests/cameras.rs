//! Cameras, film, filters, samplers.

use super::*;
use kaustika_math::Vec3;

fn camera(version: &str, inner: &str, plugin: &str) -> CameraDesc {
    let text =
        format!("<scene version=\"{version}\"><sensor type=\"{plugin}\">{inner}</sensor></scene>");
    let files = Files::new(&[("a.xml", &text)]);
    let mut d = files.read("a.xml", &[]);
    assert_eq!(files.messages(&d), Vec::<String>::new());
    assert_eq!(d.cameras.len(), 1);
    d.cameras.remove(0)
}

#[test]
fn the_default_camera() {
    let c = camera("3.0.0", "", "perspective");
    let CameraKind::Perspective { fov, fov_axis, near_clip, far_clip, focus_distance, .. } = c.kind
    else {
        panic!()
    };
    // 50 mm on 36 x 24 mm film: 2 atan(√(36² + 24²) / 100).
    assert!((fov - 46.793).abs() < 1e-3, "{fov}");
    assert_eq!(fov_axis, FovAxis::Diagonal);
    assert_eq!((near_clip, far_clip, focus_distance), (0.01, 1e4, 1e4));
    assert_eq!(c.film.resolution, [768, 576]);
    assert_eq!(c.film.filter, FilterChoice::Gaussian { radius: [2.0; 2], sigma: 0.5 });
    assert_eq!((c.shutter, c.spp, c.sampler), ([0.0; 2], None, None));
}

#[test]
fn x_runs_to_the_right() {
    let lookat = r#"<float name="fov" value="40"/><transform name="to_world">
        <lookat origin="0,0,-5" target="0,0,0" up="0,1,0"/></transform>"#;
    let c = camera("3.0.0", lookat, "perspective");
    // Looking along +z with y up, right-handed coordinates have -x on the right.
    assert_eq!(c.transform.vector(Vec3::X), -Vec3::X);
    assert_eq!(c.transform.vector(Vec3::Y), Vec3::Y);
    assert_eq!(c.transform.vector(Vec3::Z), Vec3::Z);
    assert_eq!(c.transform.point(Vec3::ZERO), Vec3::new(0.0, 0.0, -5.0));
    let inverse = c.transform.inverse().then_after(&c.transform);
    assert!((inverse.point(Vec3::splat(1.0)) - Vec3::splat(1.0)).length() < 1e-6);
    assert!(matches!(c.kind, CameraKind::Perspective { fov: 40.0, fov_axis: FovAxis::X, .. }));
}

#[test]
fn lenses_and_projections() {
    let c = camera(
        "0.6.0",
        r#"<float name="apertureRadius" value="0.25"/><float name="focusDistance" value="7"/>
        <string name="fovAxis" value="Smaller"/><float name="fov" value="30"/>
        <float name="shutterClose" value="0.5"/>"#,
        "thinlens",
    );
    let CameraKind::Perspective { lens_radius, focus_distance, fov_axis, .. } = c.kind else {
        panic!()
    };
    assert_eq!((lens_radius, focus_distance, fov_axis), (0.25, 7.0, FovAxis::Smaller));
    assert_eq!(c.shutter, [0.0, 0.5]);
    let c = camera(
        "3.0.0",
        r#"<float name="principal_point_offset_x" value="0.1"/><float name="fov" value="9"/>"#,
        "perspective",
    );
    let CameraKind::Perspective { principal_point, .. } = c.kind else { panic!() };
    assert_eq!(principal_point, [0.1, 0.0]);
    let c = camera(
        "3.0.0",
        r#"<transform name="to_world"><scale x="1.5" y="1.5"/></transform>"#,
        "orthographic",
    );
    assert!(matches!(c.kind, CameraKind::Orthographic { unit_axis: FovAxis::X, .. }));
    assert_eq!(c.transform.vector(Vec3::splat(1.0)), Vec3::new(-1.5, 1.5, 1.0));
}

#[test]
fn films_and_filters() {
    let film = |version: &str, inner: &str| {
        camera(version, &format!("<film type=\"hdrfilm\">{inner}</film>"), "perspective").film
    };
    let f = film(
        "3.0.0",
        r#"<integer name="width" value="200"/><integer name="height" value="100"/>
        <integer name="crop_offset_x" value="10"/><integer name="crop_width" value="50"/>
        <string name="pixel_format" value="rgb"/>"#,
    );
    assert_eq!((f.resolution, f.crop), ([200, 100], Some([10, 0, 60, 100])));
    for (xml, filter) in [
        (r#"<rfilter type="box"/>"#, FilterChoice::Box { radius: [0.5; 2] }),
        (r#"<rfilter type="tent"/>"#, FilterChoice::Triangle { radius: [1.0; 2] }),
        (
            r#"<rfilter type="gaussian"><float name="stddev" value="0.4"/></rfilter>"#,
            FilterChoice::Gaussian { radius: [1.6; 2], sigma: 0.4 },
        ),
        (
            r#"<rfilter type="mitchell"><float name="B" value="0.5"/></rfilter>"#,
            FilterChoice::Mitchell { radius: [2.0; 2], b: 0.5, c: 1.0 / 3.0 },
        ),
        (
            r#"<rfilter type="catmullrom"/>"#,
            FilterChoice::Mitchell { radius: [2.0; 2], b: 0.0, c: 0.5 },
        ),
        (r#"<rfilter type="lanczos"/>"#, FilterChoice::LanczosSinc { radius: [3.0; 2], tau: 3.0 }),
    ] {
        assert_eq!(film("3.0.0", xml).filter, filter);
        assert_eq!(film("0.6.0", xml).filter, filter);
    }
}

#[test]
fn samplers_by_their_nearest_name() {
    for (theirs, ours) in [
        ("independent", "independent"),
        ("stratified", "stratified"),
        ("multijitter", "pmj02"),
        ("ldsampler", "pmj02"),
        ("hammersley", "halton"),
        ("sobol", "sobol"),
    ] {
        let c = camera(
            "0.6.0",
            &format!(
                "<sampler type=\"{theirs}\"><integer name=\"sampleCount\" value=\"9\"/></sampler>"
            ),
            "perspective",
        );
        assert_eq!((c.sampler.as_deref(), c.spp), (Some(ours), Some(9)));
    }
}

#[test]
fn films_of_responses() {
    let film = |inner: &str| {
        let sensor = format!(
            r#"<sensor type="perspective"><film type="specfilm"><integer name="width" value="4"/>{inner}</film></sensor>"#
        );
        let text = format!("<scene version=\"3.0.0\">{sensor}</scene>");
        let files = Files::new(&[("a.xml", &text)]);
        let d = files.read("a.xml", &[]);
        (d.cameras.first().and_then(|c| c.film.bands.clone()), files.messages(&d))
    };
    let (bands, messages) = film(
        r#"<spectrum name="Band_A" value="400:0, 500:1, 600:0"/><spectrum name="b" type="uniform"/>"#,
    );
    assert_eq!(messages, Vec::<String>::new());
    let Some(BandsDesc::Responses(list)) = bands else { panic!("{bands:?}") };
    let names: Vec<&str> = list.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Band_A", "b"]);
    let (_, messages) = film("");
    let message = "film `specfilm` needs a response: `<spectrum name=\"...\">` inside";
    assert!(messages[0].ends_with(message), "{messages:?}");
}
