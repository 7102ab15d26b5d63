//! Cameras, lights, and what is there if a file has none.

use super::*;

#[test]
fn cameras_look_along_minus_z() {
    let d = sound(parse(
        r#"{"asset":{"version":"2.0"},
        "cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1,"aspectRatio":2}},
                   {"type":"orthographic","orthographic":{"xmag":3,"ymag":4,"znear":0,"zfar":9}}],
        "nodes":[{"camera":0,"name":"eye","translation":[0,1,0],"scale":[3,3,3]},{"camera":1}]}"#,
    ));
    let c = &d.cameras[0];
    let CameraKind::Perspective { fov, fov_axis: FovAxis::Y, near_clip, far_clip, .. } = c.kind
    else {
        panic!()
    };
    assert!((fov - 0.5f32.to_degrees()).abs() < 1e-5 && near_clip == 0.1);
    assert!(far_clip.is_infinite());
    assert_eq!((c.name.as_str(), c.film.resolution), ("eye", [1280, 640]));
    assert_eq!(c.transform.vector(Vec3::Z), -Vec3::Z);
    assert_eq!(c.transform.vector(Vec3::X), Vec3::X);
    assert_eq!(c.transform.point(Vec3::ZERO), Vec3::Y);
    let CameraKind::Orthographic { screen_window, .. } = d.cameras[1].kind else { panic!() };
    assert_eq!(screen_window, Some([-3.0, 3.0, -4.0, 4.0]));
    assert_eq!(d.cameras[1].film.resolution, [960, 1280]);
}

#[test]
fn punctual_lights_keep_their_numbers() {
    let d = sound(parse(
        r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual"],
        "extensions":{"KHR_lights_punctual":{"lights":[
            {"type":"point","color":[1,0.5,0],"intensity":20,"range":4},
            {"type":"spot","intensity":3,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.6}},
            {"type":"directional","intensity":7}]}},
        "nodes":[{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[1,2,3]},
                 {"extensions":{"KHR_lights_punctual":{"light":1}},"scale":[2,2,2]},
                 {"extensions":{"KHR_lights_punctual":{"light":2}},
                  "rotation":[-0.70710678,0,0,0.70710678]}]}"#,
    ));
    let LightKind::Point { scale, power: None, .. } = d.lights[0].kind else { panic!() };
    assert_eq!(scale, 20.0);
    assert_eq!(d.lights[0].transform.point(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    let LightKind::Spot { scale, cutoff, beam_width, falloff, .. } = d.lights[1].kind else {
        panic!()
    };
    assert_eq!((scale, falloff), (3.0, SpotFalloff::SquaredLinearCosine));
    assert!((cutoff - 0.6f32.to_degrees()).abs() < 1e-4);
    assert!((beam_width - 0.2f32.to_degrees()).abs() < 1e-4);
    assert_eq!(d.lights[1].transform.vector(Vec3::Z), -Vec3::Z);
    // A quarter turn from -z to -y.
    let down = d.lights[2].transform.vector(Vec3::Z);
    assert!((down + Vec3::Y).length() < 1e-6, "{down:?}");
}

#[test]
fn a_camera_and_a_sky_are_put_where_there_are_none() {
    let d = with_material("{}", "");
    let notes: Vec<_> = d.diagnostics.entries.iter().map(|m| m.message.as_str()).collect();
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(notes[0].starts_with("the file has no camera: one at ("), "{notes:?}");
    assert!(notes[1].starts_with("the file has no light: a white sky"), "{notes:?}");
    assert!(matches!(d.lights[0].kind, LightKind::Constant { .. }));
    // The sphere around the triangle is in front of the camera and within its view.
    let eye = d.cameras[0].transform;
    let center = eye.inverse().point(Vec3::new(0.5, 0.5, 0.0));
    assert!(center.x.abs() < 1e-5 && center.y.abs() < 1e-5 && center.z > 0.0, "{center:?}");
    let radius = 0.5f32.sqrt();
    assert!((radius / center.z).asin().to_degrees() <= 20.001);
    assert!(eye.vector(Vec3::Z).y < 0.0, "from above");
    // What emits is a light; signs are none.
    let d = with_material(r#"{"emissiveFactor":[0,1,0]}"#, "");
    assert!(d.lights.is_empty());
}
