//! Methods that trace rays from the eye, as Whitted did, to the first surfaces that scatter light
//! everywhere.

pub mod backward;
pub mod ray_tree;
