//! The scene: immutable once built, shared by all threads; answers every question a method has.

use crate::batch::RayBatch;
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::description::{MaterialId, MediumId, SourceFormat, TextureId};
use crate::geometry::{Geometry, Hit, Primitive};
use crate::lanes::{Lamps, Plain};
use crate::light::{AreaShape, Light, LightSample, LightSelection};
use crate::material::Materials;
use crate::medium::Medium;
use crate::shape::ShapeSample;
use crate::surface::{LightId, Surface};
use crate::texture::{TexturePoint, Textures};
use kaustika_accel::Segment;
use kaustika_math::ray::offset_origin;
use kaustika_math::{Ray, Vec3, gamma};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// What the scene remembers of a shape.
#[derive(Clone, Debug)]
pub struct ShapeInfo {
    /// Name in the file; may be empty.
    pub name: String,
    /// What it is made of.
    pub material: MaterialId,
    /// Cut-out texture.
    pub alpha: Option<TextureId>,
    /// True if it is only a boundary between media: shadow rays pass.
    pub interface: bool,
    /// The media on the side its normal points away from and on the side it points to, if it
    /// bounds any.
    pub boundary: Option<[Option<MediumId>; 2]>,
}

/// A scene ready to be rendered.
#[derive(Debug)]
pub struct Scene {
    /// Surfaces.
    pub geometry: Geometry,
    /// One entry a shape.
    pub shapes: Vec<ShapeInfo>,
    /// Textures.
    pub textures: Textures,
    /// Materials.
    pub materials: Materials,
    /// Participating media; none if no shape bounds one and the camera stands in none.
    pub media: Vec<Medium>,
    /// The medium that the camera stands in.
    pub camera_medium: Option<MediumId>,
    /// The medium that each light stands in, where no boundary of its own says it; empty if there
    /// are no media.
    pub light_media: Vec<Option<MediumId>>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Names in the file of the lights that are no shapes, the last ones of `lights`.
    pub light_names: Vec<String>,
    /// The lights that surround the scene.
    pub environments: Vec<LightId>,
    /// How a light is chosen.
    pub light_selection: LightSelection,
    /// The shapes of plain materials.
    pub plains: Vec<Option<Plain>>,
    /// All lights, if they are a few simple lamps.
    pub lamps: Option<Lamps>,
    /// True if methods should learn how to choose lights.
    pub learns_lights: bool,
    /// The camera.
    pub camera: Camera,
    /// What the lanes of a spectrum mean.
    pub mode: ColorMode,
    /// Centre of a sphere around all surfaces and the camera.
    pub center: Vec3,
    /// Its radius, at least a little more than 0.
    pub radius: f32,
    /// Factor of the pixel footprints that textures filter over: an eighth of a pixel, as pbrt
    /// does from 64 samples on, or 0 where the scene's own renderer does not filter.
    pub footprint_scale: f32,
    /// Format the scene came from.
    pub format: SourceFormat,
}

impl Scene {
    /// The first surface along the ray with t in (0, t_max); the ray's direction is unit.
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Surface> {
        let hit = self.hit(ray, t_max)?;
        Some(self.geometry.surface(&hit, ray))
    }

    /// As [`Scene::intersect`], without the surface.
    #[inline]
    pub fn hit(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        self.geometry.intersect(ray, t_max, |p, ray| !self.is_hole(p, ray))
    }

    /// As [`Scene::hit`] for many rays; [`RayBatch::hit`] tells what each met.
    pub fn hit_all(&self, segments: &[Segment], batch: &mut RayBatch) {
        self.geometry.intersect_all(segments, batch, |p, ray| !self.is_hole(p, ray));
    }

    /// Whether anything stands in the way of each ray, in `batch.occluded`.
    pub fn occluded_all(&self, segments: &[Segment], batch: &mut RayBatch) {
        self.geometry.occluded_all(segments, batch, |p, ray| self.is_opaque(p, ray));
    }

    /// The ray that finds whether the surface `s` sees the point of the light sample.
    ///
    /// Its direction is rounded, and what it meets is tested in coordinates relative to its
    /// origin or in another space: at its end both err in proportion to its length. So it ends
    /// before the light's surface by that error too; else a light shadows itself, the more the
    /// further away it is for its size. Eight roundings: one of the direction and those of a
    /// triangle's plane seen from afar (`triangle_point_error`).
    #[inline]
    pub fn shadow_ray(&self, s: &Surface, l: &LightSample) -> Segment {
        Segment { ray: s.spawn_to(shadow_end(s.p, l)), t_max: 1.0 }
    }

    /// [`Scene::shadow_ray`] from a point chosen on a surface.
    pub fn shadow_ray_from(&self, s: &ShapeSample, l: &LightSample) -> Segment {
        let end = shadow_end(s.p, l);
        let o = offset_origin(s.p, s.p_error, s.n, end - s.p);
        Segment { ray: Ray::new(o, end - o), t_max: 1.0 }
    }

    /// As [`Scene::shadow_ray`], from a point in space.
    #[inline]
    pub fn shadow_ray_in_space(&self, p: Vec3, time: f32, l: &LightSample) -> Segment {
        let ray = Ray { o: p, d: shadow_end(p, l) - p, time };
        Segment { ray, t_max: 1.0 }
    }

