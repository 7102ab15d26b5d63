//! Whether light passes between the two sides of a connection, and how much of it.

use super::Vertex;
use crate::extinction::{Beam, Shares, Stream};
use crate::method::PassStats;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::description::SourceFormat;
use kaustika_scene::{Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// What passes along a segment.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// Transmittance, an estimate where media vary.
    pub value: Spectrum,
    /// As [`Vertex::passing`].
    pub passing: f64,
}

impl Passage {
    /// Through nothing.
    pub const CLEAR: Passage = Passage { value: Spectrum::ONE, passing: 1.0 };
}

/// Follows a connection's segment, which begins (in the direction that it has) at `from`; `None`
/// if something is in the way. `far` says whether it ends at infinity.
pub fn passage(
    scene: &Scene,
    from: &Vertex,
    segment: &Segment,
    far: bool,
    lambda: &Wavelengths,
    stats: &mut PassStats,
) -> Option<Passage> {
    stats.shadow_rays += 1;
    if !scene.has_media() {
        return (!scene.occluded(segment)).then_some(Passage::CLEAR);
    }
    let [a, b, c] = from.u;
    let end = segment.ray.at(segment.t_max);
    let mut stream = Stream::new(&[a, b, c, end.x, end.y, end.z]);
    let mut beam = Beam::new(Shares::independent(lambda, stream.draw()));
    let medium = from.medium_toward(scene, segment.ray.d);
    let panes = scene.format != SourceFormat::Pbrt;
    let mut room = Bsdf::default();
    let open = beam.shine(scene, segment, medium, far, lambda, panes, &mut stream, &mut room);
    open.then(|| Passage { value: beam.t, passing: f64::from(beam.passing) })
}
