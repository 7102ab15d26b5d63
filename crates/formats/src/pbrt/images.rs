//! Images that a scene names: found, loaded at once, and read in the curve pbrt reads them in.

use super::build::Builder;
use super::entity::Entity;
use super::param::{ParamType, Text};
use crate::resources;
use kaustika_scene::description::{Bitmap, Encoding, Texels};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The loaded images by path, also with other curves than their files'.
#[derive(Debug, Default)]
pub(super) struct Images {
    loaded: HashMap<PathBuf, Result<Arc<Bitmap>, String>>,
    recoded: Vec<(PathBuf, Arc<Bitmap>)>,
}

impl Builder {
    /// Loads all images that entities name, in parallel.
    pub fn load_images(&mut self) {
        let mut names = Vec::new();
        let mut collect = |e: &Entity, name: &str| {
            let all = e.params.own.iter().chain(&e.params.inherited);
            let same = all.filter(|p| p.name == name && p.ty == ParamType::String);
            names.extend(same.filter_map(|p| p.strings().first().cloned()));
        };
        for t in self.scene.textures.iter().filter(|t| t.entity.kind.text == "imagemap") {
            collect(&t.entity, "filename");
        }
        for m in &self.scene.materials {
            collect(m, "normalmap");
        }
        for m in &self.scene.named_materials {
            collect(&m.entity, "normalmap");
        }
        for l in &self.scene.lights {
            collect(&l.entity, "filename");
            collect(&l.entity, "mapname");
        }
        for l in &self.scene.area_lights {
            collect(l, "filename");
        }
        let mut paths: Vec<PathBuf> = names.iter().filter_map(|n| self.find_file(n)).collect();
        paths.sort_unstable();
        paths.dedup();
        let results = resources::load_bitmaps(&paths);
        self.images.loaded = paths.into_iter().zip(results).collect();
    }

    /// An image as its file has it; an error if it can't be read.
    pub fn image(&mut self, name: &Text) -> Option<Arc<Bitmap>> {
        let path = self.file(name, "image")?;
        let cause = match self.images.loaded.get(&path) {
            Some(Ok(bitmap)) => return Some(bitmap.clone()),
            Some(Err(cause)) => cause.clone(),
            None => format!("{}: it was not loaded", path.display()),
        };
        let message = format!("can't read image {cause}");
        self.desc.diagnostics.error(name.span, message);
        None
    }

    /// An image of data or with the curve a parameter asks for. As in pbrt-v4 only PNG files
    /// listen to that (image.cpp, Image::Read).
    pub fn image_with(&mut self, name: &Text, encoding: Encoding) -> Option<Arc<Bitmap>> {
        let bitmap = self.image(name)?;
        let path = self.find_file(name)?;
        let png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if !png || bitmap.encoding == encoding {
            return Some(bitmap);
        }
        let mut known = self.images.recoded.iter();
        if let Some((_, b)) = known.find(|(p, b)| *p == path && b.encoding == encoding) {
            return Some(b.clone());
        }
        let recoded = Arc::new(Bitmap { encoding, ..(*bitmap).clone() });
        self.images.recoded.push((path, recoded.clone()));
        Some(recoded)
    }
}

/// A linear component of a texel; images of one or two channels are grey.
pub(super) fn texel(b: &Bitmap, x: u32, y: u32, c: u32) -> f32 {
    let c = if b.channels < 3 { 0 } else { c };
    let i = (y as usize * b.width as usize + x as usize) * b.channels as usize + c as usize;
    let stored = match &b.texels {
        Texels::U8(v) => v.get(i).map_or(0.0, |&v| v as f32 / 255.0),
        Texels::U16(v) => v.get(i).map_or(0.0, |&v| v as f32 / 65535.0),
        Texels::F32(v) => v.get(i).copied().unwrap_or(0.0),
    };
    match b.encoding {
        Encoding::Linear => stored,
        Encoding::Srgb => kaustika_spectra::srgb_to_linear(stored),
        Encoding::Gamma(g) => stored.powf(g),
    }
}

/// Luminance of a texel, Rec. 709.
pub(super) fn luminance(b: &Bitmap, x: u32, y: u32) -> f32 {
    0.2126 * texel(b, x, y, 0) + 0.7152 * texel(b, x, y, 1) + 0.0722 * texel(b, x, y, 2)
}

/// Mean over an image of a function of the texel.
pub(super) fn mean(b: &Bitmap, f: impl Fn(u32, u32) -> f32) -> f32 {
    let sum: f64 = (0..b.height)
        .flat_map(|y| (0..b.width).map(move |x| (x, y)))
        .map(|(x, y)| f(x, y) as f64)
        .sum();
    (sum / (b.width as f64 * b.height as f64)) as f32
}

/// True if every number is finite, as light sources need.
pub(super) fn is_finite(b: &Bitmap) -> bool {
    match &b.texels {
        Texels::F32(v) => v.iter().all(|v| v.is_finite()),
        _ => true,
    }
}
