//! The z-buffer: mixtures, ambient light, meshes that have their light already.

use crate::scenes::*;
use crate::stats::close;
use crate::zbuffer::Drawn;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use kaustika_spectra::Wavelengths;
use kaustika_transport::zbuffer::{Painted, ZBufferParams};

/// Mixtures are drawn as what they are, halves as halves: by a constant amount, and by a texture.
#[test]
fn mixtures_are_blended() {
    for textured in [false, true] {
        let mut stage = Stage::new();
        let (dark, bright) = (stage.diffuse(0.1), stage.diffuse(0.9));
        let amount = match textured {
            false => stage.d.float(0.25),
            true => texture(&mut stage, bitmap(2, 1, |x, _| [x; 3]), BitmapFilter::Bilinear),
        };
        let m = stage.material(MaterialModel::Mix { a: dark, b: bright, amount });
        stage.shape(GeometryDesc::Rectangle, HERE, m);
        stage.camera(parallel(0.9, 0.0, 5.0), look(v(0.0, 0.0, 5.0), Vec3::ZERO), [40, 40]);
        let p = ZBufferParams { ambient: 1.0, headlight: 0.0, ..ZBufferParams::default() };
        let drawn = Drawn::new(&stage, &p);
        for pixel in drawn.pixels() {
            let s = drawn.met(pixel).expect("the rectangle");
            let bsdf = drawn.scene.bsdf(&s, Vec3::Z, &mut Wavelengths::rgb()).expect("a material");
            let truth = bsdf.albedo(Vec3::Z).0[0];
            let color = drawn.rasterizer.color(pixel[0], pixel[1])[0];
            close("colour", f64::from(color), f64::from(truth), 0.02);
        }
    }
}

/// A white floor under a white sky is about white; of a sky outside a room nothing arrives but what comes
/// through a window, a pane of glass, and what the walls make of it.
#[test]
fn ambient_light_is_what_arrives() {
    let draw = |window: f32| {
        let mut stage = Stage::new();
        let (white, pane) = (stage.diffuse(0.5), stage.glass(1.5, 0.0));
        if window < 1.0 {
            // Walls of a cube but for its ceiling, which is open from one side up to `window`.
            for (axis, degrees) in
                [(Vec3::X, 90.0), (Vec3::X, -90.0), (Vec3::Y, 90.0), (Vec3::Y, -90.0)]
            {
                stage.shape(
                    GeometryDesc::Rectangle,
                    rotate(degrees, axis) * at(0.0, 0.0, -1.0),
                    white,
                );
            }
            let ceiling = at(window, 0.0, 1.0) * scale(1.0 - window, 1.0, 1.0);
            stage.shape(GeometryDesc::Rectangle, ceiling * down(), white);
            stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * down(), pane);
        }
        stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -1.0), white);
        stage.sky(1.0);
        stage.camera(pinhole(50.0), look(v(0.0, 0.0, 0.9), v(0.0, 0.0, -1.0)), [48, 48]);
        let drawn = Drawn::new(&stage, &ZBufferParams::default());
        drawn.rasterizer.color(24, 24)[0] / 0.5
    };
    // A quarter of it comes from the eye, which faces the floor.
    close("in the open", f64::from(draw(1.0)), 1.25, 0.01);
    let (narrow, wide) = (draw(0.1), draw(0.4));
    assert!(narrow > 0.0 && narrow < 0.25 && wide > 2.0 * narrow && wide < 1.0, "{narrow} {wide}");
    // Without a window it is a dark room, and a headlight shines.
    close("closed", f64::from(draw(0.0)), 1.0, 1e-3);
}

/// A mesh with colours: linear between vertices, whatever the perspective; not seen from behind.
#[test]
fn painted_meshes_are_interpolated() {
    let positions: Vec<Vec3> = vec![v(-1.0, -1.0, 0.0), v(1.0, -1.0, 0.0), v(1.0, 1.0, 0.3)];
    let color = |p: Vec3| [2.0 + p.x, 3.0 + p.y, 1.5];
    let values: Vec<f32> = positions.iter().flat_map(|&p| color(p)).collect();
    let attribute =
        MeshAttribute { name: "vertex_color".into(), channels: 3, per_face: false, values };
    let mesh = TriMesh {
        positions,
        indices: vec![[0, 1, 2]],
        attributes: vec![attribute],
        ..TriMesh::default()
    };
    for (height, shown) in [(2.0, true), (-2.0, false)] {
        let mut stage = Stage::new();
        let white = stage.diffuse(0.5);
        stage.shape(GeometryDesc::Mesh(std::sync::Arc::new(mesh.clone())), HERE, white);
        stage.camera(pinhole(60.0), look(v(0.4, -0.6, height), Vec3::ZERO), [64, 48]);
        let drawn = Drawn::new(&stage, &ZBufferParams::default());
        let mut painted = Painted::new(&mesh).expect("it has colours");
        painted.draw(&drawn.scene, &drawn.view);
        let mut pixels = 0;
        for pixel in drawn.pixels() {
            let found = painted.color(pixel[0], pixel[1]);
            match drawn.seen(pixel).filter(|_| shown) {
                Some(seen) => {
                    let truth = color(seen.p);
                    (0..3).for_each(|k| close("colour", found[k].into(), truth[k].into(), 1e-4));
                    pixels += 1;
                }
                None => assert_eq!(found, [0.0; 3]),
            }
        }
        assert_eq!(pixels > 200, shown);
    }
    assert!(Painted::new(&TriMesh { attributes: Vec::new(), ..mesh }).is_none());
}
