//! Shadow maps (Williams 1978): the scene as a lamp sees it.
//!
//! ```text
//! z_c = ((p - o)·n) / (d_c·n),   in shadow if  z(c) < min(z_c, z_p) - ε                 (1)
//! ```
//!
//! c is the texel that p falls into, d_c the direction through its middle and n the normal of the facet that p
//! lies on: the map's depth is compared with that of the facet's plane *there*, and not with z_p. So no
//! facet shadows itself, however obliquely it is lit, and ε need only cover rounding and the bend between facets.

use super::mesh::Meshes;
use super::raster::{Holes, Raster};
use super::view::View;
use kaustika_math::Vec3;

/// ε of (1): of the depth from a point, or of the scene's radius along parallel light.
const EPSILON: f32 = 1e-3;

/// What a lamp sees.
#[derive(Debug)]
pub struct ShadowMap {
    /// One of parallel light; of a point those around it: -x, +x, -y, +y, -z, +z.
    faces: Vec<Face>,
    center: Vec3,
    /// ε along parallel light.
    epsilon: f32,
}

#[derive(Debug)]
struct Face {
    view: View,
    back: [Vec3; 4],
    size: i32,
    /// Depth, row by row.
    depth: Vec<f32>,
}

impl ShadowMap {
    /// Of a lamp at `p`.
    pub fn of_point(casters: &Meshes, holes: &Holes, p: Vec3, size: u32, radius: f32) -> ShadowMap {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let views = (0..6).filter_map(|k| {
            let axis = k / 2;
            let z = if k % 2 == 0 { -axes[axis] } else { axes[axis] };
            View::face(p, [axes[(axis + 1) % 3], axes[(axis + 2) % 3], z], size, radius)
        });
        let faces = views.map(|view| Face::new(casters, holes, view)).collect();
        ShadowMap { faces, center: p, epsilon: 0.0 }
    }

    /// Of parallel light that comes from `wi`, over a ball.
    pub fn of_direction(
        casters: &Meshes,
        holes: &Holes,
        wi: Vec3,
        (center, radius): (Vec3, f32),
        size: u32,
    ) -> ShadowMap {
        let (x, y) = wi.coordinate_system();
        let view = View::of_ball(center, radius, [x, y, -wi], size);
        let faces = view.into_iter().map(|view| Face::new(casters, holes, view)).collect();
        ShadowMap { faces, center, epsilon: EPSILON * radius }
    }

    /// (1), for a point of a facet with this normal.
    // Out of line, for a fault of LLVM 22.1 (rustc 1.95) on AVX-512: inlined into a loop over lanes, x and y lie in xmm20, and of
    // the sign test of `clamp`, `vpmovd2m %xmm20, %k0; kmovd %k0, %r12d`, becomes `vmovmskps %xmm4, %r12d`, for an instruction
    // that can't name registers above 15 (llvm/llvm-project#191304): x is 0 everywhere. It shows in
    // `light_and_shadows_are_those_of_rays`; `scripts/extended_registers.py` looks for it in programs.
    #[inline(never)]
    pub fn shadows(&self, p: Vec3, n: Vec3) -> bool {
        let face = match self.faces.len() {
            1 => 0,
            _ => {
                let d = p - self.center;
                let away = d.abs();
                let axis = (1..3).fold(0, |most, i| if away[i] > away[most] { i } else { most });
                2 * axis + usize::from([d.x, d.y, d.z][axis] > 0.0)
            }
        };
        self.faces.get(face).is_some_and(|face| face.shadows(p, n, self.epsilon))
    }
}

impl Face {
    fn new(casters: &Meshes, holes: &Holes, view: View) -> Face {
        let mut raster = Raster::default();
        raster.sort(casters, &view);
        // Nothing is kept of the tiles but the buffer itself.
        raster.fill(casters, &view, holes, &mut Vec::new(), || (), |_, _| {});
        let [w, h] = view.size;
        let depth = (0..w * h).map(|i| {
            let kappa = raster.seen(i % w, i / w).map(|(_, kappa)| kappa);
            kappa.map_or(f32::INFINITY, |kappa| view.depth(f64::from(kappa)) as f32)
        });
        Face { depth: depth.collect(), back: view.back(), size: w as i32, view }
    }

    #[inline]
    fn shadows(&self, p: Vec3, n: Vec3, epsilon: f32) -> bool {
        let [u, v, w, k] = self.view.project(p);
        let z_p = self.view.depth(k / w) as f32;
        let texel = |t: f64| ((t / w).round() as i32).clamp(0, self.size - 1);
        let (x, y) = (texel(u), texel(v));
        let [o, a, dx, dy] = self.back;
        let across = dx * x as f32 + dy * y as f32;
        let (o, d, epsilon) = match self.view.perspective {
            true => (o, a + across, EPSILON * z_p),
            false => (o + across, a, epsilon),
        };
        let z_c = (p - o).dot(n) / d.dot(n);
        // The plane may be seen edge-on.
        let z_c = if z_c > z_p - 100.0 * epsilon { z_c.min(z_p) } else { z_p - 100.0 * epsilon };
        self.depth[(y * self.size + x) as usize] < z_c - epsilon // (1)
    }
}
