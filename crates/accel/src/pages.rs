//! Memory in large pages.

use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use rayon::prelude::*;

/// From this many bytes on memory is asked for in large pages.
const LARGE: usize = 4 << 20;

/// An array that does not grow. If it is large it lies in huge pages where the system has them:
/// rays jump all over a tree, and each jump to another page of 4 KiB may cost a walk through the
/// page tables, besides the node itself. And the system makes a huge page sooner than 512 small
/// ones, which shows where an array is soon done with.
#[derive(Debug)]
pub(crate) struct Array<T: Pod> {
    memory: Memory<T>,
    /// Items in use.
    len: usize,
}

#[derive(Debug)]
enum Memory<T> {
    Heap(Vec<T>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
}

impl<T: Pod + Send + Sync> Array<T> {
    /// Made in parallel, each in its place.
    pub(crate) fn collect(items: impl IndexedParallelIterator<Item = T>) -> Array<T> {
        let len = items.len();
        #[cfg(target_os = "linux")]
        if let Some(mut pages) = pages(len * size_of::<T>()) {
            let places: &mut [T] = bytemuck::cast_slice_mut(&mut pages);
            places.par_iter_mut().zip(items).for_each(|(place, item)| *place = item);
            return Array { memory: Memory::Pages(pages), len };
        }
        Array { memory: Memory::Heap(items.collect()), len }
    }

    pub(crate) fn zeros(len: usize) -> Array<T> {
        #[cfg(target_os = "linux")]
        if let Some(pages) = pages(len * size_of::<T>()) {
            return Array { memory: Memory::Pages(pages), len };
        }
        Array { memory: Memory::Heap(vec![T::zeroed(); len]), len }
    }

    /// Keeps the items that `keep` keeps, in their order.
    pub(crate) fn retain(&mut self, keep: impl Fn(&T) -> bool) {
        let mut kept = 0;
        for i in 0..self.len {
            if keep(&self[i]) {
                self[kept] = self[i];
                kept += 1;
            }
        }
        self.len = kept;
    }
}

/// Zeros, to lie in huge pages; `None` if that is not worth it, or not to be had.
#[cfg(target_os = "linux")]
fn pages(bytes: usize) -> Option<memmap2::MmapMut> {
    if bytes < LARGE {
        return None;
    }
    let pages = memmap2::MmapOptions::new().len(bytes).map_anon().ok()?;
    // A hint: without huge pages the memory is as good as any other.
    let _ = pages.advise(memmap2::Advice::HugePage);
    Some(pages)
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        let all: &[T] = match &self.memory {
            Memory::Heap(items) => items,
            #[cfg(target_os = "linux")]
            Memory::Pages(pages) => bytemuck::cast_slice(pages),
        };
        &all[..self.len]
    }
}

impl<T: Pod> DerefMut for Array<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        let all: &mut [T] = match &mut self.memory {
            Memory::Heap(items) => items,
            #[cfg(target_os = "linux")]
            Memory::Pages(pages) => bytemuck::cast_slice_mut(pages),
        };
        &mut all[..self.len]
    }
}

impl<T: Pod + Send + Sync> Clone for Array<T> {
    fn clone(&self) -> Self {
        Array::collect(self.par_iter().with_min_len(1 << 10).copied())
    }
}
