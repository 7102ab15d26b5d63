//! Automata that tell, for each layer, whether a path is its.
//!
//! The positions of letters in the expressions are the states (Glushkov 1961): no step is without
//! a letter, so the same states serve from both ends. A *front* is the set of states that the
//! events from the camera on lead to, a *back* the set from which the events to the light lead to
//! the end; a path is a layer's where they have a state of the layer in common. Sets are numbered
//! once and for all, so that a step is a look into a table.

use super::regex::{CAMERA, FIRST_LIGHT, LIGHTS, Regex, Symbols, light_symbol, symbol};
use super::{Event, ExpressionError, PathLayer, Source};
use std::collections::HashMap;

/// The part of a path at the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Front(u16);

/// The part of a path at the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Back(u16);

impl Front {
    /// True if no layer is interested any more.
    pub fn is_dead(self) -> bool {
        self.0 == 0
    }
}

impl Back {
    /// True if no layer is interested any more.
    pub fn is_dead(self) -> bool {
        self.0 == 0
    }
}

/// The layers of a picture as automata.
#[derive(Clone, Debug)]
pub struct PathClasses {
    layers: Vec<PathLayer>,
    /// Names of lights that expressions ask for.
    labels: Vec<String>,
    symbols: usize,
    front: Table,
    back: Table,
    /// For each front and back the layers, one bit each.
    met: Vec<u32>,
}

/// Most layers.
const MOST_LAYERS: usize = 32;
/// Most names of lights.
const MOST_LABELS: usize = 13;
/// Most positions of all expressions, their repeats written out.
const MOST_POSITIONS: usize = 4096;
/// Most numbered sets.
const MOST_SETS: usize = 4096;

impl PathClasses {
    /// For these layers.
    ///
    /// # Errors
    /// If there are too many, or names twice, or an expression is too long.
    pub fn new(layers: Vec<PathLayer>) -> Result<PathClasses, ExpressionError> {
        let fail = |layer: &PathLayer, message: &str| ExpressionError {
            message: message.into(),
            text: layer.to_string(),
            at: 0,
        };
        for (i, layer) in layers.iter().enumerate() {
            if i >= MOST_LAYERS {
                return Err(fail(layer, "there are more than 32 layers by path"));
            }
            if layers[..i].iter().any(|l| l.name == layer.name) {
                return Err(fail(layer, "two layers have the same name"));
            }
        }
        let mut labels: Vec<String> = Vec::new();
        for layer in &layers {
            layer.regex.labels(&mut |l| {
                if !labels.iter().any(|known| known == l) {
                    labels.push(l.into());
                }
            });
            if labels.len() > MOST_LABELS {
                return Err(fail(layer, "the expressions name more than 13 lights"));
            }
        }
        let mut states = States::default();
        for (i, layer) in layers.iter().enumerate() {
            if states.add(&layer.regex, i, &labels).is_none() {
                return Err(fail(layer, "the expression is too long with its repeats written out"));
            }
        }
        let symbols = FIRST_LIGHT as usize + 4 * (labels.len() + 1);
        let too_many = || match layers.last() {
            Some(layer) => fail(layer, "the expressions together are too intricate"),
            None => ExpressionError { message: "no layers".into(), text: String::new(), at: 0 },
        };
        let front = Table::new(states.starts(), symbols, |set, s| states.forward(set, s));
        let back = Table::new(states.ends(), symbols, |set, s| states.backward(set, s));
        let (front, back) = (front.ok_or_else(too_many)?, back.ok_or_else(too_many)?);
        let mut met = Vec::with_capacity(front.sets.len() * back.sets.len());
        for f in &front.sets {
            met.extend(back.sets.iter().map(|b| states.layers_of(f, b)));
        }
        Ok(PathClasses { layers, labels, symbols, front, back, met })
    }

    /// The layers.
    pub fn layers(&self) -> &[PathLayer] {
        &self.layers
    }

