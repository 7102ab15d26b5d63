//! A picture: named channels of floats, as renderers make and EXR files store them.

use std::fmt;

/// Named channels over one grid of pixels, with what else an image file says.
///
/// Row 0 is the top row, values are linear. Layers are name prefixes that end in a dot, as in
/// EXR: `Albedo.R`. Every channel holds `width * height` numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The channels; names are unique.
    pub channels: Vec<Channel>,
    /// Named facts about the picture, such as `samplesPerPixel`.
    pub metadata: Vec<(String, MetaValue)>,
    /// The whole frame as `[x0, y0, x1, y1]`, upper bounds exclusive, where this picture is a
    /// crop of a larger one; `None` if the frame is the picture.
    pub display_window: Option<[i32; 4]>,
    /// Column and row of the frame that pixel (0, 0) lies on.
    pub data_origin: [i32; 2],
}

/// One channel of a [`Picture`].
#[derive(Clone, PartialEq)]
pub struct Channel {
    /// Its full name, layer included: `R`, `Albedo.R`, `S0.550,938nm`.
    pub name: String,
    /// One number a pixel, row after row from the top.
    pub data: Vec<f32>,
    /// How files store it.
    pub kind: ChannelKind,
}

impl fmt::Debug for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, kind, n) = (&self.name, self.kind, self.data.len());
        write!(f, "Channel({name:?}, {kind:?}, {n} values)")
    }
}

/// Number format of a channel in an EXR file. In memory all are `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelKind {
    /// 32-bit float.
    #[default]
    Float32,
    /// 16-bit float.
    Half,
    /// 32-bit unsigned integer; above 2²⁴ the `f32` in memory rounds it.
    Uint,
}

/// The value of a metadata entry.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// Text.
    Text(String),
    /// A 32-bit integer.
    Int(i32),
    /// A 32-bit float.
    Float(f32),
    /// A 64-bit float.
    Double(f64),
    /// A 4 x 4 matrix (EXR's `M44f`), in the order of the file. pbrt and Kaustika write row
    /// after row of a matrix that acts on column vectors.
    Matrix([f32; 16]),
    /// CIE xy of red, green, blue and white.
    Chromaticities([[f32; 2]; 4]),
}

