//! Hybrids: every class of paths by what is best at it (multi-pass methods; Chen, Rushmeier, Miller &
//! Turner 1991).
//!
//! ```text
//! L(D|S)*E = C₁ ∪ … ∪ Cₙ,   Cᵢ ∩ Cⱼ = ∅                                              (1)
//! I = Σᵢ Iᵢ,   Iᵢ the light of the paths Cᵢ by method i                              (2)
//! ```
//!
//! A [`term`] is a class as an expression and who makes it: a method, or a [`walk`] from the camera
//! that ends in a light [`field`](fields) at its N-th diffuse surface. Before anything is rendered,
//! automata prove (1) ([`partition`]): no light is lost, and none counted twice. Each pass is one of
//! every term.

mod fields;
mod method_term;
mod params;
pub mod partition;
mod presets;
pub mod term;
mod walk;

pub use params::{HybridParams, parameters};

use self::fields::{Field, Lamps, Plan};
use self::method_term::MethodTerm;
use self::partition::check;
use self::presets::resolve;
use self::term::{Maker, Term};
use self::walk::Walk;
use crate::frame::Frame;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::workers::Workers;
use kaustika_film::accumulate::{Layers, PassImage};
use kaustika_scene::Scene;
use kaustika_spectra::ColorMode;

/// What hybrids are.
pub static INFO: MethodInfo = MethodInfo {
    name: "hybrid",
    summary: "several methods together, each for a class of paths of its own",
    path_class: "L(D|S)*E",
    misses: "media; what the method of a term misses of its class",
    bias: Bias::Biased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one of every term: one camera path a pixel for each, and photons",
    source: "Wallace et al. 1987; Sillion & Puech 1989; Chen et al. 1991; Heckbert 1990",
};

/// What Chen's hybrid is.
pub static CHEN_INFO: MethodInfo = MethodInfo {
    name: "chen",
    summary: "direct light by path tracing, caustics by photons, all else gathered from radiosity",
    source: "Chen, Rushmeier, Miller & Turner 1991",
    ..INFO
};

/// The method.
pub struct Hybrid {
    info: &'static MethodInfo,
    params: HybridParams,
    parts: Vec<Part>,
    /// How photons leave the lights, if there are any.
    lamps: Option<Lamps>,
}

/// A term and what makes it.
struct Part {
    term: Term,
    work: Work,
    /// The picture of this term alone.
    frame: Option<Frame>,
}

enum Work {
    Method(MethodTerm),
    /// A walk that ends in a field, known after [`Method::prepare`].
    Walk(Plan, Option<Field>),
}

impl Hybrid {
    /// With these parameters.
    ///
    /// # Errors
    /// If the terms are none, or part no paths, or a term's method can never make its class.
    pub fn new(info: &'static MethodInfo, params: HybridParams) -> Result<Hybrid, String> {
        let (terms, of) = resolve(&params.terms, &params.of)?;
        let terms = term::parse(&terms)?;
        let work = |term: &Term| match &term.maker {
            Maker::Method { name, given } => {
                MethodTerm::new(term, name, given, &params).map(Work::Method)
            }
            Maker::Field { kind, at } => {
                Plan::of(term, *kind, *at).map(|plan| Work::Walk(plan, None))
            }
        };
        let works = terms.iter().map(work).collect::<Result<Vec<_>, _>>()?;
        check(&terms, &of)?;
        let parts = terms.into_iter().zip(works);
        let parts = parts.map(|(term, work)| Part { term, work, frame: None }).collect();
        Ok(Hybrid { info, params, parts, lamps: None })
    }
}

impl Method for Hybrid {
    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn mode(&self) -> Option<ColorMode> {
        self.parts.iter().find_map(|part| match &part.work {
            Work::Method(method) => method.method.mode(),
            Work::Walk(..) => Some(ColorMode::Rgb),
        })
    }

