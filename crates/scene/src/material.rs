//! Materials: at each hit, textures are evaluated and the nested models of the file become the
//! flat list of a [`Bsdf`].

mod coating;
mod grating;
mod hair;
mod hit;
mod looks;
mod metallic_roughness;
mod oriented;
mod tables;

use crate::bsdf::{
    Bsdf, CoatedConductor, CoatedDiffuse, Conductor, Dielectric, Diffuse, DiffuseTransmission,
    HeightField, HeightFieldData, Masking, Measured, MeasuredData, MeasuredPolarized, Model,
    MuellerData, Null, OrenNayar, Part, Phong, Plastic, PlasticCoat, PolarizingFilter,
    RoughPlastic, RoughTransmittance, ThinDielectric, Ward, relief_roughness,
};
use crate::description::{
    MaterialId, MaterialModel, SceneDescription, SourceFormat, TangentSpace, TextureId,
};
use crate::geometry::Geometry;
use crate::surface::Surface;
use crate::texture::Textures;
use hit::Hit;
use kaustika_math::{Frame, Vec3};
use kaustika_spectra::{ColorMode, Wavelengths};
pub use looks::{Looks, Tint};
use oriented::is_oriented;
use std::cell::OnceCell;
use std::f32::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

/// All materials of a scene.
#[derive(Debug, Default)]
pub struct Materials {
    models: Vec<MaterialModel>,
    /// True for each material whose frames need their tangent along ∂p/∂u.
    oriented: Vec<bool>,
    /// Tables of each material that has some.
    tables: Vec<Option<Tables>>,
    masking: Masking,
    /// True: reflecting models reflect on both sides without being asked (pbrt).
    two_sided: bool,
    /// True: the relief that a map stands for shadows (Mitsuba 3).
    relief: bool,
    /// True: normals that a map turns away from the viewer are turned back (Mitsuba 3, glTF).
    turns_back: bool,
}

/// What materials precompute.
#[derive(Clone, Debug)]
enum Tables {
    Smooth(PlasticCoat),
    Rough(Arc<RoughTransmittance>),
    Measured(Arc<MeasuredData>),
    MeasuredPolarized(Arc<MuellerData>),
    HeightField(Arc<HeightFieldData>),
}

/// Where on the way down a nest of materials we are.
#[derive(Clone, Copy)]
struct Place {
    frame: Frame,
    /// The shading normal before bump or normal maps, if there were any.
    guard: Option<Vec3>,
    /// See [`Part::relief`].
    relief: f32,
    /// True on the back of a two-sided material: frames are turned over at the leaf.
    back: bool,
    weight: f32,
}

impl Materials {
    /// Prepares the materials of a description.
    pub fn new(description: &SceneDescription, textures: &Textures, mode: ColorMode) -> Materials {
        // Mitsuba multiplies the shadowing of both directions, pbrt correlates their heights.
        let masking = match description.format {
            SourceFormat::Mitsuba3 | SourceFormat::Mitsuba06 => Masking::Separable,
            SourceFormat::Pbrt | SourceFormat::Gltf | SourceFormat::BuiltIn => {
                Masking::HeightCorrelated
            }
        };
        Materials {
            models: description.materials.iter().map(|m| m.model.clone()).collect(),
            oriented: (0..description.materials.len() as u32)
                .map(|i| is_oriented(&description.materials, MaterialId(i), textures))
                .collect(),
            tables: tables::of_all(&description.materials, textures, mode),
            masking,
            two_sided: description.format == SourceFormat::Pbrt,
            relief: description.format == SourceFormat::Mitsuba3,
            turns_back: matches!(description.format, SourceFormat::Mitsuba3 | SourceFormat::Gltf),
        }
    }

