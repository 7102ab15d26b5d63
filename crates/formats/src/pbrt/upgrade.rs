//! pbrt-v3 scenes: what only v3 knows is rewritten as `pbrt --upgrade` of pbrt-v4 does
//! (parser.cpp, FormattingParserTarget), and each kind of change is noted once.
//!
//! Beyond that tool: `mapname` of an infinite light keeps its latitude-longitude layout instead
//! of asking for a converted image, and `opacity` of `uber` becomes a mask.

use super::entity::{Entity, TextureType};
use super::param::{Param, ParamType, Params, Text, Values};
use super::reader::Reader;
use kaustika_scene::description::Span;

impl Params {
    fn position(&self, name: &str, ty: ParamType) -> Option<usize> {
        self.own.iter().rposition(|p| p.name == name && p.ty == ty)
    }

    pub(super) fn remove(&mut self, name: &str, ty: ParamType) -> Option<Param> {
        self.position(name, ty).map(|i| self.own.remove(i))
    }

    /// Removes all parameters of this name; true if there were any.
    pub(super) fn remove_all(&mut self, name: &str) -> bool {
        let before = self.own.len();
        self.own.retain(|p| p.name != name);
        self.own.len() < before
    }

    pub(super) fn rename(&mut self, from: &str, to: &str) -> bool {
        let mut found = false;
        for p in self.own.iter_mut().filter(|p| p.name == from) {
            p.name = to.to_string();
            found = true;
        }
        found
    }

    pub(super) fn push(&mut self, ty: ParamType, name: &str, values: Values) {
        let (span, space) = (self.span, self.space);
        let name = name.to_string();
        self.own.push(Param { ty, name, span, values, space, bad: false, used: false });
    }

    pub(super) fn push_float(&mut self, name: &str, value: f32) {
        self.push(ParamType::Float, name, Values::Floats(vec![value]));
    }

    pub(super) fn push_string(&mut self, ty: ParamType, name: &str, value: &str) {
        let text = Text { text: value.to_string(), span: self.span };
        self.push(ty, name, Values::Strings(vec![text]));
    }

    fn remove_float(&mut self, name: &str) -> Option<f32> {
        match self.remove(name, ParamType::Float)?.values {
            Values::Floats(v) if v.len() == 1 => Some(v[0]),
            _ => None,
        }
    }

    pub(super) fn rgb(&self, name: &str) -> Option<[f32; 3]> {
        match &self.own[self.position(name, ParamType::Rgb)?].values {
            Values::Floats(v) if v.len() == 3 => Some([v[0], v[1], v[2]]),
            _ => None,
        }
    }
}

impl Reader {
    /// Renames a parameter and notes it.
    pub(super) fn renamed(&mut self, e: &mut Entity, from: &str, to: &str) {
        if e.params.rename(from, to) {
            let place = e.params.place(to);
            self.v3_note(place, format!("pbrt-v3 parameter `{from}` is read as `{to}`"));
        }
    }

    /// Removes a parameter that means nothing any more and notes it.
    pub(super) fn dropped(&mut self, e: &mut Entity, name: &str) {
        let place = e.params.place(name);
        if e.params.remove_all(name) {
            self.v3_note(place, format!("pbrt-v3 parameter `{name}` is ignored"));
        }
    }

    /// Changes the kind of an entity and notes it.
    pub(super) fn rekind(&mut self, e: &mut Entity, what: &str, to: &str) {
        let message = format!("pbrt-v3 {what} `{}` is read as `{to}`", e.kind.text);
        self.v3_note(e.kind.span, message);
        e.kind.text = to.to_string();
    }
}

/// `Film`.
pub(super) fn film(e: &mut Entity, r: &mut Reader) {
    if e.kind.text == "image" {
        r.rekind(e, "film", "rgb");
    }
    r.renamed(e, "maxsampleluminance", "maxcomponentvalue");
    let place = e.params.place("scale");
    if let Some(scale) = e.params.remove_float("scale") {
        r.v3_note(place, "pbrt-v3 parameter `scale` of the film is read as `iso`");
        e.params.push_float("iso", 100.0 * scale);
    }
}

