//! Sun and sky.

use super::*;
use kaustika_math::Vec3;
use kaustika_spectra::SpectrumDesc;

/// The sky, and direction, radius and scale of the sun in the world.
fn parts(d: &SceneDescription) -> (SkyDesc, Vec3, f32, f32) {
    let [sky, sun] = &d.lights[..] else { panic!("{:?}", d.lights) };
    let LightKind::Sky { sky: desc, .. } = &sky.kind else { panic!("{:?}", sky.kind) };
    let LightKind::Sun { radius, scale, .. } = &sun.kind else { panic!("{:?}", sun.kind) };
    let toward = sun.transform.vector(Vec3::Z).normalize();
    // Both lights know where the sun stands; a stretched sky moves its disc.
    assert!(desc.stretch > 1.0 || (sky.transform.vector(desc.sun) - toward).length() < 1e-5);
    (desc.clone(), toward, *radius, *scale)
}

/// Mitsuba 3.9.1's own direction by default; single precision rounds its Julian date to a quarter
/// of a day, which moves the sun by up to half a degree. In 0.6 +x is east, -z north, +y up.
#[test]
fn where_the_sun_stands() {
    let (_, old, ..) = parts(&scene06(r#"<emitter type="sunsky"/>"#));
    let (_, new, ..) = parts(&scene(r#"<emitter type="sunsky"/>"#));
    let peer = Vec3::new(0.0513854, 0.691748, 0.720308);
    assert!((new - peer).length() < 0.5f32.to_radians(), "{new:?}");
    // In the afternoon, in the west: azimuth beyond half a turn from north by east.
    assert!(old.x < 0.0 && old.z > 0.0, "{old:?}");
    assert!((new - Vec3::new(old.z, -old.x, old.y)).length() < 1e-5, "{old:?} {new:?}");
    let (_, turned, ..) = parts(&scene06(
        r#"<emitter type="sunsky"><transform name="toWorld"><rotate x="1" angle="90"/></transform>
        </emitter>"#,
    ));
    assert!((turned - Vec3::new(old.x, -old.z, old.y)).length() < 1e-5, "{turned:?}");
}

#[test]
fn a_direction_is_one_of_the_world() {
    let (sky, toward, ..) = parts(&scene(
        r#"<emitter type="sunsky"><vector name="sun_direction" x="3" y="4" z="0"/>
        <transform name="to_world"><rotate x="1" angle="-90"/></transform></emitter>"#,
    ));
    assert!((toward - Vec3::new(0.6, 0.8, 0.0)).length() < 1e-6);
    assert!((sky.sun.z - 0.8).abs() < 1e-6, "{:?}", sky.sun);
}

#[test]
fn parameters_of_both_dialects() {
    let (sky, _, radius, scale) = parts(&scene(
        r#"<emitter type="sunsky"><float name="turbidity" value="5"/><float name="albedo" value="0.1"/>
        <float name="sun_aperture" value="5"/><float name="sun_scale" value="2"/>
        <float name="hour" value="11"/></emitter>"#,
    ));
    assert_eq!((sky.turbidity, sky.albedo, sky.stretch), (5.0, SpectrumDesc::Constant(0.1), 1.0));
    // As much light as from the true sun.
    let ratio = (0.5f32 * 0.5358).to_radians().sin().powi(2) / 2.5f32.to_radians().sin().powi(2);
    assert!(radius == 2.5 && (scale / (2.0 * ratio) - 1.0).abs() < 1e-3, "{radius} {scale}");
    let (sky, _, radius, _) = parts(&scene06(
        r#"<emitter type="sunsky"><float name="sunRadiusScale" value="4"/>
        <float name="stretch" value="1.5"/><integer name="resolution" value="1024"/></emitter>"#,
    ));
    assert_eq!((sky.albedo, sky.stretch), (SpectrumDesc::Constant(0.2), 1.5));
    assert!((radius - 4.0 * 0.2679).abs() < 1e-6);
}

#[test]
fn a_sun_or_a_sky_alone() {
    let only = |xml: &str| scene06(xml).lights.iter().map(|l| l.kind.clone()).collect::<Vec<_>>();
    let [LightKind::Sky { scale, .. }] =
        only(r#"<emitter type="sky"><float name="scale" value="3"/></emitter>"#)[..]
    else {
        panic!()
    };
    assert_eq!(scale, 3.0);
    assert!(matches!(only(r#"<emitter type="sun"/>"#)[..], [LightKind::Sun { .. }]));
    // Without width it is a directional light of the same irradiance.
    let lights = only(r#"<emitter type="sun"><float name="sunRadiusScale" value="0"/></emitter>"#);
    let [LightKind::Directional { scale, .. }] = lights[..] else { panic!("{lights:?}") };
    assert!((scale / 6.8e-5 - 1.0).abs() < 0.02, "{scale}");
    let dark = scene(r#"<emitter type="sunsky"><float name="sun_scale" value="0"/></emitter>"#);
    assert!(matches!(dark.lights[..], [LightDesc { kind: LightKind::Sky { .. }, .. }]));
}

#[test]
fn messages() {
    for (version, inner, expected) in [
        (
            "3.0.0",
            r#"<float name="turbidity" value="12"/>"#,
            "error 2:24 `turbidity` must be in [1, 10], found 12",
        ),
        ("0.6.0", r#"<float name="hour" value="1"/>"#, "error 2:1 the sun is below the horizon"),
        (
            "3.0.0",
            r#"<float name="hour" value="1"/>"#,
            "warning 2:1 the sun is below the horizon | no light",
        ),
        (
            "3.0.0",
            r#"<float name="hour" value="1"/><vector name="sun_direction" value="0,0,1"/>"#,
            "error 2:1 `sun_direction` and `hour` exclude each other",
        ),
        (
            "3.0.0",
            r#"<vector name="sun_direction" value="0,0,0"/>"#,
            "error 2:60 the direction is zero",
        ),
        (
            "0.6.0",
            r#"<float name="sunRadiusScale" value="-1"/>"#,
            "error 2:1 a sun of -0.5358° across is none",
        ),
        (
            "3.0.0",
            r#"<boolean name="complex_sun" value="true"/>"#,
            "warning 2:24 a sun that darkens toward its limb is not supported | a disc of the same \
             mean is used",
        ),
    ] {
        let (_, found) = read(version, &format!("<emitter type=\"sunsky\">{inner}</emitter>"));
        assert_eq!(found, [expected], "{inner}");
    }
}

/// While the shutter stays shut, a `timed_sunsky` is the `sunsky` of its first moment.
#[test]
fn a_moment_of_a_timed_sky() {
    let timed = scene(
        r#"<emitter type="timed_sunsky"><integer name="start_year" value="2024"/>
<integer name="start_month" value="7"/><integer name="start_day" value="4"/>
<float name="window_start_time" value="10"/></emitter>"#,
    );
    let still = scene(
        r#"<emitter type="sunsky"><integer name="year" value="2024"/><integer name="month" value="7"/>
<integer name="day" value="4"/><float name="hour" value="10"/></emitter>"#,
    );
    let kinds = |d: &SceneDescription| -> Vec<LightKind> {
        d.lights.iter().map(|l| l.kind.clone()).collect()
    };
    assert_eq!(kinds(&timed).len(), 2);
    assert_eq!(kinds(&timed), kinds(&still));
}

#[test]
fn a_timed_sky_while_the_shutter_is_open() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective">
<float name="shutter_close" value="1"/></sensor>
<emitter type="timed_sunsky"><integer name="end_year" value="2025"/><integer name="end_day" value="EN"/>
</emitter></scene>"#;
    let files = Files::new(&[
        ("good.xml", &text.replace("EN", "3")),
        ("bad.xml", &text.replace("EN", "1")),
    ]);
    let good = files.read("good.xml", &[]);
    assert!(matches!(good.lights[..], [LightDesc { kind: LightKind::Image { .. }, .. }]));
    let bad = files.messages(&files.read("bad.xml", &[]));
    assert!(bad[0].ends_with("the days end before they begin"), "{bad:?}");
}
