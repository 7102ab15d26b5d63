//! Spectra and indices of refraction that have names in scene files.

mod conductors;
mod glasses;
mod ior;

use std::fmt;
use std::sync::LazyLock;

use crate::cie::{LAMBDA_MAX, LAMBDA_MIN};
use crate::illuminant::fluorescent;
use crate::{DenseSpectrum, SpectrumDesc, daylight, illuminant_a};

pub use conductors::{conductor, conductor_names};
pub use ior::{ior_by_name, ior_names};

/// A spectrum of our collection; compared by name.
pub struct NamedSpectrum {
    name: String,
    desc: SpectrumDesc,
    equal_energy_projection: bool,
}

impl NamedSpectrum {
    /// Its name in scene files.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it is; tables are continued beyond their ends with the last value.
    pub fn desc(&self) -> &SpectrumDesc {
        &self.desc
    }

    /// True if RGB mode projects it without an illuminant, in whatever role: the n and k of
    /// Mitsuba's conductor presets.
    pub(crate) fn equal_energy_projection(&self) -> bool {
        self.equal_energy_projection
    }
}

impl PartialEq for NamedSpectrum {
    fn eq(&self, o: &NamedSpectrum) -> bool {
        self.name == o.name
    }
}

impl fmt::Debug for NamedSpectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("NamedSpectrum").field(&self.name).finish()
    }
}

/// The spectrum of this name in pbrt's scene files: `glass-BK7` (indices of refraction),
/// `metal-Au-eta`, `metal-Au-k` (of every conductor), `stdillum-D65` (illuminants, normalised to
/// Y = 1), `illum-acesD60`. The case must match.
///
/// pbrt-v4 calls the glasses SF5, SF10 and SF11 `glass-F5`, `glass-F10` and `glass-F11`; both
/// names are known.
pub fn named(name: &str) -> Option<SpectrumDesc> {
    NAMED.iter().find(|n| n.name == name).map(SpectrumDesc::Named)
}

/// All names that [`named`] knows.
pub fn names() -> impl Iterator<Item = &'static str> {
    NAMED.iter().map(|n| n.name.as_str())
}

/// The candidate most like `name`, for "did you mean": the smallest edit distance (Levenshtein
/// 1966), case ignored, of at most a third of the letters.
pub fn suggest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (name.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|c| (edit_distance(&name.to_lowercase(), &c.to_lowercase()), c))
        .filter(|&(d, _)| d <= limit)
        .min_by_key(|&(d, _)| d)
        .map(|(_, c)| c)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

static NAMED: LazyLock<Vec<NamedSpectrum>> = LazyLock::new(|| {
    let spectrum =
        |name: String, desc| NamedSpectrum { name, desc, equal_energy_projection: false };
    let mut all = Vec::new();
    for (name, desc) in glasses::glasses() {
        all.push(spectrum(format!("glass-{name}"), desc));
    }
    for (name, eta, k) in conductors::tables() {
        all.push(spectrum(format!("metal-{name}-eta"), eta));
        all.push(spectrum(format!("metal-{name}-k"), k));
    }
    let light = |lambda: &[f32], values: &[f32]| {
        let (lambda, values) = continued(lambda, values);
        let y = DenseSpectrum::from_samples(&lambda, &values).xyz()[1];
        SpectrumDesc::Sampled {
            lambda: lambda.into(),
            values: values.iter().map(|v| v / y).collect(),
        }
    };
    let a: (Vec<f32>, Vec<f32>) =
        (0..95).map(|i| 360.0 + 5.0 * i as f32).map(|l| (l, illuminant_a(l))).unzip();
    all.push(spectrum("stdillum-A".into(), light(&a.0, &a.1)));
    for (name, kelvin) in [
        ("stdillum-D50", 5000.0),
        ("stdillum-D55", 5500.0),
        ("stdillum-D65", 6500.0),
        ("stdillum-D75", 7500.0),
        ("illum-acesD60", 6000.0),
    ] {
        if let SpectrumDesc::Sampled { lambda, values } = daylight(kelvin) {
            all.push(spectrum(name.into(), light(&lambda, &values)));
        }
    }
    for n in 1..=12 {
        let (lambda, values) = fluorescent(n);
        all.push(spectrum(format!("stdillum-F{n}"), light(&lambda, &values)));
    }
    all
});

/// The samples continued to the ends of the visible range by their first and last value.
fn continued(lambda: &[f32], values: &[f32]) -> (Vec<f32>, Vec<f32>) {
    let (mut l, mut v) = (lambda.to_vec(), values.to_vec());
    if let (Some(&first), Some(&value)) = (lambda.first(), values.first())
        && first > LAMBDA_MIN
    {
        l.insert(0, LAMBDA_MIN - 1.0);
        v.insert(0, value);
    }
    if let (Some(&last), Some(&value)) = (lambda.last(), values.last())
        && last < LAMBDA_MAX
    {
        l.push(LAMBDA_MAX + 1.0);
        v.push(value);
    }
    (l, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(name: &str, lambda: f32) -> f32 {
        named(name).unwrap_or_else(|| panic!("{name}")).value_at(lambda).expect("has values")
    }

    #[test]
    fn known_values() {
        // Schott's catalogue: n_d (587.56 nm).
        for (name, nd) in [
            ("glass-BK7", 1.51680),
            ("glass-BAF10", 1.67003),
            ("glass-FK51A", 1.48656),
            ("glass-LASF9", 1.85025),
            ("glass-SF5", 1.67271),
            ("glass-SF10", 1.72828),
            ("glass-SF11", 1.78472),
        ] {
            assert!((at(name, 587.5618) - nd).abs() < 2e-5, "{name} {}", at(name, 587.5618));
        }
        assert_eq!(
            named("glass-F11").map(|d| d.value_at(500.0)),
            Some(Some(at("glass-SF11", 500.0)))
        );
        // Between the samples 563.56 nm (0.306, 2.88) and 576.67 nm (0.267625, 2.940625).
        assert!((at("metal-Au-eta", 570.115) - 0.286_812).abs() < 1e-4);
        assert!((at("metal-Au-k", 570.115) - 2.910_312).abs() < 1e-3);
        assert!((at("metal-CuZn-eta", 555.0) - 0.516).abs() < 1e-5);
    }

    #[test]
    fn every_name_is_a_proper_spectrum_over_the_visible_range() {
        let mut count = 0;
        for name in names() {
            let desc = named(name).expect("listed");
            let SpectrumDesc::Named(n) = &desc else { panic!() };
            if let SpectrumDesc::Sampled { lambda, values } = n.desc() {
                SpectrumDesc::sampled(lambda, values).unwrap_or_else(|e| panic!("{name}: {e}"));
            }
            for l in [360.0, 450.0, 600.0, 830.0] {
                let v = at(name, l);
                assert!((0.0..30.0).contains(&v), "{name} {l} {v}");
            }
            assert_eq!(names().filter(|&n| n == name).count(), 1, "{name}");
            if name.contains("illum") {
                assert!((desc.dense().xyz()[1] - 1.0).abs() < 1e-5, "{name}");
            }
            count += 1;
        }
        assert!(count > 100, "{count}");
        assert!(named("metal-Au").is_none());
    }

    #[test]
    fn suggestions() {
        assert_eq!(suggest("glass-bk7", names()), Some("glass-BK7"));
        assert_eq!(suggest("metal-Au-etta", names()), Some("metal-Au-eta"));
        assert_eq!(suggest("watr", ior_names()), Some("water"));
        assert_eq!(suggest("nonsense", names()), None);
    }
}
