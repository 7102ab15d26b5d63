//! Light that was baked, put back on surfaces: another storage, the same picture.

use crate::kit::Place;
use kaustika::film::Picture;

const SENSOR: &str = r#"
  <integrator type="path"/>
  <sensor type="perspective"><float name="fov" value="75"/>
    <transform name="to_world">
      <lookat origin="-0.1, -0.95, 0.3" target="0.1, 0.3, -0.3" up="0, 0, 1"/>
    </transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="32"/>
      <rfilter type="box"/></film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>"#;

/// A room of two colours with a box and a ball in it, and a lamp.
const ROOM: &str = r#"
  <bsdf type="diffuse" id="white"><rgb name="reflectance" value="0.7, 0.6, 0.5"/></bsdf>
  <bsdf type="diffuse" id="blue"><rgb name="reflectance" value="0.2, 0.3, 0.8"/></bsdf>
  <shape type="cube"><boolean name="flip_normals" value="true"/><ref id="white"/></shape>
  <shape type="rectangle"><ref id="blue"/><transform name="to_world">
    <scale x="0.8" y="0.6"/><rotate x="1" angle="90"/><translate y="0.99"/></transform></shape>
  <shape type="cube"><ref id="blue"/><transform name="to_world">
    <scale value="0.3"/><rotate z="1" angle="25"/><translate x="-0.4" y="0.2" z="-0.69"/>
  </transform></shape>
  <shape type="sphere"><ref id="white"/><float name="radius" value="0.3"/>
    <point name="center" x="0.4" y="0.3" z="-0.6"/></shape>
  <shape type="rectangle"><transform name="to_world">
      <scale value="0.3"/><rotate x="1" angle="180"/><translate z="0.99"/></transform>
    <emitter type="area"><rgb name="radiance" value="8, 7, 6"/></emitter></shape>"#;

/// A mesh that shines as a texture says.
fn shining(mesh: &str, texture: &str) -> String {
    format!(
        r#"<scene version="3.0.0">{SENSOR}
  <shape type="ply"><string name="filename" value="{mesh}"/>
    <boolean name="flip_tex_coords" value="true"/>
    <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
    <emitter type="area">{texture}</emitter></shape></scene>"#
    )
}

/// Relative L2 of a picture against another, over the colours.
fn error(found: &Picture, truth: &Picture) -> f64 {
    let values = |p: &Picture| p.rgb().unwrap().pixels().flatten().collect::<Vec<f32>>();
    let (mut sum, mut all) = (0.0, 0.0);
    for (a, b) in values(found).into_iter().zip(values(truth)) {
        sum += f64::from(a - b).powi(2);
        all += f64::from(b).powi(2);
    }
    (sum / all).sqrt()
}

/// The light map of a solution, read as a texture and put on its mesh, and the colours of the vertices of its patches:
/// seen through the same samples, both are the picture that radiosity shows of the solution itself, but for what texels
/// blur.
#[test]
fn baked_light_read_back_is_the_solution() {
    let p = Place::new();
    p.write("room.xml", &format!(r#"<scene version="3.0.0">{SENSOR}{ROOM}</scene>"#));
    let map = r#"<texture type="bitmap" name="radiance"><string name="filename" value="map.exr"/>
        <boolean name="raw" value="true"/></texture>"#;
    p.write("map.xml", &shining("map.uv.ply", map));
    let colors = r#"<texture type="mesh_attribute" name="radiance">
        <string name="name" value="vertex_color"/></texture>"#;
    p.write("patches.xml", &shining("patches.ply", colors));
    let solve = "render room.xml -q -m radiosity -p direct=mesh -p solver=gauss-seidel \
                 -p patches=1500 -p samples=256";
    p.ok(&format!("{solve} -o seen.exr --bake patches.ply"));
    p.ok(&format!("{solve} --spp 1 -o a.exr --bake map.exr"));
    let seen = p.picture("seen.exr");
    for stored in ["map", "patches"] {
        p.ok(&format!("render {stored}.xml -q -m path -p max_depth=0 -o {stored}-seen.exr"));
        let e = error(&p.picture(&format!("{stored}-seen.exr")), &seen);
        assert!(e < 0.006, "{stored}: {e}");
    }
}
