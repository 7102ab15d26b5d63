//! Surfaces of revolution about the y axis.

use super::grid::grid;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::TriMesh;
use std::f32::consts::TAU;

/// Turns a smooth curve through `profile` about the y axis: points (distance from the axis,
/// height). A curve that rises outside and returns inside makes a vessel; the outside is on the
/// right of the way up. u runs around, v along the profile, in equal steps a point; each span
/// between points has `steps` cells.
pub fn lathe(profile: &[Vec2], around: u32, steps: u32) -> TriMesh {
    let spans = profile.len() as u32 - 1;
    grid(around, spans * steps, |u, v| {
        let (p, d) = catmull_rom(profile, v * spans as f32);
        let (s, c) = (u * TAU).sin_cos();
        let turned = |radial: f32, up: f32| Vec3::new(radial * c, up, -radial * s);
        (turned(p.x.max(0.0), p.y), turned(d.y, -d.x).normalize())
    })
}

/// Point and derivative at `t` in [0, n-1] of the curve through all `points` (Catmull & Rom
/// 1974). Beyond an end it goes on mirrored at the axis where the end is on it, so that the
/// surface is flat there, else straight.
fn catmull_rom(points: &[Vec2], t: f32) -> (Vec2, Vec2) {
    let last = points.len() - 1;
    let i = (t as usize).min(last - 1);
    let beyond = |end: Vec2, next: Vec2| match end.x {
        0.0 => Vec2::new(-next.x, next.y),
        _ => end * 2.0 - next,
    };
    let b = points[i];
    let c = points[i + 1];
    let a = if i == 0 { beyond(b, c) } else { points[i - 1] };
    let d = if i + 1 == last { beyond(c, b) } else { points[i + 2] };
    let t = t - i as f32;
    let (k1, k2, k3) = (c - a, a * 2.0 - b * 5.0 + c * 4.0 - d, b * 3.0 - a - c * 3.0 + d);
    let p = b + (k1 * t + k2 * (t * t) + k3 * (t * t * t)) * 0.5;
    let dp = (k1 + k2 * (2.0 * t) + k3 * (3.0 * t * t)) * 0.5;
    (p, dp)
}

#[cfg(test)]
mod tests {
    use super::super::grid::{defects, volume};
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn a_turned_semicircle_is_a_ball() {
        let points: Vec<Vec2> = (0..=12)
            .map(|i| {
                let (s, c) = (PI * i as f32 / 12.0).sin_cos();
                Vec2::new(if i == 12 { 0.0 } else { s }, -c)
            })
            .collect();
        let mesh = lathe(&points, 96, 4);
        assert_eq!(defects(&mesh), Vec::<String>::new());
        let (got, expected) = (volume(&mesh), 4.0 / 3.0 * PI);
        assert!((got / expected - 1.0).abs() < 0.01, "volume {got}, expected {expected}");
    }
}
