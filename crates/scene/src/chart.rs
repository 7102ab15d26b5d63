//! Maps of surfaces: every triangle and every quadric has a chart of its own, of which equal
//! areas are equal areas of the surface. What is kept by place, such as light that arrived, needs
//! no uv for it, which meshes may lack, repeat or overlap.

use crate::geometry::Geometry;
use crate::surface::Surface;
use kaustika_math::{Transform, Vec2, Vec3};

/// Where a point lies on the chart of its triangle or quadric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
    /// Coordinates: of a triangle the barycentric weights of its corners 1 and 2, of a quadric in
    /// [0, 1]², the azimuth first.
    pub at: Vec2,
    /// True for triangles: the chart is the half of the unit square where x + y ≤ 1.
    pub triangle: bool,
    /// World area over the share of the chart, at this place.
    pub area: f32,
    /// The same somewhere in the middle of all places: the same number for all of them.
    pub size: f32,
    /// How wide the chart is along its first coordinate over how wide it is along the second.
    pub aspect: f32,
}

impl Geometry {
    /// Where a surface lies on its chart; `None` for curves, which have none.
    pub fn chart(&self, s: &Surface) -> Option<ChartPoint> {
        let to_world = s.instance.map(|i| self.instances[i as usize].at(s.time));
        if s.triangle != u32::MAX {
            let [a, b, c] = self.triangles.corners(s.triangle);
            let place = |e: Vec3| to_world.map_or(e, |t| t.vector(e));
            let area = 0.5 * place(b - a).cross(place(c - a)).length();
            return Some(ChartPoint {
                at: s.barycentrics,
                triangle: true,
                area,
                size: area,
                aspect: 1.0,
            });
        }
        let quadric = self.quadrics.get(s.analytic as usize)?;
        let p = to_world.map_or(s.p, |t| t.inverse().point(s.p));
        let (at, aspect) = quadric.chart_at(p);
        let stretch = to_world.map_or(1.0, |t| {
            let (x, y) = t.inverse().normal(s.ng).normalize().coordinate_system();
            t.vector(x).cross(t.vector(y)).length()
        });
        let size = quadric.own_area()
            * mean_stretch(&quadric.to_world)
            * to_world.map_or(1.0, |t| mean_stretch(&t));
        let area = stretch / quadric.pdf_a_at(p);
        Some(ChartPoint { at, triangle: false, area, size, aspect })
    }
}

/// What a transform does to areas, over all directions.
fn mean_stretch(t: &Transform) -> f32 {
    t.vector(Vec3::X).cross(t.vector(Vec3::Y)).dot(t.vector(Vec3::Z)).abs().powf(2.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Quadric, QuadricForm};

    #[test]
    fn equal_areas_of_quadrics_are_equal_on_their_charts() {
        // Points that are uniform over the area are uniform over the chart.
        const N: usize = 64;
        for form in [
            QuadricForm::Sphere { radius: 1.5, z_min: -1.0, z_max: 1.5 },
            QuadricForm::Cylinder { radius: 1.0, z_min: -2.0, z_max: 1.0 },
            QuadricForm::Disk { height: 0.3, radius: 2.0, inner: 0.5 },
            QuadricForm::Disk { height: 0.3, radius: 2.0, inner: 0.0 },
        ] {
            let to_world = Transform::translate(Vec3::new(3.0, 1.0, 2.0));
            let phi_max = 2.0 * std::f32::consts::PI;
            let quadric = Quadric {
                form,
                phi_max,
                to_world,
                flip: false,
                shape: 0,
                light: None,
                from_outside: false,
            };
            let mut cells = [0; 16];
            for i in 0..N * N {
                let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                let (at, _) = quadric.chart_at(quadric.sample(u).0.p);
                let cell = |x: f32| ((4.0 * x) as usize).min(3);
                cells[4 * cell(at.y) + cell(at.x)] += 1;
            }
            // A cell has 256 of the points, give or take those on its edge.
            let expected = (N * N / 16) as i32;
            assert!(cells.iter().all(|&n: &i32| (n - expected).abs() < 40), "{form:?} {cells:?}");
        }
    }
}