    /// Makes `out` the scattering of material `id` at a surface; false where it is only an
    /// interface between media.
    #[inline]
    pub fn bsdf<'a>(
        &'a self,
        id: MaterialId,
        (geometry, textures): (&Geometry, &Textures),
        surface: &Surface,
        wo: Vec3,
        lambda: &mut Wavelengths,
        out: &mut Bsdf<'a>,
    ) -> bool {
        out.reset(surface.ng);
        let behind = surface.ns.dot(wo) < 0.0;
        let (leaf, back) = match &self.models[id.0 as usize] {
            MaterialModel::TwoSided { back, .. } if behind => (*back, true),
            MaterialModel::TwoSided { front, .. } => (*front, false),
            _ => (id, false),
        };
        let mut hit = Hit { geometry, textures, surface, at: OnceCell::new(), wo, lambda };
        match &self.models[leaf.0 as usize] {
            MaterialModel::Null { counts: false } if leaf == id => return false,
            // By far the most frequent material, without a walk through the nest.
            MaterialModel::Diffuse { reflectance } => {
                let frame = Frame::from_normal(surface.ns);
                let frame =
                    if back || (self.two_sided && behind) { frame.flipped() } else { frame };
                let model = Model::Diffuse(Diffuse { reflectance: hit.spectrum(*reflectance) });
                out.push(Part { frame, guard: None, relief: 0.0, weight: 1.0, model });
            }
            _ => {
                let frame = match self.oriented[id.0 as usize] {
                    true => Frame::from_normal_tangent(surface.ns, geometry.tangents(surface).0),
                    false => Frame::from_normal(surface.ns),
                };
                let place = Place { frame, guard: None, relief: 0.0, back, weight: 1.0 };
                self.add(leaf, place, &mut hit, out);
            }
        }
        true
    }

    /// True for materials of a pbrt scene.
    pub(crate) fn is_of_pbrt(&self) -> bool {
        self.two_sided
    }

    /// What a material is.
    pub(crate) fn model(&self, id: MaterialId) -> &MaterialModel {
        &self.models[id.0 as usize]
    }

    /// True if a material reflects on both sides without being asked, as all that pbrt knows and
    /// that only reflect.
    pub(crate) fn is_two_sided(&self, id: MaterialId) -> bool {
        use MaterialModel as M;
        let reflects = matches!(
            self.models[id.0 as usize],
            M::Diffuse { .. }
                | M::Conductor { .. }
                | M::CoatedDiffuse { .. }
                | M::CoatedConductor { .. }
                | M::Plastic { .. }
                | M::Measured(_)
        );
        self.two_sided && reflects
    }

    /// How microfacets' masking and shadowing combine.
    pub(crate) fn masking(&self) -> Masking {
        self.masking
    }

    /// The tables of a rough plastic.
    pub(crate) fn rough_coat(&self, id: MaterialId) -> Option<Arc<RoughTransmittance>> {
        match &self.tables[id.0 as usize] {
            Some(Tables::Rough(tables)) => Some(tables.clone()),
            _ => None,
        }
    }

    /// Those of a rough coat, for the models of a hit.
    fn rough_tables(&self, id: MaterialId) -> Option<&RoughTransmittance> {
        match &self.tables[id.0 as usize] {
            Some(Tables::Rough(tables)) => Some(tables),
            _ => None,
        }
    }

    /// The place under a frame that a map has turned.
    fn turned(&self, place: Place, frame: Frame, hit: &Hit) -> Place {
        let base = place.frame.n;
        let guard = Some(place.guard.unwrap_or(base));
        if !self.turns_back {
            return Place { frame, guard, ..place };
        }
        let mut frame = frame;
        if frame.n.dot(hit.wo) * base.dot(hit.wo) <= 0.0 {
            // Facing away from the viewer: mirrored about the unturned normal.
            let mirrored = base * (2.0 * frame.n.dot(base)) - frame.n;
            frame = Frame::from_normal_tangent(mirrored, frame.s);
        }
        let relief = if self.relief { relief_roughness(frame.n.dot(base)) } else { 0.0 };
        Place { frame, guard, relief, ..place }
    }

    fn add<'a>(&'a self, id: MaterialId, place: Place, hit: &mut Hit, out: &mut Bsdf<'a>) {
        use MaterialModel as M;
        let behind = place.frame.n.dot(hit.wo) < 0.0;
        let turns = behind && self.is_two_sided(id);
        let place = Place { back: place.back || turns, ..place };
        let model: Model<'a> = match &self.models[id.0 as usize] {
            M::Mix { a, b, amount } => {
                let t = hit.float(*amount).clamp(0.0, 1.0);
                self.add(*a, Place { weight: place.weight * (1.0 - t), ..place }, hit, out);
                self.add(*b, Place { weight: place.weight * t, ..place }, hit, out);
                return;
            }
            M::Sum { parts } => {
                for (weight, id) in parts {
                    self.add(*id, Place { weight: place.weight * weight, ..place }, hit, out);
                }
                return;
            }
            M::Mask { material, opacity } => {
                let t = hit.float(*opacity).clamp(0.0, 1.0);
                self.add(*material, Place { weight: place.weight * t, ..place }, hit, out);
                out.push(place.part(Model::Null(Null), place.weight * (1.0 - t)));
                return;
            }
            M::TwoSided { front, back } => {
                let behind = place.frame.n.dot(hit.wo) < 0.0;
                let id = if behind { *back } else { *front };
                self.add(id, Place { back: place.back ^ behind, ..place }, hit, out);
                return;
            }
            M::Bump { material, displacement, scale } => {
                let frame = bumped(hit, place.frame, *displacement, *scale);
                self.add(*material, self.turned(place, frame, hit), hit, out);
                return;
            }
            M::NormalMap { material, normals, space } => {
                let frame = normal_mapped(hit, place.frame, *normals, *space);
                self.add(*material, self.turned(place, frame, hit), hit, out);
                return;
            }
            M::Diffuse { reflectance } => {
                Model::Diffuse(Diffuse { reflectance: hit.spectrum(*reflectance) })
            }
            M::Conductor { color, specular_reflectance, roughness } => {
                Model::Conductor(Conductor {
                    fresnel: hit.conductor(color),
                    tint: hit.spectrum(*specular_reflectance),
                    surface: hit.microfacet(roughness, self.masking),
                })
            }
            M::Dielectric { ior, specular_reflectance, specular_transmittance, roughness } => {
                Model::Dielectric(Dielectric {
                    eta: hit.ior(ior),
                    reflectance: hit.spectrum(*specular_reflectance),
                    transmittance: hit.spectrum(*specular_transmittance),
                    surface: hit.microfacet(roughness, self.masking),
                })
            }
            M::ThinDielectric { ior, specular_reflectance, specular_transmittance } => {
                Model::ThinDielectric(ThinDielectric {
                    eta: hit.ior(ior),
                    reflectance: hit.spectrum(*specular_reflectance),
                    transmittance: hit.spectrum(*specular_transmittance),
                })
            }
            M::Plastic {
                diffuse_reflectance, specular_reflectance, nonlinear, roughness, ..
            } => {
                let diffuse = hit.spectrum(*diffuse_reflectance);
                let specular = hit.spectrum(*specular_reflectance);
                match (&self.tables[id.0 as usize], roughness) {
                    (Some(Tables::Smooth(coat)), _) => {
                        Model::Plastic(Plastic::new(*coat, diffuse, specular, *nonlinear))
                    }
                    (Some(Tables::Rough(coat)), Some(r)) => {
                        let surface = hit.microfacet(r, self.masking);
                        let m = RoughPlastic::new(coat, surface, diffuse, specular, *nonlinear);
                        Model::RoughPlastic(m)
                    }
                    _ => Model::Diffuse(Diffuse { reflectance: diffuse }),
                }
            }
            M::DiffuseTransmission { reflectance, transmittance, scale } => {
                Model::DiffuseTransmission(DiffuseTransmission {
                    reflectance: hit.spectrum(*reflectance) * *scale,
                    transmittance: hit.spectrum(*transmittance) * *scale,
                })
            }
            M::OrenNayar { reflectance, alpha, fast } => Model::OrenNayar(OrenNayar {
                reflectance: hit.spectrum(*reflectance),
                // Mitsuba's alpha is the root mean square slope times √2.
                sigma: hit.float(*alpha).max(0.0) * FRAC_1_SQRT_2,
                fast: *fast,
            }),
            M::Phong { diffuse_reflectance, specular_reflectance, exponent } => {
                Model::Phong(Phong {
                    diffuse: hit.spectrum(*diffuse_reflectance),
                    specular: hit.spectrum(*specular_reflectance),
                    exponent: hit.float(*exponent).max(0.0),
                })
            }
            M::Ward { variant, diffuse_reflectance, specular_reflectance, alpha_u, alpha_v } => {
                Model::Ward(Ward::new(
                    *variant,
                    hit.spectrum(*diffuse_reflectance),
                    hit.spectrum(*specular_reflectance),
                    hit.float(*alpha_u),
                    hit.float(*alpha_v),
                ))
            }
            M::Principled(desc) => hit.principled(desc),
            M::MetallicRoughness(desc) => {
                let (place, model) = hit.metallic_roughness(desc, place);
                out.push(place.part(Model::MetallicRoughness(model), place.weight));
                return;
            }
            M::HeightField { reflectance, .. } => match &self.tables[id.0 as usize] {
                Some(Tables::HeightField(data)) => Model::HeightField(HeightField {
                    data,
                    reflectance: hit.spectrum(*reflectance),
                }),
                _ => return,
            },
            M::Measured(_) => match &self.tables[id.0 as usize] {
                Some(Tables::Measured(data)) => {
                    Model::Measured(Measured { data, lambda: *hit.lambda })
                }
                _ => return,
            },
            M::MeasuredPolarized(_) => match &self.tables[id.0 as usize] {
                Some(Tables::MeasuredPolarized(data)) => {
                    Model::MeasuredPolarized(MeasuredPolarized { data, lambda: *hit.lambda })
                }
                _ => return,
            },
            M::Coating { material, .. } => {
                let first = out.parts().len();
                self.add(*material, place, hit, out);
                let (model, tables) = (&self.models[id.0 as usize], self.rough_tables(id));
                if let Some(layer) = hit.coating(model, tables, self.masking) {
                    out.replace_from(first, |part| coating::coated(part, layer));
                }
                return;
            }
            M::PolarizedPlastic { diffuse_reflectance, specular_reflectance, ior, roughness } => {
                let surface = hit.microfacet(roughness, self.masking);
                let reflectance = hit.spectrum(*diffuse_reflectance);
                let tint = hit.spectrum(*specular_reflectance);
                coating::polarized_plastic(surface, reflectance, tint, *ior)
            }
            M::Grating(desc) => Model::Grating(hit.grating(desc)),
            M::Hair(desc) => {
                out.push(hit.hair(desc, &place));
                return;
            }
            M::CoatedDiffuse { reflectance, coat } => {
                let coat = hit.coat(coat, self.masking);
                Model::CoatedDiffuse(CoatedDiffuse::new(hit.spectrum(*reflectance), coat))
            }
            M::CoatedConductor { color, base_roughness, coat } => {
                let coat = hit.coat(coat, self.masking);
                let base = hit.microfacet(base_roughness, self.masking);
                Model::CoatedConductor(CoatedConductor::new(hit.conductor(color), base, coat))
            }
            M::Filter { element, transmittance } => Model::PolarizingFilter(PolarizingFilter {
                element: hit.filter(element),
                transmittance: hit.spectrum(*transmittance),
            }),
            M::Null { .. } => Model::Null(Null),
        };
        out.push(place.part(model, place.weight));
    }
}

