//! Volumes: what varies over space, for media, phase functions and textures.

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId, Value};
use super::textures::Role;
use crate::vol;
use kaustika_math::{Bounds3, Transform};
use kaustika_scene::description::{
    FieldDesc, GridDesc, GridFilter, GridLayout, Span, TextureId, TextureNode,
};
use kaustika_spectra::{SpectrumDesc, rec709_luminance};
use std::sync::Arc;

const KNOWN: &[&str] = &["constvolume", "gridvolume"];

/// A volume and the unit cube it fills.
pub(super) struct Volume {
    pub desc: FieldDesc,
    pub to_world: Transform,
}

fn constant(desc: SpectrumDesc) -> Volume {
    Volume { desc: FieldDesc::Constant(desc), to_world: Transform::IDENTITY }
}

impl<'a> Converter<'a> {
    /// A volume parameter: a number, a colour, a spectrum or a volume.
    pub(super) fn volume(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
        role: Role,
    ) -> Volume {
        let fallback = constant(SpectrumDesc::Constant(default));
        let Some(p) = object.get(name) else { return fallback };
        if let Some((desc, _)) = self.plain_value(object, p, role) {
            return constant(desc);
        }
        let Some(id) = self.target(p) else {
            // Dangling references were reported.
            if !matches!(p.value, Value::Reference(_)) {
                self.wrong_type(object, p, "a number, colour, spectrum or volume");
            }
            return fallback;
        };
        match self.object(id).kind {
            Kind::Volume => self.volume_object(id, role).unwrap_or(fallback),
            Kind::Texture => match self.spectrum_object(id, role) {
                Some((desc, _)) => constant(desc),
                None => {
                    self.wrong_type(object, p, "a spectrum or volume");
                    fallback
                }
            },
            _ => {
                self.wrong_type(object, p, "a number, colour, spectrum or volume");
                fallback
            }
        }
    }

    fn volume_object(&mut self, id: ObjectId, role: Role) -> Option<Volume> {
        let object = self.object(id);
        let made = match object.plugin.as_str() {
            "constvolume" => {
                let to_world = self.transform(object, "to_world");
                let value = object.get("value").and_then(|p| {
                    let plain = self.plain_value(object, p, role);
                    let spectrum = || {
                        let id = self.target(p)?;
                        self.spectrum_object(id, role)
                    };
                    plain.or_else(spectrum)
                });
                let (desc, _) = value.unwrap_or((SpectrumDesc::Constant(1.0), 1.0));
                Some(Volume { desc: FieldDesc::Constant(desc), to_world })
            }
            "gridvolume" => self.grid_volume(object),
            _ => {
                self.unknown_plugin(object, KNOWN);
                self.replaced_silently(object);
                None
            }
        };
        self.finish(id);
        made
    }

    /// The texture `volume`: what a volume has where the surface is. A number of a colour is its
    /// luminance.
    pub(super) fn volume_texture(&mut self, object: &'a Object, role: Role) -> TextureId {
        let Some((p, id)) = self.child(object, Kind::Volume) else {
            let message = "texture `volume` needs a volume inside";
            self.out.diagnostics.error(object.span, message);
            return self.out.float(0.5);
        };
        match self.volume_object(id, role).map(|v| v.desc) {
            Some(FieldDesc::Constant(desc)) => self.spectrum_texture(desc, p.span),
            Some(FieldDesc::Grid(grid)) => {
                let grid = if role == Role::Scalar { luminance(grid) } else { grid };
                self.out.add_texture(TextureNode::Grid(grid), Some(object.span))
            }
            None => self.out.float(0.5),
        }
    }

    fn grid_volume(&mut self, object: &'a Object) -> Option<Volume> {
        let (grid, span) = self.grid(object)?;
        if grid.channels == 6 {
            let message = "samples of six channels are for the phase function `sggx`";
            self.out.diagnostics.error(span, message);
            return None;
        }
        let to_world = grid.to_world;
        Some(Volume { desc: FieldDesc::Grid(grid), to_world })
    }

    /// The samples of a `gridvolume`, and where their file was named.
    pub(super) fn grid(&mut self, object: &'a Object) -> Option<(Arc<GridDesc>, Span)> {
        object.ignore(&["raw", "accel", "max_value", "send_data"]);
        let filters = [("trilinear", GridFilter::Trilinear), ("nearest", GridFilter::Nearest)];
        let filter = self.choice(object, "filter_type", &filters, GridFilter::Trilinear);
        let wraps = [
            ("clamp", GridLayout::CellsClamped),
            ("repeat", GridLayout::CellsRepeated),
            ("mirror", GridLayout::CellsMirrored),
        ];
        let layout = self.choice(object, "wrap_mode", &wraps, GridLayout::CellsClamped);
        let to_world = self.transform(object, "to_world");
        let by_file = self.boolean(object, "use_grid_bbox", old(object));
        // 0.6 lets the scene say which box it is.
        let given = ["min", "max"].map(|n| self.vector(object, n));
        let (path, span) = self.file(object, "filename")?;
        let file = match vol::read(&path, vol::Samples::Amounts) {
            Ok(file) => file,
            Err(cause) => {
                let message = format!("can't read the volume `{}`: {cause}", path.display());
                self.out.diagnostics.error(span, message);
                return None;
            }
        };
        let bounds = match given {
            [Some(a), Some(b)] => Bounds3::new(super::convert::vec3(a), super::convert::vec3(b)),
            _ => file.bounds,
        };
        let to_world = match by_file {
            true => match of_box(&bounds) {
                Some(place) => to_world * place,
                None => {
                    self.out.diagnostics.error(span, "the box of the volume has no extent");
                    return None;
                }
            },
            false => to_world,
        };
        let layout = if old(object) { GridLayout::Corners } else { layout };
        let grid = GridDesc {
            resolution: file.resolution,
            channels: file.channels,
            values: file.values,
            to_world,
            layout,
            filter,
        };
        Some((Arc::new(grid), span))
    }
}

/// A grid of numbers in place of one of colours.
fn luminance(grid: Arc<GridDesc>) -> Arc<GridDesc> {
    if grid.channels != 3 {
        return grid;
    }
    let values = grid.values.chunks_exact(3).map(|c| rec709_luminance([c[0], c[1], c[2]]));
    Arc::new(GridDesc { channels: 1, values: values.collect(), ..*grid })
}

/// The unit cube to a box; `None` if it is flat.
pub(super) fn of_box(b: &Bounds3) -> Option<Transform> {
    Some(Transform::translate(b.min) * Transform::scale(b.diagonal())?)
}
