//! The scene that is rendered when no file is named: a still life in a room with two coloured
//! walls, made of code alone.
//!
//! It shows what path tracing does on its own: walls that colour their neighbourhood, soft
//! shadows, the caustics of a glass ball and an amber block, brushed gold, a glazed vase. The
//! softbox is large, so that paths that leave the glass by chance find it: the picture is clean
//! after the samples it asks for.
//!
//! World: right-handed, y up, one unit about a metre, the viewer looking along -z.

mod grid;
mod knot;
mod lathe;
mod niche;
mod pattern;
mod room;
mod rounded_box;
mod stage;
mod still_life;

use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, IntegratorDesc, SceneDescription,
    SourceFormat,
};
use stage::Stage;

/// Width and height of the picture by default.
const RESOLUTION: [u32; 2] = [600, 400];
/// Samples a pixel by default.
const SPP: u64 = 48;
/// Longest path: glass behind glass needs some.
const MAX_DEPTH: u32 = 10;

/// The built-in scene.
pub fn description() -> SceneDescription {
    let mut stage = Stage::default();
    stage.scene.format = SourceFormat::BuiltIn;
    stage.scene.cameras.push(camera());
    stage.scene.integrator = IntegratorDesc {
        name: "path".to_string(),
        max_depth: Some(MAX_DEPTH),
        ..IntegratorDesc::default()
    };
    room::build(&mut stage);
    still_life::build(&mut stage);
    stage.scene
}

/// Above eye level of the objects, focused on the glass, the lens wide enough to tell near from
/// far.
fn camera() -> CameraDesc {
    let eye = Vec3::new(0.0, 1.12, 4.35);
    let target = Vec3::new(0.02, 0.62, -0.3);
    let frame = Transform::look_at(eye, target, Vec3::Y).expect("the view is not along y");
    // The frame has x = up x direction, which in a right-handed world is on the viewer's left.
    let mirror = Transform::scale(Vec3::new(-1.0, 1.0, 1.0)).expect("no factor is zero");
    let kind = CameraKind::Perspective {
        fov: 29.0,
        fov_axis: FovAxis::Y,
        principal_point: [0.0; 2],
        screen_window: None,
        lens_radius: 0.012,
        focus_distance: 4.2,
        near_clip: 0.01,
        far_clip: 1000.0,
    };
    let film = FilmDesc::new(RESOLUTION, FilterChoice::Gaussian { radius: [1.5; 2], sigma: 0.5 });
    let place = frame.then_after(&mirror);
    CameraDesc { name: "main".into(), spp: Some(SPP), ..CameraDesc::new(kind, place, film) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RenderOptions, Setup, output};
    use kaustika_transport::{Budget, Observer, Progress, Session, Workers, registry};
    use std::collections::HashSet;

    struct Silent;
    impl Observer for Silent {
        fn committed(&mut self, _: &Progress, _: &kaustika_film::accumulate::PassTree) {}
    }

    #[test]
    fn everything_refers_to_something() {
        let scene = description();
        assert_eq!(scene.diagnostics.entries, []);
        assert!(scene.shapes.iter().any(|s| s.emission.is_some()));
        let mut used = HashSet::new();
        for shape in &scene.shapes {
            let material = scene.materials.get(shape.material.0 as usize);
            assert!(material.is_some(), "{} has no material", shape.name);
            used.insert(shape.material);
            if let Some(e) = &shape.emission {
                assert!((e.radiance.0 as usize) < scene.textures.len(), "{}", shape.name);
            }
        }
        assert_eq!(used.len(), scene.materials.len(), "a material is not used");
        let names: HashSet<_> = scene.shapes.iter().map(|s| &s.name).collect();
        assert_eq!(names.len(), scene.shapes.len(), "a name stands for two shapes");
    }

    /// Means of R, G, B over the pixels of columns `x` and rows `y` in fractions of the picture.
    fn mean(picture: &kaustika_film::Picture, x: [f32; 2], y: [f32; 2]) -> [f32; 3] {
        let (w, h) = (picture.width as f32, picture.height as f32);
        let [x, y] = [x.map(|v| (v * w) as u32), y.map(|v| (v * h) as u32)];
        let rgb = picture.rgb().expect("it has colours");
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for row in y[0]..y[1] {
            for column in x[0]..x[1] {
                let c = rgb.pixel((row * picture.width + column) as usize);
                (0..3).for_each(|i| sum[i] += c[i]);
                count += 1.0;
            }
        }
        sum.map(|v| v / count)
    }

    #[test]
    fn a_small_picture_is_finite_and_exposed() {
        let options =
            RenderOptions { resolution: Some([90, 60]), spp: Some(4), ..Default::default() };
        let setup = Setup::new(&description(), &options).expect("the scene can be built");
        let path = registry::find("path").expect("there is a path tracer");
        let method = (path.make)(&setup.parameters).expect("the parameters are its own");
        let workers = Workers::new(0, Default::default()).expect("threads can be started");
        let mut session = Session::new(&setup.scene, &setup.frame, method);
        let budget = Budget { end_pass: Some(setup.spp), ..Default::default() };
        session.run(&budget, &workers, &mut Silent).expect("it renders");
        let picture = output::picture(&session.tree, None, &setup.record, 0.0);
        assert!(picture.rgb().expect("it has colours").pixels().flatten().all(f32::is_finite));
        let [r, g, b] = mean(&picture, [0.0, 1.0], [0.0, 1.0]);
        // Standard errors of these means are below 2 %: the bounds are many of them away.
        assert!((0.1..0.7).contains(&g), "mean {r} {g} {b}");
        let left = mean(&picture, [0.0, 0.05], [0.2, 0.5]);
        let right = mean(&picture, [0.95, 1.0], [0.2, 0.5]);
        assert!(left[0] > 2.0 * left[2], "the left wall is {left:?}");
        assert!(right[2] > 1.5 * right[0], "the right wall is {right:?}");
    }
}
