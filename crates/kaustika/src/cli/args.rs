//! What can be said on the command line.

use super::duration;
use super::plot::PlotArgs;
use super::values::{
    FeatureList, count, finite, fractions, key_value, passes, pixels, positive, resolution,
    threads, tonemap, variance_space, whole,
};
use clap::{Args as ClapArgs, Parser, Subcommand};
use kaustika::film::FilterDesc;
use kaustika::film::metrics::VarianceSpace;
use kaustika::sampling::SamplerKind;
use kaustika::scene::LightSelectionKind;
use kaustika::spectra::{ColorMode, Tonemap};
use kaustika::{Crop, Denoiser, Environment, RenderOptions};
use std::path::PathBuf;
use std::time::Duration;

/// A photorealistic renderer with every light transport method.
#[derive(Parser, Debug)]
#[command(name = "kaustika", version, arg_required_else_help = true)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Render a scene
    Render(Box<RenderArgs>),
    /// Put shares of one render together
    Merge(MergeArgs),
    /// Take the noise out of a rendered image
    Denoise(DenoiseArgs),
    /// Measure how far an image is from a reference
    Compare(CompareArgs),
    /// List the light transport methods and their parameters
    Methods(MethodsArgs),
    /// Say what a scene file holds
    Info(InfoArgs),
    /// Measure ray throughput on given rays
    Rays(RaysArgs),
    /// Fly around what a scene shows, drawn by z-buffer, and tell how long frames take
    Fly(FlyArgs),
    /// Draw what materials do with light
    Plot(PlotArgs),
}

