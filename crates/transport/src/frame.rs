//! What all methods share of one picture: which pixels, which samples, how light is measured.

use crate::method::{PassStats, RenderError};
use crate::workers::Workers;
use kaustika_film::accumulate::{Bands, Layers, PassImage, PixelBand, PixelRecord};
use kaustika_film::path_expression::PathClasses;
use kaustika_film::{FilterDesc, FilterSampler};
use kaustika_math::Vec2;
use kaustika_sampling::hash::combine;
use kaustika_sampling::{SamplerConfig, SamplerPlan};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};

/// The picture being rendered.
#[derive(Debug)]
pub struct Frame {
    /// Width and height of the whole picture.
    pub resolution: [u32; 2],
    /// Pixels rendered: x0, y0, x1, y1, end exclusive.
    pub region: [u32; 4],
    /// Reconstruction filter.
    pub filter: FilterSampler,
    /// The filter as described.
    pub filter_desc: FilterDesc,
    /// Where samples come from.
    pub sampler: SamplerPlan,
    /// Radiance to pixel values.
    pub sensor: Sensor,
    /// Pixel components above this are clamped: biased, only where a file asks for it.
    pub max_component: Option<f32>,
    /// Values kept for each pixel.
    pub layers: Layers,
    /// What the layers' bands are, if there are any.
    pub bands: Option<Bands>,
    /// Which paths the layers by path show, if there are such.
    pub paths: Option<PathClasses>,
}

/// A sample's place on the film.
#[derive(Clone, Copy, Debug)]
pub struct FilmSample {
    /// Position in pixels of the whole picture.
    pub film: Vec2,
    /// Filter weight.
    pub weight: f32,
}

/// A number in [0, 1) for a pass, for what all its paths share: van der Corput's, shifted.
pub fn pass_number(index: u64, seed: u64) -> f32 {
    let vdc = (index as u32).reverse_bits() >> 8;
    let shift = (combine(seed, 0x7063) >> 40) as u32;
    ((vdc + shift) & 0xff_ffff) as f32 / (1u32 << 24) as f32
}

impl Frame {
    /// The pixels of a band, row by row: column and row within the band, and in the whole picture.
    #[inline]
    pub fn places(&self, band: &PixelBand) -> impl Iterator<Item = ([u32; 2], [u32; 2])> + use<> {
        let [x0, y0] = [self.region[0], self.region[1] + band.y];
        let (width, height) = (band.width(), band.height());
        let row = move |y| (0..width).map(move |x| ([x, y], [x0 + x, y0 + y]));
        (0..height).flat_map(row)
    }

    /// Fills a pass with a sample of every pixel, cut into chunks of whole rows and at least `chunk` samples.
    /// `sample` makes the record of one pixel of the picture, with its features if they are asked for; it
    /// works in what `room` makes for each thread.
    ///
    /// # Errors
    /// As [`Workers::bands`].
    pub fn sample_pixels<R: Send>(
        &self,
        out: &mut PassImage,
        workers: &Workers,
        chunk: u32,
        room: impl Fn() -> R + Sync,
        sample: impl Fn(&mut R, [u32; 2], bool, &mut PassStats) -> PixelRecord + Sync,
    ) -> Result<PassStats, RenderError> {
        let rows = chunk.div_ceil(out.width()).max(1);
        let bands = workers.bands(out, rows, room, |room, band| {
            let mut stats = PassStats::default();
            let features = band.wants_features();
            for ([x, y], pixel) in self.places(band) {
                let record = sample(room, pixel, features, &mut stats);
                band.add(x, y, &record);
            }
            stats
        })?;
        Ok(bands.into_iter().sum())
    }

    /// A frame over the whole picture.
    pub fn new(resolution: [u32; 2], filter: FilterDesc, sampler: SamplerConfig) -> Frame {
        Frame {
            resolution,
            region: [0, 0, resolution[0], resolution[1]],
            filter: FilterSampler::new(&filter),
            filter_desc: filter,
            sampler: SamplerPlan::new(sampler),
            sensor: Sensor::default(),
            max_component: None,
            layers: Layers::default(),
            bands: None,
            paths: None,
        }
    }

    /// The same picture with other layers: of a part of its light.
    pub fn of_part(&self, layers: Layers) -> Frame {
        Frame {
            resolution: self.resolution,
            region: self.region,
            filter: self.filter.clone(),
            filter_desc: self.filter_desc,
            sampler: self.sampler.clone(),
            sensor: self.sensor,
            max_component: self.max_component,
            layers,
            bands: None,
            paths: None,
        }
    }

    /// Also keeps layers of these classes of paths.
    pub fn keep_paths(&mut self, classes: PathClasses) {
        self.paths = Some(classes);
        self.keep_layers(&[]);
    }

    /// And layers of these names that a method adds.
    pub fn keep_layers(&mut self, names: &[String]) {
        let by_path = self.paths.iter().flat_map(|c| c.layers().iter().map(|l| &l.name));
        let names = by_path.chain(names).cloned().collect();
        self.layers = std::mem::take(&mut self.layers).with_paths(names);
    }

    /// Width and height of the rendered region.
    pub fn size(&self) -> [u32; 2] {
        [self.region[2] - self.region[0], self.region[3] - self.region[1]]
    }

    /// The position of a pixel's sample, by importance sampling of the filter.
    #[inline]
    pub fn film_sample(&self, pixel: [u32; 2], u: Vec2) -> FilmSample {
        let s = self.filter.sample(u);
        let center = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
        FilmSample { film: center + s.offset, weight: s.weight }
    }

    /// Adds a path's radiance to the bands of the pixel at column `x` and row `y`, with the weight
    /// `w` of the filter. Bad numbers count as black.
    #[inline]
    pub fn add_bands(
        &self,
        band: &mut PixelBand,
        [x, y]: [u32; 2],
        w: f32,
        radiance: Spectrum,
        lambda: &Wavelengths,
    ) {
        if let Some(bands) = &self.bands {
            let radiance = if radiance.is_finite() { radiance } else { Spectrum::ZERO };
            bands.add(radiance, lambda, w, band.bands(x, y));
        }
    }

    /// What the film gets of a sample of this radiance, clamped as the file asks. What is no number is black, and
    /// counted.
    #[inline]
    pub fn rgb(&self, radiance: Spectrum, lambda: &Wavelengths, stats: &mut PassStats) -> [f32; 3] {
        let rgb = self.sensor.rgb(radiance, lambda);
        if rgb.iter().all(|v| v.is_finite()) {
            self.clamp(rgb)
        } else {
            stats.bad_samples += 1;
            [0.0; 3]
        }
    }

    /// Adds a part of a sample's radiance to its sum, which is to be clamped when it is whole. What is no number
    /// is left out, and counted.
    #[inline]
    pub fn add(
        &self,
        sum: &mut [f32; 3],
        radiance: Spectrum,
        lambda: &Wavelengths,
        stats: &mut PassStats,
    ) {
        let rgb = self.sensor.rgb(radiance, lambda);
        match rgb.iter().all(|v| v.is_finite()) {
            true => sum.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v),
            false => stats.bad_samples += 1,
        }
    }

    /// Clamps what the file asks to clamp.
    #[inline]
    pub fn clamp(&self, rgb: [f32; 3]) -> [f32; 3] {
        match self.max_component {
            Some(limit) => {
                let m = rgb[0].max(rgb[1]).max(rgb[2]);
                if m > limit { rgb.map(|v| v * (limit / m)) } else { rgb }
            }
            None => rgb,
        }
    }
}
