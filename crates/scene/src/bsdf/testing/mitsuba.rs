//! Agreement with Mitsuba 3: values and densities that Mitsuba 3.9.1 (scalar_rgb) returned
//! for these materials and directions. Every model here evaluates separable masking.
//!
//! Mitsuba approximates Beckmann's masking to 0.35 % and the coat's internal reflectance to
//! 0.1 %; ours are exact, so values may differ by that. GGX must agree to rounding.

use super::super::*;
use crate::description::Distribution;
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

/// `wo` and `wi` (Mitsuba's wi and wo), not normalised.
const PAIRS: [([f32; 3], [f32; 3]); 6] = [
    ([0.3, 0.2, 0.8], [-0.4, 0.1, 0.7]),
    ([0.9, 0.1, 0.3], [-0.8, 0.2, 0.35]),
    ([0.0, 0.0, 1.0], [0.5, 0.5, 0.5]),
    ([0.2, -0.9, 0.1], [0.1, 0.3, 0.9]),
    ([0.3, 0.2, 0.8], [-0.2, -0.1, -0.9]),
    ([0.3, 0.2, -0.8], [-0.6, -0.3, 0.6]),
];

/// Red, green, blue of the value and the density, for each of the first pairs.
fn agrees(name: &str, model: &impl Scatter, figures: &[[f32; 4]], tolerance: f32) {
    for ((wo, wi), figure) in PAIRS.iter().zip(figures) {
        let (wo, wi) = (Vec3::from(*wo).normalize(), Vec3::from(*wi).normalize());
        let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        let pdf = model.pdf(wo, wi, Mode::Radiance, Lobes::ALL).0;
        for (a, b) in [value[0], value[1], value[2], pdf].into_iter().zip(*figure) {
            assert!(
                (a - b).abs() <= tolerance * b,
                "{name} {wo:?} {wi:?}: {value:?} {pdf}, Mitsuba {figure:?}"
            );
        }
    }
}

fn facets(kind: Distribution, u: f32, v: f32) -> Microfacet {
    Microfacet::new(kind, u, v).with_masking(Masking::Separable)
}

const DIFFUSE: Spectrum = Spectrum([0.1, 0.5, 0.9, 0.0]);
const WHITE: Spectrum = Spectrum([1.0, 1.0, 1.0, 0.0]);

#[test]
fn rough_plastic_agrees() {
    let figures = [
        (
            Distribution::Beckmann,
            0.1,
            false,
            2e-3,
            [
                [0.0304239, 0.13755, 0.244676, 0.260462],
                [0.00918978, 0.0459489, 0.082708, 0.0844025],
                [0.017431, 0.0871548, 0.156879, 0.170072],
                [0.0164455, 0.0822275, 0.148009, 0.110456],
            ],
        ),
        (
            Distribution::Beckmann,
            0.1,
            true,
            2e-3,
            [
                [0.0157213, 0.0835284, 0.21596, 0.260462],
                [0.00414474, 0.027412, 0.0728547, 0.0844025],
                [0.00786164, 0.0519945, 0.138189, 0.170072],
                [0.00741718, 0.049055, 0.130377, 0.110456],
            ],
        ),
        (
            Distribution::Ggx,
            0.3,
            false,
            5e-4,
            [
                [0.0367844, 0.111946, 0.187107, 0.292006],
                [0.0432971, 0.0700147, 0.0967323, 0.176096],
                [0.0155396, 0.0640085, 0.112477, 0.1756],
                [0.0284476, 0.0911947, 0.153942, 0.267843],
            ],
        ),
        (
            Distribution::Ggx,
            0.3,
            true,
            5e-4,
            [
                [0.0295726, 0.087793, 0.176161, 0.292006],
                [0.0407336, 0.0614291, 0.0928413, 0.176096],
                [0.010889, 0.0484332, 0.105419, 0.1756],
                [0.022427, 0.0710311, 0.144803, 0.267843],
            ],
        ),
    ];
    for (kind, alpha, nonlinear, tolerance, figures) in figures {
        let coat = RoughTransmittance::new(kind, alpha, 1.49);
        let surface = facets(kind, alpha, alpha);
        let model = RoughPlastic::new(&coat, surface, DIFFUSE, WHITE, nonlinear);
        agrees(&format!("roughplastic {kind:?} {nonlinear}"), &model, &figures, tolerance);
    }
}

