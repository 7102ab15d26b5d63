//! Image textures: wrap modes, nearest, bilinear and trilinear filtering.
//!
//! Texel (i, j) is centred at ((i + ½)/width, (j + ½)/height) with j counted from the bottom
//! row, so that v runs up as in a picture.

use super::mapping::{self, Mapped};
use super::{TexturePoint, uplift};
use crate::description::{
    Bitmap, BitmapChannels, BitmapFilter, BitmapTexture, Encoding, Texels, TextureMapping, Wrap,
};
use kaustika_math::Vec2;
use kaustika_spectra::{Spectrum, SpectrumRole, Wavelengths};

/// An image texture ready for lookups.
#[derive(Debug)]
pub struct BitmapSampler {
    source: BitmapTexture,
    /// Linear value of each 8-bit code.
    decode: Box<[f32; 256]>,
    /// Coarser levels: half the size each, linear values; empty unless filtered over levels.
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

impl BitmapSampler {
    /// Prepares an image.
    pub fn new(source: BitmapTexture) -> BitmapSampler {
        let decode = decode_table(source.bitmap.encoding);
        let mut sampler = BitmapSampler { source, decode, levels: Vec::new() };
        if matches!(sampler.source.filter, BitmapFilter::Trilinear | BitmapFilter::Ewa) {
            sampler.build_levels();
        }
        sampler
    }

    /// The same image, filtered over mip maps (Williams 1983) whatever the file asks for.
    pub fn mip_mapped(&self) -> BitmapSampler {
        BitmapSampler::new(BitmapTexture { filter: BitmapFilter::Trilinear, ..self.source.clone() })
    }

    /// The colour at a point, linear sRGB (or raw data).
    pub fn rgb(&self, at: &TexturePoint) -> [f32; 3] {
        let [r, g, b, _] = self.lookup(&mapping::apply(&self.source.mapping, at));
        self.finish([r, g, b])
    }

    /// The value as a number.
    pub fn float(&self, at: &TexturePoint) -> f32 {
        self.number(self.lookup(&mapping::apply(&self.source.mapping, at)))
    }

    /// The value as a spectrum in the given role; raw data and single channels are flat.
    pub fn spectrum(
        &self,
        at: &TexturePoint,
        role: SpectrumRole,
        lambda: &Wavelengths,
    ) -> Spectrum {
        match self.source.channels {
            BitmapChannels::Color if !self.source.raw => uplift(role, self.rgb(at), lambda),
            BitmapChannels::Color => Spectrum::from_rgb(self.rgb(at)),
            _ => Spectrum::splat(self.float(at)),
        }
    }

