//! The scene's nodes: who stands where.

use super::Reader;
use super::buffers::Buffers;
use super::json::{Fault, Json};
use super::materials::Materials;
use super::matrix::Matrix;
use super::meshes::{Meshes, Part};
use kaustika_math::Transform;
use kaustika_scene::description::{
    GeometryDesc, GroupDesc, GroupId, InstanceDesc, ShapeDesc, Span,
};
use std::collections::HashMap;

/// A mesh that stands in several places is stored once where that spares this many triangles:
/// below it one hierarchy over everything is faster.
const SPARED: usize = 20_000;

/// A mesh in its place.
struct Placement {
    mesh: usize,
    name: String,
    transform: Transform,
    span: Option<Span>,
}

impl Reader<'_> {
    /// Walks the scene, and places what is in it.
    pub(super) fn nodes(
        &mut self,
        root: &Json,
        buffers: &Buffers,
        materials: &mut Materials,
        meshes: &mut Meshes,
    ) -> Result<(), Fault> {
        let placements = self.walk(root, buffers, meshes)?;
        let mut uses: HashMap<usize, usize> = HashMap::new();
        placements.iter().for_each(|p| *uses.entry(p.mesh).or_default() += 1);
        let mut groups: HashMap<usize, GroupId> = HashMap::new();
        for p in &placements {
            let parts = self.mesh(p.mesh, buffers, materials, meshes);
            let triangles: usize = parts.iter().map(|part| part.mesh.indices.len()).sum();
            // What emits has a light for each place, which a group cannot have.
            let emits = parts.iter().any(|part| part.material.emission.is_some());
            if emits || (uses[&p.mesh] - 1) * triangles < SPARED {
                self.out.shapes.extend(parts.iter().map(|part| shape(part, p, p.transform)));
                continue;
            }
            let group = *groups.entry(p.mesh).or_insert_with(|| {
                let shapes = parts.iter().map(|part| shape(part, p, Transform::IDENTITY));
                self.out.groups.push(GroupDesc { name: p.name.clone(), shapes: shapes.collect() });
                GroupId(self.out.groups.len() as u32 - 1)
            });
            let (transform, span) = (p.transform, p.span);
            self.out.instances.push(InstanceDesc { group, transform, motion: Vec::new(), span });
        }
        Ok(())
    }

    /// Cameras and lights go to the description, meshes are returned.
    fn walk(
        &mut self,
        root: &Json,
        buffers: &Buffers,
        meshes: &Meshes,
    ) -> Result<Vec<Placement>, Fault> {
        let nodes = root.list("nodes")?;
        let cameras = root.list("cameras")?;
        let lights = match root.extension("KHR_lights_punctual") {
            Some(e) => e.list("lights")?,
            None => Vec::new(),
        };
        let mut stack: Vec<(usize, Matrix)> = Vec::new();
        for start in self.roots(root, &nodes)?.into_iter().rev() {
            stack.push((start, Matrix::IDENTITY));
        }
        let mut visited = vec![false; nodes.len()];
        let mut placements = Vec::new();
        while let Some((i, parent)) = stack.pop() {
            let node = &nodes[i];
            if std::mem::replace(&mut visited[i], true) {
                self.report(node.fault("a node with two parents, or its own ancestor"));
                continue;
            }
            let visible = match node.extension("KHR_node_visibility") {
                Some(e) => e.truth("visible", true)?,
                None => true,
            };
            if !visible {
                continue;
            }
            let own = match Matrix::of_node(node) {
                Ok(matrix) => matrix,
                Err(fault) => {
                    self.report(fault);
                    continue;
                }
            };
            let to_world = parent.after(&own);
            if let Err(fault) =
                self.node(node, &to_world, (&cameras, &lights), buffers, meshes, &mut placements)
            {
                self.report(fault);
            }
            for child in node.list("children")?.into_iter().rev() {
                match child.pick(&nodes, "node") {
                    Ok((c, _)) => stack.push((c, to_world)),
                    Err(fault) => self.report(fault),
                }
            }
        }
        Ok(placements)
    }

    /// The nodes at the top of the scene: those of the default scene, else of the first, else all
    /// that are nobody's children.
    fn roots(&mut self, root: &Json, nodes: &[Json]) -> Result<Vec<usize>, Fault> {
        let scenes = root.list("scenes")?;
        let scene = match root.refer("scene", &scenes, "scene")? {
            Some((_, scene)) => Some(scene),
            None => scenes.first(),
        };
        if let Some(scene) = scene {
            if scenes.len() > 1 {
                let which = if scene.name().is_empty() { &scene.path } else { scene.name() };
                let text = format!("the file has {} scenes; `{which}` is read", scenes.len());
                self.out.diagnostics.note(None, text);
            }
            let named = scene.list("nodes")?;
            return named.iter().map(|n| n.pick(nodes, "node").map(|n| n.0)).collect();
        }
        let mut is_child = vec![false; nodes.len()];
        for node in nodes {
            for child in node.list("children")? {
                is_child[child.pick(nodes, "node")?.0] = true;
            }
        }
        let top: Vec<usize> = (0..nodes.len()).filter(|i| !is_child[*i]).collect();
        match top.is_empty() && !nodes.is_empty() {
            true => {
                Err(root.require("nodes")?.fault("no node is at the top: each is another's child"))
            }
            false => Ok(top),
        }
    }

    fn node(
        &mut self,
        node: &Json,
        to_world: &Matrix,
        (cameras, lights): (&[Json], &[Json]),
        buffers: &Buffers,
        meshes: &Meshes,
        placements: &mut Vec<Placement>,
    ) -> Result<(), Fault> {
        if let Some((_, camera)) = node.refer("camera", cameras, "camera")? {
            self.camera(camera, node, to_world)?;
        }
        if let Some(e) = node.extension("KHR_lights_punctual")
            && let Some((_, light)) = e.refer("light", lights, "light")?
        {
            self.light(light, node, to_world)?;
        }
        let Some((mesh, json)) = node.refer("mesh", meshes.list(), "mesh")? else { return Ok(()) };
        let name = if node.name().is_empty() { json.name() } else { node.name() };
        let span = self.span(node);
        let mut place = |to_world: Matrix| {
            // A node of scale 0 is a way to hide it.
            if let Some(transform) = to_world.transform() {
                placements.push(Placement { mesh, name: name.into(), transform, span });
            }
        };
        match node.extension("EXT_mesh_gpu_instancing") {
            Some(e) => {
                let all = instances(&e, buffers, meshes)?;
                all.iter().for_each(|own| place(to_world.after(own)));
            }
            None => place(*to_world),
        }
        Ok(())
    }
}

