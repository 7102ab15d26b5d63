//! How elements are divided: one by one, or all until there are enough.

use super::matter::furnish;
use super::{Element, Mesh, NONE};
use kaustika_scene::Scene;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An element in the order of what is to be divided first.
struct Longest(f32, u32);

impl PartialEq for Longest {
    fn eq(&self, o: &Longest) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for Longest {}
impl PartialOrd for Longest {
    fn partial_cmp(&self, o: &Longest) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Longest {
    fn cmp(&self, o: &Longest) -> Ordering {
        self.0.total_cmp(&o.0).then(o.1.cmp(&self.1))
    }
}

impl Mesh {
    /// (1): divides leaves; what the halves reflect and emit is found out for all at once.
    pub fn divide(&mut self, scene: &Scene, leaves: &[u32]) {
        let first = self.elements.len();
        for &e in leaves {
            let halves = self.halves(scene, e);
            self.elements[e as usize].children = self.elements.len() as u32;
            self.elements.extend(halves);
        }
        let facets = &self.facets;
        self.elements[first..]
            .par_iter_mut()
            .for_each(|half| furnish(scene, &facets[half.facet as usize], half));
    }

    /// Divides the leaves with the longest sides until there are so many leaves, or nothing is
    /// left to divide. Black ones stay whole.
    pub fn divide_evenly(&mut self, scene: &Scene, count: usize) {
        let mut leaves = self.leaves();
        let mut heap: BinaryHeap<Longest> = leaves.iter().filter_map(|&e| self.order(e)).collect();
        let mut number = leaves.len();
        while number < count && !heap.is_empty() {
            // Those of about the same length together.
            leaves.clear();
            let longest = heap.peek().map_or(0.0, |l| l.0);
            while let Some(l) = heap.peek()
                && l.0 > 0.999 * longest
                && number + leaves.len() < count
            {
                leaves.push(l.1);
                heap.pop();
            }
            let first = self.elements.len() as u32;
            self.divide(scene, &leaves);
            heap.extend((first..self.elements.len() as u32).filter_map(|e| self.order(e)));
            number += leaves.len();
        }
    }

    fn order(&self, e: u32) -> Option<Longest> {
        let element = &self.elements[e as usize];
        (!element.is_black()).then(|| Longest(element.longest_side().1, e))
    }

    fn halves(&self, scene: &Scene, e: u32) -> [Element; 2] {
        let element = &self.elements[e as usize];
        let k = element.longest_side().0;
        let (i, j) = (k, (k + 1) % 3);
        let at = (element.at[i] + element.at[j]) * 0.5;
        // Halves of a flat element lie in its plane, so that both sides of an edge agree on the
        // middle to the bit.
        let middle = match self.is_flat(e) {
            true => (element.corners[i] + element.corners[j]) * 0.5,
            false => {
                let facet = &self.facets[element.facet as usize];
                scene.geometry.on_facet(facet, at, super::TIME).p
            }
        };
        let half = |corner: usize| {
            let mut half = Element { children: NONE, ..element.clone() };
            (half.at[corner], half.corners[corner]) = (at, middle);
            let [a, b, c] = half.corners;
            let cross = (b - a).cross(c - a);
            half.area = 0.5 * cross.length();
            half.normal =
                cross.try_normalize().map_or(element.normal, |n| n.face_forward(element.normal));
            half
        };
        [half(j), half(i)]
    }
}
