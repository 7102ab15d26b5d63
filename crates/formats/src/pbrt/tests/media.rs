//! `MakeNamedMedium`.

use super::*;
use kaustika_math::Vec3;
use kaustika_scene::description::{
    CloudDesc, CoefficientsDesc, DensityDesc, FieldDesc, GlowSource, GridLayout, PhaseDesc,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

fn rgb(rgb: [f32; 3]) -> FieldDesc {
    FieldDesc::Constant(SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb })
}

fn one() -> FieldDesc {
    FieldDesc::Constant(SpectrumDesc::Constant(1.0))
}

#[test]
fn homogeneous_media() {
    let s = read(
        "MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [ 1 2 3 ] \"float g\" 0.5
         \"float scale\" 2 \"rgb Le\" [ 1 0 0 ] \"float Lescale\" 3
         MakeNamedMedium \"b\" \"string type\" \"homogeneous\" \"string preset\" \"Lowfat Milk\"
         WorldBegin",
    );
    assert_eq!(messages(&s), "");
    let m = &s.media[0];
    let coefficients = CoefficientsDesc::AbsorptionScattering(one(), rgb([1.0, 2.0, 3.0]));
    assert_eq!((&m.coefficients, m.scale, &m.extent), (&coefficients, 2.0, &None));
    assert_eq!(m.phase, PhaseDesc::HenyeyGreenstein { g: 0.5 });
    let glow = m.glow.as_ref().expect("it glows");
    assert_eq!((&glow.source, glow.scale), (&GlowSource::Radiance(rgb([1.0, 0.0, 0.0])), 3.0));
    let milk = ([0.002875, 0.00575, 0.0115], [0.89187, 1.5136, 2.532]);
    let milk = CoefficientsDesc::AbsorptionScattering(rgb(milk.0), rgb(milk.1));
    assert_eq!((&s.media[1].coefficients, &s.media[1].phase), (&milk, &PhaseDesc::Isotropic));
}

#[test]
fn grids() {
    let s = read(
        "Translate 10 0 0
         MakeNamedMedium \"a\" \"string type\" \"uniformgrid\" \"float density\" [ 1 2 3 4 5 6 ]
         \"integer nx\" 3 \"integer ny\" 2 \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ 3 2 1 ]
         \"float temperature\" [ 0 1 2 3 4 5 ] \"float temperaturescale\" 1000
         \"float temperatureoffset\" -1 \"float Lescale\" 7
         MakeNamedMedium \"b\" \"string type\" \"rgbgrid\" \"rgb sigma_a\" [ 1 2 3 4 5 6 ]
         \"integer nz\" 2 \"rgb Le\" [ 0 0 1 0 1 0 ] \"float Lescale\" 2
         WorldBegin",
    );
    assert_eq!(messages(&s), "");
    let m = &s.media[0];
    let Some(DensityDesc::Grid(density)) = &m.density else { panic!() };
    assert_eq!((density.resolution, density.layout), ([3, 2, 1], GridLayout::CellsFading));
    let extent = m.extent.expect("a box");
    assert_eq!(extent.point(Vec3::ZERO), Vec3::X * 10.0);
    assert_eq!(extent.point(Vec3::splat(1.0)), Vec3::new(13.0, 2.0, 1.0));
    let glow = m.glow.as_ref().expect("it glows");
    let GlowSource::Temperature { grid, offset, factor } = &glow.source else { panic!() };
    assert_eq!((grid.values[5], *offset, *factor, glow.scale), (5.0, -1.0, 1000.0, 7.0));
    let CoefficientsDesc::AbsorptionScattering(FieldDesc::Grid(a), sigma_s) =
        &s.media[1].coefficients
    else {
        panic!()
    };
    assert_eq!((a.channels, a.resolution, sigma_s), (3, [1, 1, 2], &one()));
    assert_eq!(s.media[1].glow.as_ref().map(|g| g.scale), Some(2.0));
}

#[test]
fn clouds() {
    let s = read(
        "Translate 1 0 0 MakeNamedMedium \"a\" \"string type\" \"cloud\" \"float density\" 2
         \"float wispiness\" 0.5 \"point3 p1\" [ 3 2 1 ] WorldBegin",
    );
    assert_eq!(messages(&s), "");
    let m = &s.media[0];
    let to_world = kaustika_math::Transform::translate(Vec3::X);
    let cloud = CloudDesc { density: 2.0, wispiness: 0.5, frequency: 5.0, to_world };
    assert_eq!(m.density, Some(DensityDesc::Cloud(cloud)));
    let extent = m.extent.expect("a box");
    assert_eq!(extent.point(Vec3::splat(1.0)), Vec3::new(4.0, 2.0, 1.0));
}

#[test]
fn faults() {
    let s = read(
        "MakeNamedMedium \"a\" \"string type\" \"uniformgrid\" \"float density\" [ 1 2 ] \"integer nx\" 3
MakeNamedMedium \"b\" \"string type\" \"homogeneous\" \"string preset\" \"Skin\" \"float g\" 1
MakeNamedMedium \"c\" \"string type\" \"nanovdb\"
MakeNamedMedium \"d\" \"string type\" \"foggy\"
MakeNamedMedium \"e\" \"string type\" \"rgbgrid\"
MakeNamedMedium \"f\"
MakeNamedMedium \"g\" \"string type\" \"uniformgrid\" \"integer nx\" 0
WorldBegin",
    );
    assert_eq!(
        messages(&s),
        "error 1:49 <\"float density\"> `density` needs nx · ny · nz = 3 values, 2 given\n\
         warning 2:65 <\"Skin\"> no medium preset is called `Skin`; did you mean `Skin1`?\n\
         error 2:72 <\"float g\"> `g` must lie between -1 and 1, found 1\n\
         error 3:1 <MakeNamedMedium> medium `nanovdb` needs `filename`\n\
         error 4:35 <\"foggy\"> unknown medium type `foggy`; known: homogeneous, uniformgrid, \
         rgbgrid, cloud, nanovdb\n\
         error 5:1 <MakeNamedMedium> medium `rgbgrid` needs `sigma_a` or `sigma_s`\n\
         error 6:17 <\"f\"> medium `f` has no type; add \"string type\" \"homogeneous\"\n\
         error 7:49 <\"integer nx\"> `nx` must be at least 1, found 0\n"
    );
}