/// The places of EXT_mesh_gpu_instancing in the space of their node.
fn instances(e: &Json, buffers: &Buffers, meshes: &Meshes) -> Result<Vec<Matrix>, Fault> {
    let attributes = e.require("attributes")?;
    let get = |name: &str, width: usize| {
        attributes
            .refer(name, meshes.accessors(), "accessor")?
            .map(|(_, accessor)| buffers.numbers(accessor, &[width]))
            .transpose()
    };
    let (t, r, s) = (get("TRANSLATION", 3)?, get("ROTATION", 4)?, get("SCALE", 3)?);
    let count = [&t, &r, &s].iter().filter_map(|n| n.as_ref()).map(|n| n.len()).min().unwrap_or(0);
    let t: Option<Vec<[f32; 3]>> = t.map(|n| n.arrays().collect());
    let r: Option<Vec<[f32; 4]>> = r.map(|n| n.arrays().collect());
    let s: Option<Vec<[f32; 3]>> = s.map(|n| n.arrays().collect());
    Ok((0..count)
        .map(|i| {
            Matrix::compose(
                t.as_ref().map_or([0.0; 3], |t| t[i]),
                r.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]),
                s.as_ref().map_or([1.0; 3], |s| s[i]),
            )
        })
        .collect())
}

fn shape(part: &Part, placement: &Placement, transform: Transform) -> ShapeDesc {
    ShapeDesc {
        name: placement.name.clone(),
        geometry: GeometryDesc::Mesh(part.mesh.clone()),
        transform,
        flip_normals: false,
        material: part.material.id,
        emission: part.material.emission.clone(),
        alpha: part.material.alpha,
        interior: None,
        exterior: None,
        span: placement.span,
    }
}
