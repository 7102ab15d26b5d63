//! Complex indices of refraction of conductors by name.

use kaustika_spectra::SpectrumDesc;

/// η and k of a conductor by Mitsuba's name, such as `Au`.
pub(super) fn by_name(name: &str) -> Option<(SpectrumDesc, SpectrumDesc)> {
    let _ = name;
    None
}

/// All names.
pub(super) fn names() -> Vec<&'static str> {
    Vec::new()
}
