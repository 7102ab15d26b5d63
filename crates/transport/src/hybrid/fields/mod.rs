//! Light fields at the N-th diffuse surface of a walk from the camera, and the classes of paths that end
//! in them.
//!
//! ```text
//! P₀ = L    P₁ = L X⁺    P₂ = L (X* D)⁺ X*                light that arrives at x_N        (1)
//! C = P D (W D)ᴺ⁻¹ W E,   P a union of some of P₀, P₁, P₂                                  (2)
//! ```
//!
//! X is what light goes through on its way to a field, W what the walk does: nothing, mirrors and clear
//! glass, or all that is not diffuse. Which of them a term asks for is read from its expression: (2)
//! must be its class, as automata decide.

mod patches;

pub use crate::particle::photon_map::field::Lamps;
pub use patches::PatchField;

use super::HybridParams;
use super::partition::sets;
use super::term::{FieldKind, Term};
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::particle::photon_map::Past;
use crate::particle::photon_map::cached::{CachedField, Caching};
use crate::particle::photon_map::field::{PhotonField, Wanted};
use crate::path_space::Chain;
use crate::workers::Workers;
use kaustika_film::path_expression::PathLayer;
use kaustika_scene::Scene;
use kaustika_scene::bsdf::Lobes;

/// X of (1), and as letters of P₁ and of what stands between two D of P₂.
const CHAINS: [(Chain, &str, &str); 4] = [
    (Chain::NONE, "", ""),
    (Chain { most: 1, ..Chain::MIRRORS }, "S_M", "[S_M]"),
    (Chain::MIRRORS, "S_M+", "S_M*"),
    (Chain::ANY, "S+", "S*"),
];

/// W of (2).
const WALKS: [(Lobes, &str); 3] =
    [(Lobes::NULL, ""), (Lobes::DELTA, "S_M*"), (Lobes::SPECULAR, "S*")];

/// What a walk does and what it ends in.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// The kind of field.
    kind: FieldKind,
    /// N.
    pub(super) at: usize,
    /// W.
    pub(super) walked: Lobes,
    /// X.
    chain: Chain,
    /// P.
    pub(super) pasts: Vec<Past>,
}

impl Plan {
    /// What the term asks for of a field at the `at`-th diffuse surface.
    ///
    /// # Errors
    /// If no field knows just this class.
    pub(super) fn of(term: &Term, kind: FieldKind, at: usize) -> Result<Plan, String> {
        let mut why = String::new();
        for (chain, once, between) in CHAINS.into_iter().filter(|c| kind.knows(c.0)) {
            for (walked, w) in WALKS {
                let mut pieces = pieces((once, between), w, at);
                pieces.retain(|(past, _)| kind.keeps(*past));
                match fit(&term.layer, &pieces) {
                    Ok(pasts) => return Ok(Plan { kind, at, walked, chain, pasts }),
                    Err(message) => why = message,
                }
            }
        }
        let classes = pieces(("S+", "S*"), "S*", at).into_iter();
        let classes = classes.filter(|(past, _)| kind.keeps(*past)).map(|(_, class)| class);
        let known = classes.collect::<Vec<String>>().join(", ");
        Err(format!(
            "the term `{}`: {why}; a walk to such a field makes {known}, and S_M or nothing for S",
            term.text
        ))
    }
}

impl FieldKind {
    /// True if it may know light that went through this.
    fn knows(self, chain: Chain) -> bool {
        self != FieldKind::Cache || chain == Chain::ANY
    }

    /// True if it may know light with this past. What is cached changes slowly from place to place.
    fn keeps(self, past: Past) -> bool {
        self != FieldKind::Cache || past == Past::Reflected
    }
}

/// (2) for each of P₀, P₁ and P₂ that there is.
fn pieces((once, between): (&str, &str), w: &str, at: usize) -> Vec<(Past, String)> {
    let tail = format!("D{}{w}E", format!("{w}D").repeat(at - 1));
    let reflected = format!("L({between}D)+{between}");
    let all = [
        (Past::Straight, "L".into()),
        (Past::Caustic, format!("L{once}")),
        (Past::Reflected, reflected),
    ];
    let there = all.into_iter().filter(|(past, _)| *past != Past::Caustic || !once.is_empty());
    there.map(|(past, class): (Past, String)| (past, class + &tail)).collect()
}

/// The pieces whose union the class is; or why there are none.
fn fit(class: &PathLayer, pieces: &[(Past, String)]) -> Result<Vec<Past>, String> {
    let parsed = pieces.iter().enumerate();
    let parsed = parsed.map(|(k, (_, piece))| PathLayer::parse(&format!("p{k}={piece}")));
    let mut layers: Vec<PathLayer> = parsed.collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    layers.push(class.named("class"));
    let sets = sets(layers)?;
    let whole = 1u32 << pieces.len();
    if let Some(word) = sets.get(&whole) {
        return Err(format!("no such walk finds {word}"));
    }
    let mut pasts = Vec::new();
    for (k, (past, piece)) in pieces.iter().enumerate() {
        let find = |inside: bool| {
            let of = |set: &&u32| **set >> k & 1 != 0 && (**set & whole != 0) == inside;
            sets.keys().find(of).map(|set| &sets[set])
        };
        match (find(true), find(false)) {
            (Some(_), None) => pasts.push(*past),
            (None, _) => {}
            (Some(a), Some(b)) => {
                return Err(format!("{piece} is one light field, so {a} is not found without {b}"));
            }
        }
    }
    Ok(pasts)
}

