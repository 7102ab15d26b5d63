//! Memory in large pages.

use std::ops::Deref;

use bytemuck::Pod;
use rayon::prelude::*;

/// From this many bytes on memory is asked for in large pages.
const LARGE: usize = 4 << 20;

/// An array that does not change. If it is large it lies in huge pages where the system has them:
/// rays jump all over a tree, and each jump to another page of 4 KiB may cost a walk through the
/// page tables, besides the node itself.
#[derive(Debug)]
pub(crate) struct Array<T: Pod>(Memory<T>);

#[derive(Debug)]
enum Memory<T> {
    Heap(Vec<T>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
}

impl<T: Pod + Send + Sync> Array<T> {
    /// Made in parallel, each in its place.
    pub(crate) fn collect(items: impl IndexedParallelIterator<Item = T>) -> Array<T> {
        #[cfg(target_os = "linux")]
        if let Some(mut pages) = pages(items.len() * size_of::<T>()) {
            let places: &mut [T] = bytemuck::cast_slice_mut(&mut pages);
            places.par_iter_mut().zip(items).for_each(|(place, item)| *place = item);
            return Array(Memory::Pages(pages));
        }
        Array(Memory::Heap(items.collect()))
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
        match &self.0 {
            Memory::Heap(items) => items,
            #[cfg(target_os = "linux")]
            Memory::Pages(pages) => bytemuck::cast_slice(pages),
        }
    }
}

impl<T: Pod + Send + Sync> Clone for Array<T> {
    fn clone(&self) -> Self {
        Array::collect(self.par_iter().with_min_len(1 << 10).copied())
    }
}