impl Place {
    fn part<'a>(&self, model: Model<'a>, weight: f32) -> Part<'a> {
        let flip = |n: Vec3| if self.back { -n } else { n };
        let frame = if self.back { self.frame.flipped() } else { self.frame };
        Part { frame, guard: self.guard.map(flip), relief: self.relief, weight, model }
    }
}

/// The frame of a surface displaced along its normal by a height map (Blinn 1978):
/// ∂p'/∂u = ∂p/∂u + (∂h/∂u - n·∂p/∂u) n, the change of the normal itself left out.
fn bumped(hit: &Hit, frame: Frame, height: TextureId, scale: f32) -> Frame {
    let (dpdu, dpdv) = hit.geometry.tangents(hit.surface);
    let grad = hit.textures.gradient(height, hit.at(), (dpdu, dpdv)) * scale;
    let n = frame.n;
    let dpdu = dpdu + n * (grad.x - n.dot(dpdu));
    let dpdv = dpdv + n * (grad.y - n.dot(dpdv));
    let Some(turned) = dpdu.cross(dpdv).try_normalize() else { return frame };
    Frame::from_normal_tangent(turned.face_forward(n), dpdu)
}

/// The frame with the normal that a tangent-space map gives.
fn normal_mapped(hit: &Hit, frame: Frame, normals: TextureId, space: TangentSpace) -> Frame {
    let [x, y, z] = hit.textures.raw_rgb(normals, hit.at()).map(|v| 2.0 * v - 1.0);
    let (dpdu, dpdv) = hit.geometry.tangents(hit.surface);
    let mirrored = space.follows_v && frame.n.dot(dpdu.cross(dpdv)) < 0.0;
    let (x, y) = (x * space.scale, y * if mirrored { -space.scale } else { space.scale });
    let Some(local) = Vec3::new(x, y, z).try_normalize() else { return frame };
    Frame::from_normal_tangent(frame.to_world(local), dpdu)
}
