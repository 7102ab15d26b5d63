//! From passes to an image: sums that do not depend on who computed which pass.
//!
//! A render is a sequence of passes. Each is one [`PassImage`]; [`PassTree`] sums them in an
//! aligned binary tree over the pass index, so that the sum of passes A..B has the same bits
//! whether they were computed in one run, in an interrupted and resumed one, or on several
//! machines and merged.

mod bands;
mod layers;
mod pass;
mod total;
mod tree;

pub use bands::Bands;
pub use layers::{Feature, Layers};
pub use pass::{PassImage, PixelBand, PixelRecord};
pub use total::Total;
pub use tree::{MergeError, Node, PassTree};
