//! Methods whose passes need those before them: their pictures depend neither on threads nor on a
//! break in between.

use crate::bidirectional::SIZE;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_transport::{Frame, Method, Workers};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Holds `count` passes of a method on one thread against those on three, and on two with a break
/// before each of the `breaks`: bit for bit.
pub(crate) fn threads_and_breaks<M: Method>(
    scene: &Scene,
    make: impl Fn() -> M,
    count: u64,
    breaks: &[u64],
) {
    let alone = passes(scene, &make, count, 1, None);
    assert!(alone == passes(scene, &make, count, 3, None));
    for &broken in breaks {
        assert!(alone == passes(scene, &make, count, 2, Some(broken)), "{broken}");
    }
}

/// Passes on so many threads, saved and loaded into another method before pass `broken`.
fn passes<M: Method>(
    scene: &Scene,
    make: &impl Fn() -> M,
    count: u64,
    threads: usize,
    broken: Option<u64>,
) -> Vec<PassImage> {
    let config = SamplerConfig { kind: SamplerKind::Sobol, seed: 3, spp: 16, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    frame.keep_layers(&make().layers());
    let workers = Workers::new(threads, Arc::new(AtomicBool::new(false))).expect("threads");
    let prepared = || {
        let mut method = make();
        method.prepare(scene, &frame, &workers).expect("prepared");
        method
    };
    let mut method = prepared();
    let pass = |index| {
        if broken == Some(index) {
            let mut saved = Vec::new();
            method.save(&mut saved).expect("saved");
            method = prepared();
            method.load(&mut &saved[..]).expect("loaded");
        }
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
        image
    };
    (0..count).map(pass).collect()
}
