use super::super::testing::{Expect, Random, check_model};
use super::*;
use crate::description::{MeasuredBrdf, MeasuredChannels, SquareTable};
use kaustika_spectra::ColorMode;

/// Numbers without pattern in [0.2, 1.2), the same in the script that asked Mitsuba.
fn table(salt: usize, grids: usize, height: usize, width: usize) -> SquareTable {
    let value = |i: usize| ((i * 7919 + salt * 104_729) % 1009) as f32 / 1009.0 + 0.2;
    SquareTable { width, height, values: (0..grids * width * height).map(value).collect() }
}

fn brdf(phi: &[f32], theta: &[f32], channels: MeasuredChannels) -> MeasuredBrdf {
    let n = phi.len() * theta.len();
    let mut sigma = table(2, 1, 4, 3);
    if phi.len() == 1 {
        sigma.values = sigma.values[..3].repeat(4);
    }
    // No half vectors on the normal, where the density would have a pole.
    let mut vndf = table(3, n, 6, 5);
    vndf.values.iter_mut().step_by(5).for_each(|v| *v = 0.0);
    MeasuredBrdf {
        phi: phi.to_vec(),
        theta: theta.to_vec(),
        ndf: table(1, 1, 5, 4),
        sigma,
        vndf,
        luminance: table(4, n, 4, 4),
        reflectance: table(5, n * channels.count(), 4, 4),
        channels,
        jacobian: true,
    }
}

/// Azimuths and angles of an isotropic material and of anisotropic ones that were measured
/// around the whole, half and a quarter of the circle.
const GRIDS: [(&str, &[f32], &[f32]); 4] = [
    ("isotropic", &[0.0], &[0.0, 0.5, 1.0, 1.5]),
    ("whole", &[-PI, -0.5 * PI, 0.0, 0.5 * PI, PI], &[0.0, 0.7, 1.5]),
    ("half", &[-PI, -2.0, -1.0, 0.0], &[0.0, 0.7, 1.5]),
    ("quarter", &[-PI, -2.5, -0.5 * PI], &[0.0, 0.7, 1.5]),
];

const WAVELENGTHS: [f32; 5] = [360.0, 450.0, 550.0, 700.0, 1000.0];

#[test]
fn measured_materials_hold_the_contract() {
    // Neither reciprocal nor, with numbers without meaning, below 1; the albedo is of radiance.
    let expect = Expect {
        reciprocal: false,
        albedo_error: f32::INFINITY,
        albedo_max: f32::INFINITY,
        samples: 20_000,
        ..Expect::default()
    };
    for (name, phi, theta) in GRIDS {
        let data = MeasuredData::new(&brdf(phi, theta, MeasuredChannels::Rgb), ColorMode::Rgb);
        check_model(name, &Measured { data: &data, lambda: Wavelengths::rgb() }, expect);
    }
}

