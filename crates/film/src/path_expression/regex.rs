//! Regular expressions over the events of a path, camera first.

use super::{Event, Kind, Source, Way};

/// A set of events, as [`symbol`] numbers them; lights of a name of their own are told by
/// [`Symbols::label`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Symbols {
    /// One bit a symbol.
    pub(super) bits: u32,
    /// Only lights of this name.
    pub(super) label: Option<String>,
}

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Regex {
    /// One event of any of these sets, or of none if `not`.
    One { sets: Vec<Symbols>, not: bool },
    /// One after the other.
    Cat(Vec<Regex>),
    /// One of them.
    Or(Vec<Regex>),
    /// So many times or more, up to a number or without a limit.
    Repeat(Box<Regex>, u32, Option<u32>),
}

/// The camera.
pub(super) const CAMERA: u32 = 1;
/// `V`.
pub(super) const VOLUME: u32 = 1 << 7;
/// All lights.
pub(super) const LIGHTS: u32 = 0b1111 << FIRST_LIGHT;
/// All symbols.
pub(super) const ALL: u32 = (1 << (FIRST_LIGHT + 4)) - 1;
/// Number of the first light's symbol.
pub(super) const FIRST_LIGHT: u32 = 8;

/// The number of an event's symbol.
pub(super) fn symbol(event: Event) -> u32 {
    match event {
        Event::Volume => 7,
        Event::Surface(way, kind) => {
            let way = match way {
                Way::Reflection => 0,
                Way::Transmission => 3,
            };
            let kind = match kind {
                Kind::Diffuse => 1,
                Kind::Glossy => 2,
                Kind::Singular => 3,
            };
            way + kind
        }
    }
}

/// The number of a light's symbol, if it has no name that any expression asks for.
pub(super) fn light_symbol(source: Source) -> u32 {
    FIRST_LIGHT
        + match source {
            Source::Lamp => 0,
            Source::Surface => 1,
            Source::Background => 2,
            Source::Medium => 3,
        }
}

/// The bits of surface events of these ways (R 1, T 2) and kinds (D 1, G 2, S 4).
pub(super) fn surfaces(ways: u32, kinds: u32) -> u32 {
    let of_way = |way: u32| if ways & way != 0 { kinds } else { 0 };
    (of_way(1) << 1) | (of_way(2) << 4)
}

impl Regex {
    /// One event out of a set.
    pub(super) fn any(bits: u32) -> Regex {
        Regex::One { sets: vec![Symbols { bits, label: None }], not: false }
    }

    /// The same paths from the other end.
    pub(super) fn reversed(self) -> Regex {
        match self {
            Regex::One { .. } => self,
            Regex::Cat(parts) => Regex::Cat(parts.into_iter().rev().map(Regex::reversed).collect()),
            Regex::Or(parts) => Regex::Or(parts.into_iter().map(Regex::reversed).collect()),
            Regex::Repeat(part, from, to) => Regex::Repeat(Box::new(part.reversed()), from, to),
        }
    }

    /// Calls `each` with the names of lights that it asks for.
    pub(super) fn labels<'a>(&'a self, each: &mut impl FnMut(&'a str)) {
        match self {
            Regex::One { sets, .. } => {
                sets.iter().filter_map(|s| s.label.as_deref()).for_each(each)
            }
            Regex::Cat(parts) | Regex::Or(parts) => parts.iter().for_each(|p| p.labels(each)),
            Regex::Repeat(part, ..) => part.labels(each),
        }
    }
}
