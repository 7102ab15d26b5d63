//! What a light transport method is to the rest of the program.

use crate::frame::Frame;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::Scene;
use kaustika_scene::description::TriMesh;
use kaustika_spectra::ColorMode;
use std::io::{self, Read, Write};
use std::iter::Sum;
use std::ops::AddAssign;
use thiserror::Error;

/// What is known of a method before it runs.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Name on the command line.
    pub name: &'static str,
    /// One line: what it does.
    pub summary: &'static str,
    /// The light paths it can find, in the lecture's alphabet.
    pub path_class: &'static str,
    /// Paths that it can never make, for the user to know.
    pub misses: &'static str,
    /// What its expectation is.
    pub bias: Bias,
    /// True if it renders participating media of every kind; see also [`Method::knows_media`].
    pub media: bool,
    /// True if it knows the classes of its paths, for layers by path.
    pub layers: bool,
    /// How passes may be dealt out.
    pub schedule: Schedule,
    /// What one sample per pixel costs.
    pub one_spp: &'static str,
    /// Where it is described.
    pub source: &'static str,
}

/// Light that a mirror or clear glass sends from a light without extent to a diffuse surface.
pub(crate) const CAUSTICS_OF_POINTS: &str = "C.*<.D><.S>+[^CRTVOB]";

/// What a method converges to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bias {
    /// The right value, on average, at any number of passes.
    Unbiased,
    /// The right value as passes go on.
    Consistent,
    /// Something near it, or a part of it.
    Biased,
}

/// How passes depend on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// Not at all: machines may share them.
    Stateless,
    /// Each needs those before it: machines may run replicas.
    Sequential,
}

/// Work done, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassStats {
    /// Rays traced to the nearest surface.
    pub closest_rays: u64,
    /// Rays traced to find whether anything is in the way.
    pub shadow_rays: u64,
    /// Samples that were NaN or infinite and were counted as black.
    pub bad_samples: u64,
}

impl PassStats {
    /// Rays of both kinds.
    pub fn rays(&self) -> u64 {
        self.closest_rays + self.shadow_rays
    }
}

impl AddAssign for PassStats {
    fn add_assign(&mut self, o: PassStats) {
        self.closest_rays += o.closest_rays;
        self.shadow_rays += o.shadow_rays;
        self.bad_samples += o.bad_samples;
    }
}

impl Sum for PassStats {
    fn sum<I: Iterator<Item = PassStats>>(all: I) -> PassStats {
        all.fold(PassStats::default(), |mut sum, stats| {
            sum += stats;
            sum
        })
    }
}

/// What a pass is to the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommitKind {
    /// One more estimate: averaged.
    Average,
    /// One that counts as so many, above 0. What earlier passes were like may say how many, but
    /// not this one: its weight would know its errors.
    Weighted(f32),
    /// A better image: replaces what was.
    Replace,
    /// Nothing to see yet.
    TrainingOnly,
}

/// The end of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Commit {
    /// What the pass is to the image.
    pub kind: CommitKind,
    /// Work done.
    pub stats: PassStats,
}

/// Why a render ends early.
#[derive(Clone, Debug, Error)]
pub enum RenderError {
    /// It was asked to.
    #[error("the render was cancelled")]
    Cancelled,
    /// It can't go on; the text says why and what to do.
    #[error("{0}")]
    Failed(String),
}

/// Light on surfaces as a texture, linear RGB.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Radiance, W/(m² sr), row by row from the top.
    pub radiance: Vec<[f32; 3]>,
    /// Irradiance, W/m².
    pub irradiance: Vec<[f32; 3]>,
    /// The surfaces, with uv on the texture.
    pub mesh: TriMesh,
}

/// How far a picture can be trusted whose passes depend on each other, as the method knows it.
#[derive(Clone, Debug, Default)]
pub struct Trust {
    /// Standard error of each pixel's mean, linear RGB, row by row.
    pub error: Vec<[f32; 3]>,
    /// Layers of a number a pixel that tell more, by name.
    pub layers: Vec<(String, Vec<f32>)>,
}

/// A progressive estimator of an image, run in numbered passes.
///
/// Within a pass shared state is frozen; nothing depends on time, threads or budgets, so that
/// the first N passes of a longer run equal a run of N passes, bit for bit.
pub trait Method: Send {
    /// Name, path class and so on.
    fn info(&self) -> &'static MethodInfo;

    /// The colours it computes in, if it knows no others.
    fn mode(&self) -> Option<ColorMode> {
        None
    }

    /// Names of layers that it adds to the picture, after those by path.
    fn layers(&self) -> Vec<String> {
        Vec::new()
    }

    /// True if it renders the media of a scene, if there are any.
    fn knows_media(&self, scene: &Scene) -> bool {
        self.info().media || !scene.has_media()
    }

    /// True if its paths branch and it says how: the layer `trees`
    /// ([`Feature::Trees`](kaustika_film::Feature::Trees)).
    fn grows_trees(&self) -> bool {
        false
    }

    /// Paths that it never finds of lights without extent, where there are mirrors or clear glass: an
    /// expression ([`kaustika_film::path_expression`]).
    fn never_of_points(&self) -> Option<&'static str> {
        None
    }

    /// Why its picture of this scene shows light of paths outside its class, if it does so, and what to do: where several methods
    /// render one picture, that light would be there twice.
    fn strays(&self, _scene: &Scene) -> Option<&'static str> {
        None
    }

    /// Figures that tell how it goes, by name: what only this method knows of itself.
    fn report(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// The errors of the picture of all passes so far, where passes are not independent and their
    /// spread tells too little.
    fn trust(&self) -> Option<Trust> {
        None
    }

    /// What the user should know at the end, line by line.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// Whatever must happen before the first pass.
    ///
    /// # Errors
    /// If it can't render this scene.
    fn prepare(
        &mut self,
        _scene: &Scene,
        _frame: &Frame,
        _workers: &Workers,
    ) -> Result<(), RenderError> {
        Ok(())
    }

    /// Adds pass number `index` to the zeroed image `out`.
    ///
    /// # Errors
    /// If cancelled or unable to go on; the pass is then dropped.
    fn pass(
        &mut self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Commit, RenderError>;

    /// True if it knows the light on surfaces, whatever the view: [`Method::baked`].
    fn bakes(&self) -> bool {
        false
    }

    /// The light on all surfaces, after [`Method::prepare`]: a mesh with the attributes
    /// `vertex_color` (radiance, W/(m² sr)) and `vertex_irradiance` (W/m²), linear RGB.
    fn baked(&self, _scene: &Scene) -> Option<TriMesh> {
        None
    }

    /// The light on all surfaces as a texture, after [`Method::prepare`]; `None` if there is none, or if it
    /// would be too large.
    fn light_map(&self, _scene: &Scene) -> Option<LightMap> {
        None
    }

    /// Writes what must survive a break besides the film.
    ///
    /// # Errors
    /// As the writer's.
    fn save(&self, _out: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }

    /// Reads what [`Method::save`] wrote.
    ///
    /// # Errors
    /// As the reader's, or if it does not fit.
    fn load(&mut self, _from: &mut dyn Read) -> io::Result<()> {
        Ok(())
    }
}