    /// The medium that a ray along `d` from the surface enters, `medium` being the one it came
    /// through: the shape's on that side, or the same if the shape bounds none.
    #[inline]
    pub fn medium_beyond(
        &self,
        s: &Surface,
        d: Vec3,
        medium: Option<MediumId>,
    ) -> Option<MediumId> {
        match self.shapes[s.shape as usize].boundary {
            Some(sides) => sides[usize::from(s.ng.dot(d) > 0.0)],
            None => medium,
        }
    }

    /// The shape that a light is part of.
    pub fn shape_of_light(&self, id: LightId) -> Option<&ShapeInfo> {
        let Light::Area(light) = self.light(id) else { return None };
        let shape = match light.shape {
            AreaShape::Triangle(i, _) => self.geometry.triangles.mesh(i).shape,
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                self.geometry.quadrics[i as usize].shape
            }
        };
        self.shapes.get(shape as usize)
    }

    /// The light's name in the file, or that of its shape; may be empty.
    pub fn light_name(&self, id: LightId) -> &str {
        if let Some(shape) = self.shape_of_light(id) {
            return &shape.name;
        }
        let shapes = self.lights.len() - self.light_names.len();
        let described = (id.0 as usize).checked_sub(shapes);
        described.and_then(|i| self.light_names.get(i)).map_or("", String::as_str)
    }

    /// True if light may meet a medium.
    #[inline]
    pub fn has_media(&self) -> bool {
        !self.media.is_empty()
    }

    /// All media.
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// The medium with this number.
    #[inline]
    pub fn medium(&self, id: MediumId) -> &Medium {
        &self.media[id.0 as usize]
    }

    /// Whether anything stands in the way of a ray.
    #[inline]
    pub fn occluded(&self, s: &Segment) -> bool {
        self.geometry.occluded(&s.ray, s.t_max, |p, ray| self.is_opaque(p, ray))
    }

    /// True if nothing stands between the surface `s` and the point `target`.
    #[inline]
    pub fn unoccluded_to(&self, s: &Surface, target: Vec3) -> bool {
        !self.occluded(&Segment { ray: s.spawn_to(target), t_max: 1.0 })
    }

    /// True if light does not pass.
    #[inline]
    fn is_opaque(&self, p: &Primitive, ray: &Ray) -> bool {
        !self.shapes[p.shape(&self.geometry) as usize].interface && !self.is_hole(p, ray)
    }

    /// Decides whether a cut-out lets the ray pass here: repeatable for the same ray and place.
    #[inline]
    fn is_hole(&self, p: &Primitive, ray: &Ray) -> bool {
        let Some(alpha) = self.shapes[p.shape(&self.geometry) as usize].alpha else { return false };
        let s = self.geometry.unplaced(p, 0.0, ray);
        let a = self.textures.float(alpha, &TexturePoint::of(&self.geometry, &s));
        a < 1.0 && (a <= 0.0 || (p.hash(ray) >> 40) as f32 / (1u64 << 24) as f32 >= a)
    }

    /// The scattering at a surface for light leaving along `wo`. Dispersive materials end the
    /// secondary wavelengths. `None` where the surface is only an interface between media.
    pub fn bsdf(&self, s: &Surface, wo: Vec3, lambda: &mut Wavelengths) -> Option<Bsdf<'_>> {
        let mut bsdf = Bsdf::default();
        self.bsdf_into(s, wo, lambda, &mut bsdf).then_some(bsdf)
    }

    /// As [`Scene::bsdf`], into a value that is used for hit after hit: it is too large to be
    /// moved each time. False where there is nothing but an interface between media.
    #[inline]
    pub fn bsdf_into<'a>(
        &'a self,
        s: &Surface,
        wo: Vec3,
        lambda: &mut Wavelengths,
        out: &mut Bsdf<'a>,
    ) -> bool {
        let material = self.shapes[s.shape as usize].material;
        let parameters = (&self.geometry, &self.textures);
        self.materials.bsdf(material, parameters, s, wo, lambda, out)
    }

    /// Radiance that the surface itself emits along `wo`.
    #[inline]
    pub fn le(&self, s: &Surface, wo: Vec3, lambda: &Wavelengths) -> Spectrum {
        match s.light {
            Some(l) => self.lights[l.0 as usize].le(self, s, wo, lambda),
            None => Spectrum::ZERO,
        }
    }

    /// True if layers show normals on the viewer's side (pbrt).
    pub fn shows_facing_normals(&self) -> bool {
        self.materials.is_of_pbrt()
    }

    /// Material of a surface.
    pub fn material_of(&self, s: &Surface) -> MaterialId {
        self.shapes[s.shape as usize].material
    }

    /// The light with this number.
    #[inline]
    pub fn light(&self, id: LightId) -> &Light {
        &self.lights[id.0 as usize]
    }
}

/// Where the shadow ray from `from` to the point of a light sample ends; see
/// [`Scene::shadow_ray`].
#[inline]
pub(crate) fn shadow_end(from: Vec3, l: &LightSample) -> Vec3 {
    let back = from - l.p;
    let end_error = l.p_error + Vec3::splat(back.abs().max_component() * gamma(8));
    offset_origin(l.p, end_error, l.n, back)
}
