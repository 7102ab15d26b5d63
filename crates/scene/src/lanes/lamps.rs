//! Scenes lit by a few flat triangles of constant radiance: a point of a lamp for each of sixteen
//! paths, the twin of [`LightSelection::sample`] and [`Light::sample_li`].

use crate::Scene;
use crate::light::{AreaLight, AreaShape, FEW_LIGHTS, Light};
use crate::shape::TriangleStore;
use arrayvec::ArrayVec;
use kaustika_math::lanes::{LANES, Lanes, Vec3s, is_finite, offset_by, triangle};
use kaustika_math::ray::triangle_point_error;
use kaustika_math::{Vec3, gamma};
use kaustika_sampling::distribution::Discrete;
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// All lights of a scene, if they are a few flat triangles of constant radiance, whole, and the colours are RGB.
#[derive(Clone, Debug)]
pub struct Lamps {
    lamps: ArrayVec<Lamp, FEW_LIGHTS>,
    /// Which of them.
    choice: Discrete,
}

#[derive(Clone, Copy, Debug)]
struct Lamp {
    corners: [Vec3; 3],
    n: Vec3,
    /// How far along the normal the rounding errors of its points reach, at most.
    reach: f32,
    /// Probability of the choice times density per area.
    pdf_a: f32,
    le: Spectrum,
    two_sided: bool,
}

/// A point of a lamp for each path.
#[derive(Clone, Copy, Debug)]
pub struct LampSamples {
    /// Unit directions to the points.
    pub wi: Vec3s,
    /// The points, off the lamp on the paths' side.
    pub target: Vec3s,
    /// Densities of the directions per solid angle, times the probability of the lamp; 0 where
    /// there is no sample.
    pub pdf_w: Lanes,
    /// Radiance that arrives if nothing is in the way, linear RGB and 0.
    pub le: [Lanes; 4],
}

impl Lamps {
    pub(crate) fn of(scene: &Scene) -> Option<Lamps> {
        let choice = scene.light_selection.of_few()?.clone();
        if scene.mode != ColorMode::Rgb {
            return None;
        }
        let lamp = |(i, light): (usize, &Light)| match light {
            Light::Area(l) => Lamp::of(l, scene, choice.pmf(i)),
            _ => None,
        };
        let lamps = scene.lights.iter().enumerate().map(lamp).collect::<Option<_>>()?;
        Some(Lamps { lamps, choice })
    }

    /// A point of a lamp for each of the points `p`, from uniform numbers.
    #[inline(always)]
    pub fn sample(&self, p: Vec3s, u: [Lanes; 2]) -> LampSamples {
        let [mut ux, uy] = u;
        let mut which = [0u32; LANES];
        if self.lamps.len() > 1 {
            let mut rest = ux.to_array();
            for (u, which) in rest.iter_mut().zip(&mut which) {
                let s = self.choice.sample(*u);
                (*u, *which) = (s.u, s.index as u32);
            }
            ux = Lanes::new(rest);
        }
        let which = Lanes::new(which.map(|i| i as f32));
        let b = triangle([ux, uy]);
        let [c0, c1, c2] = [0, 1, 2].map(|k| self.pick_vec(which, |l| l.corners[k]));
        let q = (c0 * b[0]).plus(c1, b[1]).plus(c2, b[2]);
        let n = self.pick_vec(which, |l| l.n);

        let zero = Lanes::splat(0.0);
        let to_lamp = q - p;
        let d2 = to_lamp.dot(to_lamp);
        let wi = to_lamp * (Lanes::splat(1.0) / d2.sqrt());
        let cos = n.dot(wi);
        let shines = cos.simd_lt(zero)
            | self.pick(which, |l| if l.two_sided { 1.0 } else { 0.0 }).simd_gt(zero);
        // p_ω = p_A d² / |cos|.
        let pdf_w = self.pick(which, |l| l.pdf_a) * d2 / cos.abs();
        let sound = shines & is_finite(pdf_w) & d2.simd_gt(zero);
        LampSamples {
            wi,
            target: shadow_end(p, q, self.pick(which, |l| l.reach), n),
            pdf_w: sound.select(pdf_w, zero),
            le: [0, 1, 2, 3].map(|k| self.pick(which, |l| l.le.0[k])),
        }
    }

    /// A number of each path's lamp.
    #[inline(always)]
    fn pick(&self, which: Lanes, of: impl Fn(&Lamp) -> f32) -> Lanes {
        let first = Lanes::splat(of(&self.lamps[0]));
        self.lamps[1..].iter().zip(1u8..).fold(first, |value, (lamp, i)| {
            let mine = which.simd_eq(Lanes::splat(f32::from(i)));
            mine.select(Lanes::splat(of(lamp)), value)
        })
    }

    #[inline(always)]
    fn pick_vec(&self, which: Lanes, of: impl Fn(&Lamp) -> Vec3) -> Vec3s {
        Vec3s {
            x: self.pick(which, |l| of(l).x),
            y: self.pick(which, |l| of(l).y),
            z: self.pick(which, |l| of(l).z),
        }
    }
}

/// Where rays from `from` to points `p` of lights end: the twin of [`Scene::shadow_ray`]'s end.
/// `reach` says how far along the lights' normals `n` the rounding errors of the points reach.
#[inline(always)]
pub fn shadow_end(from: Vec3s, p: Vec3s, reach: Lanes, n: Vec3s) -> Vec3s {
    let back = from - p;
    let (length, size) = (back.abs(), n.abs());
    let length = length.x.fast_max(length.y).fast_max(length.z);
    let along = (size.x + size.y + size.z) * Lanes::splat(gamma(8));
    offset_by(p, length.mul_add(along, reach), n, back)
}

impl Lamp {
    fn of(light: &AreaLight, scene: &Scene, pmf: f32) -> Option<Lamp> {
        let AreaShape::Triangle(i, area) = light.shape else { return None };
        if light.alpha.is_some() || light.unseen {
            return None;
        }
        let store = &scene.geometry.triangles;
        let le = scene.textures.uniform(light.radiance, &Wavelengths::rgb())? * light.scale;
        let corners = store.corners(i);
        let n = constant_normal(store, i)?;
        // Largest at a corner: the bound is convex in the weights.
        let error = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|b| triangle_point_error(corners, b));
        let error = error[0].max(error[1]).max(error[2]);
        let (reach, pdf_a) = (n.abs().dot(error), pmf / area);
        Some(Lamp { corners, n, reach, pdf_a, le, two_sided: light.two_sided })
    }
}

/// The geometric normal, if it is on the same side at all points.
fn constant_normal(store: &TriangleStore, triangle: u32) -> Option<Vec3> {
    let at = |b: [f32; 3]| store.surface(triangle, b, 0.0, 0.0).ng;
    let n = at([1.0, 0.0, 0.0]);
    (n == at([0.0, 1.0, 0.0]) && n == at([0.0, 0.0, 1.0])).then_some(n)
}
