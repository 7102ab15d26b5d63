//! What moves while the shutter is open.
//!
//! Rays carry their time as a part of the shutter's interval: 0 when it opens, 1 when it closes.

use crate::description::MotionKey;
use kaustika_math::{Motion, Transform};

/// Where something stands, or how it moves.
#[derive(Clone, Debug)]
pub(crate) enum Placement {
    /// At one place.
    Still(Transform),
    /// In time from 0 to 1.
    Moving(Motion),
}

impl Placement {
    /// From a description: `transform`, or `keys` where there are any, while the shutter is open.
    /// Where a key mirrors and another one does not, the first stands for all.
    pub(crate) fn new(transform: &Transform, keys: &[MotionKey], [open, close]: [f32; 2]) -> Self {
        let Some(first) = keys.first() else { return Placement::Still(*transform) };
        if keys.iter().all(|k| k.transform == first.transform) {
            return Placement::Still(first.transform);
        }
        let interval = close - open;
        let still = interval <= 0.0;
        let time = |t: f32| if still { t - open } else { (t - open) / interval };
        let keys: Vec<_> = keys.iter().map(|k| (time(k.time), k.transform)).collect();
        match Motion::new(&keys) {
            // A shutter that is open for no time sees everything stand still.
            Some(motion) if still => Placement::Still(motion.at(0.0)),
            Some(motion) => Placement::Moving(motion),
            None => Placement::Still(first.transform),
        }
    }
}