/// Red, green and blue of a picture, or one grey channel three times over.
#[derive(Clone, Copy, Debug)]
pub struct RgbView<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` numbers for each of r, g, b.
    pub channels: [&'a [f32]; 3],
}

impl RgbView<'_> {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// True if there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Pixel `i`, counted row after row.
    #[inline]
    pub fn pixel(&self, i: usize) -> [f32; 3] {
        self.channels.map(|c| c[i])
    }

    /// All pixels, row after row.
    pub fn pixels(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..self.len()).map(|i| self.pixel(i))
    }
}

impl Picture {
    /// An empty picture of this size, without channels.
    pub fn new(width: u32, height: u32) -> Self {
        Picture { width, height, ..Picture::default() }
    }

    /// A picture with the channels R, G and B.
    ///
    /// # Panics
    /// If `pixels` does not hold `width * height` entries.
    pub fn from_rgb(width: u32, height: u32, pixels: &[[f32; 3]]) -> Self {
        let mut picture = Picture::new(width, height);
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            picture.push(name, pixels.iter().map(|p| p[c]).collect());
        }
        picture
    }

    /// Adds a 32-bit float channel.
    ///
    /// # Panics
    /// If `data` does not hold `width * height` numbers.
    pub fn push(&mut self, name: impl Into<String>, data: Vec<f32>) {
        assert_eq!(data.len(), self.pixel_count(), "one number a pixel");
        self.channels.push(Channel { name: name.into(), data, kind: ChannelKind::Float32 });
    }

    /// `width * height`.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The part of this picture that `crop` shows, if that is a crop of one of this size.
    pub fn part_shown_by(&self, crop: &Picture) -> Option<Picture> {
        let [x0, y0, x1, y1] = crop.display_window?;
        let [x, y] = [crop.data_origin[0] - x0, crop.data_origin[1] - y0];
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        let whole = (x1 - x0, y1 - y0) == (self.width as i32, self.height as i32);
        if !whole || x + crop.width > self.width || y + crop.height > self.height {
            return None;
        }
        let mut part = Picture { channels: Vec::new(), ..self.clone() };
        (part.width, part.height) = (crop.width, crop.height);
        (part.data_origin, part.display_window) = (crop.data_origin, crop.display_window);
        for channel in &self.channels {
            let row = |r: u32| {
                let at = ((y + r) * self.width + x) as usize;
                channel.data[at..at + crop.width as usize].iter().copied()
            };
            let data = (0..crop.height).flat_map(row).collect();
            part.channels.push(Channel { name: channel.name.clone(), data, kind: channel.kind });
        }
        Some(part)
    }

    /// The data of the channel of exactly this name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        let found = self.channels.iter().find(|c| c.name == name)?;
        Some(&found.data)
    }

    /// The value of a metadata entry.
    pub fn meta(&self, name: &str) -> Option<&MetaValue> {
        let (_, value) = self.metadata.iter().find(|(n, _)| n == name)?;
        Some(value)
    }

    /// Sets a metadata entry, replacing one of the same name.
    pub fn set_meta(&mut self, name: impl Into<String>, value: MetaValue) {
        let name = name.into();
        self.metadata.retain(|(n, _)| *n != name);
        self.metadata.push((name, value));
    }

    /// The colour of the picture: R, G, B; else Y three times; else the only channel three
    /// times; else the R, G, B of the first layer that has them.
    pub fn rgb(&self) -> Option<RgbView<'_>> {
        let grey = |y| Some([y, y, y]);
        let channels = self
            .rgb_of_layer("")
            .or_else(|| self.channel("Y").and_then(grey))
            .or_else(|| match self.channels.as_slice() {
                [only] => grey(only.data.as_slice()),
                _ => None,
            })
            .or_else(|| {
                let mut layers = self.channels.iter().filter_map(|c| c.name.strip_suffix('R'));
                layers.find_map(|prefix| self.rgb_of_layer(prefix))
            })?;
        Some(RgbView { width: self.width as usize, height: self.height as usize, channels })
    }

    /// The channels `R`, `G`, `B` behind a prefix such as `Albedo.`.
    fn rgb_of_layer(&self, prefix: &str) -> Option<[&[f32]; 3]> {
        let find = |c: &str| self.channel(&format!("{prefix}{c}"));
        Some([find("R")?, find("G")?, find("B")?])
    }

    /// What is inconsistent, if anything: sizes of channels, names.
    pub(crate) fn defect(&self) -> Option<String> {
        if self.width == 0 || self.height == 0 {
            return Some("the picture has no pixels".into());
        }
        if self.channels.is_empty() {
            return Some("the picture has no channels".into());
        }
        for (i, channel) in self.channels.iter().enumerate() {
            let (name, n) = (&channel.name, channel.data.len());
            if n != self.pixel_count() {
                let (w, h) = (self.width, self.height);
                return Some(format!("channel '{name}' has {n} values, not {w} x {h}"));
            }
            if self.channels[..i].iter().any(|c| c.name == *name) {
                return Some(format!("two channels are named '{name}'"));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_is_found_by_name() {
        let mut p = Picture::new(1, 1);
        p.push("Albedo.R", vec![1.0]);
        p.push("Albedo.B", vec![3.0]);
        p.push("Albedo.G", vec![2.0]);
        assert_eq!(p.rgb().unwrap().pixel(0), [1.0, 2.0, 3.0]);
        p.push("Y", vec![7.0]);
        assert_eq!(p.rgb().unwrap().pixel(0), [7.0; 3]);
        for (name, v) in [("B", 6.0), ("G", 5.0), ("R", 4.0)] {
            p.push(name, vec![v]);
        }
        assert_eq!(p.rgb().unwrap().pixel(0), [4.0, 5.0, 6.0]);

        let mut depth = Picture::new(1, 1);
        depth.push("Z", vec![2.0]);
        assert_eq!(depth.rgb().unwrap().pixel(0), [2.0; 3]);
        depth.push("u", vec![2.0]);
        assert!(depth.rgb().is_none());
    }

    #[test]
    fn metadata_entries_are_replaced() {
        let mut p = Picture::new(1, 1);
        p.set_meta("spp", MetaValue::Int(1));
        p.set_meta("spp", MetaValue::Int(2));
        assert_eq!(p.metadata.len(), 1);
        assert_eq!(p.meta("spp"), Some(&MetaValue::Int(2)));
    }
}
