//! The running render in the viewer tev.

use super::failure::Failure;
use kaustika::film::accumulate::PassTree;
use kaustika::film::{Picture, TevClient};
use kaustika::output;
use std::time::{Duration, Instant};

/// Time between two updates.
const INTERVAL: Duration = Duration::from_millis(500);
/// Longest time spent on handing over the final picture.
const FAREWELL: Duration = Duration::from_secs(5);

/// A picture kept up to date in tev.
pub struct Viewer {
    client: TevClient,
    name: String,
    last: Option<Instant>,
}

impl Viewer {
    /// Connects to tev at `host:port`; the picture will be called `name` there.
    ///
    /// # Errors
    /// If nobody listens there.
    pub fn connect(address: &str, name: String) -> Result<Viewer, Failure> {
        let client = TevClient::connect(address)
            .map_err(|e| Failure::Input(format!("no viewer at {address}: {e}")))?;
        Ok(Viewer { client, name, last: None })
    }

    /// Shows the passes so far, if it is time to.
    pub fn update(&mut self, tree: &PassTree) {
        if self.last.is_none_or(|t| t.elapsed() >= INTERVAL) {
            self.client.update(&self.name, &output::preview(tree));
            self.last = Some(Instant::now());
        }
    }

    /// Shows the picture with all its layers.
    pub fn finish(&mut self, picture: &Picture) {
        let start = Instant::now();
        while !self.client.update(&self.name, picture)
            && self.client.is_connected()
            && start.elapsed() < FAREWELL
        {}
    }
}