    fn layers(&self) -> Vec<String> {
        self.parts.iter().map(|part| part.term.layer.name.clone()).collect()
    }

    fn report(&self) -> Vec<(String, f64)> {
        let of = |part: &Part| {
            let figures = match &part.work {
                Work::Method(method) => method.method.report(),
                Work::Walk(_, field) => field.as_ref().map_or(Vec::new(), Field::report),
            };
            let name = part.term.layer.name.clone();
            figures.into_iter().map(move |(what, n)| (format!("{name}: {what}"), n))
        };
        self.parts.iter().flat_map(of).collect()
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        if frame.bands.is_some() {
            let message = "a spectral film keeps no hybrids: use the method `path`";
            return Err(RenderError::Failed(message.into()));
        }
        let walks = self.parts.iter().any(|p| matches!(p.work, Work::Walk(..)));
        if walks && scene.mode == ColorMode::Spectral {
            let message = "light fields are in red, green and blue: leave out `--spectral`";
            return Err(RenderError::Failed(message.into()));
        }
        self.lamps = walks.then(|| Lamps::new(scene, frame));
        let mut features = Some(frame.layers.features());
        for part in &mut self.parts {
            let layers = Layers::new(features.take().unwrap_or_default());
            let mut own = frame.of_part(layers);
            match (&mut part.work, &self.lamps) {
                (Work::Method(method), _) => {
                    method.prepare(&part.term, scene, &mut own, workers)?;
                }
                (Work::Walk(plan, field), Some(lamps)) => {
                    let of = (scene, frame, lamps);
                    *field = Some(Field::new(plan, &self.params, of, workers)?);
                }
                (Work::Walk(..), None) => {}
            }
            part.frame = Some(own);
        }
        Ok(())
    }

    fn pass(
        &mut self,
        index: u64,
        scene: &Scene,
        _frame: &Frame,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Commit, RenderError> {
        let mut stats = PassStats::default();
        let share = 1.0 / self.parts.len() as f32;
        for (k, part) in self.parts.iter_mut().enumerate() {
            let unprepared = || RenderError::Failed("nothing was prepared".into());
            let frame = part.frame.as_ref().ok_or_else(unprepared)?;
            let mut image = PassImage::new(out.width(), out.height(), frame.layers.clone());
            match (&mut part.work, &self.lamps) {
                (Work::Method(method), _) => {
                    stats += method.method.pass(index, scene, frame, &mut image, workers)?.stats;
                }
                (Work::Walk(plan, Some(field)), Some(lamps)) => {
                    let of = (scene, frame, lamps);
                    let light =
                        field.at_pass(index, plan, &self.params, of, (workers, &mut stats))?;
                    let walk = Walk { scene, frame, plan, light: &light };
                    stats += walk.look(index, &mut image, workers)?;
                }
                _ => return Err(unprepared()),
            }
            // A class by a method that knows others too is a layer of its picture.
            let from = frame.paths.as_ref().map_or(0, |_| frame.layers.path_offset(0));
            add(&image, from, out, k, share); // (2)
        }
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}

/// Adds the numbers from `from` on of each pixel of a term's picture to the colour of `out` and to its
/// layer `k`, its share of the weight, and its features.
fn add(image: &PassImage, from: usize, out: &mut PassImage, k: usize, share: f32) {
    let (stride, own) = (out.layers().stride(), image.layers().stride());
    let layer = out.layers().path_offset(k);
    let features = 4..image.layers().path_offset(0);
    let pixels = out.data_mut().chunks_exact_mut(stride);
    for (to, pixel) in pixels.zip(image.data().chunks_exact(own)) {
        for c in 0..3 {
            to[c] += pixel[from + c];
            to[layer + c] += pixel[from + c];
        }
        to[3] += share * pixel[3];
        to[features.clone()].iter_mut().zip(&pixel[features.clone()]).for_each(|(t, p)| *t += p);
    }
}
