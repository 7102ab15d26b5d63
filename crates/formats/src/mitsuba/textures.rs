//! Texture parameters and texture plugins.

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId, Parameter, Value};
use super::resources::{BitmapPlace, no_bitmap};
use super::spectra::Scaled;
use kaustika_math::Affine2;
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, Encoding, Span, TextureId, TextureMapping,
    TextureNode, Wrap,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

/// Textures that Mitsuba knows.
const KNOWN: &[&str] = &[
    "bitmap",
    "checkerboard",
    "mesh_attribute",
    "volume",
    "scale",
    "vertexcolors",
    "gridtexture",
    "wireframe",
    "curvature",
    "uniform",
    "rawconstant",
    "srgb",
    "d65",
    "blackbody",
    "regular",
    "irregular",
];

/// What a texture's values mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Role {
    /// A reflectance in [0,1].
    Reflectance,
    /// A spectrum without bounds, such as an index of refraction.
    Unbounded,
    /// Light.
    Illuminant,
    /// One number; of a colour, its luminance.
    Scalar,
    /// Three numbers that are not a colour: a normal.
    Data,
}

impl<'a> Converter<'a> {
    /// The texture of a parameter.
    pub(super) fn texture(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
        role: Role,
    ) -> TextureId {
        match object.get(name) {
            Some(p) => self.texture_of(object, p, role),
            None if role == Role::Illuminant => {
                let desc = SpectrumDesc::D65 { scale: default };
                self.out.add_texture(TextureNode::Spectrum(desc), None)
            }
            None => self.out.float(default),
        }
    }

    pub(super) fn texture_of(
        &mut self,
        object: &'a Object,
        p: &'a Parameter,
        role: Role,
    ) -> TextureId {
        match p.value {
            Value::Float(v) if role != Role::Illuminant => {
                return self.out.add_texture(TextureNode::Float(v as f32), Some(p.span));
            }
            Value::Integer(v) if role != Role::Illuminant => {
                return self.out.add_texture(TextureNode::Float(v as f32), Some(p.span));
            }
            _ => {}
        }
        if let Some(scaled) = self.plain_value(object, p, role) {
            return self.scaled_texture(scaled, Some(p.span));
        }
        match self.target(p) {
            Some(id) if self.object(id).kind == Kind::Texture => self.texture_object(id, role),
            // Reported as a dangling reference.
            None if matches!(p.value, Value::Reference(_)) => self.out.float(0.5),
            _ => {
                self.wrong_type(object, p, "a number, colour, spectrum or texture");
                self.out.float(0.5)
            }
        }
    }

    fn scaled_texture(&mut self, (desc, scale): Scaled, span: Option<Span>) -> TextureId {
        let texture = self.out.add_texture(TextureNode::Spectrum(desc), span);
        self.scale_by(texture, scale, span)
    }

    fn scale_by(&mut self, texture: TextureId, scale: f32, span: Option<Span>) -> TextureId {
        if scale == 1.0 {
            return texture;
        }
        let scale = self.out.float(scale);
        self.out.add_texture(TextureNode::Scale { texture, scale }, span)
    }

    /// A texture plugin; each is made once for each role.
    pub(super) fn texture_object(&mut self, id: ObjectId, role: Role) -> TextureId {
        if let Some(known) = self.textures.get(&(id, role)) {
            return *known;
        }
        let made = self.guarded(id, |c| c.new_texture(id, role));
        let made = made.unwrap_or_else(|| self.out.float(0.5));
        self.textures.insert((id, role), made);
        self.finish(id);
        made
    }

