//! A binary tree over space, each leaf a cell that something is learned in.
//!
//! A cell that has seen more than a given number of records is divided at their mean, across the
//! axis along which they are spread most; so cells are small where paths are many.

use crate::saved::saved;
use kaustika_math::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// What happens somewhere.
pub trait Placed {
    /// Where.
    fn place(&self) -> Vec3;
}

/// The tree.
#[derive(Clone, Debug)]
pub struct SpaceTree<C> {
    nodes: Vec<Node>,
    cells: Vec<C>,
}

/// A leaf if `axis` is [`LEAF`].
#[derive(Clone, Copy, Debug)]
struct Node {
    split: f32,
    axis: u32,
    /// The first of two children that stand side by side; of a leaf its cell.
    first: u32,
}

saved!(SpaceTree<C> { nodes, cells });
saved!(Node { split, axis, first });

const LEAF: u32 = 3;
/// Cells at most.
const MOST_CELLS: usize = 1 << 16;

impl<C: Default> Default for SpaceTree<C> {
    fn default() -> Self {
        SpaceTree {
            nodes: vec![Node { split: 0.0, axis: LEAF, first: 0 }],
            cells: vec![C::default()],
        }
    }
}

/// Records in the order of their cells; within a cell in the order in which they came.
#[derive(Debug)]
pub struct Grouped<R> {
    records: Vec<R>,
    /// Of each cell.
    ranges: Vec<Range<usize>>,
}

impl<C> SpaceTree<C> {
    /// The cells.
    pub fn cells(&self) -> &[C] {
        &self.cells
    }

    /// The cells, to be changed.
    pub fn cells_mut(&mut self) -> &mut [C] {
        &mut self.cells
    }

    /// The number of the cell around `p`.
    #[inline]
    pub fn index(&self, p: Vec3) -> usize {
        let mut at = self.nodes[0];
        while at.axis != LEAF {
            let above = p[at.axis as usize] >= at.split;
            at = self.nodes[at.first as usize + usize::from(above)];
        }
        at.first as usize
    }

    /// The cell around `p`.
    #[inline]
    pub fn cell(&self, p: Vec3) -> &C {
        &self.cells[self.index(p)]
    }

    /// Sorts records by cell.
    pub fn group<R: Placed + Copy + Send + Sync>(&self, records: &[R]) -> Grouped<R>
    where
        C: Sync,
    {
        let cells: Vec<u32> = records.par_iter().map(|r| self.index(r.place()) as u32).collect();
        let mut ranges = vec![0..0; self.cells.len()];
        cells.iter().for_each(|&c| ranges[c as usize].end += 1);
        let mut start = 0;
        for r in &mut ranges {
            *r = start..start + r.end;
            start = r.end;
        }
        let mut order = vec![0u32; records.len()];
        let mut next: Vec<usize> = ranges.iter().map(|r| r.start).collect();
        for (i, &c) in cells.iter().enumerate() {
            order[next[c as usize]] = i as u32;
            next[c as usize] += 1;
        }
        let records = order.par_iter().map(|&i| records[i as usize]).collect();
        Grouped { records, ranges }
    }

    /// Shows every cell its records.
    pub fn teach<R: Sync>(&mut self, grouped: &Grouped<R>, learn: impl Fn(&mut C, &[R]) + Sync)
    where
        C: Send,
    {
        self.cells
            .par_iter_mut()
            .zip(&grouped.ranges)
            .for_each(|(cell, range)| learn(cell, &grouped.records[range.clone()]));
    }

    /// Divides cells until each has at most `most` records, if all are counted `times` times:
    /// `grouped` may be a sample of all. Two new cells begin with what their parent was, and are
    /// told so by `half`, for what it counted.
    pub fn divide<R: Placed>(
        &mut self,
        grouped: &mut Grouped<R>,
        (times, most): (f64, f64),
        half: impl Fn(&mut C) + Copy,
    ) where
        C: Clone,
    {
        for node in 0..self.nodes.len() {
            if self.nodes[node].axis == LEAF {
                let range = grouped.ranges[self.nodes[node].first as usize].clone();
                self.divide_leaf(node, &mut grouped.records[range], (times, most), half);
            }
        }
    }

