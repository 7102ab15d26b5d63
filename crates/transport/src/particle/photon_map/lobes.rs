//! What of a surface is D, and what is S.

use kaustika_scene::bsdf::{Bsdf, Lobes, Scatter};

/// The two parts of a surface's scattering.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    /// D: photons stay here; the diffuse lobes, and glossy ones that are rough enough.
    pub(super) matte: Lobes,
    /// S: rays are followed; the other glossy lobes, and ideal ones.
    pub(super) sharp: Lobes,
}

/// Parts `bsdf`, whose glossy lobes are D from the roughness `limit` on.
#[inline]
pub(super) fn parts(bsdf: &Bsdf, limit: f32) -> Parts {
    let all = bsdf.lobes();
    let glossy = || bsdf.parts().iter().filter(|p| p.model.lobes().has(Lobes::GLOSSY));
    let rough = all.has(Lobes::GLOSSY) && glossy().all(|p| p.model.roughness() >= limit);
    let soft = if rough { Lobes::SMOOTH } else { Lobes::DIFFUSE };
    let hard = if rough { Lobes::DELTA } else { Lobes::GLOSSY | Lobes::DELTA };
    Parts { matte: all & soft, sharp: all & hard }
}
