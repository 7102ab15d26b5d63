//! Which layers by path a path belongs to.
//!
//! Where a BSDF is of several kinds, a path through it is of several classes: its value is split
//! in proportion to the parts f = f_D + f_G of the BSDF at each vertex, exactly, with no choice of
//! a kind. So a subpath is a mixture of fronts (from the eye) or backs (from the light).

use super::{Subpath, Vertex};
use kaustika_film::path_expression::{Back, Event, Front, Kind, PathClasses, Source, Way};
use kaustika_math::Vec3;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{Light, LightId, Scene};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};

/// Parts of what a subpath carries, by class; they add up to 1 but for those that no layer wants.
type Mix<S> = Vec<(S, Spectrum)>;

/// How a vertex scatters, by kind, in parts of the whole.
pub type Kinds = Vec<(Event, Spectrum)>;

/// How a path was closed. Numbers are those of the vertices that the sides end with.
#[derive(Clone, Copy, Debug)]
pub enum Closing<'a, 'b> {
    /// The eye's side found a light after as many vertices.
    Found(usize, LightId),
    /// It went through a glowing medium.
    Glow(usize),
    /// The eye's vertex asked for a light, which lies in the direction.
    NextEvent(usize, &'b Vertex<'a>, Vec3, LightId),
    /// A vertex of the light's side and one of the eye's were joined.
    Join((usize, &'b Vertex<'a>), (usize, &'b Vertex<'a>)),
    /// The light's vertex was shown to the lens, which lies in the direction.
    ToLens(usize, &'b Vertex<'a>, Vec3),
    /// The light's side met the lens after as many vertices.
    AtLens(usize),
}

/// Follows the classes of a pair of subpaths.
#[derive(Clone, Debug)]
pub struct Tracks<'f> {
    classes: &'f PathClasses,
    /// Paths that begin at each light.
    lights: Vec<Back>,
    glow: Back,
    /// Of the eye's side before each of its vertices, and after the last.
    fronts: Vec<Mix<Front>>,
    /// Of the light's.
    backs: Vec<Mix<Back>>,
    /// What each layer got.
    found: Vec<[f32; 3]>,
}

