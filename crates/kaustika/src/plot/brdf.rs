//! A material's BSDF in the plane of incidence, by component.
//!
//! ```text
//! f = f_D + f_S + f_M,   f_M Dirac                                                       (1)
//! ωᵢ = (-sin θᵢ, 0, cos θᵢ),   ωₒ = (sin θ, 0, cos θ),   -180° < θ ≤ 180°                     (2)
//! ```
//!
//! θ = θᵢ is the mirror direction, θ = -θᵢ goes back to the light, |θ| > 90° is behind the surface. f is
//! per steradian, without the cosine. Of f_M the reflectance or transmittance of each direction is
//! told: a part of the power.

use kaustika_math::{Ray, Transform, Vec2, Vec3};
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::{
    CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, GeometryDesc, MaterialId,
    SceneDescription, ShapeDesc, known_names,
};
use kaustika_scene::{BuildError, Scene, SceneOptions, Surface};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// A material on a square that light falls on.
pub struct Probe {
    scene: Scene,
    /// Places around the middle.
    surfaces: Vec<Surface>,
}

/// Places, over whose mean coats are known that are walks by chance.
const PLACES: u32 = 128;
/// How far they lie from the middle of a square of side 2.
const AROUND: f32 = 1e-3;

/// The BSDF for light from one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// θᵢ, degrees from the normal.
    pub incidence: f32,
    /// θ of each value, degrees, rising.
    pub angles: Vec<f32>,
    /// f_D, linear RGB, 1/sr.
    pub diffuse: Vec<[f32; 3]>,
    /// f_S.
    pub glossy: Vec<[f32; 3]>,
    /// f_M: θ, and the part of the power, linear RGB.
    pub singular: Vec<(f32, [f32; 3])>,
}

/// The material of this name, or with this number after `#`.
///
/// # Errors
/// If there is none; the message says which there are.
pub fn find(description: &SceneDescription, wanted: &str) -> Result<MaterialId, String> {
    let materials = &description.materials;
    let by_number = || wanted.strip_prefix('#')?.parse().ok().filter(|n| *n < materials.len());
    let found = materials.iter().position(|m| m.name == wanted).or_else(by_number);
    found.map(|i| MaterialId(i as u32)).ok_or_else(|| {
        let named = materials.iter().map(|m| m.name.as_str()).filter(|n| !n.is_empty());
        let names: Vec<&str> = named.collect();
        let advice = if names.is_empty() {
            format!("materials here have no names: say #0 to #{}", materials.len().max(1) - 1)
        } else {
            known_names(wanted, &names)
        };
        format!("no material `{wanted}`; {advice}")
    })
}

impl Probe {
    /// For one material of a description.
    ///
    /// # Errors
    /// If the material can't be built.
    pub fn new(description: &SceneDescription, material: MaterialId) -> Result<Probe, BuildError> {
        let mut d = description.clone();
        d.cameras = vec![camera()];
        (d.groups, d.instances, d.lights) = (Vec::new(), Vec::new(), Vec::new());
        d.shapes = vec![ShapeDesc {
            name: String::new(),
            geometry: GeometryDesc::Rectangle,
            transform: Transform::IDENTITY,
            flip_normals: false,
            material,
            emission: None,
            alpha: None,
            interior: None,
            exterior: None,
            span: None,
        }];
        let mode = ColorMode::Rgb;
        let options = SceneOptions { mode, camera: 0, resolution: None, light_selection: None };
        let scene = Scene::build(&d, &options)?;
        let surface = |i: u32| {
            // Evenly over a disk (Vogel 1979).
            let (r, turn) = ((i as f32 / PLACES as f32).sqrt() * AROUND, i as f32 * 2.399_963);
            let o = Vec3::new(r * turn.cos(), r * turn.sin(), 1.0);
            scene.intersect(&Ray::new(o, -Vec3::Z), f32::INFINITY)
        };
        let surfaces: Vec<Surface> = (0..PLACES).filter_map(surface).collect();
        if surfaces.is_empty() {
            let message = "the material lets everything pass".into();
            return Err(BuildError { message, span: None });
        }
        Ok(Probe { scene, surfaces })
    }

