//! Wavefront OBJ: polygons with separate indices for positions, texture coordinates and normals.
//!
//! Read are `v`, `vt`, `vn`, `f`, and for [`parse_parts`] also `o`, `g` and `usemtl`; all other
//! lines are passed over. Corners that agree in all three indices become one vertex; vertices
//! that no face uses vanish. Polygons are cut into fans about corner 0 (quads thus along 0-2).
//! Negative indices count back from the last one read. A backslash at its end continues a line.
//!
//! A corner without texture coordinates or normal, in a part where others have them, gets zero:
//! for normals this means "the geometric one", as in Mitsuba.

use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::TriMesh;

use super::error::{Fault, MeshCause, MeshNote, Place};
use super::{MeshOptions, normals, unit_normal};

/// A run of faces of one object or group and one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjPart {
    /// The names after the last `o` or `g`, or empty.
    pub name: String,
    /// The name after the last `usemtl`, if there was one.
    pub material: Option<String>,
    /// Its faces.
    pub mesh: TriMesh,
}

/// Reads all faces of an OBJ file into one mesh.
///
/// # Errors
///
/// The line of a number that cannot be read or is not finite, or of an index out of range.
pub fn parse(
    bytes: &[u8],
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, Fault> {
    let mut reader = Reader::new(bytes, options, false);
    reader.read()?;
    let mesh = std::mem::take(&mut reader.part).mesh;
    reader.note(notes);
    Ok(mesh)
}

/// Like [`parse`], but begins a new part at each `o`, `g` and `usemtl` that has faces after it
/// (Mitsuba 0.6 with `collapse` false; it disregards `o`). Vertices are not shared between parts.
/// Normals are as `options` want them.
///
/// # Errors
///
/// As [`parse`].
pub fn parse_parts(
    bytes: &[u8],
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<Vec<ObjPart>, Fault> {
    let mut reader = Reader::new(bytes, options, true);
    reader.read()?;
    reader.finish_part();
    let mut parts = std::mem::take(&mut reader.parts);
    reader.note(notes);
    for part in &mut parts {
        normals::apply(&mut part.mesh, options.normals, notes);
    }
    Ok(parts)
}

/// No texture coordinate or normal; end of a chain.
const NONE: u32 = u32::MAX;

/// A corner's indices, counted from 0.
#[derive(Clone, Copy, PartialEq)]
struct Corner {
    v: u32,
    vt: u32,
    vn: u32,
}

/// A vertex made from a corner, in the chain of those with the same position.
struct Made {
    v: u32,
    vt: u32,
    vn: u32,
    next: u32,
}

struct Reader<'a> {
    words: Words<'a>,
    options: &'a MeshOptions,
    split: bool,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// First vertex of the current part made from each position, or `NONE`.
    first: Vec<u32>,
    /// Of the current part, parallel to `part.mesh.positions`.
    made: Vec<Made>,
    part: ObjPart,
    parts: Vec<ObjPart>,
    thin: u64,
    fanned: u64,
    largest: u64,
    dropped: u64,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], options: &'a MeshOptions, split: bool) -> Self {
        Reader {
            words: Words { bytes, position: 0, line: 1 },
            options,
            split,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            first: Vec::new(),
            made: Vec::new(),
            part: ObjPart::default(),
            parts: Vec::new(),
            thin: 0,
            fanned: 0,
            largest: 0,
            dropped: 0,
        }
    }

    fn read(&mut self) -> Result<(), Fault> {
        loop {
            match self.words.next() {
                Some(b"v") => {
                    let p = self.words.vector()?;
                    if !p.is_finite() {
                        let place = Place::Line(self.words.line);
                        return Err(Fault::new(place, MeshCause::NotFinite("position")));
                    }
                    self.positions.push(p);
                    self.first.push(NONE);
                }
                Some(b"vt") => {
                    let u = self.words.number()?;
                    let v = self.words.optional_number()?.unwrap_or(0.0);
                    let v = if self.options.flip_v { 1.0 - v } else { v };
                    self.uvs.push(Vec2::new(u, v));
                }
                Some(b"vn") => {
                    let n = self.words.vector()?;
                    self.normals.push(unit_normal(n, &mut self.dropped));
                }
                Some(b"f") => self.face()?,
                Some(b"o" | b"g") if self.split => {
                    self.finish_part();
                    self.part.name = self.words.rest_of_line();
                }
                Some(b"usemtl") if self.split => {
                    self.finish_part();
                    self.part.material = Some(self.words.rest_of_line());
                }
                Some(_) | None => {}
            }
            if !self.words.next_line() {
                return Ok(());
            }
        }
    }

    fn face(&mut self) -> Result<(), Fault> {
        let mut corners = 0u64;
        let (mut a, mut last) = (0, 0);
        while let Some(word) = self.words.next() {
            let corner = self.corner(word)?;
            let vertex = self.vertex(corner)?;
            match corners {
                0 => a = vertex,
                1 => {}
                _ => self.part.mesh.indices.push([a, last, vertex]),
            }
            last = vertex;
            corners += 1;
        }
        if corners < 3 {
            self.thin += 1;
        } else if corners > 4 {
            self.fanned += 1;
            self.largest = self.largest.max(corners);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &[u8]) -> Result<Corner, Fault> {
        let mut fields = word.split(|&b| b == b'/');
        let mut next = |what, count: usize| match fields.next() {
            None | Some(b"") => Ok(NONE),
            Some(digits) => self.index(digits, what, count),
        };
        let v = next("vertex", self.positions.len())?;
        let vt = next("texture coordinate", self.uvs.len())?;
        let vn = next("normal", self.normals.len())?;
        if v == NONE || fields.next().is_some() {
            let word = String::from_utf8_lossy(word);
            let message = format!("expected v, v/vt, v//vn or v/vt/vn, found `{word}`");
            return Err(Fault::line(self.words.line, message));
        }
        let vn = if self.options.normals.uses_stored() { vn } else { NONE };
        Ok(Corner { v, vt, vn })
    }

    /// An index as written, 1 for the first and -1 for the last so far, counted from 0.
    fn index(&self, digits: &[u8], what: &'static str, count: usize) -> Result<u32, Fault> {
        let Some(index) = parse_integer(digits) else {
            let word = String::from_utf8_lossy(digits);
            let message = format!("expected a {what} index, found `{word}`");
            return Err(Fault::line(self.words.line, message));
        };
        if index == 0 {
            let message = format!("{what} index 0 is out of range (they count from 1)");
            return Err(Fault::line(self.words.line, message));
        }
        let from_zero = if index < 0 { index + count as i64 } else { index - 1 };
        if (0..count as i64).contains(&from_zero) && from_zero < NONE as i64 {
            return Ok(from_zero as u32);
        }
        let cause = MeshCause::IndexOutOfRange { what, index, count };
        Err(Fault::new(Place::Line(self.words.line), cause))
    }

    /// The number of the vertex for a corner, made if it is new.
    fn vertex(&mut self, corner: Corner) -> Result<u32, Fault> {
        let mesh = &mut self.part.mesh;
        let head = &mut self.first[corner.v as usize];
        let mut vertex = *head;
        while vertex != NONE {
            let made = &self.made[vertex as usize];
            if made.vt == corner.vt && made.vn == corner.vn {
                return Ok(vertex);
            }
            vertex = made.next;
        }
        let new = u32::try_from(mesh.positions.len())
            .ok()
            .filter(|&new| new != NONE)
            .ok_or_else(|| Fault::line(self.words.line, "more than 2^32 - 2 vertices"))?;
        mesh.positions.push(self.positions[corner.v as usize]);
        // Arrays start when the first corner needs them, with zeros for all before it.
        if corner.vt != NONE {
            mesh.uvs.resize(new as usize, Vec2::ZERO);
            mesh.uvs.push(self.uvs[corner.vt as usize]);
        } else if !mesh.uvs.is_empty() {
            mesh.uvs.push(Vec2::ZERO);
        }
        if corner.vn != NONE {
            mesh.normals.resize(new as usize, Vec3::ZERO);
            mesh.normals.push(self.normals[corner.vn as usize]);
        } else if !mesh.normals.is_empty() {
            mesh.normals.push(Vec3::ZERO);
        }
        self.made.push(Made { v: corner.v, vt: corner.vt, vn: corner.vn, next: *head });
        *head = new;
        Ok(new)
    }

    /// Puts the current part aside if it has faces, and begins one with the same names.
    fn finish_part(&mut self) {
        let mesh = std::mem::take(&mut self.part.mesh);
        for made in self.made.drain(..) {
            self.first[made.v as usize] = NONE;
        }
        if !mesh.indices.is_empty() {
            self.parts.push(ObjPart { mesh, ..self.part.clone() });
        }
    }

    fn note(&self, notes: &mut Vec<MeshNote>) {
        if self.thin > 0 {
            notes.push(MeshNote::ThinFacesSkipped(self.thin));
        }
        if self.fanned > 0 {
            notes.push(MeshNote::PolygonsFanned { count: self.fanned, largest: self.largest });
        }
        if self.dropped > 0 && self.options.normals.uses_stored() {
            notes.push(MeshNote::NormalsDropped(self.dropped));
        }
    }
}