    fn divide_leaf<R: Placed>(
        &mut self,
        node: usize,
        records: &mut [R],
        (times, most): (f64, f64),
        half: impl Fn(&mut C) + Copy,
    ) where
        C: Clone,
    {
        if records.len() as f64 * times <= most || self.cells.len() >= MOST_CELLS {
            return;
        }
        let n = records.len() as f64;
        let axis = |k: usize| records.iter().map(move |r| f64::from(r.place()[k]));
        let means: [f64; 3] = std::array::from_fn(|k| axis(k).sum::<f64>() / n);
        let spread = |k: usize| axis(k).map(|x| (x - means[k]).powi(2)).sum::<f64>();
        let spreads: [f64; 3] = std::array::from_fn(spread);
        let widest = (0..3).fold(0, |a, b| if spreads[b] > spreads[a] { b } else { a });
        let split = means[widest] as f32;
        let middle = partition(records, |r| r.place()[widest] < split);
        if middle == 0 || middle == records.len() {
            return;
        }
        let (first, cell) = (self.nodes.len() as u32, self.nodes[node].first);
        self.nodes[node] = Node { split, axis: widest as u32, first };
        self.nodes.push(Node { split: 0.0, axis: LEAF, first: cell });
        self.nodes.push(Node { split: 0.0, axis: LEAF, first: self.cells.len() as u32 });
        half(&mut self.cells[cell as usize]);
        self.cells.push(self.cells[cell as usize].clone());
        let (below, above) = records.split_at_mut(middle);
        self.divide_leaf(first as usize, below, (times, most), half);
        self.divide_leaf(first as usize + 1, above, (times, most), half);
    }
}

/// Brings those for which `first` holds to the front; their number.
fn partition<R>(records: &mut [R], first: impl Fn(&R) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..records.len() {
        if first(&records[i]) {
            records.swap(middle, i);
            middle += 1;
        }
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Here(Vec3, u32);

    impl Placed for Here {
        fn place(&self) -> Vec3 {
            self.0
        }
    }

    /// Places crowded toward a corner.
    fn places(n: u32) -> Vec<Here> {
        let number =
            |i: u32, k: u64| (mix_bits(u64::from(i) * 3 + k) >> 40) as f32 / (1 << 24) as f32;
        let at = |i: u32| Vec3::new(number(i, 0).powi(3), number(i, 1).powi(3), 0.1 * number(i, 2));
        (0..n).map(|i| Here(at(i), i)).collect()
    }

    #[test]
    fn cells_divide_until_none_has_too_many() {
        let places = places(20_000);
        let mut tree = SpaceTree::<u32>::default();
        let mut grouped = tree.group(&places);
        tree.divide(&mut grouped, (2.0, 1000.0), |_| ());
        assert!(tree.cells().len() > 40);
        let grouped = tree.group(&places);
        tree.teach(&grouped, |cell, of_cell| *cell = of_cell.len() as u32);
        assert_eq!(tree.cells().iter().sum::<u32>(), 20_000);
        assert!(tree.cells().iter().all(|n| (1..=500).contains(n)), "{:?}", tree.cells());
    }

    #[test]
    fn records_come_to_their_cells_in_order() {
        let places = places(3000);
        let mut tree = SpaceTree::<Vec<u32>>::default();
        let mut grouped = tree.group(&places);
        tree.divide(&mut grouped, (1.0, 200.0), |_| ());
        let grouped = tree.group(&places);
        tree.teach(&grouped, |cell, records| cell.extend(records.iter().map(|r| r.1)));
        for here in &places {
            assert!(tree.cell(here.0).contains(&here.1));
        }
        assert!(tree.cells().iter().all(|c| c.is_sorted()));
    }

    #[test]
    fn what_lies_in_one_point_is_not_divided() {
        let mut tree = SpaceTree::<u32>::default();
        let same = vec![Here(Vec3::Z, 0); 500];
        let mut grouped = tree.group(&same);
        tree.divide(&mut grouped, (1.0, 10.0), |_| ());
        assert_eq!(tree.cells().len(), 1);
    }
}
