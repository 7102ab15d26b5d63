//! The element `vertex`: positions, normals, texture coordinates and attributes.

use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::TriMesh;
use rayon::prelude::*;

use super::attributes::{self, Reading, Slots};
use super::header::Element;
use super::values::{BLOCK, Values};
use crate::mesh::error::{Fault, MeshCause, MeshNote, Place};
use crate::mesh::{MeshOptions, unit_normal};

/// Vertices a task.
const TASK: usize = 64 * BLOCK;

/// Reads all vertices into `mesh`; in parallel if they are binary, equally long and without
/// attributes.
pub(super) fn read<V: Values>(
    values: &mut V,
    element: &Element,
    mesh: &mut TriMesh,
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<(), Fault> {
    let mut slots = Slots::new(element);
    let Some(position) = slots.claim(element, &["x", "y", "z"]) else {
        let cause = MeshCause::Header("element `vertex` lacks x, y or z".into());
        return Err(Fault::new(Place::File, cause));
    };
    const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
    let normal = if options.normals.uses_stored() { slots.claim(element, &NORMAL) } else { None };
    const UV: [[&str; 2]; 4] =
        [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
    let uv = UV.iter().find_map(|names| slots.claim(element, names));
    let mut attributes =
        attributes::find(element, "vertex", &mut slots, &NORMAL, options.srgb_float_colors, notes);

    // The count has been compared with what the file holds.
    let count = element.count as usize;
    mesh.positions = vec![Vec3::ZERO; count];
    mesh.normals = vec![Vec3::ZERO; if normal.is_some() { count } else { 0 }];
    mesh.uvs = vec![Vec2::ZERO; if uv.is_some() { count } else { 0 }];
    let columns = Columns { element, slots, position, normal, uv, flip_v: options.flip_v };
    let shared = if attributes.is_empty() { values.share(element, TASK) } else { None };
    let dropped = match shared {
        Some(cursors) => {
            // Each list is as long as that of the cursors, or empty.
            let mut normals = mesh.normals.chunks_mut(TASK);
            let mut uvs = mesh.uvs.chunks_mut(TASK);
            let tasks: Vec<_> = cursors
                .into_iter()
                .zip(mesh.positions.chunks_mut(TASK))
                .enumerate()
                .map(|(i, (values, positions))| {
                    let normals = normals.next().unwrap_or_default();
                    let uvs = uvs.next().unwrap_or_default();
                    (values, Vertices { first: i * TASK, positions, normals, uvs })
                })
                .collect();
            let done: Vec<Result<u64, Fault>> = tasks
                .into_par_iter()
                .map(|(mut values, vertices)| columns.read(&mut values, vertices, &mut []))
                .collect();
            // The first fault, whichever was found first.
            done.into_iter().sum::<Result<u64, Fault>>()?
        }
        None => {
            let TriMesh { positions, normals, uvs, .. } = mesh;
            columns.read(values, Vertices { first: 0, positions, normals, uvs }, &mut attributes)?
        }
    };
    if dropped > 0 {
        notes.push(MeshNote::NormalsDropped(dropped));
    }
    mesh.attributes.extend(attributes.into_iter().map(Reading::finish));
    Ok(())
}

/// Which column of a block holds what.
struct Columns<'a> {
    element: &'a Element,
    slots: Slots,
    position: Vec<usize>,
    normal: Option<Vec<usize>>,
    uv: Option<Vec<usize>>,
    flip_v: bool,
}

/// Consecutive vertices, to be read; normals and texture coordinates where the file has them.
struct Vertices<'a> {
    /// The number of the first.
    first: usize,
    positions: &'a mut [Vec3],
    normals: &'a mut [Vec3],
    uvs: &'a mut [Vec2],
}

impl Columns<'_> {
    /// Fills `vertices` from the records that follow. Returns the number of normals dropped.
    fn read<V: Values>(
        &self,
        values: &mut V,
        vertices: Vertices,
        attributes: &mut [Reading],
    ) -> Result<u64, Fault> {
        let mut columns = vec![[0.0; BLOCK]; self.slots.columns];
        let mut dropped = 0;
        let mut normals = vertices.normals.chunks_mut(BLOCK);
        let mut uvs = vertices.uvs.chunks_mut(BLOCK);
        for (block, positions) in vertices.positions.chunks_mut(BLOCK).enumerate() {
            let (first, n) = (vertices.first + block * BLOCK, positions.len());
            values.block(self.element, &self.slots.of_property, &mut columns, first as u64, n)?;
            let [x, y, z] = [0, 1, 2].map(|i| &columns[self.position[i]][..n]);
            for (i, p) in positions.iter_mut().enumerate() {
                *p = Vec3::new(x[i], y[i], z[i]);
            }
            if !positions.iter().fold(true, |all, p| all & p.is_finite()) {
                let bad = positions.iter().position(|p| !p.is_finite()).unwrap_or(0);
                let place = Place::entry("vertex", (first + bad) as u64);
                return Err(Fault::new(place, MeshCause::NotFinite("position")));
            }
            if let (Some(c), Some(normals)) = (&self.normal, normals.next()) {
                let [x, y, z] = [0, 1, 2].map(|i| &columns[c[i]][..n]);
                for (i, normal) in normals.iter_mut().enumerate() {
                    *normal = unit_normal(Vec3::new(x[i], y[i], z[i]), &mut dropped);
                }
            }
            if let (Some(c), Some(uvs)) = (&self.uv, uvs.next()) {
                let [u, v] = [0, 1].map(|i| &columns[c[i]][..n]);
                for (i, uv) in uvs.iter_mut().enumerate() {
                    *uv = Vec2::new(u[i], if self.flip_v { 1.0 - v[i] } else { v[i] });
                }
            }
            for attribute in &mut *attributes {
                for i in 0..n {
                    attribute.push(&columns, i);
                }
            }
        }
        Ok(dropped)
    }
}
