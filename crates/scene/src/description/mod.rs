//! What a scene file says, free of any file format: the readers' output, the builder's input.

mod bitmap;
mod mesh;

pub use bitmap::{Bitmap, Encoding, Texels};
pub use mesh::{MeshAttribute, TriMesh};
