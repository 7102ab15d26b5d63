//! Choosing between a glossy and a diffuse lobe.

use super::Lobes;
use kaustika_spectra::Spectrum;

/// Probability of the glossy lobe, by the averages of both colours, when only `lobes` may be
/// drawn; `None` if neither may.
#[inline]
pub(super) fn glossy_share(lobes: Lobes, glossy: Spectrum, diffuse: Spectrum) -> Option<f32> {
    let on = |class, color: Spectrum| if lobes.has(class) { color.average() } else { 0.0 };
    let g = on(Lobes::GLOSSY_REFLECTION, glossy);
    let d = on(Lobes::DIFFUSE_REFLECTION, diffuse);
    (g + d > 0.0).then(|| g / (g + d))
}

/// The classes of a glossy and a diffuse lobe that are not black.
#[inline]
pub(super) fn classes(glossy: Spectrum, diffuse: Spectrum) -> Lobes {
    let on = |class, color: Spectrum| if color.is_black() { Lobes::NONE } else { class };
    on(Lobes::GLOSSY_REFLECTION, glossy) | on(Lobes::DIFFUSE_REFLECTION, diffuse)
}