/// A decimal integer with optional sign, of at most 18 digits.
fn parse_integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for &b in digits {
        if !b.is_ascii_digit() {
            return None;
        }
        value = value * 10 + (b - b'0') as i64;
    }
    Some(if negative { -value } else { value })
}

/// Words of text, line by line.
struct Words<'a> {
    bytes: &'a [u8],
    position: usize,
    /// From 1.
    line: usize,
}

impl<'a> Words<'a> {
    /// The next word of this line.
    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match self.bytes.get(self.position)? {
                b'\n' | b'#' => return None,
                b'\\' if self.continues() => {}
                b if b.is_ascii_whitespace() => self.position += 1,
                _ => break,
            }
        }
        let rest = &self.bytes[self.position..];
        let length = rest.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len());
        // A backslash right at the line's end is not part of the word before it.
        let next = rest.get(length);
        let continued =
            length > 1 && rest[length - 1] == b'\\' && matches!(next, Some(b'\n' | b'\r'));
        let length = length - usize::from(continued);
        self.position += length;
        Some(&rest[..length])
    }

    /// Passes over a backslash that ends a line, with the line's end.
    fn continues(&mut self) -> bool {
        let length = match &self.bytes[self.position..] {
            [b'\\', b'\n', ..] => 2,
            [b'\\', b'\r', b'\n', ..] => 3,
            _ => return false,
        };
        self.position += length;
        self.line += 1;
        true
    }

    /// Goes to the start of the next line; false at the end of the file.
    fn next_line(&mut self) -> bool {
        while self.next().is_some() {}
        // At a line's end, a comment or the end of the file.
        let rest = &self.bytes[self.position..];
        match rest.iter().position(|&b| b == b'\n') {
            None => {
                self.position = self.bytes.len();
                false
            }
            Some(end) => {
                self.position += end + 1;
                self.line += 1;
                true
            }
        }
    }

    /// What is left of this line, comments aside, with single spaces.
    fn rest_of_line(&mut self) -> String {
        let mut text = String::new();
        while let Some(word) = self.next() {
            if !text.is_empty() {
                text.push(' ');
            }
            text.push_str(&String::from_utf8_lossy(word));
        }
        text
    }

    fn optional_number(&mut self) -> Result<Option<f32>, Fault> {
        let Some(word) = self.next() else {
            return Ok(None);
        };
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.map(Some).ok_or_else(|| {
            let word = String::from_utf8_lossy(&word[..word.len().min(40)]);
            Fault::line(self.line, format!("expected a number, found `{word}`"))
        })
    }

    fn number(&mut self) -> Result<f32, Fault> {
        self.optional_number()?
            .ok_or_else(|| Fault::line(self.line, "expected a number, found the line's end"))
    }

    fn vector(&mut self) -> Result<Vec3, Fault> {
        Ok(Vec3::new(self.number()?, self.number()?, self.number()?))
    }
}
