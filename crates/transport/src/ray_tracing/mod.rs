//! Methods that trace rays as Whitted did: from the eye to the first surface that is no mirror.

pub mod backward;