    /// Names of lights that the expressions ask for; [`PathClasses::light`] gets an index of it.
    pub fn labels(&self) -> &[String] {
        &self.labels
    }

    /// A path that begins at the camera.
    pub fn camera(&self) -> Front {
        Front(self.front.step(FIRST, CAMERA.trailing_zeros() as usize, self.symbols))
    }

    /// And goes on.
    #[inline]
    pub fn onward(&self, front: Front, event: Event) -> Front {
        Front(self.front.step(front.0, symbol(event) as usize, self.symbols))
    }

    /// A path that begins at a light, with a name out of [`PathClasses::labels`] or none.
    pub fn light(&self, source: Source, label: Option<usize>) -> Back {
        let symbol = light_symbol(source) as usize + label.map_or(0, |l| 4 * (l + 1));
        Back(self.back.step(FIRST, symbol, self.symbols))
    }

    /// And came from an event before, as the camera sees it.
    #[inline]
    pub fn backward(&self, back: Back, event: Event) -> Back {
        Back(self.back.step(back.0, symbol(event) as usize, self.symbols))
    }

    /// The layers of a path of two parts, one bit each.
    #[inline]
    pub fn met(&self, front: Front, back: Back) -> u32 {
        self.met[front.0 as usize * self.back.sets.len() + back.0 as usize]
    }
}

/// A set of states.
type Set = Vec<u64>;

/// The empty set has number 0, the one that all begins with 1.
const FIRST: u16 = 1;

/// Sets of states and the steps between them.
#[derive(Clone, Debug)]
struct Table {
    sets: Vec<Set>,
    steps: Vec<u16>,
}

impl Table {
    fn new(first: Set, symbols: usize, step: impl Fn(&Set, usize) -> Set) -> Option<Table> {
        let mut sets = vec![vec![0; first.len()], first];
        let mut numbers: HashMap<Set, u16> =
            sets.iter().cloned().enumerate().map(|(i, s)| (s, i as u16)).collect();
        let mut steps = Vec::new();
        let mut at = 0;
        while at < sets.len() {
            for s in 0..symbols {
                let set = step(&sets[at], s);
                let next = sets.len() as u16;
                let number = *numbers.entry(set).or_insert_with_key(|set| {
                    sets.push(set.clone());
                    next
                });
                steps.push(number);
            }
            if sets.len() > MOST_SETS {
                return None;
            }
            at += 1;
        }
        Some(Table { sets, steps })
    }

    #[inline]
    fn step(&self, set: u16, symbol: usize, symbols: usize) -> u16 {
        self.steps[set as usize * symbols + symbol]
    }
}

/// The states of all expressions: before anything, and after each letter.
#[derive(Default)]
struct States {
    /// The symbols after which a state is reached; none for those before anything.
    symbols: Vec<u64>,
    /// Which may follow.
    follow: Vec<Vec<usize>>,
    /// Of which layer.
    layer: Vec<usize>,
    starts: Vec<usize>,
    ends: Vec<usize>,
}

/// How a part of an expression joins with others.
struct Part {
    /// True if nothing at all matches it.
    empty: bool,
    first: Vec<usize>,
    last: Vec<usize>,
}

impl States {
    fn new_state(&mut self, symbols: u64, layer: usize) -> Option<usize> {
        self.symbols.push(symbols);
        self.follow.push(Vec::new());
        self.layer.push(layer);
        (self.symbols.len() <= MOST_POSITIONS).then_some(self.symbols.len() - 1)
    }

    fn add(&mut self, regex: &Regex, layer: usize, labels: &[String]) -> Option<()> {
        let start = self.new_state(0, layer)?;
        let part = self.part(regex, layer, labels)?;
        self.follow[start].extend(&part.first);
        self.starts.push(start);
        self.ends.extend(part.last);
        if part.empty {
            self.ends.push(start);
        }
        Some(())
    }

