//! The graphics state: transforms, attributes, objects.

use super::{assert_maps, messages, model, read, rgb, sphere_radius, world};
use kaustika_math::Vec3;
use kaustika_scene::description::{GroupId, MaterialModel, MediumId};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

#[test]
fn the_last_transform_acts_first() {
    let s = world("Translate 1 2 3 Scale 2 2 2 Rotate 90 0 0 1 Shape \"sphere\"");
    // (1,0,0) turns to (0,1,0), grows to (0,2,0), moves to (1,4,3).
    assert_maps(&s.shapes[0].transform, [1.0, 0.0, 0.0], [1.0, 4.0, 3.0]);
}

#[test]
fn matrices_are_written_by_columns() {
    let text = "Translate 1 0 0 ConcatTransform [ 1 0 0 0  0 2 0 0  0 0 1 0  5 6 7 1 ]
        Shape \"sphere\" Transform [ 1 0 0 0  0 2 0 0  0 0 1 0  5 6 7 1 ] Shape \"sphere\"
        Identity Shape \"sphere\"";
    let s = world(text);
    assert_maps(&s.shapes[0].transform, [1.0, 1.0, 1.0], [7.0, 8.0, 8.0]);
    assert_maps(&s.shapes[1].transform, [1.0, 1.0, 1.0], [6.0, 8.0, 8.0]);
    assert!(s.shapes[2].transform.is_identity());
}

#[test]
fn the_camera_stands_where_look_at_says() {
    let s = read("LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin");
    let t = &s.cameras[0].transform;
    assert_maps(t, [0.0, 0.0, 0.0], [0.0, 0.0, 5.0]);
    assert_maps(t, [0.0, 0.0, 5.0], [0.0, 0.0, 0.0]);
    assert_maps(t, [0.0, 1.0, 0.0], [0.0, 1.0, 5.0]);
    // +x is to the right of the picture; up x forward in the file's own handedness.
    assert_maps(t, [1.0, 0.0, 0.0], [-1.0, 0.0, 5.0]);
}

#[test]
fn the_camera_may_be_mirrored() {
    let s = read("Scale -1 1 1 LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin");
    assert_maps(&s.cameras[0].transform, [1.0, 0.0, 0.0], [1.0, 0.0, 5.0]);
    assert!(s.cameras[0].transform.swaps_handedness());
}

#[test]
fn world_begin_resets_the_transform_and_camera_is_a_coordinate_system() {
    let text = "Translate 0 0 -3 Camera \"perspective\" WorldBegin Shape \"sphere\"
        CoordSysTransform \"camera\" Shape \"sphere\" Translate 7 0 0 CoordinateSystem \"mine\"
        Identity CoordSysTransform \"mine\" Shape \"sphere\"
        CoordSysTransform \"world\" Shape \"sphere\"";
    let s = read(text);
    assert_eq!(messages(&s), "");
    assert_maps(&s.shapes[0].transform, [0.0; 3], [0.0; 3]);
    assert_maps(&s.shapes[1].transform, [0.0; 3], [0.0, 0.0, 3.0]);
    assert_maps(&s.shapes[2].transform, [0.0; 3], [7.0, 0.0, 3.0]);
    assert_maps(&s.shapes[3].transform, [0.0; 3], [0.0; 3]);
}

#[test]
fn attributes_nest() {
    let text = "Material \"diffuse\" \"rgb reflectance\" [ .1 .1 .1 ]
        AttributeBegin Translate 1 0 0 ReverseOrientation
            Material \"diffuse\" \"rgb reflectance\" [ .2 .2 .2 ] AreaLightSource \"diffuse\"
            AttributeBegin Translate 1 0 0 ReverseOrientation Shape \"sphere\" AttributeEnd
            Shape \"sphere\"
        AttributeEnd Shape \"sphere\"";
    let s = world(text);
    let grey = |i: usize| match model(&s, &s.shapes[i]) {
        MaterialModel::Diffuse { reflectance } => rgb(&s, *reflectance)[0],
        _ => panic!(),
    };
    assert_maps(&s.shapes[0].transform, [0.0; 3], [2.0, 0.0, 0.0]);
    assert_maps(&s.shapes[1].transform, [0.0; 3], [1.0, 0.0, 0.0]);
    assert_maps(&s.shapes[2].transform, [0.0; 3], [0.0; 3]);
    assert_eq!([0, 1, 2].map(grey), [0.2, 0.2, 0.1]);
    assert_eq!([0, 1, 2].map(|i| s.shapes[i].flip_normals), [false, true, false]);
    assert_eq!([0, 1, 2].map(|i| s.shapes[i].emission.is_some()), [true, true, false]);
}

#[test]
fn attribute_gives_parameters_that_a_shape_may_override() {
    let text = "AttributeBegin Attribute \"shape\" \"float radius\" 3 \"float alpha\" .5
        Shape \"sphere\" Shape \"sphere\" \"float radius\" 4 AttributeEnd Shape \"sphere\"";
    let s = world(text);
    assert_eq!([0, 1, 2].map(|i| sphere_radius(&s.shapes[i])), [3.0, 4.0, 1.0]);
    assert_eq!([0, 1, 2].map(|i| s.shapes[i].alpha.is_some()), [true, true, false]);
}

