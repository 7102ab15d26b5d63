//! Rejection sampling.

/// What became of the proposals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejection {
    /// Proposals accepted.
    pub accepted: u64,
    /// Proposals made.
    pub proposed: u64,
    /// Proposals whose acceptance probability was above 1 or not a number: the bound on the
    /// density is wrong and the samples are not distributed as asked.
    pub out_of_bounds: u64,
}

impl Rejection {
    /// The share of proposals accepted so far. For a density f/∫f under uniform proposals and
    /// acceptance f/max f it tends to mean f / max f; times max f it estimates the integral,
    /// which is the power that accepted photons carry.
    pub fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.proposed.max(1) as f64
    }
}

/// A sample with density proportional to (density of `propose`) × `acceptance` (von Neumann
/// 1951), where `acceptance` is in [0, 1]; `None` after `max_proposals` rejections in a row, so
/// that a function that is zero everywhere does not hang the caller.
///
/// `random` gives uniform numbers in [0, 1); it is used for the proposals too. Their number
/// varies, so a stratified source is best [sought](crate::Sampler::seek) to a fixed place
/// afterwards.
pub fn rejection<R: FnMut() -> f32, T>(
    stats: &mut Rejection,
    max_proposals: u32,
    mut random: R,
    mut propose: impl FnMut(&mut R) -> T,
    mut acceptance: impl FnMut(&T) -> f32,
) -> Option<T> {
    for _ in 0..max_proposals {
        let candidate = propose(&mut random);
        let p = acceptance(&candidate);
        stats.proposed += 1;
        if !(0.0..=1.0).contains(&p) {
            stats.out_of_bounds += 1;
        }
        if random() < p {
            stats.accepted += 1;
            return Some(candidate);
        }
    }
    None
}
