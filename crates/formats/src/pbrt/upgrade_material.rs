//! Materials of pbrt-v3 (see `upgrade.rs`).

use super::entity::Entity;
use super::param::{ParamType, Values};
use super::reader::Reader;

/// Name under which `uber`'s opacity is handed on; no file can write it.
pub(super) const OPACITY: &str = "v3 opacity";

impl Reader {
    /// Removes a factor that v4 does not have; true if it had this constant value. Another
    /// value is lost with a warning.
    fn factor_was(&mut self, e: &mut Entity, name: &str, value: f32) -> bool {
        if !e.params.has(name) {
            return false;
        }
        let place = e.params.place(name);
        let matches = e.params.rgb(name) == Some([value; 3]);
        if e.params.remove_all(name) && !matches {
            let message = format!("pbrt-v3 factor `{name}` of `{}` is lost", e.kind.text);
            self.notes.warning(place, message);
        }
        matches
    }
}

/// `Material` and `MakeNamedMaterial`.
pub(super) fn material(e: &mut Entity, r: &mut Reader) {
    let kind = e.kind.text.clone();
    if matches!(kind.as_str(), "glass" | "uber") {
        r.renamed(e, "index", "eta");
    }
    r.renamed(e, "bumpmap", "displacement");
    match kind.as_str() {
        "uber" => {
            if r.factor_was(e, "Ks", 0.0) {
                e.params.remove_all("roughness");
                e.params.remove_all("eta");
                r.rekind(e, "material", "diffuse");
            } else {
                r.rekind(e, "material", "coateddiffuse");
            }
            r.factor_was(e, "Kr", 0.0);
            r.factor_was(e, "Kt", 0.0);
            r.renamed(e, "Kd", "reflectance");
            if e.params.rgb("opacity") == Some([1.0; 3]) {
                e.params.remove_all("opacity");
            }
            e.params.rename("opacity", OPACITY);
        }
        "mix" => mix(e, r),
        "substrate" => {
            r.rekind(e, "material", "coateddiffuse");
            r.factor_was(e, "Ks", 1.0);
            r.renamed(e, "Kd", "reflectance");
        }
        "glass" => {
            r.rekind(e, "material", "dielectric");
            r.factor_was(e, "Kr", 1.0);
            r.factor_was(e, "Kt", 1.0);
        }
        "plastic" => {
            if r.factor_was(e, "Ks", 0.0) {
                e.params.remove_all("roughness");
                e.params.remove_all("eta");
                r.rekind(e, "material", "diffuse");
            } else {
                r.rekind(e, "material", "coateddiffuse");
            }
            r.renamed(e, "Kd", "reflectance");
        }
        "kdsubsurface" => {
            r.rekind(e, "material", "subsurface");
            r.renamed(e, "Kd", "reflectance");
        }
        "matte" => {
            r.rekind(e, "material", "diffuse");
            r.renamed(e, "Kd", "reflectance");
            r.dropped(e, "sigma");
        }
        "metal" => {
            r.rekind(e, "material", "conductor");
            r.factor_was(e, "Kr", 1.0);
        }
        "translucent" => {
            r.rekind(e, "material", "diffusetransmission");
            r.renamed(e, "Kd", "transmittance");
            r.factor_was(e, "reflect", 0.0);
            r.factor_was(e, "transmit", 1.0);
            r.factor_was(e, "Ks", 0.0);
            r.dropped(e, "roughness");
        }
        "mirror" => {
            r.rekind(e, "material", "conductor");
            e.params.push_float("roughness", 0.0);
            e.params.push_string(ParamType::Spectrum, "eta", "metal-Ag-eta");
            e.params.push_string(ParamType::Spectrum, "k", "metal-Ag-k");
            r.factor_was(e, "Kr", 1.0);
        }
        "disney" => {
            r.rekind(e, "material", "diffuse");
            r.renamed(e, "color", "reflectance");
            e.params.own.retain(|p| matches!(p.name.as_str(), "reflectance" | "displacement"));
        }
        "hair" => r.renamed(e, "color", "reflectance"),
        "fourier" => {
            let message = "pbrt-v3 material `fourier` is not supported, a grey diffuse is used";
            r.notes.warning(e.kind.span, message);
            r.v3 = true;
            e.kind.text = "diffuse".into();
            e.params.own.clear();
        }
        "" | "none" => {
            let message = format!("material `{kind}` is deprecated and read as `interface`");
            r.notes.note(e.kind.span, message);
            e.kind.text = "interface".into();
        }
        _ => {}
    }
}

/// v3 gives `amount` as a colour, the weight of the first material.
fn mix(e: &mut Entity, r: &mut Reader) {
    if let Some(rgb) = e.params.rgb("amount") {
        let place = e.params.place("amount");
        e.params.remove("amount", ParamType::Rgb);
        r.v3_note(place, "pbrt-v3 colour `amount` of `mix` is read as a number");
        if rgb != [rgb[0]; 3] {
            r.notes.warning(place, "the colour of `amount` is lost, its mean is used");
        }
        e.params.push_float("amount", (rgb[0] + rgb[1] + rgb[2]) / 3.0);
    }
    if !e.params.has("namedmaterial1") && !e.params.has("namedmaterial2") {
        return;
    }
    let place = e.params.place("namedmaterial1");
    r.v3_note(
        place,
        "pbrt-v3 parameters `namedmaterial1` and `namedmaterial2` are read as `materials`",
    );
    // The order is the other way round in v4.
    let mut names = Vec::new();
    for name in ["namedmaterial2", "namedmaterial1"] {
        if let Some(p) = e.params.remove(name, ParamType::String)
            && let Values::Strings(v) = p.values
        {
            names.extend(v.into_iter().take(1));
        }
    }
    e.params.push(ParamType::String, "materials", Values::Strings(names));
}
