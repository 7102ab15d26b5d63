//! Light by wavelength: what a spectral film keeps beside its colour.
//!
//! ```text
//! c_j = n_j Σ w r_j(λᵢ) Lᵢ/pᵢ  /  Σ w r_j(λᵢ)/pᵢ                                            (1)
//! bins:       r = 1 within the bin, n = 1:        the mean of L over the bin
//! responses:  n = ∫ r dλ:                          ∫ L r dλ, λ in nm
//! ```
//!
//! λᵢ are a path's wavelengths, pᵢ their density, w the filter's weight. (1) divides by what the
//! sum would be for L = 1, so that the luck of which wavelengths were drawn does not show; as any
//! ratio of sums it is right in the limit only. Bins are pbrt-v4's `spectral` film, responses
//! Mitsuba 3's `specfilm`; channels are named after Fichet et al. 2021, "An OpenEXR Layout for
//! Spectral Images", where they are bins.

use kaustika_scene::description::BandsDesc;
use kaustika_spectra::{ColorMode, CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths};

/// Channels by wavelength.
#[derive(Debug)]
pub struct Bands {
    names: Vec<String>,
    responses: Responses,
}

#[derive(Debug)]
enum Responses {
    /// From a wavelength on, of this width, nm.
    Bins { min: f32, width: f32 },
    /// r and n.
    Curves(Vec<(CompiledSpectrum, f32)>),
}

impl Bands {
    /// Prepares a description.
    pub fn new(desc: &BandsDesc) -> Bands {
        match desc {
            BandsDesc::Bins { count, range: [min, max] } => {
                let width = (max - min) / *count as f32;
                let centre = |i: u32| f64::from(*min) + (f64::from(i) + 0.5) * f64::from(width);
                // Dots separate layers.
                let name = |i| format!("S0.{:.3}nm", centre(i)).replacen('.', "\u{0}", 1);
                let name = |i| name(i).replace('.', ",").replace('\u{0}', ".");
                let names = (0..*count).map(name).collect();
                Bands { names, responses: Responses::Bins { min: *min, width } }
            }
            BandsDesc::Responses(list) => {
                let curve = |desc| {
                    let r =
                        CompiledSpectrum::new(desc, SpectrumRole::Unbounded, ColorMode::Spectral);
                    let at = |l| {
                        let lambda = [l; 4];
                        r.eval(&Wavelengths { lambda, pdf: [1.0; 4], mode: ColorMode::Spectral })[0]
                    };
                    // By the midpoint rule over the wavelengths that paths have.
                    let integral =
                        (0..4700).map(|i| f64::from(at(360.05 + 0.1 * i as f32))).sum::<f64>();
                    (r, (0.1 * integral) as f32)
                };
                Bands {
                    names: list.iter().map(|(name, _)| name.clone()).collect(),
                    responses: Responses::Curves(list.iter().map(|(_, d)| curve(d)).collect()),
                }
            }
        }
    }

    /// Names of the channels.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Adds a path's `radiance` with weight `w` of the filter to the sums above and below the line
    /// of (1), one after the other for each channel.
    pub fn add(&self, radiance: Spectrum, lambda: &Wavelengths, w: f32, sums: &mut [f32]) {
        for i in 0..4 {
            let p = lambda.pdf[i];
            if p <= 0.0 {
                continue;
            }
            let k = w / p;
            match &self.responses {
                Responses::Bins { min, width } => {
                    let bin = (lambda.lambda[i] - min) / width;
                    let last = self.names.len() as f32;
                    // The last bin has both its ends.
                    let bin = if bin == last { last - 1.0 } else { bin };
                    if (0.0..last).contains(&bin) {
                        let at = 2 * bin as usize;
                        sums[at] += k * radiance[i];
                        sums[at + 1] += k;
                    }
                }
                Responses::Curves(curves) => {
                    for ((r, n), sums) in curves.iter().zip(sums.chunks_exact_mut(2)) {
                        let r = r.eval(lambda)[i];
                        sums[0] += k * n * r * radiance[i];
                        sums[1] += k * r;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_spectra::SpectrumDesc;

    /// The channels of L(λ), by (1) over many stratified paths.
    fn seen(desc: &BandsDesc, l: impl Fn(f32) -> f32, paths: u32) -> Vec<f32> {
        let bands = Bands::new(desc);
        let mut sums = vec![0.0; 2 * bands.names().len()];
        for i in 0..paths {
            let w = Wavelengths::sample((i as f32 + 0.5) / paths as f32);
            bands.add(Spectrum(w.lambda.map(&l)), &w, 1.0 + (i % 3) as f32, &mut sums);
        }
        sums.chunks(2).map(|s| s[0] / s[1]).collect()
    }

    #[test]
    fn bins_have_the_mean_of_their_range() {
        let desc = BandsDesc::Bins { count: 5, range: [400.0, 700.0] };
        // A few paths are enough for what does not vary.
        assert!(seen(&desc, |_| 3.0, 20).iter().all(|v| (v - 3.0).abs() < 1e-5));
        for (i, v) in seen(&desc, |l| 0.01 * l, 100_000).iter().enumerate() {
            let centre = 430.0 + 60.0 * i as f32;
            assert!((v - 0.01 * centre).abs() < 2e-3, "{i}: {v}");
        }
        let names =
            ["S0.430,000nm", "S0.490,000nm", "S0.550,000nm", "S0.610,000nm", "S0.670,000nm"];
        assert_eq!(Bands::new(&desc).names(), names);
    }

    #[test]
    fn responses_have_their_integral() {
        // A triangle of area 50 about 550 nm and a flat one over everything.
        let triangle =
            SpectrumDesc::sampled(&[500.0, 550.0, 600.0], &[0.0, 1.0, 0.0]).expect("rises");
        let list = vec![("a".into(), triangle), ("b".into(), SpectrumDesc::EqualEnergy(2.0))];
        let desc = BandsDesc::Responses(list);
        let [a, b] = seen(&desc, |l| 0.01 * l, 100_000)[..] else { panic!("two") };
        assert!((a - 50.0 * 5.5).abs() < 0.2, "{a}");
        assert!((b - 2.0 * 470.0 * 5.95).abs() < 4.0, "{b}");
    }

    #[test]
    fn wavelengths_that_ended_are_made_up_for() {
        let desc = BandsDesc::Bins { count: 2, range: [360.0, 830.0] };
        let bands = Bands::new(&desc);
        let mut sums = [0.0; 4];
        for i in 0..40_000 {
            let mut w = Wavelengths::sample((i as f32 + 0.5) / 40_000.0);
            w.terminate_secondary();
            bands.add(Spectrum(w.lambda.map(|l| 0.01 * l)), &w, 1.0, &mut sums);
        }
        assert!((sums[0] / sums[1] - 4.775).abs() < 0.01, "{sums:?}");
    }
}
