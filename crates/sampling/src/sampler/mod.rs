//! Samplers: where the numbers of a light path come from.

mod halton;
mod independent;
mod kind;
mod plan;
mod pmj02;
mod sobol;
mod sobol_matrix;
mod stratified;
mod zsobol;

pub use kind::{SamplerKind, UnknownSampler};
pub use plan::{SamplerConfig, SamplerPlan};

use halton::Halton;
use independent::Independent;
use kaustika_math::Vec2;
use kaustika_math::lanes::{LANES, Row};
use pmj02::Pmj02;
use sobol::Sobol;
use stratified::Stratified;
use zsobol::ZSobol;

/// How many numbers [`Sampler::get_vertex`] draws.
pub const VERTEX_NUMBERS: usize = 8;

/// A source of primary samples that is not a point set: the state of a Markov chain.
///
/// Metropolis methods implement it and hand path code [`Sampler::from_primary`], so that the
/// same code runs under either. Numbers must lie in [0, 1).
pub trait PrimarySample {
    /// The next coordinate of the chain's state.
    fn get_1d(&mut self) -> f32;

    /// The next two coordinates.
    fn get_2d(&mut self) -> Vec2 {
        let x = self.get_1d();
        Vec2::new(x, self.get_1d())
    }

    /// Continues with the coordinates from `dimension` on, for sources that address them.
    fn seek(&mut self, _dimension: u32) {}
}

/// The numbers of one sample of one pixel, drawn in the order in which the path needs them.
///
/// An enum rather than a trait object: it lives on the stack, is made by value for every path
/// and its draws inline. Path code takes `&mut Sampler`.
///
/// All numbers lie in [0, 1) and are at most
/// [`ONE_MINUS_EPSILON`](kaustika_math::ONE_MINUS_EPSILON). There is no last dimension and no
/// last index. Two paths of one pixel whose draws mean the same thing in the same place are
/// stratified against each other; [`Sampler::seek`] restores that after a draw whose number
/// varies.
pub struct Sampler<'a> {
    dimension: u32,
    source: Source<'a>,
}