    fn new_texture(&mut self, id: ObjectId, role: Role) -> TextureId {
        let object = self.object(id);
        let span = Some(object.span);
        if let Some(scaled) = self.spectrum_object(id, role) {
            return self.scaled_texture(scaled, span);
        }
        match object.plugin.as_str() {
            "bitmap" | "ldrtexture" | "exrtexture" => self.bitmap(object, role),
            "checkerboard" => {
                let mut a = self.texture(object, "color0", 0.4, role);
                let mut b = self.texture(object, "color1", 0.2, role);
                // Mitsuba 3 (seen in 3.9.1) exchanges the two where a number is asked for.
                if role == Role::Scalar {
                    std::mem::swap(&mut a, &mut b);
                }
                let mapping = TextureMapping::Uv(self.uv_mapping(object));
                self.out.add_texture(TextureNode::Checkerboard { a, b, mapping }, span)
            }
            "mesh_attribute" => {
                let scale = self.number(object, "scale", 1.0);
                let name = self.string(object, "name").map(|(n, _)| n.to_string());
                if name.is_none() && !object.has("name") {
                    self.out
                        .diagnostics
                        .error(object.span, "texture `mesh_attribute` needs `name`");
                }
                let name = name.unwrap_or_default();
                self.out.add_texture(TextureNode::MeshAttribute { name, scale }, span)
            }
            "vertexcolors" => {
                let name = "vertex_color".to_string();
                self.out.add_texture(TextureNode::MeshAttribute { name, scale: 1.0 }, span)
            }
            "d65" => {
                let scale = self.number(object, "scale", 1.0);
                self.scaled_child(object, role, scale)
            }
            "scale" => self.scale_plugin(object, role),
            "gridtexture" => {
                let between = self.texture(object, "color0", 0.2, role);
                let lines = self.texture(object, "color1", 0.4, role);
                let half_width = self.number(object, "line_width", 0.01);
                let mapping = TextureMapping::Uv(self.uv_mapping(object));
                let node = TextureNode::LineGrid { between, lines, half_width, mapping };
                self.out.add_texture(node, span)
            }
            "volume" => self.volume_texture(object, role),
            "wireframe" => {
                let color = self.texture(object, "interior_color", 0.5, role);
                self.replaced(object, "its interior colour is used");
                color
            }
            "curvature" => {
                self.replaced(object, "0.5 is used everywhere");
                self.out.float(0.5)
            }
            _ => {
                self.unknown_plugin(object, KNOWN);
                self.out.float(0.5)
            }
        }
    }

    /// The texture inside a texture, times a number.
    fn scaled_child(&mut self, object: &'a Object, role: Role, scale: f32) -> TextureId {
        match self.child(object, Kind::Texture) {
            Some((_, child)) => {
                let inner = self.texture_object(child, role);
                self.scale_by(inner, scale, Some(object.span))
            }
            None => {
                let message = format!("texture `{}` needs a texture inside", object.plugin);
                self.out.diagnostics.error(object.span, message);
                self.out.float(0.5)
            }
        }
    }

    /// Mitsuba 0.6's `scale`: a texture or `value` times `scale`, a number or a colour.
    fn scale_plugin(&mut self, object: &'a Object, role: Role) -> TextureId {
        let inner = match object.get("value") {
            Some(p) => self.texture_of(object, p, role),
            None => self.scaled_child(object, role, 1.0),
        };
        let scale = match object.get("scale") {
            Some(p) => self.texture_of(object, p, Role::Unbounded),
            None => return inner,
        };
        self.out.add_texture(TextureNode::Scale { texture: inner, scale }, Some(object.span))
    }

