//! Meshes and images are loaded together at the end; until then a stand-in holds their place.

use super::convert::Converter;
use crate::resources::{MeshRequest, load_bitmaps, load_meshes};
use kaustika_scene::description::{
    Bitmap, Encoding, GeometryDesc, GroupId, LightKind, SceneDescription, ShapeDesc, Span, Texels,
    TextureId, TextureNode, TriMesh,
};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Files to load and where their contents belong.
#[derive(Debug, Default)]
pub(super) struct Pending {
    meshes: Vec<(MeshRequest, Span, MeshPlace)>,
    bitmaps: Vec<(PathBuf, Span, BitmapPlace, Option<Encoding>)>,
}

/// The shape a mesh belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshPlace {
    /// `None`: a shape of the scene.
    pub group: Option<GroupId>,
    /// Number among those shapes.
    pub shape: usize,
}

/// What an image belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) enum BitmapPlace {
    /// A texture node.
    Texture(TextureId),
    /// A light, by number.
    Light(usize),
}

impl Pending {
    pub(super) fn mesh(&mut self, request: MeshRequest, span: Span, place: MeshPlace) {
        self.meshes.push((request, span, place));
    }

    /// `encoding` replaces the file's own.
    pub(super) fn bitmap(
        &mut self,
        path: PathBuf,
        span: Span,
        place: BitmapPlace,
        encoding: Option<Encoding>,
    ) {
        self.bitmaps.push((path, span, place, encoding));
    }
}

/// One black texel.
pub(super) fn no_bitmap() -> Arc<Bitmap> {
    let texels = Texels::U8(vec![0]);
    Arc::new(Bitmap { width: 1, height: 1, channels: 1, texels, encoding: Encoding::Linear })
}

impl Converter<'_> {
    /// Loads what was asked for; files that can't be read are errors where they are named.
    pub(super) fn load(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        let requests: Vec<MeshRequest> = pending.meshes.iter().map(|m| m.0.clone()).collect();
        for (result, (_, span, place)) in load_meshes(&requests).into_iter().zip(&pending.meshes) {
            match result {
                Ok(mesh) => put_mesh(&mut self.out, *place, mesh),
                Err(cause) => {
                    self.out.diagnostics.error(*span, cause);
                }
            }
        }
        let paths: Vec<PathBuf> = pending.bitmaps.iter().map(|b| b.0.clone()).collect();
        // Images whose stored numbers are read in another way than the file says.
        let mut recoded: HashMap<(PathBuf, String), Arc<Bitmap>> = HashMap::new();
        for (result, (path, span, place, encoding)) in
            load_bitmaps(&paths).into_iter().zip(&pending.bitmaps)
        {
            match result {
                Ok(bitmap) => {
                    let bitmap = match encoding {
                        Some(e) if *e != bitmap.encoding => recoded
                            .entry((path.clone(), format!("{e:?}")))
                            .or_insert_with(|| {
                                Arc::new(Bitmap { encoding: *e, ..bitmap.as_ref().clone() })
                            })
                            .clone(),
                        _ => bitmap,
                    };
                    put_bitmap(&mut self.out, *place, bitmap);
                }
                Err(cause) => {
                    self.out.diagnostics.error(*span, cause);
                }
            }
        }
    }
}

fn put_mesh(out: &mut SceneDescription, place: MeshPlace, mesh: Arc<TriMesh>) {
    let shapes: Option<&mut Vec<ShapeDesc>> = match place.group {
        None => Some(&mut out.shapes),
        Some(group) => out.groups.get_mut(group.0 as usize).map(|g| &mut g.shapes),
    };
    if let Some(shape) = shapes.and_then(|s| s.get_mut(place.shape)) {
        shape.geometry = GeometryDesc::Mesh(mesh);
    }
}

fn put_bitmap(out: &mut SceneDescription, place: BitmapPlace, loaded: Arc<Bitmap>) {
    match place {
        BitmapPlace::Texture(id) => {
            if let Some(TextureNode::Bitmap(t)) =
                out.textures.get_mut(id.0 as usize).map(|t| &mut t.node)
            {
                t.bitmap = loaded;
            }
        }
        BitmapPlace::Light(index) => {
            if let Some(LightKind::Image { bitmap, .. }) =
                out.lights.get_mut(index).map(|l| &mut l.kind)
            {
                *bitmap = loaded;
            }
        }
    }
}