/// `kaustika render`.
#[derive(ClapArgs, Debug)]
pub struct RenderArgs {
    /// Scene file: .pbrt, .pbrt.gz, .xml (Mitsuba), .gltf or .glb; without one a built-in scene is
    /// rendered
    pub scene: Option<PathBuf>,
    /// Image to write: .exr (all layers, metadata), .png, .jpg, .hdr, .pfm; may be repeated
    #[arg(short, long = "output", alias = "outfile", value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Light transport method; `kaustika methods` lists them
    #[arg(short, long, value_name = "METHOD")]
    pub method: Option<String>,
    /// Parameter of the method; may be repeated
    #[arg(short, long = "parameter", value_name = "KEY=VALUE", value_parser = key_value)]
    pub parameter: Vec<(String, String)>,
    /// Value of a scene variable (Mitsuba's $name); may be repeated
    #[arg(short = 'D', long = "define", value_name = "KEY=VALUE", value_parser = key_value)]
    pub define: Vec<(String, String)>,
    /// Samples a pixel
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true)]
    pub spp: Option<u64>,
    /// Stop after this time: 60, 60s, 5m, 1h
    #[arg(long, alias = "timeout", value_name = "TIME",
        value_parser = duration::parse, allow_hyphen_values = true)]
    pub time: Option<Duration>,
    /// Stop when 95 % of the pixels have at most this estimated relative error
    #[arg(long, value_name = "ERROR", value_parser = positive, allow_hyphen_values = true)]
    pub noise: Option<f32>,
    /// Seed; different seeds give independent renders
    #[arg(long, value_name = "N", value_parser = whole::<u64>, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Threads; 0: one a core
    #[arg(short = 't', long, alias = "nthreads", value_name = "N", default_value_t = 0,
        value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = resolution, allow_hyphen_values = true)]
    pub resolution: Option<[u32; 2]>,
    /// Pixels to render, end exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = pixels, group = "part",
        allow_hyphen_values = true)]
    pub crop: Option<[u32; 4]>,
    /// As pbrt: part of the picture to render, in fractions
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = fractions, group = "part",
        allow_hyphen_values = true)]
    pub cropwindow: Option<[f32; 4]>,
    /// As pbrt: pixels to render, end exclusive
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = pixels, group = "part",
        allow_hyphen_values = true)]
    pub pixelbounds: Option<[u32; 4]>,
    /// Transport red, green and blue (default except for pbrt scenes)
    #[arg(long, group = "mode")]
    pub rgb: bool,
    /// Transport sampled wavelengths (default for pbrt scenes)
    #[arg(long, group = "mode")]
    pub spectral: bool,
    /// Camera by name or number
    #[arg(long, value_name = "NAME|N")]
    pub camera: Option<String>,
    /// Light around the scene, instead of the scene's: an image or a radiance
    #[arg(long, value_name = "FILE|R,G,B")]
    pub environment: Option<Environment>,
    /// Sampler: independent, stratified, halton, sobol, zsobol, pmj02
    #[arg(long, value_name = "SAMPLER")]
    pub sampler: Option<SamplerKind>,
    /// Reconstruction filter: box, tent, gaussian, mitchell, catmull-rom, lanczos
    #[arg(long, value_name = "FILTER[:RADIUS]")]
    pub filter: Option<FilterDesc>,
    /// How lights are chosen: uniform, power, bvh, learned
    #[arg(long, value_name = "KIND")]
    pub light_sampler: Option<LightSelectionKind>,
    /// Feature layers: albedo, normal, ..., or all of the first surface
    #[arg(long, value_name = "LAYERS")]
    pub aov: Option<FeatureList>,
    /// Layer of some paths: a light path expression from the camera (C<RD>.*L) or from the light
    /// (LS+DS*E), or one of Arnold's names (diffuse_direct); or layers of all: bounces:N by their
    /// number of bounces, words:N by words of D and S; may be repeated
    #[arg(long, value_name = "NAME=EXPR")]
    pub layer: Vec<String>,
    /// Take the noise out of the picture: with Kaustika's own filter, or with Intel's (oidn); the
    /// noisy picture stays in .exr as the layer Noisy
    #[arg(long, value_name = "FILTER", num_args = 0..=1, require_equals = true,
        default_missing_value = "kaustika")]
    pub denoise: Option<Denoiser>,
    /// Also write the light on all surfaces: at the vertices of a mesh (.ply, .glb), or as a light map
    /// (.exr) with the mesh that it belongs on beside it (.ply); of methods that know it whatever the
    /// view (radiosity)
    #[arg(long, value_name = "FILE")]
    pub bake: Option<PathBuf>,
    /// How values become colours in .png and .jpg
    #[command(flatten)]
    pub look: LookArgs,
    /// Show the picture in the viewer tev while it is rendered
    #[arg(long, alias = "display-server", value_name = "HOST:PORT")]
    pub display: Option<String>,
    /// Render only these passes, end exclusive; `kaustika merge` puts shares together
    #[arg(long, value_name = "A..B", value_parser = passes)]
    pub passes: Option<[u64; 2]>,
    /// Go on from the checkpoint beside the first output, and keep one
    #[arg(long)]
    pub resume: bool,
    /// Write what the render cost, as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// How linear values become colours to look at.
#[derive(ClapArgs, Clone, Copy, Debug)]
pub struct LookArgs {
    /// Stops of exposure in .png and .jpg
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = finite,
        allow_hyphen_values = true)]
    pub exposure: f32,
    /// Tone curve of .png and .jpg: clamp, reinhard, aces, aces-narkowicz, agx, filmic
    #[arg(long, value_name = "CURVE", default_value = "clamp", value_parser = tonemap)]
    pub tonemap: Tonemap,
}

/// `kaustika merge`.
#[derive(ClapArgs, Debug)]
pub struct MergeArgs {
    /// Shares: checkpoints (.ckpt), or images beside which they lie
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// Image to write; may be repeated
    #[arg(short, long = "output", required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// How values become colours in .png and .jpg
    #[command(flatten)]
    pub look: LookArgs,
}

