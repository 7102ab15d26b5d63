//! The scene's lights as classical pictures have them: lamps without extent, and ambient light.
//!
//! ```text
//! surface of power Φ that faces one way:   I(θ) = (Φ/π) cos θ, from its middle           (1)
//! closed surface:                          I = Φ/4π                                    (2)
//! environment:                             I_a as much as arrives ([`ambient`])          (3)
//! reflected:  L = k_d (I_a + Σ E cos θ / π) + k_s (I_a + Σ E cos θ r)                        (4)
//! Phong:      r = (n + 2)/2π (r·v)ⁿ                                                       (5)
//! Blinn:      r = D G / (4 cos θ n·v),  D = (m + 2)/2π (n·h)ᵐ,
//!             G = min(1, 2 n·h n·v / v·h, 2 n·h cos θ / v·h)                              (6)
//! ```
//!
//! (5) is Phong's (1975) lobe in the normalised form that loses energy and never gains it (Lafortune & Willems 1994), (6)
//! Blinn's (1977) with Torrance and Sparrow's shadowing and without Fresnel's factor. E is what arrives from a lamp, if no
//! shadow map says otherwise. A headlight lights what faces the eye.

use super::ambient::ambient;
use super::looks::Look;
use super::mesh::Meshes;
use super::params::{Model, ZBufferParams};
use super::raster::Holes;
use super::shadow::ShadowMap;
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s, mask_of};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::{AreaShape, Light, LightId, Scene};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// What lights a scene.
#[derive(Debug)]
pub struct Lamps {
    lamps: Vec<Lamp>,
    ambient: [f32; 3],
    headlight: f32,
}

#[derive(Debug)]
struct Lamp {
    kind: Kind,
    shadow: Option<ShadowMap>,
    /// Luminous power, to find the strongest.
    power: f32,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Point {
        p: Vec3,
        intensity: [f32; 3],
    },
    /// (1); on both sides if so.
    Cosine {
        p: Vec3,
        axis: Vec3,
        intensity: [f32; 3],
        both: bool,
    },
    /// From a direction.
    Parallel {
        wi: Vec3,
        irradiance: [f32; 3],
    },
    /// As the scene's light itself says.
    Other {
        id: LightId,
        p: Vec3,
    },
}

/// Sixteen points of surfaces.
pub struct Points {
    /// Where.
    pub p: Vec3s,
    /// Shading normals on the eye's side, unit.
    pub n: Vec3s,
    /// Normals of the facets on the eye's side, unit.
    pub facet: Vec3s,
    /// Directions to the eye, unit.
    pub v: Vec3s,
    /// n of (5).
    pub exponent: Lanes,
    /// The points that count, a bit each.
    pub live: u32,
}

/// The factors of k_d and k_s in (4).
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// Of k_d.
    pub diffuse: [Lanes; 3],
    /// Of k_s.
    pub specular: [Lanes; 3],
}

fn rgb(s: Spectrum) -> [f32; 3] {
    Sensor::default().rgb(s, &Wavelengths::rgb())
}

/// An emitting shape: power, and the middle and normal weighted by it.
#[derive(Default)]
struct Emitter {
    power: Spectrum,
    weight: f32,
    p: Vec3,
    n: Vec3,
    both: bool,
}

