//! The method a file asks for.

use super::convert::Converter;
use super::document::{Kind, Object, ObjectId};
use kaustika_scene::description::{IntegratorDesc, Span};

/// Integrators of Mitsuba 3 and 0.6.
const KNOWN: &[&str] = &[
    "path",
    "direct",
    "volpath",
    "volpathmis",
    "ptracer",
    "aov",
    "moment",
    "depth",
    "stokes",
    "prb",
    "prb_basic",
    "prbvolpath",
    "direct_projective",
    "prb_projective",
    "volpath_simple",
    "bdpt",
    "mlt",
    "pssmlt",
    "erpt",
    "photonmapper",
    "ppm",
    "sppm",
    "vpl",
    "ao",
    "irrcache",
    "adaptive",
    "multichannel",
    "field",
    "mtspath",
];

/// Kinds of layers of `aov`, and what of Kaustika's has the same values.
const LAYERS: &[(&str, Option<&str>)] = &[
    ("albedo", Some("albedo")),
    ("depth", Some("depth")),
    ("position", Some("position")),
    ("uv", Some("uv")),
    ("geo_normal", Some("normal")),
    ("sh_normal", Some("sh_normal")),
    ("shape_index", Some("shape_id")),
    ("prim_index", None),
    ("dp_du", None),
    ("dp_dv", None),
    ("duv_dx", None),
    ("duv_dy", None),
    ("boundary_test", None),
];

/// Those whose parameters are all known here; others have settings of their own.
const PLAIN: &[&str] = &["path", "direct", "volpath", "volpathmis", "volpath_simple", "ptracer"];

impl<'a> Converter<'a> {
    pub(super) fn integrator(&mut self, id: ObjectId) {
        let object = self.object(id);
        if !self.out.integrator.name.is_empty() {
            self.out
                .diagnostics
                .warning(object.span, "the scene has more than one integrator")
                .label("the first counts");
            return;
        }
        if object.plugin == "aov" {
            self.layers(object);
        }
        // Integrators around others (`moment`, `aov`, `adaptive`, ...) add to what these do; of
        // several the first that makes a picture counts.
        let inner = self.children(object, Kind::Integrator);
        let (depths, pictures): (Vec<_>, Vec<_>) =
            inner.into_iter().partition(|(_, child)| self.object(*child).plugin == "depth");
        for (_, child) in depths {
            self.depth_layer(self.object(child));
        }
        if let Some((_, child)) = pictures.first() {
            let made = self.guarded(id, |c| c.integrator(*child));
            if made.is_some() {
                self.out.integrator.polarized |= object.plugin == "stokes";
                return;
            }
        }
        if object.plugin == "depth" {
            self.depth_layer(object);
        }
        if !KNOWN.contains(&object.plugin.as_str()) {
            self.out
                .diagnostics
                .warning(object.type_span, format!("unknown integrator `{}`", object.plugin))
                .nearest(&object.plugin, KNOWN);
        }
        let max_depth = match object.plugin.as_str() {
            // One bounce by definition.
            "direct" | "direct_projective" => Some(1),
            _ => self.depth(object, "max_depth", -1),
        };
        self.out.integrator = IntegratorDesc {
            name: object.plugin.clone(),
            max_depth,
            rr_depth: self.depth(object, "rr_depth", 1),
            hide_emitters: self.boolean(object, "hide_emitters", false),
            polarized: object.plugin == "stokes",
            strict_normals: self.boolean(object, "strict_normals", false),
            light_sampler: None,
            span: Some(object.span),
        };
        object.ignore(&[
            "timeout",
            "block_size",
            "samples_per_pass",
            "shading_samples",
            "emitter_samples",
            "bsdf_samples",
            "use_spectral_mis",
            "hide_environment",
        ]);
        if PLAIN.contains(&object.plugin.as_str()) {
            self.finish(id);
        } else {
            self.note_unread(object);
        }
    }

    /// Mitsuba counts from 1 for emission, so one less here; -1 means none. `lowest` is the
    /// least that is allowed.
    fn depth(&mut self, object: &'a Object, name: &'static str, lowest: i64) -> Option<u32> {
        let depth = self.integer(object, name)?;
        if depth < lowest {
            let span = object.get(name).map(|p| p.value_span);
            let message = format!("`{name}` must be at least {lowest}");
            self.out.diagnostics.error(span, message);
            return None;
        }
        (depth >= 0).then(|| u32::try_from(depth.saturating_sub(1).max(0)).unwrap_or(u32::MAX))
    }

    /// `aovs="name:kind,..."`: the kinds are what is asked for.
    fn layers(&mut self, object: &'a Object) {
        let Some((text, span)) = self.string(object, "aovs") else { return };
        for item in text.split(',').map(str::trim).filter(|i| !i.is_empty()) {
            match item.split_once(':') {
                Some((name, kind)) if !name.is_empty() && !kind.is_empty() => {
                    self.layer(kind.trim(), span);
                }
                _ => {
                    let message = format!("expected `name:kind`, found `{item}`");
                    self.out.diagnostics.error(span, message);
                }
            }
        }
    }

    /// One kind of layer.
    fn layer(&mut self, kind: &str, span: Span) {
        match LAYERS.iter().find(|(name, _)| *name == kind) {
            Some((_, Some(ours))) => self.aovs.push(ours.to_string()),
            Some((_, None)) => {
                let message = format!("there is no layer `{kind}`, it is left out");
                self.out.diagnostics.warning(span, message);
            }
            None => {
                let known: Vec<&str> = LAYERS.iter().map(|(name, _)| *name).collect();
                let message = format!("unknown layer `{kind}`");
                self.out.diagnostics.error(span, message).nearest(kind, &known);
            }
        }
    }

    /// What the integrator `depth` shows is a layer beside the picture.
    fn depth_layer(&mut self, object: &Object) {
        self.aovs.push("depth".to_string());
        let message = "the distances of integrator `depth` are the layer Depth.Z";
        self.out.diagnostics.note(object.span, message);
    }

    fn note_unread(&mut self, object: &Object) {
        let names: Vec<String> = object
            .parameters
            .iter()
            .filter(|p| !p.used.get())
            .map(|p| format!("`{}`", p.written))
            .collect();
        if !names.is_empty() {
            let message = format!("settings of integrator `{}` are not read", object.plugin);
            self.out.diagnostics.note(object.span, message).label(names.join(", "));
        }
    }
}