/// What is known of a light field before the first pass.
pub(super) enum Field {
    /// Nothing: photons leave with every pass.
    Photons,
    /// Its patches.
    Patches(Box<PatchField>),
    /// How caches are made.
    Cache(Box<Caching>),
}

/// A light field as a pass sees it.
pub(super) enum LightField<'f> {
    /// Photons of the pass.
    Photons(PhotonField),
    /// Patches.
    Patches(&'f PatchField),
    /// An irradiance cache of the pass.
    Cache(CachedField<'f>),
}

impl Field {
    /// For a walk.
    ///
    /// # Errors
    /// If there is nothing diffuse for patches, or if cancelled.
    pub(super) fn new(
        plan: &Plan,
        params: &HybridParams,
        of: (&Scene, &Frame, &Lamps),
        workers: &Workers,
    ) -> Result<Field, RenderError> {
        Ok(match plan.kind {
            FieldKind::Photons => Field::Photons,
            FieldKind::Radiosity => {
                Field::Patches(Box::new(PatchField::new(of, params, plan.chain, workers)?))
            }
            FieldKind::Cache => {
                let (scene, frame, _) = of;
                Field::Cache(Box::new(Caching::new(params.caching(), scene, frame, workers)?))
            }
        })
    }

    /// The field in pass `index`.
    ///
    /// # Errors
    /// If cancelled.
    pub(super) fn at_pass<'f>(
        &'f mut self,
        index: u64,
        plan: &Plan,
        params: &HybridParams,
        (scene, frame, lamps): (&'f Scene, &'f Frame, &Lamps),
        (workers, stats): (&Workers, &mut PassStats),
    ) -> Result<LightField<'f>, RenderError> {
        let of = (scene, frame);
        Ok(match self {
            Field::Patches(patches) => LightField::Patches(patches),
            Field::Cache(caching) => LightField::Cache(caching.field(index, of, workers, stats)?),
            Field::Photons => {
                let (pasts, chain) = (&plan.pasts, plan.chain);
                let wanted = Wanted { pasts, chain, count: params.photons };
                let reading = params.reading();
                LightField::Photons(lamps.field(index, of, &wanted, &reading, workers, stats)?)
            }
        })
    }

    /// Figures of it.
    pub(super) fn report(&self) -> Vec<(String, f64)> {
        match self {
            Field::Patches(patches) => patches.report(),
            Field::Photons | Field::Cache(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::term::{Maker, parse};
    use super::*;
    use Past::*;

    fn plan(term: &str) -> Result<Plan, String> {
        let term = &parse(term).expect(term)[0];
        let Maker::Field { kind, at } = term.maker else { panic!("{term:?} has no field") };
        Plan::of(term, kind, at)
    }

    #[test]
    fn classes_say_what_a_walk_does() {
        let one_mirror = CHAINS[1].0;
        for (term, chain, walked, pasts) in [
            ("photons@1:LDE", Chain::NONE, Lobes::NULL, &[Straight][..]),
            ("photons@1:LS+DS*E", Chain::ANY, Lobes::SPECULAR, &[Caustic]),
            ("photons@1:C<.S>*D<.S>+L", Chain::MIRRORS, Lobes::DELTA, &[Caustic]),
            (
                "radiosity@2:L(D|S)*DS*DS*E",
                Chain::ANY,
                Lobes::SPECULAR,
                &[Straight, Caustic, Reflected],
            ),
            ("radiosity@1:LDD+E", Chain::NONE, Lobes::NULL, &[Reflected]),
            ("radiosity@1:LD+E", Chain::NONE, Lobes::NULL, &[Straight, Reflected]),
            (
                "radiosity@1:L([S_M]D)*[S_M]DS_M*E",
                one_mirror,
                Lobes::DELTA,
                &[Straight, Caustic, Reflected],
            ),
            ("radiosity@3:LD*DDDE", Chain::NONE, Lobes::NULL, &[Straight, Reflected]),
            ("cache@1:L(D|S)*DS*DS*E", Chain::ANY, Lobes::SPECULAR, &[Reflected]),
        ] {
            let plan = plan(term).expect(term);
            assert_eq!(
                (plan.chain, plan.walked, &plan.pasts[..]),
                (chain, walked, pasts),
                "{term}"
            );
        }
    }

    #[test]
    fn others_are_no_walks() {
        for (term, message) in [
            ("photons@1:L(D|S)*E", "no such walk finds `LE`"),
            ("radiosity@2:LDE", "no such walk finds `LDE`"),
            ("photons@1:LSDS*E", "`LSDE`"),
            ("radiosity@1:LDDE", "is one light field"),
            ("cache@1:LDE", "no such walk finds `LDE`"),
            ("cache@2:L(D|S)*DS*DS*E", "no such walk finds `LDDE`"),
        ] {
            let error = plan(term).expect_err(term);
            assert!(error.contains(message), "{term}: {error}");
        }
    }
}
