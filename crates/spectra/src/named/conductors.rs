//! Complex indices of refraction n + ik of metals and other opaque materials.

use std::sync::LazyLock;

use super::{NamedSpectrum, continued};
use crate::SpectrumDesc;
use crate::illuminant::table;

/// n and k of a material by the name Mitsuba's `material` parameter uses (`Au`, `Cr`, `TiO2`,
/// ...; also `CuZn`, brass). The case must match. Mitsuba's `none`, a perfect mirror, is the
/// reader's to handle.
///
/// In RGB mode these are projected as Mitsuba 3 does: without an illuminant and unclamped but
/// for negative values. The same tables under [`named`](super::named)'s `metal-...` names are
/// projected under D65 as everything else.
pub fn conductor(material: &str) -> Option<(SpectrumDesc, SpectrumDesc)> {
    CONDUCTORS
        .iter()
        .find(|(name, _)| *name == material)
        .map(|(_, [eta, k])| (SpectrumDesc::Named(eta), SpectrumDesc::Named(k)))
}

/// All names that [`conductor`] knows.
pub fn conductor_names() -> impl Iterator<Item = &'static str> {
    CONDUCTORS.iter().map(|(name, _)| *name)
}

static CONDUCTORS: LazyLock<Vec<(&'static str, [NamedSpectrum; 2])>> = LazyLock::new(|| {
    let spectrum = |name: String, desc| NamedSpectrum { name, desc, equal_energy_projection: true };
    tables()
        .into_iter()
        .map(|(name, eta, k)| {
            (name, [spectrum(format!("{name}.eta"), eta), spectrum(format!("{name}.k"), k)])
        })
        .collect()
});

/// Name, n and k of every material; materials of several names share their tables.
pub(super) fn tables() -> Vec<(&'static str, SpectrumDesc, SpectrumDesc)> {
    let text: &'static str = include_str!("../../data/conductors.txt");
    let mut all = Vec::new();
    // What stands before the first "material" is the comment at the head of the file.
    for section in text.split("\nmaterial ").skip(1) {
        let (names, rows) = section.split_once('\n').unwrap_or((section, ""));
        let rows: Vec<[f64; 3]> = table(rows);
        let column = |k: usize| rows.iter().map(|r| r[k] as f32).collect::<Vec<_>>();
        let lambda = column(0);
        let sampled = |values: Vec<f32>| {
            let (lambda, values) = continued(&lambda, &values);
            SpectrumDesc::Sampled { lambda: lambda.into(), values: values.into() }
        };
        let (eta, k) = (sampled(column(1)), sampled(column(2)));
        all.extend(names.split_ascii_whitespace().map(|n| (n, eta.clone(), k.clone())));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_mitsubas_presets() {
        let presets = "a-C Ag Al AlAs AlAs_palik AlSb AlSb_palik Au Be Be_palik Cr CsI CsI_palik Cu \
            Cu_palik Cu2O Cu2O_palik CuO CuO_palik d-C d-C_palik Hg Hg_palik HgTe HgTe_palik Ir \
            Ir_palik K K_palik Li Li_palik MgO MgO_palik Mo Mo_palik Na_palik Nb Nb_palik Ni_palik \
            Rh Rh_palik Se Se_palik SiC SiC_palik SnTe SnTe_palik Ta Ta_palik Te Te_palik ThF4 \
            ThF4_palik TiC TiC_palik TiN TiN_palik TiO2 TiO2_palik VC VC_palik V_palik VN VN_palik W";
        for name in presets.split_whitespace() {
            assert!(conductor(name).is_some(), "{name}");
            assert!(conductor_names().any(|n| n == name), "{name}");
        }
        assert!(conductor("none").is_none());
    }
}
