//! Weights from three numbers that a subpath carries along (Georgiev 2012, "Implementing vertex
//! connection and merging"; lecture card a).
//!
//! ```text
//! m(x) = xᵇ   (b = 1 balance, 2 power),   η = π r² N,   η_m = m(η), η_c = m(1/η)
//! light, x₁:  VCM = m(p_D / (p_E P→₁))    VC = m(g←₀ / (p_E P→₁)), 0 if not hittable   VM = VC η_c     (1)
//! eye, xₖ₋₁:  VCM = m(n p_C / (p_L P←ₖ₋₁))    VC = VM = 0: the lens is not met                     (2)
//! onward from x to y:                                                                            (3)
//!   VC' = m(g_x / P_y) (η_m + VCM + m(p_back) VC)     VM' = m(g_x / P_y) (1 + η_c VCM + m(p_back) VM)
//!   VCM' = m(1 / P_y)
//!   over a Dirac lobe only m(g_x / P_y) m(p_back) VC (and VM) are left, and VCM' = 0
//! ```
//!
//! In media nothing is merged: at their vertices η_m of VC' and the 1 of VM' are 0. η_m is 0 where nothing is merged, η_c where nothing is connected. g_x is what turns a density
//! per solid angle at y into one of x, p_back the density of the way back at x.

use crate::path_space::{CameraEnd, LightEnd, Vertex};
use kaustika_scene::{LightSelection, Scene};

/// The three numbers at one vertex.
#[derive(Clone, Copy, Debug, Default)]
pub struct Carried {
    /// Of the last connection or merge.
    pub vcm: f32,
    /// Of the connections before.
    pub vc: f32,
    /// Of the merges before.
    pub vm: f32,
}

/// What the weights of one pass depend on.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// True: power heuristic; false: balance.
    pub power: bool,
    /// m(η), or 0.
    pub eta_m: f32,
    /// m(1/η), or 0.
    pub eta_c: f32,
    /// Light paths for each camera path of the picture, n.
    pub light_paths: f64,
}

impl Weights {
    /// Of a pass with merges within `radius` of `count` light paths.
    pub fn new(
        power: bool,
        radius: f32,
        count: f64,
        light_paths: f64,
        connects: bool,
        merges: bool,
    ) -> Weights {
        let mut weights = Weights { power, eta_m: 0.0, eta_c: 0.0, light_paths };
        let eta = std::f64::consts::PI * f64::from(radius).powi(2) * count;
        if merges {
            weights.eta_m = weights.m(eta);
        }
        if connects && merges {
            weights.eta_c = weights.m(1.0 / eta);
        }
        weights
    }

    /// m(x).
    #[inline]
    pub fn m(&self, x: f64) -> f32 {
        (if self.power { x * x } else { x }) as f32
    }

    /// (1) and (3) along a light path.
    pub fn of_light(
        &self,
        scene: &Scene,
        lights: &LightSelection,
        end: &LightEnd,
        path: &[Vertex],
        carried: &mut Vec<Carried>,
    ) {
        carried.clear();
        let Some(first) = path.first() else { return };
        let made = end.emission * first.arrival;
        let next_event = end.next_event(scene, lights, first);
        let vc = match end.hittable {
            true => self.m(end.area(first.surface.p) * first.passing / made),
            false => 0.0,
        };
        carried.push(Carried { vcm: self.m(next_event / made), vc, vm: vc * self.eta_c });
        self.onward(path, carried);
    }

    /// (2) and (3) along an eye path.
    pub fn of_eye(&self, camera: &CameraEnd, path: &[Vertex], carried: &mut Vec<Carried>) {
        carried.clear();
        let Some(first) = path.first() else { return };
        let vcm = match camera.seen {
            true => self.m(self.light_paths * camera.connection / (camera.lens * first.arrival)),
            false => 0.0,
        };
        carried.push(Carried { vcm, vc: 0.0, vm: 0.0 });
        self.onward(path, carried);
    }

    /// (3)
    fn onward(&self, path: &[Vertex], carried: &mut Vec<Carried>) {
        for pair in path.windows(2) {
            let [x, y] = pair else { continue };
            let Some(&c) = carried.last() else { return };
            let g = x.arriving_from(y.surface.p) * y.passing;
            let (eta_m, merges) = self.merging_at(x);
            let (k, back) = (self.m(g / y.arrival), self.m(x.pdf_rev));
            carried.push(match x.delta {
                true => Carried { vcm: 0.0, vc: k * back * c.vc, vm: k * back * c.vm },
                false => Carried {
                    vcm: self.m(1.0 / y.arrival),
                    vc: k * (eta_m + c.vcm + back * c.vc),
                    vm: k * (merges + self.eta_c * c.vcm + back * c.vm),
                },
            });
        }
    }

    /// η_m, and 1, at a vertex where paths merge; nothing in media, where they don't.
    #[inline]
    fn merging_at(&self, v: &Vertex) -> (f32, f32) {
        if v.inside.is_some() { (0.0, 0.0) } else { (self.eta_m, 1.0) }
    }

    /// η_m at a vertex.
    #[inline]
    pub fn eta_m_at(&self, v: &Vertex) -> f32 {
        self.merging_at(v).0
    }

    /// What the other ways on one side of a connection at `v` amount to: `density` is that of the
    /// vertex as the other side makes it, `back` the density of the way on along its own side.
    #[inline]
    pub fn side(&self, v: &Vertex, c: &Carried, density: f64, back: f64) -> f32 {
        self.m(density) * (self.merging_at(v).0 + c.vcm + self.m(back) * c.vc)
    }

    /// The same at a merge; `on` is the density of the way on as the other side makes it.
    #[inline]
    pub fn merged_side(&self, c: &Carried, on: f64) -> f32 {
        c.vcm * self.eta_c + c.vm * self.m(on)
    }
}