impl Lamps {
    /// Of a scene. `casters` throw shadows.
    pub fn new(
        scene: &Scene,
        params: &ZBufferParams,
        looks: &[Look],
        casters: &Meshes,
        holes: &Holes,
    ) -> Lamps {
        let mut lamps = of_points(scene);
        lamps.extend(of_surfaces(scene));
        // The strongest; of equals the first.
        lamps.sort_by(|a, b| b.power.total_cmp(&a.power));
        lamps.truncate(params.lamps as usize);
        if params.shadows {
            for lamp in &mut lamps {
                let (size, radius) = (params.shadow_map, scene.radius);
                lamp.shadow = Some(match lamp.kind {
                    Kind::Point { p, .. } | Kind::Cosine { p, .. } | Kind::Other { p, .. } => {
                        ShadowMap::of_point(casters, holes, p, size, radius)
                    }
                    Kind::Parallel { wi, .. } => {
                        let ball = (scene.center, radius);
                        ShadowMap::of_direction(casters, holes, wi, ball, size)
                    }
                });
            }
        }
        let given = params.ambient >= 0.0;
        let mut ambient = match given {
            true => [params.ambient; 3],
            false => ambient(scene, looks), // (3)
        };
        let mean = (ambient[0] + ambient[1] + ambient[2]) / 3.0;
        let headlight = match (lamps.is_empty(), mean > 0.0) {
            _ if params.headlight >= 0.0 => params.headlight,
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) if given => mean,
            (true, true) => {
                // Half of the light comes from the eye, to show shapes: 2/3 of it on what is seen of a ball.
                ambient = ambient.map(|a| 0.5 * a);
                0.75 * mean
            }
        };
        Lamps { lamps, ambient, headlight }
    }

    /// (4) at sixteen points.
    #[inline]
    pub fn light(&self, scene: &Scene, at: &Points, model: Model, highlights: bool) -> Lit {
        let zero = Lanes::splat(0.0);
        let facing = at.n.dot(at.v).fast_max(zero) * Lanes::splat(self.headlight);
        let base = self.ambient.map(|a| facing + Lanes::splat(a));
        let mut lit = Lit { diffuse: base, specular: base };
        for lamp in &self.lamps {
            let (l, e) = lamp.arriving(scene, at);
            let cos = at.n.dot(l);
            let mut mask = cos.simd_gt(zero) & at.facet.dot(l).simd_gt(zero);
            let bits = mask.to_bitmask() & at.live;
            if bits == 0 {
                continue;
            }
            if let Some(map) = &lamp.shadow {
                mask = mask_of(bits & !shadowed(map, at, bits));
            }
            let e = e.map(|e| mask.select(e * cos, zero));
            for k in 0..3 {
                lit.diffuse[k] = e[k].mul_add(Lanes::splat(1.0 / PI), lit.diffuse[k]);
            }
            if highlights {
                let r = match model {
                    Model::Blinn => blinn(at, l, cos),
                    _ => phong(at, l, cos),
                };
                for k in 0..3 {
                    lit.specular[k] =
                        mask.select(e[k].mul_add(r, lit.specular[k]), lit.specular[k]);
                }
            }
        }
        lit
    }
}

/// Which of the points are in shadow, a bit each.
fn shadowed(map: &ShadowMap, at: &Points, bits: u32) -> u32 {
    let (p, n) = (at.p.to_rows(), at.facet.to_rows());
    let vec = |rows: &[Row; 3], i: usize| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
    let lanes = (0..LANES).filter(|i| bits >> i & 1 != 0);
    lanes.filter(|&i| map.shadows(vec(&p, i), vec(&n, i))).fold(0, |all, i| all | 1 << i)
}

/// xⁿ for x ≥ 0.
fn power(x: Lanes, n: Lanes) -> Lanes {
    (x.fast_max(Lanes::splat(1e-30)).ln() * n).exp()
}

/// (5).
fn phong(at: &Points, l: Vec3s, cos: Lanes) -> Lanes {
    let two = Lanes::splat(2.0);
    let along = (two * cos).mul_add(at.n.dot(at.v), -l.dot(at.v));
    (at.exponent + two) * Lanes::splat(0.5 / PI) * power(along, at.exponent)
}

/// (6).
fn blinn(at: &Points, l: Vec3s, cos: Lanes) -> Lanes {
    let (one, two, tiny) = (Lanes::splat(1.0), Lanes::splat(2.0), Lanes::splat(1e-6));
    let h = (l + at.v).normalize();
    let (nh, vh) = (at.n.dot(h), at.v.dot(h).fast_max(tiny));
    let nv = at.n.dot(at.v).fast_max(tiny);
    let m = at.exponent * Lanes::splat(4.0);
    let d = (m + two) * Lanes::splat(0.5 / PI) * power(nh, m);
    let g = one.fast_min(two * nh * nv / vh).fast_min(two * nh * cos / vh);
    d * g / (Lanes::splat(4.0) * nv * cos.fast_max(tiny))
}