impl<'f> Tracks<'f> {
    /// For the layers of a picture of a scene.
    pub fn new(classes: &'f PathClasses, scene: &Scene) -> Tracks<'f> {
        let label = |id| {
            let name = scene.light_name(id);
            classes.labels().iter().position(|l| l == name)
        };
        let ids = (0..scene.lights.len()).map(|i| LightId(i as u32));
        let lights = ids.map(|id| classes.light(source(scene.light(id)), label(id))).collect();
        let found = vec![[0.0; 3]; classes.layers().len()];
        let glow = classes.light(Source::Medium, None);
        Tracks { classes, lights, glow, fronts: Vec::new(), backs: Vec::new(), found }
    }

    /// Begins a sample: the classes along the eye's side.
    pub fn follow_eye(&mut self, eye: &Subpath) {
        self.found.fill([0.0; 3]);
        self.turn_eye(eye);
    }

    /// The sample's eye went another way: the classes along this one.
    pub fn turn_eye(&mut self, eye: &Subpath) {
        let classes = self.classes;
        let first = vec![(classes.camera(), Spectrum::ONE)];
        let step = |front, event| Some(classes.onward(front, event)).filter(|f| !f.is_dead());
        follow(first, eye, Mode::Radiance, step, &mut self.fronts);
    }

    /// The classes along the light's side, which begins at a light.
    pub fn follow_light(&mut self, light: &Subpath, id: LightId) {
        let classes = self.classes;
        let first = vec![(self.lights[id.0 as usize], Spectrum::ONE)];
        let step = |back, event| Some(classes.backward(back, event)).filter(|b| !b.is_dead());
        follow(first, light, Mode::Importance, step, &mut self.backs);
    }

    /// The classes of the light's side before its vertex `j`.
    pub fn back(&self, j: usize) -> &[(Back, Spectrum)] {
        &self.backs[j]
    }

    /// Adds a path's value to the layers that it belongs to.
    pub fn add(
        &mut self,
        closing: &Closing,
        value: Spectrum,
        lambda: &Wavelengths,
        sensor: &Sensor,
    ) {
        let mut found = std::mem::take(&mut self.found);
        self.each(closing, |layer, part| add_rgb(&mut found[layer], value * part, lambda, sensor));
        self.found = found;
    }

    /// Adds what light with these classes adds that arrives at the eye's vertex `i` along `wi`.
    pub fn add_merged(
        &mut self,
        (i, z, wi): (usize, &Vertex, Vec3),
        back: &[(Back, Spectrum)],
        value: Spectrum,
        lambda: &Wavelengths,
        sensor: &Sensor,
    ) {
        let front = self.front_beyond(i, z, wi);
        let mut found = std::mem::take(&mut self.found);
        self.meet(&front, back, |layer, part| {
            add_rgb(&mut found[layer], value * part, lambda, sensor);
        });
        self.found = found;
    }

    /// Adds a path whose light's side ends in the vertex `y`, before which it has these classes,
    /// joined with the eye's vertex `i`.
    pub fn add_joined(
        &mut self,
        (y, back): (&Vertex, &[(Back, Spectrum)]),
        (i, z): (usize, &Vertex),
        value: Spectrum,
        lambda: &Wavelengths,
        sensor: &Sensor,
    ) {
        let d = (z.surface.p - y.surface.p).normalize();
        let back = self.beyond(back, y, d);
        self.add_merged((i, z, -d), &back, value, lambda, sensor);
    }

    /// What the layers got since [`Tracks::follow_eye`], linear RGB.
    pub fn found(&self) -> &[[f32; 3]] {
        &self.found
    }

    /// Calls `each` with the layers of a path, and the part of it that is theirs.
    pub fn each(&self, closing: &Closing, each: impl FnMut(usize, Spectrum)) {
        let light = |id: LightId| [(self.lights[id.0 as usize], Spectrum::ONE)];
        let camera = [(self.classes.camera(), Spectrum::ONE)];
        match *closing {
            Closing::Found(i, id) => self.meet(&self.fronts[i], &light(id), each),
            Closing::Glow(i) => self.meet(&self.fronts[i], &[(self.glow, Spectrum::ONE)], each),
            Closing::NextEvent(i, z, wi, id) => {
                self.meet(&self.front_beyond(i, z, wi), &light(id), each);
            }
            Closing::Join((j, y), (i, z)) => {
                let d = (z.surface.p - y.surface.p).normalize();
                self.meet(&self.front_beyond(i, z, -d), &self.back_beyond(j, y, d), each);
            }
            Closing::ToLens(j, y, d) => self.meet(&camera, &self.back_beyond(j, y, d), each),
            Closing::AtLens(j) => self.meet(&camera, &self.backs[j], each),
        }
    }

    /// Calls `each` with the layers of a whole path from a light, and the part of it that is theirs; of its
    /// vertices, from the eye on, the kinds in which they scatter.
    pub fn each_of_path(
        &self,
        id: LightId,
        vertices: impl Iterator<Item = Kinds>,
        each: impl FnMut(usize, Spectrum),
    ) {
        let step = |front, event| Some(self.classes.onward(front, event)).filter(|f| !f.is_dead());
        let mut front = vec![(self.classes.camera(), Spectrum::ONE)];
        for kinds in vertices {
            front = advance(&front, &kinds, step);
        }
        self.meet(&front, &[(self.lights[id.0 as usize], Spectrum::ONE)], each);
    }

    fn front_beyond(&self, i: usize, z: &Vertex, wi: Vec3) -> Mix<Front> {
        let step = |front, event| Some(self.classes.onward(front, event)).filter(|f| !f.is_dead());
        advance(&self.fronts[i], &parts(z, wi, Mode::Radiance), step)
    }

    fn back_beyond(&self, j: usize, y: &Vertex, wi: Vec3) -> Mix<Back> {
        self.beyond(&self.backs[j], y, wi)
    }

    fn beyond(&self, back: &[(Back, Spectrum)], y: &Vertex, wi: Vec3) -> Mix<Back> {
        let step = |back, event| Some(self.classes.backward(back, event)).filter(|b| !b.is_dead());
        advance(back, &parts(y, wi, Mode::Importance), step)
    }

    fn meet(
        &self,
        fronts: &[(Front, Spectrum)],
        backs: &[(Back, Spectrum)],
        mut each: impl FnMut(usize, Spectrum),
    ) {
        for (front, a) in fronts {
            for (back, b) in backs {
                let mut layers = self.classes.met(*front, *back);
                while layers != 0 {
                    each(layers.trailing_zeros() as usize, *a * *b);
                    layers &= layers - 1;
                }
            }
        }
    }
}

fn add_rgb(sum: &mut [f32; 3], value: Spectrum, lambda: &Wavelengths, sensor: &Sensor) {
    let rgb = sensor.rgb(value, lambda);
    if rgb.iter().all(|v| v.is_finite()) {
        sum.iter_mut().zip(rgb).for_each(|(s, v)| *s += v);
    }
}

/// What kind of light it is.
fn source(light: &Light) -> Source {
    match light {
        Light::Area(_) => Source::Surface,
        Light::Environment(_) => Source::Background,
        _ => Source::Lamp,
    }
}

/// The mixtures before each vertex of a subpath, and after the last.
fn follow<S: Copy + PartialEq>(
    first: Mix<S>,
    path: &Subpath,
    mode: Mode,
    step: impl Fn(S, Event) -> Option<S>,
    mixes: &mut Vec<Mix<S>>,
) {
    mixes.clear();
    mixes.push(first);
    for (k, v) in path.iter().enumerate() {
        let next = match v.onward {
            None => Vec::new(),
            Some(_) if v.straight => mixes[k].clone(),
            Some((ray, _)) if v.delta => {
                advance(&mixes[k], &turning(v.surface.ng, (v.wo, ray.d)), &step)
            }
            Some((ray, _)) => advance(&mixes[k], &parts(v, ray.d, mode), &step),
        };
        mixes.push(next);
    }
}

/// A mixture after an event of one of these kinds.
fn advance<S: Copy + PartialEq>(
    mix: &[(S, Spectrum)],
    events: &[(Event, Spectrum)],
    step: impl Fn(S, Event) -> Option<S>,
) -> Mix<S> {
    let mut next: Mix<S> = Vec::new();
    for (state, part) in mix {
        for (event, share) in events {
            let (Some(state), part) = (step(*state, *event), *part * *share) else { continue };
            match next.iter_mut().find(|(s, _)| *s == state) {
                Some((_, sum)) => *sum += part,
                None if part.is_black() => {}
                None => next.push((state, part)),
            }
        }
    }
    next
}

/// How a vertex scatters from `wo` to `wi`.
fn parts(v: &Vertex, wi: Vec3, mode: Mode) -> Kinds {
    match v.inside {
        Some(_) => vec![(Event::Volume, Spectrum::ONE)],
        None => scattering(&v.bsdf, v.surface.ng, (v.wo, wi), mode),
    }
}

/// How a surface with a Dirac lobe turns light.
pub fn turning(ng: Vec3, (wo, wi): (Vec3, Vec3)) -> Kinds {
    vec![(Event::Surface(way(ng, wo, wi), Kind::Singular), Spectrum::ONE)]
}

/// How a surface scatters from `wo` to `wi`.
pub fn scattering(bsdf: &Bsdf, ng: Vec3, (wo, wi): (Vec3, Vec3), mode: Mode) -> Kinds {
    let way = way(ng, wo, wi);
    let f = bsdf.eval(wo, wi, mode, Lobes::ALL);
    let diffuse = bsdf.eval(wo, wi, mode, Lobes::DIFFUSE);
    let diffuse = diffuse.safe_div(f).clamp(0.0, 1.0);
    let event = |kind| Event::Surface(way, kind);
    vec![(event(Kind::Diffuse), diffuse), (event(Kind::Glossy), Spectrum::ONE - diffuse)]
}

fn way(ng: Vec3, wo: Vec3, wi: Vec3) -> Way {
    match ng.dot(wo) * ng.dot(wi) > 0.0 {
        true => Way::Reflection,
        false => Way::Transmission,
    }
}
