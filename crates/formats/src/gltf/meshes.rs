//! Meshes: primitives that make triangles, with what their materials need.

use super::Reader;
use super::accessors::Numbers;
use super::buffers::{Buffers, COMPRESSIONS};
use super::json::{Fault, Json};
use super::materials::{Material, Materials};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::{MeshAttribute, TriMesh};
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// A primitive: triangles of one material.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub mesh: Arc<TriMesh>,
    pub material: Material,
}

/// The meshes of a file, read when first placed.
pub(super) struct Meshes<'a> {
    list: Vec<Json<'a>>,
    accessors: Vec<Json<'a>>,
    built: HashMap<usize, Rc<Vec<Part>>>,
}

impl<'a> Meshes<'a> {
    pub fn new(root: &Json<'a>) -> Result<Meshes<'a>, Fault> {
        let (list, accessors) = (root.list("meshes")?, root.list("accessors")?);
        Ok(Meshes { list, accessors, built: HashMap::new() })
    }

    /// The meshes as the file has them.
    pub fn list(&self) -> &[Json<'a>] {
        &self.list
    }

    /// The accessors of the file.
    pub fn accessors(&self) -> &[Json<'a>] {
        &self.accessors
    }

    /// An attribute's numbers, if the primitive has it.
    fn attribute(
        &self,
        attributes: &Json,
        name: &str,
        widths: &[usize],
        buffers: &Buffers,
    ) -> Result<Option<Numbers>, Fault> {
        match attributes.refer(name, &self.accessors, "accessor")? {
            Some((_, accessor)) => buffers.numbers(accessor, widths).map(Some),
            None => Ok(None),
        }
    }
}

impl Reader<'_> {
    /// The primitives of a mesh; what is wrong with one is reported, and the others are read.
    pub(super) fn mesh(
        &mut self,
        index: usize,
        buffers: &Buffers,
        materials: &mut Materials,
        meshes: &mut Meshes,
    ) -> Rc<Vec<Part>> {
        if let Some(parts) = meshes.built.get(&index) {
            return parts.clone();
        }
        let mut parts = Vec::new();
        let mesh = meshes.list[index].clone();
        match mesh.list("primitives") {
            Ok(primitives) => {
                for p in primitives {
                    match self.primitive(&p, buffers, materials, meshes) {
                        Ok(part) => parts.extend(part),
                        Err(fault) => self.report(fault),
                    }
                }
            }
            Err(fault) => self.report(fault),
        }
        let parts = Rc::new(parts);
        meshes.built.insert(index, parts.clone());
        parts
    }

    fn primitive(
        &mut self,
        p: &Json,
        buffers: &Buffers,
        materials: &mut Materials,
        meshes: &Meshes,
    ) -> Result<Option<Part>, Fault> {
        for name in COMPRESSIONS {
            if p.extension(name).is_some() {
                return Err(p
                    .fault(format!("`{name}` is not supported"))
                    .hint("write the scene without compression"));
            }
        }
        let mode = p.size("mode", 4)?;
        if mode < 4 {
            self.report(p.fault("points and lines are not supported and are left out").mild());
            return Ok(None);
        }
        if p.get("targets").is_some_and(|t| t.len() > 0) {
            self.report(
                p.fault("morph targets are not applied: the mesh has its rest pose").mild(),
            );
        }
        let attributes = p.require("attributes")?;
        let Some(positions) = meshes.attribute(&attributes, "POSITION", &[3], buffers)? else {
            self.report(attributes.fault("a primitive without POSITION shows nothing").mild());
            return Ok(None);
        };
        let n = positions.len();
        let mut mesh = TriMesh {
            positions: positions.arrays().map(Vec3::from).collect(),
            ..TriMesh::default()
        };
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            return Err(attributes.fault(format!("position {i} is not finite")));
        }
        let fits = |name: &str, numbers: &Numbers| {
            let found = numbers.len();
            let text = format!("{n} positions, but {found} elements of {name}");
            if found == n { Ok(()) } else { Err(attributes.fault(text)) }
        };
        if let Some(normals) = meshes.attribute(&attributes, "NORMAL", &[3], buffers)? {
            fits("NORMAL", &normals)?;
            let unit = |n: [f32; 3]| Vec3::from(n).try_normalize().unwrap_or(Vec3::ZERO);
            mesh.normals = normals.arrays().map(unit).collect();
        }
        let listed = p.refer("material", materials.list(), "material")?.map(|m| m.0);
        let sets = materials.uv_sets(listed);
        for (k, set) in sets.iter().enumerate() {
            let name = format!("TEXCOORD_{set}");
            let Some(uvs) = meshes.attribute(&attributes, &name, &[2], buffers)? else {
                let text = format!("the material needs {name}, which the mesh has not");
                self.report(attributes.fault(text).mild());
                continue;
            };
            fits(&name, &uvs)?;
            let up = uvs.arrays().map(|[u, v]: [f32; 2]| [u, 1.0 - v]);
            if k == 0 {
                mesh.uvs = up.map(|[u, v]| Vec2::new(u, v)).collect();
            } else {
                mesh.attributes.push(MeshAttribute {
                    name: format!("uv{set}"),
                    channels: 3,
                    per_face: false,
                    values: up.flat_map(|[u, v]| [u, v, 0.0]).collect(),
                });
            }
        }
        let (mut has_color, mut has_alpha) = (false, false);
        if let Some(colors) = meshes.attribute(&attributes, "COLOR_0", &[3, 4], buffers)? {
            fits("COLOR_0", &colors)?;
            has_color = true;
            let values = colors.arrays::<3>().flatten().map(|v| v.clamp(0.0, 1.0)).collect();
            let attribute = |name: &str, channels, values| MeshAttribute {
                name: name.into(),
                channels,
                per_face: false,
                values,
            };
            mesh.attributes.push(attribute("vertex_color", 3, values));
            let alphas: Vec<f32> = colors.arrays::<4>().map(|c| c[3].clamp(0.0, 1.0)).collect();
            if colors.width == 4 && alphas.iter().any(|a| *a != 1.0) {
                has_alpha = true;
                mesh.attributes.push(attribute("vertex_alpha", 1, alphas));
            }
        }
        let indices = match p.refer("indices", &meshes.accessors, "accessor")? {
            Some((_, accessor)) => buffers.indices(accessor, n)?,
            None => (0..n as u32).collect(),
        };
        mesh.indices = triangles(mode, &indices)
            .ok_or_else(|| p.fault(format!("unknown mode {mode}")).hint("modes are 0 to 6"))?;
        if mode == 4 && indices.len() % 3 != 0 {
            let left = indices.len() % 3;
            self.report(
                p.fault(format!("{left} indices are left over after the last triangle")).mild(),
            );
        }
        if mesh.indices.is_empty() {
            return Ok(None);
        }
        let material = self.material(listed, (has_color, has_alpha), materials);
        Ok(Some(Part { mesh: Arc::new(mesh), material }))
    }
}

/// The triangles of a list (4), strip (5) or fan (6), all with the same front.
fn triangles(mode: usize, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        4 => indices.as_chunks::<3>().0.to_vec(),
        5 => {
            let turned = |(i, w): (usize, &[u32])| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        6 => indices
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|w| [w[0], w[1], indices[0]])
            .collect(),
        _ => return None,
    })
}
