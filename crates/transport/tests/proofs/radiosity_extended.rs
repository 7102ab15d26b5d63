//! Form factors by way of mirrors and glass: those of virtual images, and no more than there is.

use crate::irradiance::lambert;
use crate::radiosity::{cube, meshed};
use crate::scenes::*;
use crate::stats::close;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use kaustika_transport::radiosity::form_factor::{FormFactorKind, FormFactors, Row};
use std::f64::consts::PI;

/// A smooth mirror of a colour.
fn mirror(stage: &mut Stage, rgb: [f32; 3]) -> MaterialId {
    let (roughness, specular_reflectance) = (stage.rough(0.0), stage.d.rgb(rgb));
    let color = ConductorColor::Mirror;
    stage.material(MaterialModel::Conductor { color, specular_reflectance, roughness })
}

/// Between two walls that mirror, a small square below a larger one: to the square itself the form factor is that of
/// Lambert's formula, by way of a mirror it is that to the virtual image times the mirror's ρ in every colour, and by
/// way of both, to the images behind the image, times their product.
#[test]
fn a_mirror_box_shows_darker_virtual_images() {
    let (left, right) = ([0.9f32, 0.6, 0.3], [0.5f32, 0.8, 0.7]);
    let mut stage = Stage::new();
    let white = stage.diffuse(0.5);
    stage.shape(GeometryDesc::Rectangle, scale(0.002, 0.002, 1.0), white);
    stage.shape(GeometryDesc::Rectangle, at(0.2, 0.1, 1.0) * down() * scale(0.4, 0.5, 1.0), white);
    for (x, turn, rgb) in [(-1.0, 90.0, left), (1.0, -90.0, right)] {
        let m = mirror(&mut stage, rgb);
        let wall = at(x, 0.0, 0.0) * rotate(turn, Vec3::Y) * scale(60.0, 60.0, 1.0);
        stage.shape(GeometryDesc::Rectangle, wall, m);
    }
    let scene = stage.build();
    let mesh = meshed(&scene, 60);
    let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 1 << 17, true);
    let of = |i: usize| &mesh.elements[ff.patches[i] as usize];
    let is_square = |j: usize| of(j).center().z == 1.0 && !of(j).is_black();
    // Images at x, 2 - x, -2 - x, x + 4, x - 4, ...; each reflection at the right wall or the left.
    let factor = |image: &dyn Fn(f64) -> f64| {
        let corner = |x: f64, y: f64| [image(x), y, 1.0];
        let [x0, x1, y0, y1] = [-0.2, 0.6, -0.4, 0.6];
        lambert(1.0, &[corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)], [0.0; 3])
            / PI
    };
    let direct = factor(&|x| x);
    for i in (0..ff.len()).filter(|&i| of(i).center().z == 0.0 && of(i).normal.z > 0.0) {
        let row = ff.row(i);
        let seen = row.seen.iter().filter(|(j, _)| is_square(*j as usize));
        close("seen", seen.map(|(_, f)| f64::from(*f)).sum(), direct, 0.01);
        for k in 0..3 {
            let [l, r] = [left[k], right[k]].map(f64::from);
            let mut truth = 0.0;
            for n in 0..4 {
                let (far, both) = (4.0 * f64::from(n), (l * r).powi(n));
                truth += both * r * factor(&|x| 2.0 + far - x);
                truth += both * l * factor(&|x| -2.0 - far - x);
                truth += both * l * r * (factor(&|x| x + 4.0 + far) + factor(&|x| x - 4.0 - far));
            }
            let mirrored = row.mirrored.iter().filter(|(j, _)| is_square(*j as usize));
            let found = mirrored.map(|(_, f)| f64::from(f.0[k])).sum();
            close(&format!("by the mirrors, colour {k}"), found, truth, 0.01);
        }
    }
}

/// Σⱼ F_ij over what reflects or emits: mirrors and glass only pass on what they are sent.
fn matte_sum(ff: &FormFactors, row: &Row) -> [f64; 3] {
    let mut sum = [0.0; 3];
    row.each(|j, f| {
        if !ff.element(j).is_black() {
            (0..3).for_each(|k| sum[k] += f64::from(f.0[k]));
        }
    });
    sum
}

/// In a closed room with glass all that leaves a patch arrives at patches, whatever it passed; rough glass loses what
/// bounces between facets (`furnace.rs`), and nothing gains.
#[test]
fn rows_sum_to_one_through_glass() {
    for (alpha, least) in [(0.0, 0.999), (0.2, 0.95)] {
        let mut stage = cube(0.5);
        let glass = stage.glass(1.5, alpha);
        stage.shape(sphere(0.4), at(0.3, 0.2, -0.3), glass);
        stage.shape(GeometryDesc::Cube, at(-0.4, -0.3, 0.1) * scale(0.3, 0.2, 0.4), glass);
        let scene = stage.build();
        let mesh = meshed(&scene, 300);
        let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 1024, true);
        let rows = ff.rows(|_| Some(())).expect("rows");
        let lit: Vec<usize> = (0..ff.len()).filter(|&i| !ff.element(i).is_black()).collect();
        let (mut all, mut by_glass) = (0.0, 0.0);
        for &i in &lit {
            let sum = matte_sum(&ff, &rows[i])[0];
            assert!(sum < 1.0 + 1e-4, "α {alpha}: a row sums to {sum}");
            all += sum / lit.len() as f64;
            let mirrored = rows[i].mirrored.iter().map(|(_, f)| f64::from(f.0[0]));
            by_glass += mirrored.sum::<f64>() / lit.len() as f64;
        }
        assert!(by_glass > 0.1 && all > least, "α {alpha}: {all} on average, {by_glass} by glass");
    }
}

/// One plane mirror of a room takes 1 - ρ of what it is sent, which are the same rays without it.
#[test]
fn a_mirror_takes_what_it_does_not_reflect() {
    let rho = [0.9f32, 0.6, 0.3];
    let mut stage = cube(0.5);
    let m = mirror(&mut stage, rho);
    let wall = at(-0.99, 0.1, 0.0) * rotate(90.0, Vec3::Y) * scale(0.7, 0.6, 1.0);
    stage.shape(GeometryDesc::Rectangle, wall, m);
    let scene = stage.build();
    let mesh = meshed(&scene, 400);
    let factors = |extended| FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 1024, extended);
    let (with, without) = (factors(true), factors(false));
    let mut met = 0.0;
    // Patches that reach behind it see its back, which takes all.
    let before = |i: &usize| with.element(*i).corners.iter().all(|c| c.x > -0.98);
    for i in (0..with.len()).filter(before) {
        let [row, plain] = [with.row(i), without.row(i)];
        // In the same rays what is not matte is the mirror.
        let sent = f64::from(plain.sum()) - matte_sum(&without, &plain)[0];
        for (sum, rho) in matte_sum(&with, &row).into_iter().zip(rho) {
            close("a row", sum, 1.0 - (1.0 - f64::from(rho)) * sent, 1e-4);
        }
        met += sent;
    }
    assert!(met > 10.0, "{met}");
}