/// `kaustika denoise`.
#[derive(ClapArgs, Debug)]
pub struct DenoiseArgs {
    /// Image to filter, with layers as `render --aov albedo,sh_normal,depth` writes them
    pub image: PathBuf,
    /// Image to write; may be repeated
    #[arg(short, long = "output", required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Which filter: kaustika or oidn
    #[arg(long, value_name = "FILTER", default_value = "kaustika")]
    pub filter: Denoiser,
    /// How values become colours in .png and .jpg
    #[command(flatten)]
    pub look: LookArgs,
}

/// `kaustika compare`.
#[derive(ClapArgs, Debug)]
pub struct CompareArgs {
    /// Image to judge
    pub image: PathBuf,
    /// What it should look like
    pub reference: PathBuf,
    /// Variance of ONE sample of each pixel: adds statistical tests
    #[arg(long, value_name = "FILE")]
    pub variance: Option<PathBuf>,
    /// Samples a pixel of the image, if its metadata do not say
    #[arg(long, value_name = "N", value_parser = positive, requires = "variance")]
    pub spp: Option<f32>,
    /// Space of the variance: xyz (Mitsuba's test data) or rgb
    #[arg(long, value_name = "SPACE", default_value = "xyz", value_parser = variance_space)]
    pub space: VarianceSpace,
    /// Samples a pixel of the reference; exact if not given
    #[arg(long, value_name = "M", value_parser = positive, requires = "variance")]
    pub ref_spp: Option<f32>,
    /// Side of the tiles of the tile test
    #[arg(long, value_name = "PIXELS", default_value_t = 16)]
    pub tile: usize,
    /// Stops of exposure before FLIP
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = finite,
        allow_hyphen_values = true)]
    pub exposure: f32,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// `kaustika methods`.
#[derive(ClapArgs, Debug)]
pub struct MethodsArgs {
    /// Only this method, with its parameters
    pub name: Option<String>,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// `kaustika info`.
#[derive(ClapArgs, Debug)]
pub struct InfoArgs {
    /// Scene file
    pub scene: PathBuf,
    /// Value of a scene variable (Mitsuba's $name); may be repeated
    #[arg(short = 'D', long = "define", value_name = "KEY=VALUE", value_parser = key_value)]
    pub define: Vec<(String, String)>,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// `kaustika rays`.
#[derive(ClapArgs, Debug)]
pub struct RaysArgs {
    /// Triangle mesh
    pub mesh: PathBuf,
    /// Rays: little-endian float32, seven a ray: ox oy oz dx dy dz tmax; `any:` or `closest:`
    /// before a file's name decides for it what is asked
    #[arg(required = true)]
    pub rays: Vec<PathBuf>,
    /// Threads; 0: one a core
    #[arg(short = 't', long, value_name = "N", default_value_t = 0,
        value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// Ask only whether anything is hit, for files whose name does not say
    #[arg(long)]
    pub occlusion: bool,
    /// Timed runs over all rays, after one that is not
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = count, allow_hyphen_values = true)]
    pub repeat: u64,
    /// Write JSON: one line for each file of rays
    #[arg(long)]
    pub json: bool,
}

/// `kaustika fly`.
#[derive(ClapArgs, Debug)]
#[command(after_help = "Examples:
  kaustika fly scene.xml --resolution 1280x720
  kaustika fly scene.xml -p model=blinn -p shadows=false --frames 250 --swing 20 -o frames")]
