//! S of paths: what lies between two matte surfaces.

use kaustika_scene::bsdf::Lobes;

/// Which lobes take light on from one matte surface to the next, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// Which; what goes straight through is always among them.
    pub lobes: Lobes,
    /// How often at most.
    pub most: u32,
}

impl Chain {
    /// S*: whatever is not diffuse.
    pub const ANY: Chain = Chain { lobes: Lobes::SPECULAR, most: u32::MAX };
    /// S_M*: mirrors and clear glass.
    pub const MIRRORS: Chain = Chain { lobes: Lobes::DELTA, most: u32::MAX };
    /// Nothing.
    pub const NONE: Chain = Chain { lobes: Lobes::NULL, most: 0 };

    /// The lobes that may follow after so many.
    pub fn after(self, count: u32) -> Lobes {
        if count < self.most { self.lobes } else { Lobes::NULL }
    }
}
