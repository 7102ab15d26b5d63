//! Threads, and the flag that stops them.

use crate::method::RenderError;
use kaustika_film::accumulate::{PassImage, PixelBand};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A pool of threads that methods cut their passes over.
#[derive(Clone, Debug)]
pub struct Workers {
    pool: Arc<rayon::ThreadPool>,
    cancel: Arc<AtomicBool>,
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
        Ok(Workers { pool: Arc::new(pool), cancel })
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
    /// computed does not depend on the number of threads.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] if the flag was raised meanwhile; the image is then useless.
    pub fn bands<T: Send>(
        &self,
        image: &mut PassImage,
        rows: u32,
        f: impl Fn(&mut PixelBand) -> T + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let bands = image.bands(rows);
        let results: Vec<Option<T>> = self.pool.install(|| {
            bands
                .into_par_iter()
                .with_max_len(1)
                .map(|mut band| (!self.cancelled()).then(|| f(&mut band)))
                .collect()
        });
        results.into_iter().collect::<Option<Vec<T>>>().ok_or(RenderError::Cancelled)
    }
}