impl Lamp {
    /// Unit directions to it, and irradiance across them.
    #[inline]
    fn arriving(&self, scene: &Scene, at: &Points) -> (Vec3s, [Lanes; 3]) {
        let splat = |v: Vec3| Vec3s::load(&[[v.x; LANES], [v.y; LANES], [v.z; LANES]]);
        let (zero, one) = (Lanes::splat(0.0), Lanes::splat(1.0));
        let toward = |p: Vec3| {
            let d = splat(p) - at.p;
            let inv2 = one / d.dot(d);
            (d * inv2.sqrt(), inv2)
        };
        match self.kind {
            Kind::Point { p, intensity } => {
                let (l, inv2) = toward(p);
                (l, intensity.map(|i| Lanes::splat(i) * inv2))
            }
            Kind::Cosine { p, axis, intensity, both } => {
                let (l, inv2) = toward(p);
                let cos = -splat(axis).dot(l);
                let cos = if both { cos.abs() } else { cos.fast_max(zero) };
                (l, intensity.map(|i| Lanes::splat(i) * inv2 * cos)) // (1)
            }
            Kind::Parallel { wi, irradiance } => (splat(wi), irradiance.map(Lanes::splat)),
            Kind::Other { id, .. } => {
                let p = at.p.to_rows();
                let (mut l, mut e) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
                for i in (0..LANES).filter(|i| at.live >> i & 1 != 0) {
                    let from = Vec3::new(p[0][i], p[1][i], p[2][i]);
                    let sample =
                        scene.light(id).sample_li(scene, from, Vec2::ZERO, &Wavelengths::rgb());
                    let Some(sample) = sample else { continue };
                    let light = rgb(sample.le);
                    for k in 0..3 {
                        (l[k][i], e[k][i]) = (sample.wi[k], light[k]);
                    }
                }
                (Vec3s::load(&l), e.map(Lanes::new))
            }
        }
    }
}

/// The lights without extent.
fn of_points(scene: &Scene) -> Vec<Lamp> {
    let lambda = Wavelengths::rgb();
    let kind = |(i, light): (usize, &Light)| {
        let id = LightId(i as u32);
        let kind = match light {
            Light::Point(l) => {
                Kind::Point { p: l.p, intensity: rgb(l.intensity.eval(&lambda) * l.scale) }
            }
            Light::Directional(l) => Kind::Parallel {
                wi: -l.direction,
                irradiance: rgb(l.irradiance.eval(&lambda) * l.scale),
            },
            Light::Spot(_) | Light::Goniometric(_) | Light::Projection(_) | Light::Projector(_) => {
                // From anywhere that it lights it says where it is.
                let ray =
                    light.sample_le(scene, Vec2::new(0.5, 0.5), Vec2::new(0.5, 0.5), &lambda)?;
                Kind::Other { id, p: ray.ray.o }
            }
            _ => return None,
        };
        Some(Lamp { kind, shadow: None, power: light.power(scene, &lambda).luminance(&lambda) })
    };
    scene.lights.iter().enumerate().filter_map(kind).collect()
}

/// (1) and (2): a lamp for each shape that emits.
fn of_surfaces(scene: &Scene) -> impl Iterator<Item = Lamp> {
    let lambda = Wavelengths::rgb();
    let mut emitters: BTreeMap<u32, Emitter> = BTreeMap::new();
    for light in &scene.lights {
        let Light::Area(area) = light else { continue };
        let shape = match area.shape {
            AreaShape::Triangle(i, _) => scene.geometry.triangles.mesh(i).shape,
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                scene.geometry.quadrics[i as usize].shape
            }
        };
        let power = light.power(scene, &lambda);
        let weight = power.luminance(&lambda);
        let emitter = emitters.entry(shape).or_default();
        emitter.both = area.two_sided;
        emitter.power += power;
        emitter.weight += weight;
        const N: u32 = 8;
        for k in 0..N * N {
            let u = Vec2::new((k % N) as f32 + 0.5, (k / N) as f32 + 0.5) / N as f32;
            if let Some(ray) = light.sample_le(scene, u, Vec2::new(0.1, 0.1), &lambda) {
                emitter.p += ray.ray.o * (weight / (N * N) as f32);
                emitter.n += ray.n * (weight / (N * N) as f32);
            }
        }
    }
    emitters.into_values().filter(|e| e.weight > 0.0).map(|e| {
        let (p, n) = (e.p / e.weight, e.n / e.weight);
        let flux = rgb(e.power);
        let kind = match n.try_normalize().filter(|_| n.length() > 0.5) {
            Some(axis) => {
                let sides = if e.both { 2.0 } else { 1.0 };
                Kind::Cosine { p, axis, intensity: flux.map(|f| f / (PI * sides)), both: e.both }
            }
            None => Kind::Point { p, intensity: flux.map(|f| f / (4.0 * PI)) },
        };
        Lamp { kind, shadow: None, power: e.weight }
    })
}
