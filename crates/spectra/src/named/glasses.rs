//! Optical glasses.

use crate::SpectrumDesc;

/// Names and Sellmeier equations, coefficients from Schott's catalogue (the N- kinds where the
/// glass has been replaced), as refractiveindex.info lists them; valid from about 0.35 to 2.5 µm.
pub(super) fn glasses() -> Vec<(&'static str, SpectrumDesc)> {
    let sf5 = glass(
        [1.524_818_89, 0.187_085_527, 1.427_290_15],
        [0.011_254_756, 0.058_899_539_2, 129.141_675],
    );
    let sf10 = glass(
        [1.621_539_02, 0.256_287_842, 1.644_475_52],
        [0.012_224_145_7, 0.059_573_677_5, 147.468_793],
    );
    let sf11 = glass(
        [1.737_596_95, 0.313_747_346, 1.898_781_01],
        [0.013_188_707, 0.062_306_814_2, 155.236_29],
    );
    vec![
        (
            "BK7",
            glass(
                [1.039_612_12, 0.231_792_344, 1.010_469_45],
                [0.006_000_698_67, 0.020_017_914_4, 103.560_653],
            ),
        ),
        (
            "BAF10",
            glass(
                [1.585_149_5, 0.143_559_385, 1.085_212_69],
                [0.009_266_812_82, 0.042_448_980_5, 105.613_573],
            ),
        ),
        (
            "FK51A",
            glass(
                [0.971_247_817, 0.216_901_417, 0.904_651_666],
                [0.004_723_019_95, 0.015_357_561_2, 168.681_33],
            ),
        ),
        (
            "LASF9",
            glass(
                [2.000_295_47, 0.298_926_886, 1.806_918_43],
                [0.012_142_601_7, 0.053_873_623_6, 156.530_829],
            ),
        ),
        ("SF5", sf5.clone()),
        ("F5", sf5),
        ("SF10", sf10.clone()),
        ("F10", sf10),
        ("SF11", sf11.clone()),
        ("F11", sf11),
    ]
}

fn glass(b: [f32; 3], c: [f32; 3]) -> SpectrumDesc {
    SpectrumDesc::Sellmeier { b, c }
}