#[test]
fn of_equal_parameters_the_last_counts() {
    let s = world("Shape \"sphere\" \"float radius\" 3 \"float radius\" 5");
    assert_eq!(sphere_radius(&s.shapes[0]), 5.0);
}

#[test]
fn colour_spaces_belong_to_the_colours_behind_them() {
    let s = world(
        "AttributeBegin ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]
        AttributeEnd Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]",
    );
    let spaces: Vec<ColorSpace> = s
        .textures
        .iter()
        .map(|t| match &t.node {
            kaustika_scene::description::TextureNode::Spectrum(SpectrumDesc::Rgb {
                space, ..
            }) => *space,
            _ => panic!(),
        })
        .collect();
    assert_eq!(spaces, [ColorSpace::Rec2020, ColorSpace::Srgb]);
}

#[test]
fn objects_are_placed_by_instances() {
    let text = "AttributeBegin Translate 1 0 0 ObjectBegin \"ball\"
            Scale 2 2 2 Shape \"sphere\" Shape \"disk\"
        ObjectEnd AttributeEnd
        Translate 0 5 0 ObjectInstance \"ball\" Translate 0 5 0 ObjectInstance \"ball\"";
    let s = world(text);
    assert_eq!((s.shapes.len(), s.groups.len(), s.instances.len()), (0, 1, 2));
    assert_eq!((s.groups[0].name.as_str(), s.groups[0].shapes.len()), ("ball", 2));
    assert_maps(&s.groups[0].shapes[0].transform, [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]);
    assert_eq!(s.instances[1].group, GroupId(0));
    assert_maps(&s.instances[1].transform, [0.0; 3], [0.0, 10.0, 0.0]);
}

#[test]
fn shapes_cameras_and_instances_move() {
    let text = "TransformTimes 0.25 0.5
        ActiveTransform EndTime Translate 0 0 -3 ActiveTransform All Camera \"perspective\" WorldBegin
        ObjectBegin \"o\" Shape \"sphere\" ObjectEnd
        ActiveTransform StartTime Translate 1 0 0
        ActiveTransform EndTime Translate 2 0 0 Shape \"sphere\" Shape \"disk\" ObjectInstance \"o\"
        ActiveTransform All Translate 0 1 0 Shape \"sphere\" Identity Shape \"sphere\"";
    let s = read(text);
    assert_eq!(messages(&s), "");
    assert_eq!((s.shapes.len(), s.groups.len(), s.instances.len()), (1, 3, 3));
    // Shapes of one motion are placed together.
    assert_eq!((s.groups[1].shapes.len(), s.groups[2].shapes.len()), (2, 1));
    assert!(s.groups[1].shapes[0].transform.is_identity());
    let ends = |i: usize| [0, 1].map(|k| s.instances[i].motion[k].transform.point(Vec3::ZERO));
    assert_eq!(ends(0), [Vec3::X, Vec3::X * 2.0]);
    assert_eq!(ends(1), [Vec3::X + Vec3::Y, Vec3::X * 2.0 + Vec3::Y]);
    assert_eq!((s.instances[2].group, ends(2)), (GroupId(0), ends(0)));
    let camera = &s.cameras[0].motion;
    assert_eq!((camera[0].time, camera[1].time), (0.25, 0.5));
    assert_maps(&camera[1].transform, [0.0; 3], [0.0, 0.0, 3.0]);
}

#[test]
fn what_does_not_move_is_told() {
    let text = "WorldBegin TransformTimes 1 0 ObjectBegin \"o\" ActiveTransform EndTime Translate 1 0 0
        Shape \"disk\" ObjectEnd ActiveTransform EndTime Translate 2 0 0
        LightSource \"point\" AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd
        Scale -1 1 1 Shape \"disk\"";
    let s = read(text);
    assert_eq!(
        messages(&s),
        "error 1:12 <TransformTimes> `TransformTimes` is not allowed after `WorldBegin`; move it \
         before `WorldBegin`\n\
         warning 3:9 <LightSource> lights and textures do not move, using the start\n\
         warning 4:22 <Shape> the transform at the end mirrors what that at the start does not, \
         using the start\n\
         warning 3:70 <Shape> shapes that shine do not move, using the start\n\
         warning 2:9 <Shape> shapes do not move inside objects, using the start\n"
    );
    assert!(s.instances.is_empty());
    let s = read("TransformTimes 1 0.5 WorldBegin");
    assert_eq!(
        messages(&s),
        "error 1:1 <TransformTimes> `TransformTimes 1 0.5` does not end after it starts\n"
    );
}

#[test]
fn media_are_named_inside_and_outside() {
    let text = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" WorldBegin
        MediumInterface \"fog\" \"\" Shape \"sphere\" MediumInterface \"fog\" Shape \"sphere\"";
    let s = read(text);
    let fog = Some(MediumId(0));
    assert_eq!((s.shapes[0].interior, s.shapes[0].exterior), (fog, None));
    assert_eq!((s.shapes[1].interior, s.shapes[1].exterior), (fog, fog));
    assert_eq!((s.media[0].name.as_str(), s.media[0].kind.as_str()), ("fog", "homogeneous"));
    assert_eq!(messages(&s), "");
}
