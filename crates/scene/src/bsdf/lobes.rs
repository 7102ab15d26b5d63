//! Classes of scattering.

use std::ops::{BitAnd, BitOr};

/// A set of scattering classes. A sampled lobe is a set of one; as an argument it says which
/// classes take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// No class.
    pub const NONE: Lobes = Lobes(0);
    /// Diffuse reflection.
    pub const DIFFUSE_REFLECTION: Lobes = Lobes(1);
    /// Diffuse transmission.
    pub const DIFFUSE_TRANSMISSION: Lobes = Lobes(2);
    /// Glossy reflection.
    pub const GLOSSY_REFLECTION: Lobes = Lobes(4);
    /// Glossy transmission.
    pub const GLOSSY_TRANSMISSION: Lobes = Lobes(8);
    /// Mirror reflection: a Dirac distribution.
    pub const DELTA_REFLECTION: Lobes = Lobes(16);
    /// Ideal refraction: a Dirac distribution.
    pub const DELTA_TRANSMISSION: Lobes = Lobes(32);
    /// Passing straight through, as if there were nothing: a Dirac distribution.
    pub const NULL: Lobes = Lobes(64);
    /// Diffuse, both sides.
    pub const DIFFUSE: Lobes = Lobes(1 | 2);
    /// Glossy, both sides.
    pub const GLOSSY: Lobes = Lobes(4 | 8);
    /// Every class but the diffuse: the S of path classes.
    pub const SPECULAR: Lobes = Lobes(4 | 8 | 16 | 32 | 64);
    /// Every Dirac class.
    pub const DELTA: Lobes = Lobes(16 | 32 | 64);
    /// Every class with a density, so that light sampling can find it.
    pub const SMOOTH: Lobes = Lobes(1 | 2 | 4 | 8);
    /// Every reflection.
    pub const REFLECTION: Lobes = Lobes(1 | 4 | 16);
    /// Every transmission, passing straight through included.
    pub const TRANSMISSION: Lobes = Lobes(2 | 8 | 32 | 64);
    /// Every class.
    pub const ALL: Lobes = Lobes(127);

    /// True if the sets share a class.
    #[inline]
    pub const fn has(self, o: Lobes) -> bool {
        self.0 & o.0 != 0
    }

    /// True if every class of `o` is in this set.
    #[inline]
    pub const fn contains(self, o: Lobes) -> bool {
        self.0 & o.0 == o.0
    }

    /// The classes in it, one by one.
    pub fn classes(self) -> impl Iterator<Item = Lobes> {
        (0..7).map(|bit| Lobes(1 << bit)).filter(move |&c| self.has(c))
    }

    /// True if there is no class in it.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl BitOr for Lobes {
    type Output = Lobes;
    #[inline]
    fn bitor(self, o: Lobes) -> Lobes {
        Lobes(self.0 | o.0)
    }
}

impl BitAnd for Lobes {
    type Output = Lobes;
    #[inline]
    fn bitand(self, o: Lobes) -> Lobes {
        Lobes(self.0 & o.0)
    }
}
