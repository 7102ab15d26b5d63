//! Images: files, data URIs and buffer views, decoded together.

use super::buffers::{Buffers, inline, path_of};
use super::json::{Fault, Json};
use kaustika_film::files::{bitmap_from_bytes, read_bitmap};
use kaustika_scene::description::{Bitmap, Encoding};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Extensions of textures with images that are not read; the plain image beside them is.
pub(super) const KNOWN: &[&str] =
    &["EXT_texture_avif", "EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"];

/// The images that textures name, and those with another curve than the file's.
pub(super) struct Images {
    decoded: Vec<Option<Result<Arc<Bitmap>, Fault>>>,
    linear: HashMap<usize, Arc<Bitmap>>,
}

/// Where an image's bytes are.
enum Source<'b> {
    File(PathBuf),
    Bytes(Vec<u8>),
    View(&'b [u8]),
}

impl Images {
    /// Decodes every image that a texture names.
    pub fn new(root: &Json, buffers: &Buffers) -> Result<Images, Fault> {
        let images = root.list("images")?;
        let mut used = vec![false; images.len()];
        for t in root.list("textures")? {
            if let Some(i) = t.get("source").and_then(|s| s.whole().ok())
                && let Some(u) = used.get_mut(i)
            {
                *u = true;
            }
        }
        let sources: Vec<_> = images
            .iter()
            .zip(used)
            .map(|(image, used)| used.then(|| source(image, buffers)))
            .collect();
        let decoded = images
            .iter()
            .zip(sources)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(image, source)| source.map(|s| decode(&image.path, s?)))
            .collect();
        Ok(Images { decoded, linear: HashMap::new() })
    }

    /// An image by number, its numbers as they are or with the sRGB curve.
    pub fn get(&mut self, i: usize, linear: bool) -> Option<Result<Arc<Bitmap>, Fault>> {
        let bitmap = match self.decoded.get(i)?.as_ref()? {
            Ok(bitmap) => bitmap.clone(),
            Err(fault) => return Some(Err(fault.clone())),
        };
        if !linear || bitmap.encoding == Encoding::Linear {
            return Some(Ok(bitmap));
        }
        let recoded = self.linear.entry(i).or_insert_with(|| {
            Arc::new(Bitmap { encoding: Encoding::Linear, ..bitmap.as_ref().clone() })
        });
        Some(Ok(recoded.clone()))
    }
}

fn source<'b>(image: &Json, buffers: &'b Buffers) -> Result<Source<'b>, Fault> {
    if let Some(uri) = image.get("uri") {
        let text = uri.text().ok_or_else(|| uri.fault("expected text"))?;
        return match inline(&uri, text) {
            Some(bytes) => bytes.map(Source::Bytes),
            None => Ok(Source::File(path_of(&buffers.folder, text))),
        };
    }
    match image.refer("bufferView", buffers.views(), "buffer view")? {
        Some((_, view)) => buffers.view(view).map(Source::View),
        None => Err(image.fault("neither `uri` nor `bufferView` says where it is")),
    }
}

fn decode(path: &str, source: Source) -> Result<Arc<Bitmap>, Fault> {
    let bitmap = match &source {
        Source::File(file) => read_bitmap(file),
        Source::Bytes(bytes) => bitmap_from_bytes("image", bytes),
        Source::View(bytes) => bitmap_from_bytes("image", bytes),
    };
    bitmap.map(Arc::new).map_err(|e| Fault {
        path: path.into(),
        message: format!("can't read {e}"),
        hint: None,
        severity: kaustika_scene::description::Severity::Error,
    })
}
