//! Which layers share paths, which paths are no layer's, and the shortest path that shows it.
//!
//! ```text
//! δ(F, event) = F′ over sets of states F;   layers of F·light = {k : F′ ∩ ends of k ≠ ∅}    (1)
//! ```
//!
//! The sets of states that the automata of all expressions can be in at the same time are few and
//! numbered (Rabin & Scott 1959), so a search over them, shortest paths first, has seen every
//! path there is: what no path shows there no path shows at all.

use super::{Event, Front, Kind, PathClasses, Source, Way};
use std::collections::{BTreeMap, HashSet, VecDeque};
use std::fmt;

/// A path by what happens on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// What happens, from the camera.
    pub events: Vec<Event>,
    /// The light.
    pub source: Source,
    /// Its name, if expressions ask for it.
    pub label: Option<String>,
}

/// Events at surfaces, in the order in which they are tried: the plainest words come first.
const SURFACES: [Event; 6] = [
    Event::Surface(Way::Reflection, Kind::Diffuse),
    Event::Surface(Way::Reflection, Kind::Glossy),
    Event::Surface(Way::Reflection, Kind::Singular),
    Event::Surface(Way::Transmission, Kind::Diffuse),
    Event::Surface(Way::Transmission, Kind::Glossy),
    Event::Surface(Way::Transmission, Kind::Singular),
];

/// Lights, but for media that glow.
const LIGHTS: [Source; 3] = [Source::Surface, Source::Lamp, Source::Background];

impl PathClasses {
    /// Every set of layers, one bit each, that some path without media belongs to, and to no others,
    /// with a shortest such path. Sets that are not there have none.
    pub fn sets(&self) -> BTreeMap<u32, Word> {
        let labels = || [None].into_iter().chain((0..self.labels().len()).map(Some));
        let mut found = BTreeMap::new();
        let mut known = HashSet::from([self.camera()]);
        let mut queue = VecDeque::from([(self.camera(), Vec::new())]);
        while let Some((front, events)) = queue.pop_front() {
            for (source, label) in LIGHTS.into_iter().flat_map(|s| labels().map(move |l| (s, l))) {
                let set = self.met(front, self.light(source, label)); // (1)
                let label = || label.map(|l| self.labels()[l].clone());
                let word = || Word { events: events.clone(), source, label: label() };
                found.entry(set).or_insert_with(word);
            }
            for event in SURFACES {
                let next: Front = self.onward(front, event);
                if known.insert(next) {
                    let longer = events.iter().copied().chain([event]).collect();
                    queue.push_back((next, longer));
                }
            }
        }
        found
    }
}

impl fmt::Display for Word {
    /// In Heckbert's letters from the light to the eye, then in OSL's from the camera.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("`L")?;
        for event in self.events.iter().rev() {
            f.write_str(match event {
                Event::Surface(_, Kind::Diffuse) => "D",
                Event::Surface(_, Kind::Glossy) => "S",
                Event::Surface(_, Kind::Singular) => "S_M",
                Event::Volume => "V",
            })?;
        }
        f.write_str("E` (from the camera `C")?;
        for event in &self.events {
            match event {
                Event::Surface(way, kind) => {
                    let way = if *way == Way::Reflection { 'R' } else { 'T' };
                    let kind = match kind {
                        Kind::Diffuse => 'D',
                        Kind::Glossy => 'G',
                        Kind::Singular => 'S',
                    };
                    write!(f, "<{way}{kind}>")?;
                }
                Event::Volume => f.write_str("V")?,
            }
        }
        let light = match self.source {
            Source::Lamp => 'L',
            Source::Surface | Source::Medium => 'O',
            Source::Background => 'B',
        };
        match &self.label {
            Some(label) => write!(f, "<{light}.'{label}'>`)"),
            None => write!(f, "{light}`)"),
        }
    }
}
