//! How elements are divided: one by one, or all until there are enough.
//!
//! ```text
//! A ℓ²,   A the area, ℓ the longest side: divide where it is largest                (2)
//! ```
//!
//! (2) is the square that a patch errs by where light changes evenly along surfaces, ΔH ∝ ℓ. Not ℓ alone:
//! moulded edges are slivers, as long as a wall and a hair wide, which would take all patches before the wall
//! is divided at all.

use super::matter::furnish;
use super::{Element, Mesh, NONE};
use kaustika_scene::Scene;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An element in the order of what is to be divided first.
struct First(f32, u32);

impl PartialEq for First {
    fn eq(&self, o: &First) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for First {}
impl PartialOrd for First {
    fn partial_cmp(&self, o: &First) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for First {
    fn cmp(&self, o: &First) -> Ordering {
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
        let (facets, glossy) = (&self.facets, self.glossy);
        self.elements[first..]
            .par_iter_mut()
            .for_each(|half| furnish(scene, &facets[half.facet as usize], half, glossy));
    }

    /// (2): divides the leaves until there are so many leaves, or nothing is
    /// left to divide. Black ones stay whole.
    pub fn divide_evenly(&mut self, scene: &Scene, count: usize) {
        let leaves = self.leaves();
        let heap = leaves.iter().filter_map(|&e| self.order(e)).collect();
        // Those of about the same size together.
        self.divide_first(scene, (heap, leaves.len(), count), 0.999, |mesh, _, half| {
            mesh.order(half)
        });
    }

    /// Divides the leaves that err most, as `errs` has it of each leaf, until there are so many
    /// leaves. Errors are those of squares: a half, of half the area, errs about a quarter.
    pub fn divide_worst(&mut self, scene: &Scene, count: usize, errs: &[(u32, f32)]) {
        let heap = errs.iter().filter(|(_, err)| *err > 0.0).map(|&(e, err)| First(err, e));
        let all = (heap.collect(), errs.len(), count);
        self.divide_first(scene, all, 0.5, |_, err, half| Some(First(0.25 * err, half)));
    }

    /// Divides what is first in a heap of leaves, all within a part of it together, until `number`
    /// leaves have become `count`. `then` says where halves come.
    fn divide_first(
        &mut self,
        scene: &Scene,
        (mut heap, mut number, count): (BinaryHeap<First>, usize, usize),
        together: f32,
        then: impl Fn(&Mesh, f32, u32) -> Option<First>,
    ) {
        while number < count && !heap.is_empty() {
            let mut divided = Vec::new();
            let bound = heap.peek().map_or(0.0, |l| l.0) * together;
            while let Some(l) = heap.peek()
                && l.0 > bound
                && number + divided.len() < count
            {
                divided.extend(heap.pop());
            }
            let first = self.elements.len() as u32;
            let leaves: Vec<u32> = divided.iter().map(|l| l.1).collect();
            self.divide(scene, &leaves);
            for (k, First(order, _)) in divided.into_iter().enumerate() {
                let half = first + 2 * k as u32;
                heap.extend([half, half + 1].into_iter().filter_map(|e| then(self, order, e)));
            }
            number += leaves.len();
        }
    }

    /// (2).
    fn order(&self, e: u32) -> Option<First> {
        let element = &self.elements[e as usize];
        (!element.is_black()).then(|| First(element.area * element.longest_side().1.powi(2), e))
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