    /// (1) for light at `incidence` degrees, every `step` degrees.
    pub fn lobe(&self, incidence: f32, step: f32) -> Lobe {
        let half = (180.0 / step).floor() as i32;
        let angles: Vec<f32> = (1 - half..=half).map(|k| k as f32 * step).collect();
        let wi = along(-incidence);
        let value = |&angle: &f32, lobes| self.value(wi, along(angle), lobes);
        let of = |lobes| angles.iter().map(|a| value(a, lobes)).collect();
        Lobe {
            incidence,
            diffuse: of(Lobes::DIFFUSE),
            glossy: of(Lobes::GLOSSY),
            singular: self.singular(wi),
            angles,
        }
    }

    /// f of these lobes, linear RGB, 1/sr.
    pub fn value(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> [f32; 3] {
        let cos = wi.z.abs();
        if cos == 0.0 {
            return [0.0; 3];
        }
        let sum = self.surfaces.iter().fold(Spectrum::ZERO, |sum, s| {
            let bsdf = self.scene.bsdf(s, wo, &mut Wavelengths::rgb());
            sum + bsdf.map_or(Spectrum::ZERO, |f| f.eval(wo, wi, Mode::Radiance, lobes))
        });
        (sum / (cos * self.surfaces.len() as f32)).rgb()
    }

    /// f_M of light from `wi`.
    fn singular(&self, wi: Vec3) -> Vec<(f32, [f32; 3])> {
        let mut found = Vec::new();
        let Some(bsdf) = self.scene.bsdf(&self.surfaces[0], wi, &mut Wavelengths::rgb()) else {
            return vec![(wi.x.atan2(wi.z).to_degrees() + 180.0, [1.0; 3])];
        };
        let numbers = (0.5, Vec2::splat(0.5));
        bsdf.sample_each(wi, numbers, Mode::Importance, Lobes::DELTA, |s| {
            let angle = s.wi.x.atan2(s.wi.z).to_degrees();
            found.push((angle, s.weight.rgb()));
        });
        found
    }
}

/// (2).
fn along(degrees: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(sin, 0.0, cos)
}

/// A scene has one; nobody looks through it.
fn camera() -> CameraDesc {
    let film = FilmDesc::new([1, 1], FilterChoice::Box { radius: [0.5; 2] });
    CameraDesc::new(CameraKind::pinhole(45.0, FovAxis::X), Transform::IDENTITY, film)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_formats::pbrt::read_pbrt_str;
    use kaustika_math::Frame;
    use kaustika_scene::bsdf::{Bsdf, Model, Part, Phong};
    use kaustika_scene::description::MaterialModel;
    use std::f32::consts::PI;
    use std::path::Path;

    fn pbrt(material: &str) -> Probe {
        let text = format!("WorldBegin\nMaterial {material}\nShape \"disk\"\n");
        let d = read_pbrt_str(&text, Path::new("a material"));
        assert!(d.diagnostics.entries.is_empty(), "{:?}", d.diagnostics.entries);
        Probe::new(&d, d.shapes[0].material).expect("a sound material")
    }

    fn close(what: &str, a: f32, b: f32) {
        assert!((a - b).abs() <= 1e-4 * b.abs() + 1e-6, "{what}: {a}, expected {b}");
    }

    /// ρ/π over the whole half circle, nothing behind it.
    #[test]
    fn lambert_is_a_half_circle() {
        let lobe = pbrt("\"diffuse\" \"rgb reflectance\" [ .2 .5 .8 ]").lobe(35.0, 5.0);
        assert_eq!((lobe.angles.len(), lobe.angles[71]), (72, 180.0));
        for (angle, f) in lobe.angles.iter().zip(&lobe.diffuse) {
            let lit = angle.abs() < 89.9;
            for (f, rho) in f.iter().zip([0.2, 0.5, 0.8]) {
                if (angle.abs() - 90.0).abs() > 0.1 {
                    close(&format!("{angle}"), *f, if lit { rho / PI } else { 0.0 });
                }
            }
        }
        assert!(lobe.glossy.iter().all(|f| *f == [0.0; 3]) && lobe.singular.is_empty());
    }

    /// Phong's lobe (Lafortune & Willems 1994) in its closed form, and as [`Bsdf::eval`] has it: each
    /// component by itself, its top in the mirror direction, half of it arccos(2^(-1/n)) away.
    #[test]
    fn phong_is_its_formula() {
        let (rho_d, rho_s, n) = (0.3, 0.5, 20.0);
        let mut d = SceneDescription::default();
        let [diffuse_reflectance, specular_reflectance, exponent] =
            [rho_d, rho_s, n].map(|v| d.float(v));
        let model = MaterialModel::Phong { diffuse_reflectance, specular_reflectance, exponent };
        let material = d.add_material("paint", model, None);
        assert_eq!(find(&d, "paint"), Ok(material));
        assert_eq!(find(&d, "#0"), Ok(material));
        let error = find(&d, "point").expect_err("none of this name");
        assert_eq!(error, "no material `point`; did you mean `paint`?");
        let probe = Probe::new(&d, material).expect("sound");
        let (diffuse, specular) = (Spectrum::splat(rho_d), Spectrum::splat(rho_s));
        let mut bsdf = Bsdf::default();
        bsdf.reset(Vec3::Z);
        bsdf.push(Part {
            frame: Frame::from_normal(Vec3::Z),
            guard: None,
            relief: 0.0,
            weight: 1.0,
            model: Model::Phong(Phong { diffuse, specular, exponent: n }),
        });
        for incidence in [0.0, 35.0, 55.0] {
            let lobe = probe.lobe(incidence, 1.0);
            let wi = along(-incidence);
            for (k, angle) in lobe.angles.iter().enumerate().filter(|(_, a)| a.abs() < 89.5) {
                let what = format!("{incidence} {angle}");
                let alpha = (angle - incidence).to_radians();
                let s = rho_s * (n + 2.0) / (2.0 * PI) * alpha.cos().max(0.0).powf(n);
                close(&what, lobe.glossy[k][1], s);
                close(&what, lobe.diffuse[k][1], rho_d / PI);
                let all = bsdf.eval(along(*angle), wi, Mode::Radiance, Lobes::ALL).0[1];
                close(&what, (lobe.glossy[k][1] + lobe.diffuse[k][1]) * wi.z, all);
            }
            let top = lobe.glossy.iter().map(|f| f[1]).fold(0.0, f32::max);
            let at = |angle: f32| probe.value(wi, along(angle), Lobes::GLOSSY)[1];
            close("the top", at(incidence), top);
            let half = 0.5f32.powf(1.0 / n).acos().to_degrees();
            close("half the top", at(incidence - half), 0.5 * top);
        }
    }

    /// Clear glass sends a part where mirrors do and the rest through: Fresnel's 4 % straight down,
    /// and half of 0.092013 + 0.008466 at 45°.
    #[test]
    fn glass_has_two_directions() {
        let probe = pbrt("\"dielectric\" \"float eta\" 1.5");
        for (incidence, reflected) in [(0.0, 0.04), (45.0, 0.0502395)] {
            let lobe = probe.lobe(incidence, 10.0);
            assert!(lobe.diffuse.iter().chain(&lobe.glossy).all(|f| *f == [0.0; 3]));
            let [(back, r), (through, t)] = lobe.singular[..] else { panic!("{lobe:?}") };
            close("reflected", back, incidence);
            let refracted = (incidence.to_radians().sin() / 1.5).asin().to_degrees();
            close("refracted", through, 180.0 - refracted);
            close("R", r[0], reflected);
            close("R + T", r[0] + t[0], 1.0);
        }
    }

    /// Light that grazes facets leaves beyond the mirror direction (Torrance & Sparrow 1967; Blinn
    /// 1977); light from above does not.
    #[test]
    fn facets_have_off_specular_peaks() {
        let probe = pbrt("\"conductor\" \"float roughness\" 0.3 \"bool remaproughness\" false");
        let peak = |incidence: f32| {
            let lobe = probe.lobe(incidence, 0.5);
            let values = lobe.angles.iter().zip(&lobe.glossy);
            values.max_by(|a, b| a.1[0].total_cmp(&b.1[0])).map_or(0.0, |(angle, _)| *angle)
        };
        assert!(peak(0.0).abs() < 1.0, "{}", peak(0.0));
        assert!(peak(60.0) > 63.0 && peak(75.0) > 78.0, "{} {}", peak(60.0), peak(75.0));
    }

    /// f(ωᵢ,ωₒ) = f(ωₒ,ωᵢ): what is drawn for one direction of light is found in the drawing for another.
    #[test]
    fn rough_metal_is_reciprocal() {
        let probe = pbrt("\"conductor\" \"float roughness\" 0.3");
        for (a, b) in [(10.0, 50.0), (35.0, 75.0), (60.0, 20.0)] {
            let f = probe.value(along(-a), along(b), Lobes::GLOSSY);
            let g = probe.value(along(-b), along(a), Lobes::GLOSSY);
            assert!(f[0] > 0.0);
            close("both ways", f[0], g[0]);
        }
    }
}
