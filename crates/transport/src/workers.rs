//! Threads, and the flag that stops them.

use crate::method::RenderError;
use kaustika_film::accumulate::{PassImage, PixelBand};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A pool of threads that methods cut their passes over.
#[derive(Clone, Debug)]
pub struct Workers {
    pool: Arc<rayon::ThreadPool>,
    cancel: Arc<AtomicBool>,
    listener: Option<Listener>,
}

/// Whoever is told how a method gets ready.
#[derive(Clone)]
struct Listener(Arc<dyn Fn(&str) + Send + Sync>);

impl std::fmt::Debug for Listener {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("Listener")
    }
}

impl Workers {
    /// A pool of `threads` threads (0: one a core) and the flag that cancels a running pass.
    ///
    /// # Errors
    /// If the system refuses the threads.
    pub fn new(threads: usize, cancel: Arc<AtomicBool>) -> Result<Workers, RenderError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| RenderError::Failed(format!("can't start threads: {e}")))?;
        Ok(Workers { pool: Arc::new(pool), cancel, listener: None })
    }

    /// With someone who is told how methods get ready for their first pass.
    #[must_use]
    pub fn told_to(mut self, listener: impl Fn(&str) + Send + Sync + 'static) -> Workers {
        self.listener = Some(Listener(Arc::new(listener)));
        self
    }

    /// Says how far a method is on its way to the first pass, to whoever listens. Cheap if nobody does.
    pub fn tell(&self, text: impl FnOnce() -> String) {
        if let Some(listener) = &self.listener {
            (listener.0)(&text());
        }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// True once the render is to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// Runs `f` inside the pool.
    pub fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.pool.install(f)
    }

    /// Fills bands of `rows` rows in parallel and returns what each returned, in order. What is
    /// computed does not depend on the number of threads: `f` also gets room to work in, made by
    /// `room` for each thread, in which an earlier band may have left anything.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] if the flag was raised meanwhile; the image is then useless.
    pub fn bands<S: Send, T: Send>(
        &self,
        image: &mut PassImage,
        rows: u32,
        room: impl Fn() -> S + Sync,
        f: impl Fn(&mut S, &mut PixelBand) -> T + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let all = 0..image.height().div_ceil(rows) as usize;
        self.some_bands(image, rows, all, &room, f)
    }

    /// As [`Workers::bands`], of the bands with these numbers alone.
    ///
    /// # Errors
    /// As [`Workers::bands`].
    pub fn some_bands<S: Send, T: Send>(
        &self,
        image: &mut PassImage,
        rows: u32,
        which: std::ops::Range<usize>,
        room: &(impl Fn() -> S + Sync),
        f: impl Fn(&mut S, &mut PixelBand) -> T + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let mut bands = image.bands(rows);
        bands.truncate(which.end);
        let bands = bands.split_off(which.start.min(bands.len()));
        let rooms = Mutex::new(Vec::new());
        let free = || rooms.lock().unwrap_or_else(PoisonError::into_inner);
        let fill = |mut band: PixelBand| {
            if self.cancelled() {
                return None;
            }
            let mut mine = free().pop().unwrap_or_else(room);
            let result = f(&mut mine, &mut band);
            free().push(mine);
            Some(result)
        };
        let results: Vec<Option<T>> =
            self.pool.install(|| bands.into_par_iter().with_max_len(1).map(fill).collect());
        results.into_iter().collect::<Option<Vec<T>>>().ok_or(RenderError::Cancelled)
    }
}
