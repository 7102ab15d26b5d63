//! A class of paths by a method.

use super::HybridParams;
use super::partition::sets;
use super::term::Term;
use crate::frame::Frame;
use crate::method::{Method, MethodInfo, RenderError, Schedule};
use crate::registry;
use crate::workers::Workers;
use kaustika_film::path_expression::{PathClasses, PathLayer, Word};
use kaustika_math::Vec2;
use kaustika_scene::bsdf::{Bsdf, Lobes};
use kaustika_scene::{Light, Scene};
use kaustika_spectra::Wavelengths;
use serde_json::{Map, Value};

/// A method that makes one class of paths.
pub(super) struct MethodTerm {
    /// The method.
    pub(super) method: Box<dyn Method>,
}

impl MethodTerm {
    /// With parameters of its own, over those of the hybrid.
    ///
    /// # Errors
    /// If there is no such method, or it can never make the class, or not alone.
    pub(super) fn new(
        term: &Term,
        name: &str,
        given: &Map<String, Value>,
        params: &HybridParams,
    ) -> Result<MethodTerm, String> {
        let fail = |message: String| format!("the term `{}`: {message}", term.text);
        let entry = registry::find(name).ok_or_else(|| fail(unknown(name)))?;
        let mut all = Map::new();
        given.keys().try_for_each(|key| entry.knows(key)).map_err(fail)?;
        if params.hide_emitters && entry.knows("hide_emitters").is_ok() {
            all.insert("hide_emitters".into(), true.into());
        }
        all.extend(given.clone());
        let method = (entry.make)(&all).map_err(|e| fail(format!("method `{name}`: {e}")))?;
        makes(method.info(), term).map_err(fail)?;
        Ok(MethodTerm { method })
    }

    /// Makes it ready, with `frame` for the class alone.
    ///
    /// # Errors
    /// If the method can't render the scene, or the class in it.
    pub(super) fn prepare(
        &mut self,
        term: &Term,
        scene: &Scene,
        frame: &mut Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        let fail =
            |message: String| RenderError::Failed(format!("the term `{}`: {message}", term.text));
        if let Some(why) = self.method.strays(scene) {
            let name = self.method.info().name;
            return Err(fail(format!("its picture is not of its class alone: `{name}` {why}")));
        }
        if let Some(word) = self.lost(term, scene) {
            let name = self.method.info().name;
            return Err(fail(format!(
                "`{name}` never finds {word} of lights without extent, which this scene has beside \
                 mirrors or clear glass; give such paths to `light`, `sppm` or `photons@1`"
            )));
        }
        if self.method.info().layers {
            let class = PathClasses::new(vec![term.layer.clone()]);
            frame.keep_paths(class.map_err(|e| fail(e.message))?);
        }
        frame.keep_layers(&self.method.layers());
        self.method.prepare(scene, frame, workers).map_err(|e| match e {
            RenderError::Failed(message) => fail(message),
            cancelled => cancelled,
        })
    }

    /// A path of the class that the method never finds in the scene.
    fn lost(&self, term: &Term, scene: &Scene) -> Option<Word> {
        let never = PathLayer::parse(&format!("never={}", self.method.never_of_points()?)).ok()?;
        let class = term.layer.named("class");
        let has_points =
            scene.lights.iter().any(|l| !matches!(l, Light::Area(_) | Light::Environment(_)));
        let lost = sets(vec![class, never]).ok()?.remove(&0b11)?;
        (has_points && has_mirrors(scene)).then_some(lost)
    }
}

fn unknown(name: &str) -> String {
    let known: Vec<&str> = registry::ALL.iter().map(|e| e.info.name).collect();
    let known = known.join(", ");
    format!("unknown method `{name}`; known: {known}, and photons@N, radiosity@N, cache@N")
}

/// Whether a method can make a term's class.
fn makes(info: &MethodInfo, term: &Term) -> Result<(), String> {
    let name = info.name;
    if info.schedule == Schedule::Sequential {
        return Err(format!(
            "passes of `{name}` depend on each other, which those of a hybrid's methods must not"
        ));
    }
    let class =
        PathLayer::parse(&format!("class={}", info.path_class)).map_err(|e| e.to_string())?;
    let term = term.layer.named("term");
    let sets = sets(vec![term, class])?;
    if let Some(word) = sets.get(&0b01) {
        let (class, misses) = (info.path_class, info.misses);
        return Err(format!("`{name}` makes {class}, and never {word}; it misses {misses}"));
    }
    match sets.get(&0b10).filter(|_| !info.layers) {
        Some(word) => Err(format!(
            "`{name}` does not tell its paths apart: it makes all of {}, {word} too",
            info.path_class
        )),
        None => Ok(()),
    }
}

/// True if something in the scene is a mirror or clear glass.
fn has_mirrors(scene: &Scene) -> bool {
    let mut bsdf = Bsdf::default();
    let mut known = vec![false; scene.shapes.len()];
    scene.geometry.facets().iter().any(|facet| {
        let s = scene.geometry.on_facet(facet, Vec2::splat(1.0 / 3.0), 0.0);
        if std::mem::replace(&mut known[s.shape as usize], true) {
            return false;
        }
        let mirrors = Lobes::DELTA_REFLECTION | Lobes::DELTA_TRANSMISSION;
        [s.ng, -s.ng].into_iter().any(|wo| {
            let met = scene.bsdf_into(&s, wo, &mut Wavelengths::rgb(), &mut bsdf);
            met && bsdf.lobes().has(mirrors)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::term::parse;
    use super::*;

    fn made(term: &str) -> Result<(), String> {
        let term = &parse(term).expect(term)[0];
        let super::super::term::Maker::Method { name, given } = &term.maker else {
            panic!("{term:?}")
        };
        MethodTerm::new(term, name, given, &HybridParams::default()).map(|_| ())
    }

    #[test]
    fn methods_get_what_they_can_make() {
        for term in [
            "path:LS+DE",
            "light:L(D|S)*DE",
            "light:C[DG].*L",
            "whitted:L[D|S]S_M*E",
            "radiosity(patches=100):LD*E",
            "sppm:LS+DS*E",
            "photonmap:L(D|S)*E",
        ] {
            made(term).expect(term);
        }
        for (term, message) in [
            ("light:LE", "`light` makes L(D|S)*(D|S_G)E, and never `LE`"),
            ("light:LDS_ME", "never `LDS_ME`"),
            ("sppm:L(D|S)*E", "never `LE`"),
            ("radiosity:L(D|S)*E", "never `LSE`"),
            ("radiosity:LD+E", "does not tell its paths apart: it makes all of LD*E, `LE`"),
            (
                "radiosity(patch=100):LD*E",
                "method `radiosity` has no parameter `patch`; known: solver",
            ),
            ("paths:LE", "unknown method `paths`"),
            ("mlt:L(D|S)*E", "depend on each other"),
        ] {
            let error = made(term).expect_err(term);
            assert!(error.contains(message), "{term}: {error}");
        }
    }

    /// Classes of all methods are expressions, which terms are held against.
    #[test]
    fn classes_of_methods_are_expressions() {
        for entry in registry::ALL {
            PathLayer::parse(&format!("class={}", entry.info.path_class)).expect(entry.info.name);
        }
    }
}