    fn part(&mut self, regex: &Regex, layer: usize, labels: &[String]) -> Option<Part> {
        match regex {
            Regex::One { sets, not } => {
                let bits = sets.iter().fold(0, |b, s| b | bits_of(s, labels));
                let state = self.new_state(if *not { !bits } else { bits }, layer)?;
                Some(Part { empty: false, first: vec![state], last: vec![state] })
            }
            Regex::Cat(parts) => {
                let mut all = Part { empty: true, first: Vec::new(), last: Vec::new() };
                for regex in parts {
                    let part = self.part(regex, layer, labels)?;
                    all = self.joined(all, part);
                }
                Some(all)
            }
            Regex::Or(parts) => {
                let mut all = Part { empty: false, first: Vec::new(), last: Vec::new() };
                for regex in parts {
                    let part = self.part(regex, layer, labels)?;
                    all.empty |= part.empty;
                    all.first.extend(part.first);
                    all.last.extend(part.last);
                }
                Some(all)
            }
            Regex::Repeat(regex, from, to) => {
                let mut all = Part { empty: true, first: Vec::new(), last: Vec::new() };
                for _ in 0..*from {
                    let part = self.part(regex, layer, labels)?;
                    all = self.joined(all, part);
                }
                match to {
                    None => {
                        let mut part = self.part(regex, layer, labels)?;
                        for &l in &part.last {
                            self.follow[l].extend(&part.first);
                        }
                        part.empty = true;
                        all = self.joined(all, part);
                    }
                    Some(to) => {
                        for _ in *from..*to {
                            let mut part = self.part(regex, layer, labels)?;
                            part.empty = true;
                            all = self.joined(all, part);
                        }
                    }
                }
                Some(all)
            }
        }
    }

    fn joined(&mut self, a: Part, b: Part) -> Part {
        for &l in &a.last {
            self.follow[l].extend(&b.first);
        }
        let mut first = a.first;
        if a.empty {
            first.extend(&b.first);
        }
        let mut last = b.last;
        if b.empty {
            last.extend(&a.last);
        }
        Part { empty: a.empty && b.empty, first, last }
    }

    fn set(&self, states: impl IntoIterator<Item = usize>) -> Set {
        let mut set = vec![0; self.symbols.len().div_ceil(64)];
        states.into_iter().for_each(|s| set[s / 64] |= 1 << (s % 64));
        set
    }

    fn starts(&self) -> Set {
        self.set(self.starts.iter().copied())
    }

    fn ends(&self) -> Set {
        self.set(self.ends.iter().copied())
    }

    fn forward(&self, set: &Set, symbol: usize) -> Set {
        let reached = (0..self.symbols.len()).filter(|s| has(set, *s));
        let follow = reached.flat_map(|s| self.follow[s].iter().copied());
        self.set(follow.filter(|t| self.symbols[*t] >> symbol & 1 != 0))
    }

    fn backward(&self, set: &Set, symbol: usize) -> Set {
        let leads = |s: &usize| {
            let mut follow = self.follow[*s].iter();
            follow.any(|t| has(set, *t) && self.symbols[*t] >> symbol & 1 != 0)
        };
        self.set((0..self.symbols.len()).filter(leads))
    }

    fn layers_of(&self, front: &Set, back: &Set) -> u32 {
        let both = (0..self.symbols.len()).filter(|s| has(front, *s) && has(back, *s));
        both.fold(0, |layers, s| layers | 1 << self.layer[s])
    }
}

fn has(set: &Set, state: usize) -> bool {
    set[state / 64] >> (state % 64) & 1 != 0
}

/// The bits of a set of symbols, those of lights with names included: each name has symbols of
/// its own after those without.
fn bits_of(set: &Symbols, labels: &[String]) -> u64 {
    let lights = u64::from(set.bits & LIGHTS);
    let named = |i: usize| lights << (4 * (i + 1));
    match &set.label {
        Some(label) => labels.iter().position(|l| l == label).map_or(0, named),
        None => (0..labels.len()).fold(u64::from(set.bits), |bits, i| bits | named(i)),
    }
}
