//! Sixteen paths side by side: [`Walk`]s, number by number.

use super::walk::{Previous, Walk};
use kaustika_math::Vec3;
use kaustika_math::lanes::{LANES, Lanes, Row};
use kaustika_scene::Segment;
use kaustika_spectra::{Spectrum, Wavelengths};

/// Sixteen paths between two vertices. What lanes do not compute with (where the ray starts, the
/// wavelengths, the sampler) is kept by the wave.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct Pack {
    /// Direction of the ray to be traced next.
    pub(super) d: [Row; 3],
    pub(super) beta: [Row; 4],
    pub(super) radiance: [Row; 4],
    pub(super) eta_scale: Row,
    pub(super) footprint: Row,
    pub(super) spread: Row,
    pub(super) previous_p: [Row; 3],
    pub(super) previous_n: [Row; 3],
    pub(super) previous_pdf_w: Row,
    pub(super) depth: [u32; LANES],
    pub(super) passages: [u32; LANES],
    /// Lanes whose previous direction only the BSDF could have taken.
    pub(super) delta: u32,
}

impl Default for Pack {
    fn default() -> Pack {
        let zero = [0.0; LANES];
        Pack {
            d: [zero; 3],
            beta: [zero; 4],
            radiance: [zero; 4],
            eta_scale: zero,
            footprint: zero,
            spread: zero,
            previous_p: [zero; 3],
            previous_n: [zero; 3],
            previous_pdf_w: zero,
            depth: [0; LANES],
            passages: [0; LANES],
            delta: 0,
        }
    }
}

/// The lane's numbers.
#[inline(always)]
fn column<const N: usize>(rows: &[Row; N], lane: usize) -> [f32; N] {
    std::array::from_fn(|k| rows[k][lane])
}

#[inline(always)]
fn set_column<const N: usize>(rows: &mut [Row; N], lane: usize, values: [f32; N]) {
    for (row, v) in rows.iter_mut().zip(values) {
        row[lane] = v;
    }
}

impl Pack {
    /// The path of a lane; what the pack does not keep is given.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize, segment: Segment, lambda: Wavelengths) -> Walk {
        let lane = lane % LANES;
        Walk {
            segment,
            radiance: Spectrum(column(&self.radiance, lane)),
            beta: Spectrum(column(&self.beta, lane)),
            eta_scale: self.eta_scale[lane],
            depth: self.depth[lane],
            passages: self.passages[lane],
            footprint: self.footprint[lane],
            spread: self.spread[lane],
            previous: self.previous(lane),
            lambda,
            film_weight: 1.0,
        }
    }

    /// The previous vertex of a lane's path.
    #[inline(always)]
    pub(super) fn previous(&self, lane: usize) -> Previous {
        Previous {
            p: Vec3::from(column(&self.previous_p, lane)),
            n: Vec3::from(column(&self.previous_n, lane)),
            pdf_w: self.previous_pdf_w[lane],
            delta: self.delta >> lane & 1 != 0,
        }
    }

    /// Puts a path into a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, walk: &Walk) {
        let lane = lane % LANES;
        set_column(&mut self.d, lane, walk.segment.ray.d.into());
        set_column(&mut self.radiance, lane, walk.radiance.0);
        set_column(&mut self.beta, lane, walk.beta.0);
        self.eta_scale[lane] = walk.eta_scale;
        self.depth[lane] = walk.depth;
        self.passages[lane] = walk.passages;
        self.footprint[lane] = walk.footprint;
        self.spread[lane] = walk.spread;
        set_column(&mut self.previous_p, lane, walk.previous.p.into());
        set_column(&mut self.previous_n, lane, walk.previous.n.into());
        self.previous_pdf_w[lane] = walk.previous.pdf_w;
        self.delta = self.delta & !(1 << lane) | u32::from(walk.previous.delta) << lane;
    }

    /// Radiance that a lane's path has found.
    #[inline(always)]
    pub(super) fn radiance(&self, lane: usize) -> Spectrum {
        Spectrum(column(&self.radiance, lane % LANES))
    }

    /// Adds to it.
    #[inline(always)]
    pub(super) fn add(&mut self, lane: usize, radiance: Spectrum) {
        let sum = self.radiance(lane) + radiance;
        set_column(&mut self.radiance, lane % LANES, sum.0);
    }

    /// Throughput of a lane's path.
    #[inline(always)]
    pub(super) fn beta(&self, lane: usize) -> Spectrum {
        Spectrum(column(&self.beta, lane % LANES))
    }

    /// Bounces, as numbers.
    #[inline(always)]
    pub(super) fn depths(&self) -> Lanes {
        Lanes::new(self.depth.map(|d| d as f32))
    }
}

/// The lanes of a mask.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros() as usize % LANES)?;
        bits &= bits - 1;
        Some(lane)
    })
}
