//! Buffers and the views into them.

use super::json::{Fault, Json};
use base64::Engine;
use std::path::{Path, PathBuf};

/// Compressions of buffer views and meshes, which are not read.
pub(super) const COMPRESSIONS: &[&str] =
    &["EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_meshopt_compression"];

/// The bytes a file refers to.
pub(super) struct Buffers<'a> {
    views: Vec<Json<'a>>,
    buffers: Vec<(Json<'a>, Result<Vec<u8>, Fault>)>,
    /// Folder of the file.
    pub folder: PathBuf,
}

/// Contents of a `data:` URI, `None` for any other.
pub(super) fn inline(at: &Json, uri: &str) -> Option<Result<Vec<u8>, Fault>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((kind, data)) = rest.split_once(',') else {
        return Some(Err(at.fault("a data URI without a comma")));
    };
    if !kind.ends_with(";base64") {
        return Some(Ok(percent_encoding::percent_decode_str(data).collect()));
    }
    let engine = base64::engine::general_purpose::GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        base64::engine::GeneralPurposeConfig::new()
            .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true),
    );
    Some(engine.decode(data).map_err(|e| at.fault(format!("a data URI of broken base64: {e}"))))
}

/// The file that a URI names.
pub(super) fn path_of(folder: &Path, uri: &str) -> PathBuf {
    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let decoded = folder.join(name.as_ref());
    // Some writers leave percent signs as they are.
    if decoded.exists() { decoded } else { folder.join(uri) }
}

impl<'a> Buffers<'a> {
    /// Loads all buffers of a file at `path`.
    pub fn new(root: &Json<'a>, path: &Path, chunk: Option<Vec<u8>>) -> Result<Buffers<'a>, Fault> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut chunk = chunk;
        let mut buffers = Vec::new();
        for (i, b) in root.list("buffers")?.into_iter().enumerate() {
            let bytes = load(&b, &folder, if i == 0 { chunk.take() } else { None });
            buffers.push((b, bytes));
        }
        Ok(Buffers { views: root.list("bufferViews")?, buffers, folder })
    }

    /// The views of the file.
    pub fn views(&self) -> &[Json<'a>] {
        &self.views
    }

    /// The bytes of a view.
    pub fn view(&self, view: &Json) -> Result<&[u8], Fault> {
        for name in COMPRESSIONS {
            if view.extension(name).is_some() {
                return Err(view
                    .fault(format!("`{name}` is not supported"))
                    .hint("write the scene without compression"));
            }
        }
        let buffer = view.require("buffer")?;
        let (_, (_, bytes)) = buffer.pick(&self.buffers, "buffer")?;
        let bytes = bytes.as_ref().map_err(Clone::clone)?;
        let offset = view.size("byteOffset", 0)?;
        let length = view.require("byteLength")?.whole()?;
        offset.checked_add(length).and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            let all = bytes.len();
            view.fault(format!("{length} bytes from byte {offset} of a buffer of {all}"))
        })
    }
}

fn load(buffer: &Json, folder: &Path, chunk: Option<Vec<u8>>) -> Result<Vec<u8>, Fault> {
    let length = buffer.require("byteLength")?.whole()?;
    let bytes = match (buffer.get("uri"), chunk) {
        (Some(uri), _) => {
            let text = uri.text().ok_or_else(|| uri.fault("expected text"))?;
            match inline(&uri, text) {
                Some(bytes) => bytes?,
                None => {
                    let path = path_of(folder, text);
                    std::fs::read(&path)
                        .map_err(|e| uri.fault(format!("can't read {}: {e}", path.display())))?
                }
            }
        }
        (None, Some(chunk)) => chunk,
        (None, None) => {
            return Err(buffer
                .fault("neither `uri` nor the binary chunk of a .glb holds its bytes")
                .hint("a .gltf file needs a `uri` for every buffer"));
        }
    };
    if bytes.len() < length {
        return Err(buffer.fault(format!("{length} bytes announced, {} found", bytes.len())));
    }
    Ok(bytes)
}