/// `PixelFilter`.
pub(super) fn filter(e: &mut Entity, r: &mut Reader) {
    r.renamed(e, "xwidth", "xradius");
    r.renamed(e, "ywidth", "yradius");
    let place = e.params.place("alpha");
    if e.kind.text == "gaussian"
        && let Some(alpha) = e.params.remove_float("alpha")
    {
        r.v3_note(place, "pbrt-v3 parameter `alpha` of the filter is read as `sigma`");
        e.params.push_float("sigma", 1.0 / (2.0 * alpha).sqrt());
    }
}

/// `Sampler`.
pub(super) fn sampler(e: &mut Entity, r: &mut Reader) {
    let to = match e.kind.text.as_str() {
        "lowdiscrepancy" | "02sequence" => "paddedsobol",
        "maxmindist" => "pmj02bn",
        "random" => "independent",
        _ => return,
    };
    r.rekind(e, "sampler", to);
}

/// `Integrator`.
pub(super) fn integrator(e: &mut Entity, r: &mut Reader) {
    r.dropped(e, "rrthreshold");
    if e.kind.text == "sppm" {
        r.dropped(e, "imagewritefrequency");
        r.dropped(e, "numiterations");
    }
    let place = e.params.place("lightsamplestrategy");
    if e.params.remove_all("lightsamplestrategy") {
        r.v3_note(place, "pbrt-v3 parameter `lightsamplestrategy` is ignored");
    }
    if e.kind.text == "directlighting" {
        r.rekind(e, "integrator", "path");
        e.params.remove_all("maxdepth");
        e.params.remove_all("strategy");
        e.params.push(ParamType::Integer, "maxdepth", Values::Ints(vec![1]));
    }
}

/// `Camera`.
pub(super) fn camera(e: &mut Entity, r: &mut Reader) {
    if e.kind.text == "environment" {
        r.rekind(e, "camera", "spherical");
        e.params.push_string(ParamType::String, "mapping", "equirectangular");
    }
    if e.kind.text == "realistic" {
        r.dropped(e, "simpleweighting");
    }
}

/// A factor of a light: `scale` as a colour and the second number of a black body.
fn light_scale(e: &mut Entity, r: &mut Reader) {
    let mut total = 1.0;
    take_grey(e, r, "scale", &mut total);
    for p in e.params.own.iter_mut().filter(|p| p.ty == ParamType::Blackbody) {
        if let Values::Floats(v) = &mut p.values
            && v.len() == 2
        {
            total *= v[1];
            v.truncate(1);
            r.v3 = true;
            r.notes.note(p.span, "pbrt-v3 black body: its second number is read as `scale`");
        }
    }
    if total != 1.0 {
        let scale = e.params.remove_float("scale").unwrap_or(1.0);
        e.params.push_float("scale", total * scale);
    }
}