    fn bitmap(&mut self, object: &'a Object, role: Role) -> TextureId {
        // Mitsuba 3's `accel`, `format` and 0.6's `cache`, `maxAnisotropy` are about speed.
        object.ignore(&["accel", "format", "cache", "max_anisotropy"]);
        let filters = [
            ("bilinear", BitmapFilter::Bilinear),
            ("nearest", BitmapFilter::Nearest),
            ("trilinear", BitmapFilter::Trilinear),
            ("ewa", BitmapFilter::Ewa),
        ];
        let default = if old(object) { BitmapFilter::Ewa } else { BitmapFilter::Bilinear };
        let filter = self.choice(object, "filter_type", &filters, default);
        let wraps = [
            ("repeat", Wrap::Repeat),
            ("mirror", Wrap::Mirror),
            ("clamp", Wrap::Clamp),
            ("zero", Wrap::Black),
            ("black", Wrap::Black),
        ];
        let wrap = self.choice(object, "wrap_mode", &wraps, Wrap::Repeat);
        let mut wrap = [wrap, wrap];
        if old(object) {
            wrap[0] = self.choice(object, "wrap_mode_u", &wraps, wrap[0]);
            wrap[1] = self.choice(object, "wrap_mode_v", &wraps, wrap[1]);
        }
        let raw = self.boolean(object, "raw", false);
        let encoding = if raw { Some(Encoding::Linear) } else { self.gamma(object) };
        let channels = self.channels(object, role);
        let mapping = TextureMapping::Uv(rows_from_top(self.uv_mapping(object)));
        let file = self.file(object, "filename");
        let node = TextureNode::Bitmap(BitmapTexture {
            bitmap: no_bitmap(),
            channels,
            filter,
            wrap,
            mapping,
            scale: 1.0,
            invert: false,
            raw: raw || matches!(role, Role::Scalar | Role::Data),
            space: ColorSpace::Srgb,
        });
        let id = self.out.add_texture(node, Some(object.span));
        if let Some((path, span)) = file {
            self.pending.bitmap(path, span, BitmapPlace::Texture(id), encoding);
        }
        id
    }

    /// 0.6's `gamma`: -1 is sRGB, 0 the file's own, anything else an exponent.
    pub(super) fn gamma(&mut self, object: &'a Object) -> Option<Encoding> {
        if !old(object) {
            return None;
        }
        let gamma = self.number(object, "gamma", 0.0);
        match gamma {
            0.0 => None,
            -1.0 => Some(Encoding::Srgb),
            1.0 => Some(Encoding::Linear),
            g => Some(Encoding::Gamma(g)),
        }
    }

    /// The channels that are read; 0.6 can name one.
    fn channels(&mut self, object: &'a Object, role: Role) -> BitmapChannels {
        let default = match role {
            Role::Scalar => BitmapChannels::Luminance,
            _ => BitmapChannels::Color,
        };
        if !old(object) {
            return default;
        }
        let names = [
            ("", default),
            ("r", BitmapChannels::Channel(0)),
            ("g", BitmapChannels::Channel(1)),
            ("b", BitmapChannels::Channel(2)),
            ("a", BitmapChannels::Alpha),
            ("y", BitmapChannels::Luminance),
        ];
        self.choice(object, "channel", &names, default)
    }

    /// The map from a surface's uv to the texture's. 0.6 scales first, then shifts.
    fn uv_mapping(&mut self, object: &'a Object) -> Affine2 {
        if old(object) {
            object.ignore(&["coordinates"]);
            let both = self.number(object, "uvscale", 1.0);
            let su = self.number(object, "uscale", both);
            let sv = self.number(object, "vscale", both);
            let du = self.number(object, "uoffset", 0.0);
            let dv = self.number(object, "voffset", 0.0);
            if !object.has("to_uv") {
                return Affine2::scale_shift(su, sv, du, dv);
            }
        }
        let Some(p) = object.get("to_uv") else { return Affine2::IDENTITY };
        match &p.value {
            // Of a 3D transform, what it does in the plane z = 0.
            Value::Transform(m) => {
                Affine2 { m: [0, 1].map(|i| [m[i][0] as f32, m[i][1] as f32, m[i][3] as f32]) }
            }
            _ => {
                self.wrong_type(object, p, "a transform");
                Affine2::IDENTITY
            }
        }
    }

    /// A spectrum everywhere.
    pub(super) fn spectrum_texture(&mut self, desc: SpectrumDesc, span: Span) -> TextureId {
        self.out.add_texture(TextureNode::Spectrum(desc), Some(span))
    }
}

/// Mitsuba's v = 0 is the top row of an image, the description's the bottom row: v becomes 1 - v
/// after the mapping.
fn rows_from_top(to_uv: Affine2) -> Affine2 {
    let [u, v] = to_uv.m;
    Affine2 { m: [u, [-v[0], -v[1], 1.0 - v[2]]] }
}
