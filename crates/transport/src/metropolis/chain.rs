//! Metropolis sampling (Metropolis et al. 1953; Hastings 1970): a chain whose states come to be
//! distributed as any function f ≥ 0 that can be computed, whatever its integral is.
//!
//! ```text
//! f(x) T(x→y) a(x→y) = f(y) T(y→x) a(y→x)                   detailed balance          (1)
//! a(x→y) = min(1, f(y) T(y→x) / (f(x) T(x→y)))                                        (2)
//! record x with weight 1 - a, y with weight a                expected values           (3)
//! ```
//!
//! T is the density with which y is proposed from x. Weights add up to one for each step.

/// What one step records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recording {
    /// The state after the step.
    Visited,
    /// (3): both states, by their chances. The same mean, and states of low f are seen more often.
    #[default]
    Expected,
}

/// (2), from f(x) T(x→y) and f(y) T(y→x); `None` if that is no number, which rejects.
pub fn acceptance(there: f64, back: f64) -> Option<f64> {
    let ratio = back / there;
    (!ratio.is_nan() && back.is_finite()).then(|| ratio.min(1.0))
}

/// A chain: its present state, and what that has yet to record.
#[derive(Clone, Debug)]
pub struct Chain<X> {
    state: X,
    weight: f64,
    recording: Recording,
}

impl<X> Chain<X> {
    /// A chain that starts at `state`, which itself is not recorded.
    pub fn new(state: X, recording: Recording) -> Chain<X> {
        Chain { state, weight: 0.0, recording }
    }

    /// Where it stands.
    pub fn state(&self) -> &X {
        &self.state
    }

    /// Where it stands, for good.
    pub fn into_state(self) -> X {
        self.state
    }

    /// One step: goes to `proposal` if `u` in [0, 1) is below the acceptance `a`; `proposal` is then
    /// the state that was left. `record` gets states and weights, once for each visit.
    pub fn step(
        &mut self,
        proposal: &mut X,
        a: f64,
        u: f64,
        record: &mut impl FnMut(&X, f64),
    ) -> bool {
        let accepted = u < a;
        let (stay, go) = match self.recording {
            Recording::Expected => (1.0 - a, a),
            Recording::Visited => (f64::from(u8::from(!accepted)), f64::from(u8::from(accepted))),
        };
        self.weight += stay;
        if accepted {
            self.record(record);
            std::mem::swap(&mut self.state, proposal);
            self.weight = go;
        } else if go > 0.0 {
            record(proposal, go);
        }
        accepted
    }

    /// A step whose proposal failed.
    pub fn stay(&mut self) {
        self.weight += 1.0;
    }

    /// Records what the present state has collected.
    pub fn record(&mut self, record: &mut impl FnMut(&X, f64)) {
        if self.weight > 0.0 {
            record(&self.state, self.weight);
        }
        self.weight = 0.0;
    }
}