/// Turns a colour into a factor of `total`; one that is not grey is averaged with a warning.
fn take_grey(e: &mut Entity, r: &mut Reader, name: &str, total: &mut f32) {
    if let Some(rgb) = e.params.rgb(name) {
        let place = e.params.place(name);
        e.params.remove(name, ParamType::Rgb);
        *total *= (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        r.v3_note(place, format!("pbrt-v3 colour `{name}` is read as the number `scale`"));
        if rgb != [rgb[0]; 3] {
            r.notes.warning(place, format!("the colour of `{name}` is lost, its mean is used"));
        }
    }
}

/// `LightSource`.
pub(super) fn light(e: &mut Entity, r: &mut Reader) {
    r.dropped(e, "samples");
    r.dropped(e, "nsamples");
    if e.params.has("mapname") {
        let factor = if e.kind.text == "infinite" { "L" } else { "I" };
        let mut total = 1.0;
        if e.kind.text != "goniometric" {
            take_grey(e, r, factor, &mut total);
        }
        if total != 1.0 {
            let scale = e.params.remove_float("scale").unwrap_or(1.0);
            e.params.push_float("scale", total * scale);
        }
        if e.kind.text == "infinite" {
            let place = e.params.place("mapname");
            r.v3_note(place, "pbrt-v3 parameter `mapname`: a latitude-longitude image");
        } else {
            r.renamed(e, "mapname", "filename");
        }
    }
    light_scale(e, r);
}

/// `AreaLightSource`.
pub(super) fn area_light(e: &mut Entity, r: &mut Reader) {
    if e.kind.text == "area" {
        r.rekind(e, "area light", "diffuse");
    }
    r.dropped(e, "nsamples");
    r.dropped(e, "samples");
    light_scale(e, r);
}

/// `Texture`.
pub(super) fn texture(e: &mut Entity, ty: TextureType, r: &mut Reader) {
    match e.kind.text.as_str() {
        "scale" if e.params.has("tex1") || e.params.has("tex2") => scale_texture(e, ty, r),
        "imagemap" | "ptex" => {
            if let Some(p) = e.params.remove("trilinear", ParamType::Bool) {
                r.v3_note(p.span, "pbrt-v3 parameter `trilinear` is read as `filter`");
                let filter =
                    if p.values == Values::Bools(vec![true]) { "trilinear" } else { "bilinear" };
                e.params.push_string(ParamType::String, "filter", filter);
            }
            gamma(e, r);
            r.dropped(e, "noncolor");
        }
        _ => {}
    }
}

/// `tex1` and `tex2` of v3's scale texture become `tex` and the number `scale`.
fn scale_texture(e: &mut Entity, ty: TextureType, r: &mut Reader) {
    let place = e.params.place(if e.params.has("tex1") { "tex1" } else { "tex2" });
    r.v3_note(
        place,
        "pbrt-v3 parameters `tex1` and `tex2` of `scale` are read as `tex` and `scale`",
    );
    if ty == TextureType::Float {
        e.params.rename("tex1", "tex");
        e.params.rename("tex2", "scale");
        return;
    }
    // The grey one of the two becomes the number; of two colours the second is averaged.
    let grey = |p: &Params, name: &str| p.rgb(name).is_some_and(|c| c == [c[0]; 3]);
    let number = if grey(&e.params, "tex2") {
        "tex2"
    } else if grey(&e.params, "tex1") || e.params.rgb("tex2").is_none() {
        "tex1"
    } else {
        "tex2"
    };
    let tex = if number == "tex1" { "tex2" } else { "tex1" };
    if let Some(rgb) = e.params.rgb(number) {
        let place = e.params.place(number);
        e.params.remove(number, ParamType::Rgb);
        e.params.push_float("scale", (rgb[0] + rgb[1] + rgb[2]) / 3.0);
        if rgb != [rgb[0]; 3] {
            let message = "two colours in a pbrt-v3 `scale` texture: the mean of one is used";
            r.notes.warning(place, message);
        }
    } else {
        e.params.rename(number, "scale");
    }
    e.params.rename(tex, "tex");
}

fn gamma(e: &mut Entity, r: &mut Reader) {
    let place = e.params.place("gamma");
    let encoding = if let Some(g) = e.params.remove_float("gamma") {
        format!("gamma {g}")
    } else if let Some(p) = e.params.remove("gamma", ParamType::Bool) {
        let srgb = p.values == Values::Bools(vec![true]);
        if srgb { "sRGB".to_string() } else { "linear".to_string() }
    } else {
        return;
    };
    r.v3_note(place, "pbrt-v3 parameter `gamma` is read as `encoding`");
    e.params.push_string(ParamType::String, "encoding", &encoding);
}

/// `Shape`.
pub(super) fn shape(e: &mut Entity, r: &mut Reader) {
    match e.kind.text.as_str() {
        "trianglemesh" => {
            r.renamed(e, "st", "uv");
            for p in e.params.own.iter_mut().filter(|p| p.name == "uv" && p.ty == ParamType::Float)
            {
                p.ty = ParamType::Point2;
                r.v3 = true;
                r.notes.note(p.span, "pbrt-v3 type `float` of `uv` is read as `point2`");
            }
        }
        "loopsubdiv" => r.renamed(e, "nlevels", "levels"),
        _ => {}
    }
    if matches!(e.kind.text.as_str(), "trianglemesh" | "plymesh") {
        r.dropped(e, "discarddegenerateUVs");
        r.dropped(e, "shadowalpha");
    }
}

/// Whether names may be defined twice; pbrt-v3 lets the last definition count.
pub(super) fn report_redefined(r: &mut Reader) {
    for (name, what) in std::mem::take(&mut r.redefined) {
        let span: Span = name.span;
        if r.v3 {
            r.notes.note(
                span,
                format!("{what}s are defined twice, as pbrt-v3 allows: the last counts"),
            );
        } else {
            let message = format!("{what} `{}` is defined twice", name.text);
            r.diag.error(span, message).hint("give it another name");
        }
    }
}