pub struct FlyArgs {
    /// Scene file, as `render` takes it; without one the built-in scene
    pub scene: Option<PathBuf>,
    /// Folder for the frames: 0000.png and so on
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Show this mesh with its own colours in place of the scene's surfaces and lights: light that
    /// `render -m radiosity --bake FILE.ply|.glb` found
    #[arg(long, value_name = "FILE.ply|.glb")]
    pub baked: Option<PathBuf>,
    /// Frames of the flight
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = count, allow_hyphen_values = true)]
    pub frames: u64,
    /// How far the camera swings to each side around the middle of the picture, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 8.0, value_parser = finite,
        allow_hyphen_values = true)]
    pub swing: f32,
    /// Parameter of the method `zbuffer`; may be repeated
    #[arg(short, long = "parameter", value_name = "KEY=VALUE", value_parser = key_value)]
    pub parameter: Vec<(String, String)>,
    /// Value of a scene variable (Mitsuba's $name); may be repeated
    #[arg(short = 'D', long = "define", value_name = "KEY=VALUE", value_parser = key_value)]
    pub define: Vec<(String, String)>,
    /// Camera by name or number
    #[arg(long, value_name = "NAME|N")]
    pub camera: Option<String>,
    /// Size of the frames in pixels
    #[arg(long, value_name = "WxH", value_parser = resolution, allow_hyphen_values = true)]
    pub resolution: Option<[u32; 2]>,
    /// Threads; 0: one a core
    #[arg(short = 't', long, value_name = "N", default_value_t = 0,
        value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// How values become colours
    #[command(flatten)]
    pub look: LookArgs,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

impl RenderArgs {
    /// The library's view of them.
    pub fn options(&self) -> RenderOptions {
        let transposed = |[x0, x1, y0, y1]: [u32; 4]| Crop::Pixels([x0, y0, x1, y1]);
        let fractions = |[x0, x1, y0, y1]: [f32; 4]| Crop::Fractions([x0, y0, x1, y1]);
        let of_pbrt = self.pixelbounds.map(transposed).or(self.cropwindow.map(fractions));
        let mode = match (self.rgb, self.spectral) {
            (true, _) => Some(ColorMode::Rgb),
            (_, true) => Some(ColorMode::Spectral),
            _ => None,
        };
        RenderOptions {
            method: self.method.clone(),
            parameters: self.parameter.clone(),
            mode,
            camera: self.camera.clone(),
            resolution: self.resolution,
            crop: self.crop.map(Crop::Pixels).or(of_pbrt),
            sampler: self.sampler,
            filter: self.filter,
            seed: self.seed,
            spp: self.spp,
            features: self.aov.as_ref().map(|l| l.0.clone()).unwrap_or_default(),
            light_sampler: self.light_sampler,
            path_layers: self.layer.clone(),
            denoiser: self.denoise,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn render(args: &str) -> Result<RenderArgs, clap::Error> {
        let words = ["kaustika", "render", "a.pbrt"].into_iter().chain(args.split_whitespace());
        match Args::try_parse_from(words)?.command {
            Command::Render(args) => Ok(*args),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn flags_of_pbrt_are_understood() {
        let a = render("--outfile a.exr --nthreads 3 --pixelbounds 1,2,3,4 --display-server h:1")
            .unwrap();
        assert_eq!((a.output, a.threads), (vec![PathBuf::from("a.exr")], 3));
        assert_eq!(a.display.as_deref(), Some("h:1"));
        let a = render("--pixelbounds 1,2,3,4").unwrap();
        assert_eq!(a.options().crop, Some(Crop::Pixels([1, 3, 2, 4])));
        let a = render("--cropwindow 0,.5,.25,1").unwrap();
        assert_eq!(a.options().crop, Some(Crop::Fractions([0.0, 0.25, 0.5, 1.0])));
        assert_eq!(render("--timeout 2m").unwrap().time, Some(Duration::from_secs(120)));
    }

    #[test]
    fn nonsense_is_refused() {
        let wrong = ["--spp 0", "--spp many", "--noise -1", "--crop 1,2,3", "--resolution 0x5"];
        let odd = ["--spp -4", "--cropwindow nan,1,0,1", "--exposure nan", "--crop -1,0,2,2"];
        let more = ["--passes 4..4", "--passes 5", "--crop 0,0,1,1 --pixelbounds 0,1,0,1"];
        let most = ["-p depth", "--rgb --spectral", "--aov colour", "--environment 1,2"];
        for args in wrong.into_iter().chain(odd).chain(more).chain(most) {
            assert!(render(args).is_err(), "{args}");
        }
    }
}
