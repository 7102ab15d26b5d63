//! The image of one pass.

use super::{Feature, Layers};

/// One estimate of every pixel of the rendered region; additive, zero at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct PassImage {
    width: u32,
    height: u32,
    layers: Layers,
    data: Vec<f32>,
}

impl PassImage {
    /// A black image of `width` x `height` pixels.
    pub fn new(width: u32, height: u32, layers: Layers) -> PassImage {
        let data = vec![0.0; width as usize * height as usize * layers.stride()];
        PassImage { width, height, layers, data }
    }

    /// A black image in memory that served before, whatever it holds.
    pub(super) fn reusing(data: Vec<f32>, width: u32, height: u32, layers: Layers) -> PassImage {
        let mut data = data;
        data.clear();
        data.resize(width as usize * height as usize * layers.stride(), 0.0);
        PassImage { width, height, layers, data }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The layout of a pixel.
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// All numbers: pixels row by row, each [`Layers::stride`] long.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// All numbers, to be added to.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// Gives up the numbers.
    pub(super) fn into_data(self) -> Vec<f32> {
        self.data
    }

    /// Weighs all numbers but those that name something.
    pub(super) fn scale(&mut self, weight: f32, ids: &[bool]) {
        for pixel in self.data.chunks_exact_mut(self.layers.stride()) {
            let numbers = pixel.iter_mut().zip(ids).filter(|(_, names)| !**names);
            numbers.for_each(|(v, _)| *v *= weight);
        }
    }

    /// Cuts the image into bands of `rows` rows that can be filled at the same time.
    pub fn bands(&mut self, rows: u32) -> Vec<PixelBand<'_>> {
        let stride = self.layers.stride();
        let layers = &self.layers;
        let width = self.width;
        self.data
            .chunks_mut((width * rows) as usize * stride)
            .enumerate()
            .map(|(i, data)| PixelBand { y: i as u32 * rows, width, layers, stride, data })
            .collect()
    }

    /// Adds to the colour of a pixel, or to that of a layer by path, for methods whose samples
    /// choose the pixel.
    pub fn splat(&mut self, x: u32, y: u32, layer: Option<usize>, rgb: [f32; 3]) {
        let offset = layer.map_or(0, |k| self.layers.path_offset(k));
        let at = (y as usize * self.width as usize + x as usize) * self.layers.stride() + offset;
        for (d, v) in self.data[at..at + 3].iter_mut().zip(rgb) {
            *d += v;
        }
    }
}

/// Some rows of a pass.
#[derive(Debug)]
pub struct PixelBand<'a> {
    /// First row, from the top of the region.
    pub y: u32,
    width: u32,
    layers: &'a Layers,
    /// [`Layers::stride`] of `layers`.
    stride: usize,
    data: &'a mut [f32],
}

/// What one camera path contributes to its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelRecord {
    /// Sensor response, linear RGB.
    pub rgb: [f32; 3],
    /// Filter weight.
    pub weight: f32,
    /// See [`Feature::Albedo`].
    pub albedo: [f32; 3],
    /// See [`Feature::Normal`].
    pub normal: [f32; 3],
    /// See [`Feature::ShadingNormal`].
    pub shading_normal: [f32; 3],
    /// See [`Feature::Depth`].
    pub depth: f32,
    /// See [`Feature::Position`].
    pub position: [f32; 3],
    /// See [`Feature::Uv`].
    pub uv: [f32; 2],
    /// See [`Feature::ShapeId`].
    pub shape: u32,
    /// See [`Feature::MaterialId`].
    pub material: u32,
}

impl PixelBand<'_> {
    /// Rows in this band.
    pub fn height(&self) -> u32 {
        (self.data.len() / (self.width as usize * self.stride)) as u32
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// True if features are kept.
    pub fn wants_features(&self) -> bool {
        !self.layers.features().is_empty()
    }

    /// Adds a camera path to the pixel at column `x` and row `y` of the band. Everything but
    /// numbers that name something is weighted by the filter.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, r: &PixelRecord) {
        let at = (y as usize * self.width as usize + x as usize) * self.stride;
        let pixel = &mut self.data[at..at + self.stride];
        for i in 0..3 {
            pixel[i] += r.weight * r.rgb[i];
        }
        pixel[3] += r.weight;
        if self.wants_features() {
            self.add_features(at, r);
        }
    }

    /// Adds a camera path's Stokes vector, S₀ to S₃ as linear RGB, to the pixel at column `x` and
    /// row `y` of the band, with its weight of the filter; nothing if [`Feature::Stokes`] is not kept.
    pub fn add_stokes(&mut self, x: u32, y: u32, weight: f32, stokes: &[[f32; 3]; 4]) {
        let Some(offset) = self.layers.offset(Feature::Stokes) else { return };
        let at = (y as usize * self.width as usize + x as usize) * self.stride + offset;
        for (p, v) in self.data[at..at + 12].iter_mut().zip(stokes.as_flattened()) {
            *p += weight * v;
        }
    }

    /// Adds what became of a sample's paths, in the order of [`Feature::Trees`]; nothing if that is
    /// not kept.
    pub fn add_trees(&mut self, x: u32, y: u32, weight: f32, trees: [f32; 5]) {
        let Some(offset) = self.layers.offset(Feature::Trees) else { return };
        let at = (y as usize * self.width as usize + x as usize) * self.stride + offset;
        for (p, v) in self.data[at..at + 5].iter_mut().zip(trees) {
            *p += weight * v;
        }
    }

    /// The two sums of each of the bands of the pixel at column `x` and row `y`; see
    /// [`Bands::add`](super::Bands::add).
    pub fn bands(&mut self, x: u32, y: u32) -> &mut [f32] {
        let at = (y as usize * self.width as usize + x as usize) * self.stride;
        &mut self.data[at + self.layers.offset_of_bands()..at + self.stride]
    }

    /// Adds what a camera path found to the layers by path, from number `first` on, of the pixel at
    /// column `x` and row `y`, with its weight of the filter.
    pub fn add_paths(&mut self, x: u32, y: u32, weight: f32, first: usize, rgb: &[[f32; 3]]) {
        let offset = self.layers.path_offset(first);
        let at = (y as usize * self.width as usize + x as usize) * self.stride + offset;
        for (p, v) in self.data[at..at + 3 * rgb.len()].iter_mut().zip(rgb.as_flattened()) {
            *p += weight * v;
        }
    }

    /// The part of [`PixelBand::add`] that pixels of colour alone do without.
    fn add_features(&mut self, at: usize, r: &PixelRecord) {
        let pixel = &mut self.data[at..at + self.stride];
        let mut at = 4;
        for f in self.layers.features() {
            let (values, n): ([f32; 3], usize) = match f {
                Feature::Albedo => (r.albedo, 3),
                Feature::Normal => (r.normal, 3),
                Feature::ShadingNormal => (r.shading_normal, 3),
                Feature::Depth => ([r.depth, 0.0, 0.0], 1),
                Feature::Position => (r.position, 3),
                Feature::Uv => ([r.uv[0], r.uv[1], 0.0], 2),
                Feature::ShapeId => ([r.shape as f32, 0.0, 0.0], 1),
                Feature::MaterialId => ([r.material as f32, 0.0, 0.0], 1),
                // The last ones; see [`PixelBand::add_stokes`] and [`PixelBand::add_trees`].
                Feature::Stokes | Feature::Trees => break,
            };
            for (p, v) in pixel[at..at + n].iter_mut().zip(values) {
                if f.is_id() {
                    *p = v;
                } else {
                    *p += r.weight * v;
                }
            }
            at += n;
        }
    }
}