    /// (∂/∂u, ∂/∂v) of [`BitmapSampler::float`], exact for bilinear interpolation.
    pub fn gradient(&self, at: &TexturePoint) -> Vec2 {
        let m = mapping::apply(&self.source.mapping, at);
        let (w, h) = self.size(0);
        let (x, y) = (m.st.x * w as f32 - 0.5, m.st.y * h as f32 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let value = |di, dj| self.number(self.texel(0, i + di, j + dj));
        let (v00, v10, v01, v11) = (value(0, 0), value(1, 0), value(0, 1), value(1, 1));
        let ds = ((v10 - v00) * (1.0 - fy) + (v11 - v01) * fy) * w as f32;
        let dt = ((v01 - v00) * (1.0 - fx) + (v11 - v10) * fx) * h as f32;
        match &self.source.mapping {
            TextureMapping::Uv(a) => {
                Vec2::new(a.m[0][0] * ds + a.m[1][0] * dt, a.m[0][1] * ds + a.m[1][1] * dt)
            }
            _ => Vec2::new(ds, dt),
        }
    }

    fn number(&self, c: [f32; 4]) -> f32 {
        let [r, g, b] = self.finish([c[0], c[1], c[2]]);
        match self.source.channels {
            BitmapChannels::Color | BitmapChannels::Mean => (r + g + b) / 3.0,
            BitmapChannels::Luminance => 0.2126 * r + 0.7152 * g + 0.0722 * b,
            BitmapChannels::Alpha | BitmapChannels::Channel(3) => c[3],
            BitmapChannels::Channel(i) => [r, g, b][i.min(2) as usize],
        }
    }

    fn finish(&self, mut c: [f32; 3]) -> [f32; 3] {
        if !self.source.raw {
            c = self.source.space.to_srgb(c);
        }
        let s = self.source.scale;
        if self.source.invert { c.map(|v| s * (1.0 - v).max(0.0)) } else { c.map(|v| s * v) }
    }

    fn lookup(&self, m: &Mapped) -> [f32; 4] {
        match self.source.filter {
            BitmapFilter::Nearest => {
                let (w, h) = self.size(0);
                let cell = |t: f32, n: u32| (t * n as f32).floor() as i64;
                self.texel(0, cell(m.st.x, w), cell(m.st.y, h))
            }
            BitmapFilter::Bilinear => self.bilinear(0, m.st),
            BitmapFilter::Trilinear | BitmapFilter::Ewa => {
                let (w, h) = self.size(0);
                let texels = (m.width * w.max(h) as f32).max(1e-8);
                let level = texels.log2().clamp(0.0, self.levels.len() as f32);
                let (coarse, t) = (level.floor(), level - level.floor());
                let fine = self.bilinear(coarse as usize, m.st);
                if t == 0.0 || coarse as usize >= self.levels.len() {
                    return fine;
                }
                let next = self.bilinear(coarse as usize + 1, m.st);
                std::array::from_fn(|i| fine[i] * (1.0 - t) + next[i] * t)
            }
        }
    }

    fn bilinear(&self, level: usize, st: Vec2) -> [f32; 4] {
        let (w, h) = self.size(level);
        let (x, y) = (st.x * w as f32 - 0.5, st.y * h as f32 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let [a, b, c, d] = self.corners(level, i, j);
        std::array::from_fn(|k| {
            (a[k] * (1.0 - fx) + b[k] * fx) * (1.0 - fy) + (c[k] * (1.0 - fx) + d[k] * fx) * fy
        })
    }

    /// The texels (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1), as [`BitmapSampler::texel`]
    /// would give them one by one: their columns and rows are wrapped once, and what kind of
    /// texels there are is asked once.
    #[inline]
    fn corners(&self, level: usize, i: i64, j: i64) -> [[f32; 4]; 4] {
        let (w, h) = self.size(level);
        let columns = wrap_pair(i, w as i64, self.source.wrap[0]);
        let rows = wrap_pair(j, h as i64, self.source.wrap[1]);
        let ([Some(i0), Some(i1)], [Some(j0), Some(j1)]) = (columns, rows) else {
            let (right, up) = (i.saturating_add(1), j.saturating_add(1));
            return [(i, j), (right, j), (i, up), (right, up)]
                .map(|(i, j)| self.texel(level, i, j));
        };
        let [row0, row1] = [j0, j1].map(|j| (h as usize - 1 - j) * w as usize);
        let indices = [row0 + i0, row0 + i1, row1 + i0, row1 + i1];
        match level {
            0 => fetch_four(&self.source.bitmap, &self.decode, indices),
            n => {
                let texels = &self.levels[n - 1].texels;
                let [a, b, c, d] = indices;
                [texels[a], texels[b], texels[c], texels[d]]
            }
        }
    }

    fn size(&self, level: usize) -> (u32, u32) {
        match level {
            0 => (self.source.bitmap.width, self.source.bitmap.height),
            n => (self.levels[n - 1].width, self.levels[n - 1].height),
        }
    }

    /// Linear value of the texel in column `i` and row `j` from the bottom, wrapped.
    fn texel(&self, level: usize, i: i64, j: i64) -> [f32; 4] {
        let (w, h) = self.size(level);
        let (Some(i), Some(j)) =
            (wrap(i, w as i64, self.source.wrap[0]), wrap(j, h as i64, self.source.wrap[1]))
        else {
            return [0.0, 0.0, 0.0, 1.0];
        };
        let index = (h as usize - 1 - j) * w as usize + i;
        match level {
            0 => fetch(&self.source.bitmap, &self.decode, index),
            n => self.levels[n - 1].texels[index],
        }
    }

    /// Halves the image until one texel is left, by means over 2 x 2 texels (3 where a size is
    /// odd, the last row or column counting twice).
    fn build_levels(&mut self) {
        let (mut w, mut h) = self.size(0);
        let mut finer: Vec<[f32; 4]> = (0..w as usize * h as usize)
            .map(|i| fetch(&self.source.bitmap, &self.decode, i))
            .collect();
        while w > 1 || h > 1 {
            let (nw, nh) = (w.div_ceil(2), h.div_ceil(2));
            let at =
                |x: u32, y: u32| finer[y.min(h - 1) as usize * w as usize + x.min(w - 1) as usize];
            let texels: Vec<[f32; 4]> = (0..nw * nh)
                .map(|k| {
                    let (x, y) = (2 * (k % nw), 2 * (k / nw));
                    let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                    std::array::from_fn(|c| 0.25 * four.iter().map(|t| t[c]).sum::<f32>())
                })
                .collect();
            self.levels.push(Level { width: nw, height: nh, texels: texels.clone() });
            (w, h, finer) = (nw, nh, texels);
        }
    }
}

/// The linear RGB of every texel, row 0 at the top (for environment maps).
pub fn linear_rgb(bitmap: &Bitmap) -> Vec<[f32; 3]> {
    let decode = decode_table(bitmap.encoding);
    (0..bitmap.width as usize * bitmap.height as usize)
        .map(|i| {
            let [r, g, b, _] = fetch(bitmap, &decode, i);
            [r, g, b]
        })
        .collect()
}

/// Linear value of each 8-bit code.
fn decode_table(encoding: Encoding) -> Box<[f32; 256]> {
    Box::new(std::array::from_fn(|code| linear(code as f32 / 255.0, encoding)))
}

#[inline]
fn wrap(i: i64, n: i64, mode: Wrap) -> Option<usize> {
    // Nearly always, and without a division.
    if (0..n).contains(&i) {
        return Some(i as usize);
    }
    let w = match mode {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Black => return None,
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    };
    Some(w as usize)
}

/// [`wrap`] of `i` and `i` + 1: nearly always neighbours within the image, and no division.
#[inline]
fn wrap_pair(i: i64, n: i64, mode: Wrap) -> [Option<usize>; 2] {
    let next = i.saturating_add(1);
    if i >= 0 && next < n {
        return [Some(i as usize), Some(next as usize)];
    }
    if mode == Wrap::Repeat {
        let first = i.rem_euclid(n);
        let second = if first + 1 < n { first + 1 } else { 0 };
        return [Some(first as usize), Some(second as usize)];
    }
    [wrap(i, n, mode), wrap(next, n, mode)]
}

/// [`fetch`] of four texels; of the two usual kinds of images without asking four times.
#[inline]
fn fetch_four(bitmap: &Bitmap, decode: &[f32; 256], indices: [usize; 4]) -> [[f32; 4]; 4] {
    let [a, b, c, d] = indices;
    match (&bitmap.texels, bitmap.channels) {
        (Texels::U8(t), 3) => {
            [rgb8(t, decode, a), rgb8(t, decode, b), rgb8(t, decode, c), rgb8(t, decode, d)]
        }
        (Texels::U8(t), 1) => {
            [grey8(t, decode, a), grey8(t, decode, b), grey8(t, decode, c), grey8(t, decode, d)]
        }
        _ => indices.map(|index| fetch(bitmap, decode, index)),
    }
}

#[inline(always)]
fn rgb8(texels: &[u8], decode: &[f32; 256], index: usize) -> [f32; 4] {
    let t = &texels[3 * index..3 * index + 3];
    [decode[usize::from(t[0])], decode[usize::from(t[1])], decode[usize::from(t[2])], 1.0]
}

#[inline(always)]
fn grey8(texels: &[u8], decode: &[f32; 256], index: usize) -> [f32; 4] {
    let v = decode[usize::from(texels[index])];
    [v, v, v, 1.0]
}

/// Linear (r, g, b, alpha) of a texel.
#[inline]
fn fetch(bitmap: &Bitmap, decode: &[f32; 256], index: usize) -> [f32; 4] {
    match (&bitmap.texels, bitmap.channels) {
        (Texels::U8(t), 3) => rgb8(t, decode, index),
        (Texels::U8(t), 1) => grey8(t, decode, index),
        _ => fetch_any(bitmap, decode, index),
    }
}

/// As [`fetch`], channel by channel.
#[inline(never)]
fn fetch_any(bitmap: &Bitmap, decode: &[f32; 256], index: usize) -> [f32; 4] {
    let n = bitmap.channels as usize;
    let at = index * n;
    let alpha_channel = n == 2 || n == 4;
    let channel = |c: usize| -> f32 {
        let is_alpha = alpha_channel && c == n - 1;
        match &bitmap.texels {
            Texels::U8(t) if is_alpha => t[at + c] as f32 / 255.0,
            Texels::U8(t) => decode[t[at + c] as usize],
            Texels::U16(t) if is_alpha => t[at + c] as f32 / 65535.0,
            Texels::U16(t) => linear(t[at + c] as f32 / 65535.0, bitmap.encoding),
            Texels::F32(t) if is_alpha => t[at + c],
            Texels::F32(t) => linear(t[at + c], bitmap.encoding),
        }
    };
    match n {
        1 => [channel(0), channel(0), channel(0), 1.0],
        2 => [channel(0), channel(0), channel(0), channel(1)],
        3 => [channel(0), channel(1), channel(2), 1.0],
        _ => [channel(0), channel(1), channel(2), channel(3)],
    }
}

fn linear(v: f32, encoding: Encoding) -> f32 {
    match encoding {
        Encoding::Linear => v,
        Encoding::Srgb => kaustika_spectra::srgb_to_linear(v),
        Encoding::Gamma(g) => v.max(0.0).powf(g),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Vec3;
    use std::sync::Arc;

    fn sampler(filter: BitmapFilter, wrap: Wrap) -> BitmapSampler {
        // Top row 0, 1; bottom row 2, 3.
        let texels = Texels::F32(vec![0.0, 1.0, 2.0, 3.0]);
        let bitmap =
            Bitmap { width: 2, height: 2, channels: 1, texels, encoding: Encoding::Linear };
        BitmapSampler::new(BitmapTexture {
            bitmap: Arc::new(bitmap),
            channels: BitmapChannels::Mean,
            filter,
            wrap: [wrap; 2],
            mapping: TextureMapping::default(),
            scale: 1.0,
            invert: false,
            raw: true,
            space: Default::default(),
        })
    }

    fn at(u: f32, v: f32) -> TexturePoint {
        TexturePoint {
            p: Vec3::ZERO,
            n: Vec3::Z,
            uv: Vec2::new(u, v),
            uv_width: 0.0,
            triangle: u32::MAX,
            barycentrics: Vec2::ZERO,
        }
    }

    #[test]
    fn v_runs_up_and_texels_are_centred() {
        let s = sampler(BitmapFilter::Bilinear, Wrap::Clamp);
        assert_eq!(s.float(&at(0.25, 0.25)), 2.0);
        assert_eq!(s.float(&at(0.75, 0.75)), 1.0);
        assert_eq!(s.float(&at(0.5, 0.5)), 1.5);
        assert_eq!(s.float(&at(-3.0, 9.0)), 0.0);
        let n = sampler(BitmapFilter::Nearest, Wrap::Repeat);
        assert_eq!(n.float(&at(1.1, -0.1)), 0.0);
        let m = sampler(BitmapFilter::Nearest, Wrap::Mirror);
        assert_eq!(m.float(&at(1.1, 0.1)), 3.0);
        let b = sampler(BitmapFilter::Nearest, Wrap::Black);
        assert_eq!(b.float(&at(1.1, 0.1)), 0.0);
    }

    #[test]
    fn gradients_are_those_of_the_interpolation() {
        let s = sampler(BitmapFilter::Bilinear, Wrap::Repeat);
        for (u, v) in [(0.4, 0.6), (0.1, 0.9), (0.55, 0.35)] {
            let h = 1e-3;
            let g = s.gradient(&at(u, v));
            let du = (s.float(&at(u + h, v)) - s.float(&at(u - h, v))) / (2.0 * h);
            let dv = (s.float(&at(u, v + h)) - s.float(&at(u, v - h))) / (2.0 * h);
            assert!((g - Vec2::new(du, dv)).length() < 1e-2, "{g:?} {du} {dv}");
        }
    }

    #[test]
    fn corners_are_the_texels_one_by_one() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::Mirror] {
            for channels in 1..=4usize {
                let (w, h) = (3usize, 2usize);
                let codes: Vec<u8> = (0..w * h * channels).map(|k| (k * 37 % 256) as u8).collect();
                let floats = codes.iter().map(|&c| c as f32).collect();
                for texels in [Texels::U8(codes), Texels::F32(floats)] {
                    let mut s = sampler(BitmapFilter::Bilinear, wrap);
                    s.source.bitmap = Arc::new(Bitmap {
                        width: w as u32,
                        height: h as u32,
                        channels: channels as u32,
                        texels,
                        encoding: Encoding::Srgb,
                    });
                    s.decode = decode_table(Encoding::Srgb);
                    for (i, j) in (-8..8).flat_map(|i| (-8..8).map(move |j| (i, j))) {
                        let one_by_one = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
                        let want = one_by_one.map(|(i, j)| s.texel(0, i, j));
                        assert_eq!(s.corners(0, i, j), want, "{wrap:?} {channels} {i} {j}");
                    }
                }
            }
        }
    }

    #[test]
    fn wide_footprints_see_the_mean() {
        let s = sampler(BitmapFilter::Trilinear, Wrap::Repeat);
        let wide = TexturePoint { uv_width: 8.0, ..at(0.1, 0.2) };
        assert_eq!(s.float(&wide), 1.5);
    }
}
