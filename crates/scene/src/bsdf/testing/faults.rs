//! The harness finds what it is for: a Lambert surface with one fault each.

use super::super::{BsdfSample, Diffuse, Lobes, Mode, Scatter};
use super::{Expect, check_model};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// A Lambert surface with one fault.
struct Faulty(Fault);

#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    Density,
    Value,
    Reverse,
    Brighter,
    Class,
}

impl Scatter for Faulty {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        let tilt = if self.0 == Fault::Value { 1.0 + 0.05 * wo.z } else { 1.0 };
        self.lambert().eval(wo, wi, mode, lobes) * tilt
    }
    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        let (f, r) = self.lambert().pdf(wo, wi, mode, lobes);
        match self.0 {
            // Normalised, but 10 % off at the pole.
            Fault::Density => (f * (1.2 - 0.3 * wi.z), r * (1.2 - 0.3 * wo.z)),
            Fault::Reverse => (f, f),
            _ => (f, r),
        }
    }
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let mut s = self.lambert().sample(wo, uc, u2, mode, lobes)?;
        (s.pdf, s.pdf_rev) = self.pdf(wo, s.wi, mode, lobes);
        s.weight = self.eval(wo, s.wi, mode, lobes) / s.pdf;
        if self.0 == Fault::Class {
            s.lobe = Lobes::GLOSSY_REFLECTION;
        }
        Some(s)
    }
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.lambert().reflectance
    }
    fn roughness(&self) -> f32 {
        1.0
    }
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION
    }
}

impl Faulty {
    fn lambert(&self) -> Diffuse {
        let rho = if self.0 == Fault::Brighter { 1.1 } else { 0.8 };
        Diffuse { reflectance: Spectrum([rho, 0.5, 0.2, 0.0]) }
    }
}

#[test]
fn lambert_passes() {
    check_model(
        "lambert",
        &Faulty(Fault::None),
        Expect { albedo_error: 1e-4, ..Expect::default() },
    );
}

macro_rules! found {
    ($($name:ident $fault:ident $message:literal)*) => { $(
        #[test]
        #[should_panic(expected = $message)]
        fn $name() {
            check_model("faulty", &Faulty(Fault::$fault), Expect::default());
        }
    )* };
}
found! {
    wrong_density_is_found Density "chi-square"
    wrong_value_is_found Value "f and its adjoint"
    wrong_reverse_density_is_found Reverse "reverse density"
    gain_is_found Brighter "albedo"
    wrong_class_is_found Class "wrong class"
}