/// Values and densities of Mitsuba 3.9.1 (scalar_rgb; scalar_spectral at 400, 500, 600, 750 nm)
/// for the same tables, written to files.
#[test]
fn mitsuba_agrees() {
    let pairs = [
        ([0.3, 0.2, 0.8], [-0.4, 0.1, 0.7]),
        ([0.9, 0.1, 0.3], [-0.8, 0.2, 0.35]),
        ([0.1, -0.05, 1.0], [0.5, 0.5, 0.5]),
        ([0.2, -0.9, 0.1], [0.1, 0.3, 0.9]),
        ([-0.3, -0.2, 0.8], [-0.2, 0.6, 0.5]),
    ];
    let figures: [[[f32; 4]; 5]; 4] = [
        [
            [0.234307, 0.342299, 0.288082, 0.185095],
            [0.299132, 0.266789, 0.286041, 0.214081],
            [0.192165, 0.137712, 0.234196, 0.0731801],
            [0.222133, 0.170108, 0.25439, 0.0481835],
            [0.282161, 0.203399, 0.178678, 0.0885922],
        ],
        [
            [0.17637, 0.186232, 0.179407, 0.227091],
            [0.176028, 0.220393, 0.209431, 0.169226],
            [0.188073, 0.140162, 0.183499, 0.0462811],
            [0.197351, 0.109366, 0.218197, 0.0491067],
            [0.133761, 0.120865, 0.145389, 0.0642363],
        ],
        [
            [0.0764455, 0.113126, 0.06517, 0.214878],
            [0.255082, 0.197619, 0.266127, 0.13367],
            [0.181895, 0.145311, 0.143604, 0.0810839],
            [0.211794, 0.135079, 0.204002, 0.0615673],
            [0.135594, 0.121981, 0.140012, 0.0667609],
        ],
        [
            [0.0601777, 0.116755, 0.0740557, 0.200811],
            [0.256048, 0.198052, 0.267622, 0.134979],
            [0.114709, 0.131518, 0.136912, 0.0600214],
            [0.232825, 0.141804, 0.226976, 0.0901048],
            [0.142759, 0.123564, 0.123495, 0.0733205],
        ],
    ];
    let spectral = [
        [0.212165, 0.210146, 0.256249, 0.211146],
        [0.278952, 0.319927, 0.285745, 0.331786],
        [0.165238, 0.17201, 0.172196, 0.234331],
        [0.193132, 0.214071, 0.226558, 0.241161],
        [0.201146, 0.17885, 0.173741, 0.261205],
    ];
    // Mitsuba never sets the number of sectors of isotropic materials, and mirrors `wo` where its
    // x and y have unlike signs if chance left a 4 there.
    let spoilt = |phi: &[f32], wo: [f32; 3]| phi.len() == 1 && wo[0] * wo[1] < 0.0;
    let near = |a: f32, b: f32, what: &str| {
        assert!((a - b).abs() <= 1e-4 * b, "{what}: {a}, Mitsuba {b}");
    };
    let unit =
        |(wo, wi): ([f32; 3], [f32; 3])| (Vec3::from(wo).normalize(), Vec3::from(wi).normalize());
    for ((name, phi, theta), figures) in GRIDS.iter().zip(figures) {
        let data = MeasuredData::new(&brdf(phi, theta, MeasuredChannels::Rgb), ColorMode::Rgb);
        let model = Measured { data: &data, lambda: Wavelengths::rgb() };
        for (pair, figure) in pairs.into_iter().zip(figures) {
            if spoilt(phi, pair.0) {
                continue;
            }
            let (wo, wi) = unit(pair);
            let (value, (pdf, _)) = model.eval_pdf(wo, wi, Mode::Radiance, Lobes::ALL);
            (0..3).for_each(|i| near(value[i], figure[i], name));
            near(pdf, figure[3], name);
        }
    }
    let channels = MeasuredChannels::Wavelengths(WAVELENGTHS.to_vec());
    let brdf = brdf(GRIDS[0].1, GRIDS[0].2, channels);
    let data = MeasuredData::new(&brdf, ColorMode::Spectral);
    let lambda = Wavelengths { lambda: [400.0, 500.0, 600.0, 750.0], ..Wavelengths::sample(0.0) };
    for (pair, figure) in pairs.into_iter().zip(spectral) {
        if spoilt(GRIDS[0].1, pair.0) {
            continue;
        }
        let (wo, wi) = unit(pair);
        let value = Measured { data: &data, lambda }.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        (0..4).for_each(|i| near(value[i], figure[i], "spectral"));
    }
}

/// The directional albedo at the directions of the tables, by uniform directions.
#[test]
fn the_albedo_is_the_integral() {
    let (_, phi, theta) = GRIDS[0];
    let data = MeasuredData::new(&brdf(phi, theta, MeasuredChannels::Rgb), ColorMode::Rgb);
    let model = Measured { data: &data, lambda: Wavelengths::rgb() };
    let mut random = Random::new(11);
    for &theta in &theta[..3] {
        let wo = Vec3::new(theta.sin(), 0.0, theta.cos());
        let n = 400_000;
        let mut sum = 0.0;
        for _ in 0..n {
            let wi = kaustika_math::warp::uniform_hemisphere(random.next_2d());
            sum += model.eval(wo, wi, Mode::Radiance, Lobes::ALL)[0] as f64;
        }
        let exact = sum / n as f64 * 2.0 * std::f64::consts::PI;
        let stated = model.albedo(wo)[0] as f64;
        assert!((stated / exact - 1.0).abs() < 0.03, "{theta}: {stated}, truth {exact}");
    }
}

/// A flat spectrum is white in RGB, a measurement in RGB keeps its colour in spectral mode.
#[test]
fn colours_survive_the_change_of_mode() {
    let channels = MeasuredChannels::Wavelengths(WAVELENGTHS.to_vec());
    let mut flat = brdf(GRIDS[0].1, GRIDS[0].2, channels);
    flat.reflectance.values.fill(0.4);
    flat.jacobian = false;
    let data = MeasuredData::new(&flat, ColorMode::Rgb);
    let model = Measured { data: &data, lambda: Wavelengths::rgb() };
    let (wo, wi) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.28, 0.96));
    let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    (0..3).for_each(|i| assert!((value[i] - 0.4).abs() < 1e-3, "{value:?}"));
    assert_eq!(value[3], 0.0);

    let mut grey = brdf(GRIDS[0].1, GRIDS[0].2, MeasuredChannels::Rgb);
    grey.reflectance.values.fill(0.4);
    grey.jacobian = false;
    let data = MeasuredData::new(&grey, ColorMode::Spectral);
    let model = Measured { data: &data, lambda: Wavelengths::sample(0.3) };
    let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    (0..4).for_each(|i| assert!((value[i] - 0.4).abs() < 2e-3, "{value:?}"));
}
