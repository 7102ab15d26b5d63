//! The closed set of scattering models.

use super::{
    BsdfSample, CoatedConductor, CoatedDiffuse, Coating, Conductor, Dielectric, Diffuse,
    DiffuseTransmission, Grating, Hair, HeightField, Lobes, Measured, MeasuredPolarized,
    MetallicRoughness, Mode, Null, OrenNayar, Phong, Plastic, PolarizingFilter, Principled,
    PrincipledThin, RoughPlastic, Scatter, ThinDielectric, Ward,
};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// Generates [`Model`] and its dispatch. To add a model: its file, and one line here.
macro_rules! models {
    ($($(#[$doc:meta])* $Name:ident($T:ty)),+ $(,)?) => {
        /// Any scattering model, by value.
        #[derive(Clone, Copy, Debug)]
        pub enum Model<'a> {

            $($(#[$doc])* $Name($T)),+
        }

        impl Scatter for Model<'_> {
            #[inline]
            fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
                match self { $(Model::$Name(m) => m.eval(wo, wi, mode, lobes)),+ }
            }
            #[inline]
            fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
                match self { $(Model::$Name(m) => m.pdf(wo, wi, mode, lobes)),+ }
            }
            #[inline]
            fn eval_pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (Spectrum, (f32, f32)) {
                match self { $(Model::$Name(m) => m.eval_pdf(wo, wi, mode, lobes)),+ }
            }
            #[inline]
            fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
                match self { $(Model::$Name(m) => m.sample(wo, uc, u2, mode, lobes)),+ }
            }
            #[inline]
            fn albedo(&self, wo: Vec3) -> Spectrum {
                match self { $(Model::$Name(m) => m.albedo(wo)),+ }
            }
            #[inline]
            fn roughness(&self) -> f32 {
                match self { $(Model::$Name(m) => m.roughness()),+ }
            }
            #[inline]
            fn lobes(&self) -> Lobes {
                match self { $(Model::$Name(m) => m.lobes()),+ }
            }
        }
    };
}

models! {
    /// Lambert.
    Diffuse(Diffuse),
    /// Metal.
    Conductor(Conductor),
    /// Glass.
    Dielectric(Dielectric),
    /// A thin pane.
    ThinDielectric(ThinDielectric),
    /// Smooth plastic.
    Plastic(Plastic),
    /// Rough plastic.
    RoughPlastic(RoughPlastic<'a>),
    /// Rough matte.
    OrenNayar(OrenNayar),
    /// Matte on both sides.
    DiffuseTransmission(DiffuseTransmission),
    /// Matte and a cosine lobe.
    Phong(Phong),
    /// Matte and an anisotropic highlight.
    Ward(Ward),
    /// Disney's.
    Principled(Principled),
    /// Disney's, of thin sheets.
    PrincipledThin(PrincipledThin),
    /// glTF's.
    MetallicRoughness(MetallicRoughness),
    /// Matte under a coat.
    CoatedDiffuse(CoatedDiffuse),
    /// Metal under a coat.
    CoatedConductor(CoatedConductor),
    /// Another model under a coat.
    Coating(Coating<'a>),
    /// Lines that diffract.
    Grating(Grating<'a>),
    /// A fibre.
    Hair(Hair),
    /// Bumps seen from afar.
    HeightField(HeightField<'a>),
    /// What was measured.
    Measured(Measured<'a>),
    /// What was measured, with its polarization.
    MeasuredPolarized(MeasuredPolarized<'a>),
    /// Polarizer or retarder.
    PolarizingFilter(PolarizingFilter),
    /// Nothing there.
    Null(Null),
}

/// Models are copied at every hit; the rare ones must not make all of them larger.
#[test]
fn rare_models_are_no_larger_than_frequent_ones() {
    let frequent = size_of::<CoatedConductor>();
    let rare = [
        size_of::<Coating>(),
        size_of::<Grating>(),
        size_of::<Hair>(),
        size_of::<HeightField>(),
        size_of::<Measured>(),
        size_of::<MeasuredPolarized>(),
    ];
    assert!(rare.iter().all(|size| *size <= frequent), "{rare:?}, {frequent}");
}
