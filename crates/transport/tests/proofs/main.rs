//! Proofs of the scene and the path tracer against values known in closed form, and of
//! estimators against each other.
//!
//! Seeds are fixed and samples independent, so each test passes always or never. Statistical
//! comparisons share one family-wise level of 1 % (Šidák), see [`stats`].

mod adjoint;
mod backward;
mod beams;
mod bidirectional;
mod bidirectional_media;
mod breaks;
mod cameras;
mod classes;
mod cutouts;
mod distributed;
mod fields;
mod furnace;
mod guided;
mod guided_light;
mod guided_photons;
mod hair;
mod hybrid;
mod hybrid_passes;
mod irradiance;
mod layers;
mod learned;
mod light_kinds;
mod media;
mod meters;
mod metropolis;
mod metropolis_1d;
mod metropolis_generations;
mod metropolis_guides;
mod metropolis_separate;
mod metropolis_trust;
mod mis;
mod motion;
mod nephroid;
mod photons;
mod placing;
mod polarized;
mod radiosity;
mod radiosity_extended;
mod radiosity_hierarchy;
mod radiosity_mesh;
mod radiosity_pictures;
mod radiosity_refinement;
mod radiosity_solvers;
mod ray_trees;
mod refraction;
mod roulette;
mod samplers;
mod scenes;
mod selection;
mod shaders;
mod spectral;
mod stats;
mod subsurface;
mod surfaces;
mod virtual_lights;
mod waves;
mod zbuffer;
mod zbuffer_looks;
mod zbuffer_models;
mod zbuffer_placed;