// The draws of all variants but the first are kept out of line: inlined into one function they
// would make it save six registers even for the cheapest of them.
enum Source<'a> {
    Independent(Independent),
    Stratified(Stratified<'a>),
    Halton(Halton<'a>),
    Sobol(Sobol),
    ZSobol(ZSobol),
    Pmj02(Pmj02<'a>),
    Primary(&'a mut (dyn PrimarySample + Send)),
}

impl<'a> Sampler<'a> {
    /// A sampler that draws from a Markov chain's state.
    pub fn from_primary(chain: &'a mut (dyn PrimarySample + Send)) -> Self {
        Sampler { dimension: 0, source: Source::Primary(chain) }
    }

    /// The next number.
    #[inline]
    pub fn get_1d(&mut self) -> f32 {
        let d = self.dimension;
        self.dimension = d.wrapping_add(1);
        match &mut self.source {
            Source::Independent(s) => s.get_1d(),
            Source::Stratified(s) => s.get_1d(d),
            Source::Halton(s) => s.get_1d(d),
            Source::Sobol(s) => s.get_1d(d),
            Source::ZSobol(s) => s.get_1d(d),
            Source::Pmj02(s) => s.get_1d(d),
            Source::Primary(s) => s.get_1d(),
        }
    }

    /// The next two numbers, stratified together.
    #[inline]
    pub fn get_2d(&mut self) -> Vec2 {
        let d = self.dimension;
        self.dimension = d.wrapping_add(2);
        match &mut self.source {
            Source::Independent(s) => s.get_2d(),
            Source::Stratified(s) => s.get_2d(d),
            Source::Halton(s) => s.get_2d(d),
            Source::Sobol(s) => s.get_2d(d),
            Source::ZSobol(s) => s.get_2d(d),
            Source::Pmj02(s) => s.get_2d(d),
            Source::Primary(s) => s.get_2d(),
        }
    }

    /// The numbers of one path vertex, drawn together, which is cheaper than one by one. The
    /// first four are stratified together in four dimensions where the sampler can (two 2D
    /// choices that belong together), each of the others by itself.
    #[inline]
    pub fn get_vertex(&mut self) -> [f32; VERTEX_NUMBERS] {
        if let Source::Sobol(s) = &mut self.source {
            let d = self.dimension;
            self.dimension = d.wrapping_add(VERTEX_NUMBERS as u32);
            return s.get_vertex(d);
        }
        let (a, b) = (self.get_2d(), self.get_2d());
        let mut u = [a.x, a.y, b.x, b.y, 0.0, 0.0, 0.0, 0.0];
        u[4..].fill_with(|| self.get_1d());
        u
    }

    /// [`Sampler::get_vertex`] of those of up to sixteen samplers whose bit is set in `wanted`;
    /// number k of sampler i goes to `out[k][i]`.
    #[inline]
    pub fn get_vertices(samplers: &mut [Self], wanted: u32, out: &mut [Row; VERTEX_NUMBERS]) {
        let wanted = |i: usize| wanted >> i & 1 != 0;
        if samplers.iter().all(|s| matches!(s.source, Source::Sobol(_))) {
            let mut seeds = [[0; LANES]; 3];
            for (i, sampler) in samplers.iter_mut().enumerate().take(LANES) {
                if let (true, Source::Sobol(s)) = (wanted(i), &mut sampler.source) {
                    let of_path = s.vertex_seeds(sampler.dimension);
                    seeds.iter_mut().zip(of_path).for_each(|(row, seed)| row[i] = seed);
                    sampler.dimension = sampler.dimension.wrapping_add(VERTEX_NUMBERS as u32);
                }
            }
            return sobol::vertices_from_seeds(&seeds, out);
        }
        for (i, sampler) in samplers.iter_mut().enumerate().take(LANES) {
            if wanted(i) {
                let u = sampler.get_vertex();
                out.iter_mut().zip(u).for_each(|(row, u)| row[i] = u);
            }
        }
    }

    /// How many numbers have been drawn, counted from the start or the last
    /// [`seek`](Self::seek).
    #[inline]
    pub fn dimension(&self) -> u32 {
        self.dimension
    }

    /// Continues at `dimension`, whatever was drawn before: the same dimension gives the same
    /// numbers. A path tracer that gives each vertex a fixed range keeps its vertices stratified
    /// even when some draw more than others. The independent sampler jumps to a stream of its
    /// own for that dimension, which differs from the numbers of an unbroken draw.
    pub fn seek(&mut self, dimension: u32) {
        self.dimension = dimension;
        match &mut self.source {
            Source::Independent(s) => s.seek(dimension),
            Source::Primary(s) => s.seek(dimension),
            Source::Sobol(s) => s.seek(),
            Source::Pmj02(s) => s.seek(),
            Source::Stratified(_) | Source::Halton(_) | Source::ZSobol(_) => {}
        }
    }

    /// A sampler for one of several continuations of this path (splitting): independent of this
    /// one and of other branches, stratified over sample indices as this one is. A chain has no
    /// branches: its fork continues to draw from the same state.
    pub fn fork(&mut self, branch: u64) -> Sampler<'_> {
        let (dimension, branch) = (self.dimension, self.branch(branch));
        match &mut self.source {
            Source::Primary(s) => Sampler { dimension, source: Source::Primary(&mut **s) },
            _ => branch.expect("all but chains have branches"),
        }
    }

    /// True for a Markov chain's state, which has no branches.
    pub fn is_chain(&self) -> bool {
        matches!(self.source, Source::Primary(_))
    }

    /// As [`Sampler::fork`], not bound to this one; `None` for a chain.
    pub fn branch<'b>(&self, branch: u64) -> Option<Sampler<'b>>
    where
        'a: 'b,
    {
        let salt = crate::hash::combine(u64::from(self.dimension), branch);
        let source = match &self.source {
            Source::Independent(s) => Source::Independent(s.fork(salt)),
            Source::Stratified(s) => Source::Stratified(s.fork(salt)),
            Source::Halton(s) => Source::Halton(s.fork(salt)),
            Source::Sobol(s) => Source::Sobol(s.fork(salt)),
            Source::ZSobol(s) => Source::ZSobol(s.fork(salt)),
            Source::Pmj02(s) => Source::Pmj02(s.fork(salt)),
            Source::Primary(_) => return None,
        };
        // Not from 0: a Halton branch that took the parent's first bases again would only rotate
        // what the parent drew.
        Some(Sampler { dimension: self.dimension, source })
    }
}
