//! Sensors that measure.

use super::*;
use kaustika_math::Vec3;

/// The description without the camera that every test scene begins with.
fn cameras(inner: &str) -> Vec<CameraDesc> {
    scene(inner).cameras.split_off(1)
}

#[test]
fn on_a_shape() {
    for (plugin, wanted) in [("irradiancemeter", false), ("fluxmeter", true)] {
        let found = cameras(&format!(
            r#"<shape type="sphere"/><shape type="rectangle"><sensor type="{plugin}" id="m">
            <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
            </film></sensor></shape>"#
        ));
        assert_eq!(found[0].kind, CameraKind::Irradiance { shape: 1, flux: wanted });
        assert_eq!((found[0].name.as_str(), found[0].film.resolution), ("m", [1, 1]));
    }
}

#[test]
fn along_a_line() {
    let found = cameras(
        r#"<sensor type="radiancemeter"><point name="origin" value="1,2,3"/>
        <vector name="direction" value="0,2,0"/></sensor>
        <sensor type="radiancemeter"><transform name="to_world"><translate x="4"/></transform>
        </sensor>"#,
    );
    assert!(found.iter().all(|c| c.kind == CameraKind::Radiance));
    assert_eq!(found[0].transform.point(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    assert!((found[0].transform.vector(Vec3::Z) - Vec3::Y).length() < 1e-6);
    assert_eq!(found[1].transform.point(Vec3::ZERO), Vec3::new(4.0, 0.0, 0.0));
}

#[test]
fn from_far_away() {
    let found = cameras(
        r#"<sensor type="distant"><vector name="direction" value="0,0,-1"/></sensor>
        <sensor type="distant"><point name="target" value="1,2,3"/></sensor>
        <sensor type="distant"><shape type="rectangle" name="target"><transform name="to_world">
        <scale value="2"/></transform></shape></sensor>"#,
    );
    let target = |i: usize| match &found[i].kind {
        CameraKind::Distant { target } => target.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(target(0), MeterTarget::Scene);
    assert_eq!(target(1), MeterTarget::Point(Vec3::new(1.0, 2.0, 3.0)));
    let MeterTarget::Rectangle(t) = target(2) else { panic!() };
    assert_eq!(t.vector(Vec3::X), Vec3::new(2.0, 0.0, 0.0));
}

#[test]
fn side_by_side() {
    let found = cameras(
        r#"<sensor type="batch"><sensor type="radiancemeter"/><sensor type="perspective"/>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="4"/>
        </film></sensor>"#,
    );
    assert_eq!((found.len(), found[0].film.resolution), (1, [8, 4]));
    let CameraKind::Batch { cameras } = &found[0].kind else { panic!("{found:?}") };
    assert_eq!(cameras[0].kind, CameraKind::Radiance);
    assert!(matches!(cameras[1].kind, CameraKind::Perspective { .. }));
}

#[test]
fn messages() {
    for (inner, expected) in [
        (
            r#"<sensor type="irradiancemeter"/>"#,
            "error 2:1 sensor `irradiancemeter` measures on a shape | put it into a `<shape>`",
        ),
        (
            r#"<shape type="cube"><sensor type="perspective"/></shape>"#,
            "error 2:34 sensor `perspective` can't stand on a shape",
        ),
        (
            r#"<shape type="cube"><sensor type="fluxmeter"><transform name="to_world"/></sensor></shape>"#,
            "error 2:20 a `fluxmeter` stands where its shape stands | remove `to_world`",
        ),
        (
            r#"<sensor type="radiancemeter"><point name="origin" value="1"/></sensor>"#,
            "error 2:1 a `radiancemeter` needs both `origin` and `direction`",
        ),
        (
            r#"<sensor type="distant"><vector name="direction" value="0"/></sensor>"#,
            "error 2:56 the direction is zero",
        ),
        (
            r#"<sensor type="distant"><float name="target" value="1"/></sensor>"#,
            "error 2:24 `target` of sensor `distant` must be a point or a rectangle, found a number",
        ),
        (r#"<sensor type="batch"/>"#, "error 2:1 a batch without sensors"),
    ] {
        assert_eq!(read("3.0.0", inner).1, [expected], "{inner}");
    }
}
