//! How the rays of a batch go through a tree: in crowds, as packets, or side by side.

use crate::accept::Accept;
use crate::classes::{Classes, MAX_RAYS};
use crate::crowd::{self, CrowdStack};
use crate::packet::{self, Packet, PacketStack};
use crate::ray::is_moderate;
use crate::simd::LANES;
use crate::stream::{self, Segment, Tree};
use crate::triangle_bvh::TriangleHit;

/// Up to how many leaves crowds are faster, if rays seek the nearest hit: some 10,000 triangles.
const MOST_LEAVES_CLOSEST: usize = 1500;
/// And if any hit will do: some 45,000.
const MOST_LEAVES_ANY: usize = 6000;

/// A way that is open to all rays of a batch. All give the same answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// Rays of one class go together, wherever they start and go.
    Crowds,
    /// Rays that seek the nearest hit go together if they are nearly the same; others each take
    /// turns.
    Flights,
}

impl Way {
    /// The fastest in a tree of so many leaves.
    pub(crate) fn of<const ANY: bool>(leaves: usize) -> Way {
        let most = if ANY { MOST_LEAVES_ANY } else { MOST_LEAVES_CLOSEST };
        if leaves <= most { Way::Crowds } else { Way::Flights }
    }
}

/// Traces `segments`: to the nearest hit that is accepted, or with `ANY` to the first that comes.
/// `accept` and `done` are told the number of the segment; `done` hears of each once, in any order.
pub(crate) fn trace<const STACK: usize, const ANY: bool>(
    tree: &Tree,
    way: Way,
    segments: &[Segment],
    mut accept: impl Accept,
    mut done: impl FnMut(usize, Option<TriangleHit>),
) {
    if way == Way::Crowds && is_moderate(tree.bounds) {
        in_crowds::<STACK, ANY>(tree, segments, &mut accept, &mut done);
    } else if ANY {
        let all = segments.iter().copied().enumerate();
        stream::trace::<STACK, ANY>(tree, all, |i, hit| accept.accept(i, hit), done);
    } else {
        in_packets::<STACK>(tree, segments, &mut accept, &mut done);
    }
}

/// Crowds of each class, then the rays that belong to none.
fn in_crowds<const STACK: usize, const ANY: bool>(
    tree: &Tree,
    segments: &[Segment],
    accept: &mut impl Accept,
    done: &mut impl FnMut(usize, Option<TriangleHit>),
) {
    let mut stack = CrowdStack::<STACK>::new();
    for first in (0..segments.len()).step_by(MAX_RAYS) {
        let classes = Classes::new(segments, first, tree.bounds);
        for (class, places) in classes.plain() {
            for places in places.chunks(crowd::RAYS) {
                let stack = &mut stack;
                crowd::trace::<STACK, ANY>(tree, segments, class, places, stack, accept, done);
            }
        }
        let special = classes.special();
        if special.is_empty() {
            // As nearly always: room for flights is not even made.
            continue;
        }
        let left = special.iter().map(|i| (*i as usize, segments[*i as usize]));
        stream::trace::<STACK, ANY>(tree, left, |i, hit| accept.accept(i, hit), &mut *done);
    }
}

/// Groups of eight rays of nearly one way as packets, then all others. To the nearest hit.
fn in_packets<const STACK: usize>(
    tree: &Tree,
    segments: &[Segment],
    accept: &mut impl Accept,
    done: &mut impl FnMut(usize, Option<TriangleHit>),
) {
    let (groups, rest) = segments.as_chunks::<LANES>();
    let mut stack = PacketStack::<STACK>::new();
    let mut alone = Vec::with_capacity(groups.len());
    for (i, group) in groups.iter().enumerate() {
        let Some(packet) = Packet::new(group, tree.bounds) else {
            alone.push(i);
            continue;
        };
        let first = i * LANES;
        let hits = packet::trace(tree, &packet, group, &mut stack, |lane, hit| {
            accept.accept(first + lane, hit)
        });
        for (lane, hit) in hits.into_iter().enumerate() {
            done(first + lane, hit);
        }
    }
    let groups = alone.into_iter().flat_map(|i| i * LANES..(i + 1) * LANES);
    let rest = segments.len() - rest.len()..segments.len();
    let left = groups.chain(rest).map(|i| (i, segments[i]));
    stream::trace::<STACK, false>(tree, left, |i, hit| accept.accept(i, hit), done);
}