#[test]
fn smooth_plastic_agrees() {
    let coat = PlasticCoat::new(1.49);
    let linear = [
        [0.0278287, 0.139143, 0.250458, 0.253516],
        [0.009552, 0.04776, 0.085968, 0.0842623],
        [0.0181326, 0.0906629, 0.163193, 0.170073],
        [0.0143997, 0.0719983, 0.129597, 0.0880219],
    ];
    let nonlinear = [
        [0.0121044, 0.0808177, 0.218867, 0.253516],
        [0.00415476, 0.0277401, 0.0751246, 0.0842623],
        [0.00788699, 0.0526591, 0.142609, 0.170073],
        [0.00626331, 0.0418183, 0.113251, 0.0880219],
    ];
    agrees("linear", &Plastic::new(coat, DIFFUSE, WHITE, false), &linear, 2e-3);
    agrees("nonlinear", &Plastic::new(coat, DIFFUSE, WHITE, true), &nonlinear, 2e-3);
}

#[test]
fn rough_glass_agrees() {
    let grey = |figures: [[f32; 2]; 6]| figures.map(|[f, p]| [f, f, f, p]);
    let beckmann = grey([
        [0.0224575, 0.0224575],
        [0.00362355, 0.00362671],
        [0.000692936, 0.000692936],
        [2.80115e-05, 2.80115e-05],
        [10.6538, 23.971],
        [6.25929, 2.78191],
    ]);
    let ggx = grey([
        [0.0151041, 0.0152173],
        [0.0160073, 0.0177513],
        [0.00248772, 0.0025661],
        [0.00719702, 0.007207],
        [8.13051, 18.3162],
        [4.40568, 2.00587],
    ]);
    for (kind, figures, tolerance) in
        [(Distribution::Beckmann, beckmann, 7e-3), (Distribution::Ggx, ggx, 5e-4)]
    {
        let surface = facets(kind, 0.3, 0.2);
        let glass = Dielectric { eta: 1.5, reflectance: WHITE, transmittance: WHITE, surface };
        agrees(&format!("roughdielectric {kind:?}"), &glass, &figures, tolerance);
    }
}

#[test]
fn rough_metal_agrees() {
    let beckmann = [
        [0.525492, 0.339946, 0.181046, 0.552114],
        [0.0246775, 0.0167251, 0.0108737, 0.0261883],
        [0.0160783, 0.0104016, 0.00554779, 0.0168942],
        [0.000457824, 0.000297705, 0.000167491, 0.000482447],
    ];
    let ggx = [
        [0.353426, 0.228635, 0.121764, 0.374114],
        [0.109015, 0.0738841, 0.0480355, 0.128181],
        [0.0577227, 0.037343, 0.0199172, 0.0625631],
        [0.117629, 0.0764895, 0.0430337, 0.124128],
    ];
    for (kind, figures, tolerance) in
        [(Distribution::Beckmann, beckmann, 7e-3), (Distribution::Ggx, ggx, 5e-4)]
    {
        let fresnel = ConductorFresnel::EtaK {
            eta: Spectrum([0.2, 0.9, 1.4, 0.0]),
            k: Spectrum([3.9, 2.4, 1.6, 0.0]),
        };
        let metal = Conductor { fresnel, tint: WHITE, surface: facets(kind, 0.3, 0.2) };
        agrees(&format!("roughconductor {kind:?}"), &metal, &figures, tolerance);
    }
}
