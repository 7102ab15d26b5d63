//! Stanford PLY: text or binary of either byte order.
//!
//! Read are `vertex` (`x y z`, `nx ny nz`, `u v` or `s t` or `texture_u texture_v` or
//! `texture_s texture_t`, and attributes, see `attributes`), `face` (`vertex_indices` or
//! `vertex_index`, attributes) and `tristrips`. Quads are cut along the diagonal 0-2, larger
//! polygons into fans about corner 0. Other elements are passed over.

mod attributes;
mod ellipsoids;
mod header;
#[cfg(test)]
mod tests;
mod values;
mod vertices;

pub use ellipsoids::{StoredEllipsoid, read_ellipsoids};

use attributes::{Reading, Slots};
use header::{Element, Encoding, Kind, Scalar};
use kaustika_scene::description::TriMesh;
use values::{Ascii, BLOCK, Binary, Column, Values};

use super::MeshOptions;
use super::error::{Fault, MeshCause, MeshNote, Place};

/// Reads a PLY file, not gzipped, from its bytes. Normals are as in the file, made unit, or
/// dropped if `options.normals` has no use for them.
///
/// # Errors
///
/// The line of a header or number that cannot be read; the vertex or face that the file ends in,
/// that is not finite, or that names a vertex which does not exist; a count that the file is too
/// short for.
pub fn parse(
    bytes: &[u8],
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, Fault> {
    let header = header::parse(bytes)?;
    let body = &bytes[header.length..];
    let elements = header.elements.as_slice();
    match header.encoding {
        Encoding::Ascii => read(Ascii::new(bytes, header.length), elements, options, notes),
        Encoding::LittleEndian => read(Binary::<false>::new(body), elements, options, notes),
        Encoding::BigEndian => read(Binary::<true>::new(body), elements, options, notes),
    }
}

fn read<V: Values>(
    mut values: V,
    elements: &[Element],
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, Fault> {
    let header_fault =
        |message: &str| Err(Fault::new(Place::File, MeshCause::Header(message.to_owned())));
    let Some(vertex) = elements.iter().find(|e| e.name == "vertex") else {
        return header_fault("no element `vertex`");
    };
    let Ok(vertex_count) = u32::try_from(vertex.count) else {
        return header_fault("more than 2^32 - 1 vertices");
    };
    if !elements.iter().any(|e| e.name == "face" || e.name == "tristrips") {
        return header_fault("no element `face`: points alone make no surface");
    }
    let mut mesh = TriMesh::default();
    for element in elements {
        check_count(&values, element)?;
        match element.name.as_str() {
            "vertex" => vertices::read(&mut values, element, &mut mesh, options, notes)?,
            "face" => {
                let polygons = Polygons::new(vertex_count);
                polygons.faces(&mut values, element, &mut mesh, options, notes)?;
            }
            "tristrips" => strips(&mut values, element, vertex_count, &mut mesh)?,
            name => {
                notes.push(MeshNote::Skipped { name: name.to_owned(), why: "unknown element" });
                pass_over(&mut values, element)?;
            }
        }
    }
    if mesh.indices.len() > u32::MAX as usize {
        return header_fault("more than 2^32 - 1 triangles");
    }
    let trailing = values.trailing();
    if trailing > 0 {
        notes.push(MeshNote::TrailingBytes(trailing));
    }
    Ok(mesh)
}

/// Compares the announced count with the bytes that are left for it.
fn check_count<V: Values>(values: &V, element: &Element) -> Result<(), Fault> {
    let least: u64 = element
        .properties
        .iter()
        .map(|p| match p.kind {
            Kind::Number(of) | Kind::List { count: of, .. } => V::least_bytes(of),
        })
        .sum();
    let left = values.left();
    // The last number of a text may lack its separator.
    if least.saturating_mul(element.count) > left + 1 {
        let cause =
            MeshCause::CountTooLarge { list: element.name.clone(), count: element.count, left };
        return Err(Fault::new(Place::File, cause));
    }
    Ok(())
}

fn pass_over<V: Values>(values: &mut V, element: &Element) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let slots = vec![None; element.properties.len()];
    let mut done = 0;
    while done < element.count {
        let n = (element.count - done).min(BLOCK as u64) as usize;
        values.block(element, &slots, &mut [], done, n)?;
        done += n as u64;
    }
    Ok(())
}

/// The list property that holds a face's (or strip's) vertices.
fn vertex_list(element: &Element) -> Result<usize, Fault> {
    let list = element.properties.iter().position(|p| {
        (p.name == "vertex_indices" || p.name == "vertex_index")
            && matches!(p.kind, Kind::List { .. })
    });
    list.ok_or_else(|| {
        let message = format!("element `{}` lacks the list `vertex_indices`", element.name);
        Fault::new(Place::File, MeshCause::Header(message))
    })
}

/// Cuts polygons into triangles.
struct Polygons {
    vertices: u32,
    /// Faces of fewer than three corners.
    thin: u64,
    /// Faces of more than four.
    fanned: u64,
    /// Corners of the largest.
    largest: u64,
}

impl Polygons {
    fn new(vertices: u32) -> Polygons {
        Polygons { vertices, thin: 0, fanned: 0, largest: 0 }
    }

    fn faces<V: Values>(
        mut self,
        values: &mut V,
        element: &Element,
        mesh: &mut TriMesh,
        options: &MeshOptions,
        notes: &mut Vec<MeshNote>,
    ) -> Result<(), Fault> {
        let list = vertex_list(element)?;
        let mut slots = Slots::new(element);
        let mut attributes = attributes::find(
            element,
            "face",
            &mut slots,
            &["vertex_indices", "vertex_index"],
            options.srgb_float_colors,
            notes,
        );
        if let Some(triangles) = values.triangles(element, self.vertices.min(1 << 31)) {
            mesh.indices = match mesh.indices.is_empty() {
                true => triangles,
                false => [std::mem::take(&mut mesh.indices), triangles].concat(),
            };
            return Ok(());
        }
        // The one record that is read at a time is row 0 of each column.
        let mut row: Vec<Column> = vec![[0.0; BLOCK]; slots.columns];
        mesh.indices.reserve_exact(element.count as usize);
        for number in 0..element.count {
            let first = mesh.indices.len();
            for (i, property) in element.properties.iter().enumerate() {
                let read = match property.kind {
                    Kind::List { count, item } if i == list => {
                        self.polygon(values, count, item, &mut mesh.indices)
                    }
                    Kind::List { count, item } => {
                        values.count(count).and_then(|n| values.skip(item, n))
                    }
                    Kind::Number(of) => match slots.of_property[i] {
                        Some(slot) => values.number(of).map(|value| row[slot][0] = value),
                        None => values.skip(of, 1),
                    },
                };
                read.map_err(|cause| values.fault(cause, "face", number))?;
            }
            let triangles = mesh.indices.len() - first;
            for attribute in &mut attributes {
                for i in 0..triangles {
                    match i {
                        0 => attribute.push(&row, 0),
                        _ => attribute.repeat(),
                    }
                }
            }
        }
        if self.thin > 0 {
            notes.push(MeshNote::ThinFacesSkipped(self.thin));
        }
        if self.fanned > 0 {
            notes.push(MeshNote::PolygonsFanned { count: self.fanned, largest: self.largest });
        }
        mesh.attributes.extend(attributes.into_iter().map(Reading::finish));
        Ok(())
    }

    #[inline]
    fn polygon<V: Values>(
        &mut self,
        values: &mut V,
        count: Scalar,
        item: Scalar,
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), MeshCause> {
        let n = values.count(count)?;
        if n == 3
            && let Some(triangle) = values.peek_triangle(item)
            && triangle.iter().all(|&v| v < self.vertices.min(1 << 31))
        {
            triangles.push(triangle);
            return values.skip(item, 3);
        }
        if n < 3 {
            self.thin += 1;
            return values.skip(item, n);
        }
        let a = self.vertex(values, item)?;
        let b = self.vertex(values, item)?;
        let mut last = self.vertex(values, item)?;
        triangles.push([a, b, last]);
        for _ in 3..n {
            let next = self.vertex(values, item)?;
            triangles.push([a, last, next]);
            last = next;
        }
        if n > 4 {
            self.fanned += 1;
            self.largest = self.largest.max(n);
        }
        Ok(())
    }

    #[inline]
    fn vertex<V: Values>(&self, values: &mut V, item: Scalar) -> Result<u32, MeshCause> {
        let index = values.integer(item)?;
        match u32::try_from(index) {
            Ok(vertex) if vertex < self.vertices => Ok(vertex),
            _ => Err(out_of_range(index, self.vertices)),
        }
    }
}

#[cold]
fn out_of_range(index: i64, vertices: u32) -> MeshCause {
    MeshCause::IndexOutOfRange { what: "vertex", index, count: vertices as usize }
}

/// Triangle strips as in the Stanford archive: vertex numbers, -1 begins a new strip, every other
/// triangle of a strip is turned around.
fn strips<V: Values>(
    values: &mut V,
    element: &Element,
    vertices: u32,
    mesh: &mut TriMesh,
) -> Result<(), Fault> {
    let list = vertex_list(element)?;
    for number in 0..element.count {
        for (i, property) in element.properties.iter().enumerate() {
            let read = match property.kind {
                Kind::List { count, item } if i == list => values
                    .count(count)
                    .and_then(|n| strip(values, n, item, vertices, &mut mesh.indices)),
                Kind::List { count, item } => {
                    values.count(count).and_then(|n| values.skip(item, n))
                }
                Kind::Number(of) => values.skip(of, 1),
            };
            read.map_err(|cause| values.fault(cause, "tristrips", number))?;
        }
    }
    Ok(())
}

fn strip<V: Values>(
    values: &mut V,
    n: u64,
    item: Scalar,
    vertices: u32,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), MeshCause> {
    // The two vertices before, and how many this strip has had.
    let (mut a, mut b, mut length) = (0, 0, 0u64);
    for _ in 0..n {
        let index = values.integer(item)?;
        if index == -1 {
            length = 0;
            continue;
        }
        let c = match u32::try_from(index) {
            Ok(vertex) if vertex < vertices => vertex,
            _ => return Err(out_of_range(index, vertices)),
        };
        if length >= 2 {
            triangles.push(if length % 2 == 0 { [a, b, c] } else { [b, a, c] });
        }
        (a, b) = (b, c);
        length += 1;
    }
    Ok(())
}
