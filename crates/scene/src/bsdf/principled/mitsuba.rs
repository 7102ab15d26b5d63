//! Agreement with Mitsuba 3: values and densities that Mitsuba 3.9.1 (scalar_rgb) returned.

use super::super::{Lobes, Mode, Scatter};
use super::*;
use kaustika_math::Vec3;

/// `wo` and `wi` (Mitsuba's wi and wo), not normalised: four reflections from above, a
/// refraction from above and from below, a reflection from below.
const PAIRS: [([f32; 3], [f32; 3]); 7] = [
    ([0.3, 0.2, 0.8], [-0.4, 0.1, 0.7]),
    ([0.9, 0.1, 0.3], [-0.8, 0.2, 0.35]),
    ([0.0, 0.0, 1.0], [0.5, 0.5, 0.5]),
    ([0.2, -0.9, 0.1], [0.1, 0.3, 0.9]),
    ([0.3, 0.2, 0.8], [-0.2, -0.1, -0.9]),
    ([0.3, 0.2, -0.8], [-0.6, -0.3, 0.6]),
    ([0.3, 0.2, -0.8], [-0.3, -0.3, -0.6]),
];

/// Red, green, blue of the value and the density, for each of the first pairs.
fn agrees(model: &impl Scatter, figures: &[[f32; 4]]) {
    for ((wo, wi), figure) in PAIRS.iter().zip(figures) {
        let (wo, wi) = (Vec3::from(*wo).normalize(), Vec3::from(*wi).normalize());
        let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        let pdf = model.pdf(wo, wi, Mode::Radiance, Lobes::ALL).0;
        for (a, b) in [value[0], value[1], value[2], pdf].into_iter().zip(*figure) {
            assert!(
                (a - b).abs() <= 1e-4 * b,
                "{wo:?} {wi:?}: {value:?} {pdf}, Mitsuba {figure:?}"
            );
        }
    }
}

fn solid() -> PrincipledParameters {
    PrincipledParameters {
        base_color: Spectrum([0.2, 0.8, 0.1, 0.0]),
        base_luminance: 0.212_671 * 0.2 + 0.715_16 * 0.8 + 0.072_169 * 0.1,
        ..Default::default()
    }
}

fn thin() -> PrincipledThinParameters {
    PrincipledThinParameters {
        base_color: Spectrum([0.7, 0.1, 0.1, 0.0]),
        base_luminance: 0.212_671 * 0.7 + 0.787_329 * 0.1,
        eta: 1.33,
        ..Default::default()
    }
}

#[test]
fn opaque_models_agree() {
    let a = PrincipledParameters {
        roughness: 0.15,
        anisotropic: 0.8,
        metallic: 0.1,
        clearcoat: 0.9,
        sheen: 0.9,
        eta: eta_from_specular(0.7),
        ..solid()
    };
    agrees(
        &Principled::new(a),
        &[
            [0.0593082, 0.207554, 0.0346006, 0.153516],
            [0.0500604, 0.110228, 0.0400325, 0.0750056],
            [0.0345627, 0.133464, 0.0180792, 0.086212],
            [0.04833, 0.175953, 0.0270595, 0.134382],
        ],
    );
    let b = PrincipledParameters {
        roughness: 0.4,
        metallic: 0.6,
        spec_tint: 0.5,
        sheen: 0.5,
        sheen_tint: 0.7,
        flatness: 0.6,
        clearcoat: 0.5,
        clearcoat_gloss: 0.7,
        eta: 1.5,
        ..solid()
    };
    agrees(
        &Principled::new(b),
        &[
            [0.0838747, 0.31107, 0.0460087, 0.403466],
            [0.0475679, 0.139157, 0.0323031, 0.142864],
            [0.0183814, 0.0707887, 0.00964688, 0.0775374],
            [0.0389826, 0.147909, 0.0208281, 0.158302],
        ],
    );
}

#[test]
fn transparent_models_agree() {
    let c = PrincipledParameters {
        roughness: 0.5,
        metallic: 0.3,
        spec_tint: 0.4,
        spec_trans: 0.6,
        anisotropic: 0.5,
        clearcoat: 1.0,
        sheen: 0.3,
        eta: 1.33,
        ..solid()
    };
    agrees(
        &Principled::new(c),
        &[
            [0.0480946, 0.151783, 0.0308132, 0.226762],
            [0.0290063, 0.0620696, 0.0234957, 0.0946628],
            [0.0158591, 0.0567784, 0.00903917, 0.067716],
            [0.0261701, 0.092112, 0.0151797, 0.103879],
            [0.760106, 1.52021, 0.537476, 1.968],
            [0.271324, 0.542649, 0.191855, 0.840857],
            [0.00829586, 0.00829586, 0.00829586, 0.0199331],
        ],
    );
    let d = PrincipledParameters {
        roughness: 0.5,
        spec_trans: 0.9,
        eta: 0.7,
        spec_tint: 0.5,
        ..solid()
    };
    agrees(
        &Principled::new(d),
        &[
            [0.0167309, 0.0406898, 0.0127377, 0.084844],
            [0.242631, 0.249493, 0.241487, 0.247343],
            [0.00539172, 0.017528, 0.00336901, 0.0255799],
            [0.199734, 0.216831, 0.196884, 0.204036],
            [0.187732, 0.375465, 0.132747, 0.187174],
            [0.00646164, 0.0129233, 0.00456907, 0.0333913],
            [0.028791, 0.028791, 0.028791, 0.032238],
        ],
    );
}

#[test]
fn thin_models_agree() {
    let a = PrincipledThinParameters {
        roughness: 0.5,
        spec_trans: 0.4,
        diff_trans: 1.4,
        anisotropic: 0.8,
        sheen: 0.8,
        eta: 1.33,
        ..thin()
    };
    agrees(
        &PrincipledThin::new(a),
        &[
            [0.0357024, 0.00608088, 0.00608088, 0.0777209],
            [0.019991, 0.00763944, 0.00763944, 0.0273121],
            [0.0234351, 0.00351001, 0.00351001, 0.0378584],
            [0.0371674, 0.00639165, 0.00639165, 0.0606275],
            [0.35265, 0.0503786, 0.0503786, 0.320661],
            [0.172693, 0.0246705, 0.0246705, 0.170054],
            [0.0371947, 0.00912403, 0.00912403, 0.153826],
        ],
    );
    let b = PrincipledThinParameters {
        roughness: 0.2,
        spec_trans: 0.8,
        diff_trans: 0.4,
        spec_tint: 0.6,
        sheen: 0.5,
        sheen_tint: 0.5,
        flatness: 0.7,
        eta: 1.33,
        ..thin()
    };
    agrees(
        &PrincipledThin::new(b),
        &[
            [0.026776, 0.0041993, 0.0041993, 0.0704487],
            [0.0252257, 0.00549735, 0.00549735, 0.024733],
            [0.0176538, 0.00253836, 0.00253836, 0.0305311],
            [0.0306689, 0.00470236, 0.00470236, 0.0523402],
            [0.0811468, 0.0115924, 0.0115924, 0.0652084],
            [0.00860839, 0.00122977, 0.00122977, 0.010437],
            [0.050167, 0.0114174, 0.0114174, 0.335232],
        ],
    );
}
