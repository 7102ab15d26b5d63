//! The header of a PLY file: which elements there are and how their properties are stored.
//!
//! The format: Greg Turk, "The PLY Polygon File Format" (1994). The type names with sizes
//! (`int32`, `float64`) and the 64-bit integers are later additions that many programs write.

use crate::mesh::error::{Fault, MeshCause, Place};

/// How numbers are written after the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Scalar> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "long" | "int64" => Scalar::I64,
            "ulong" | "uint64" => Scalar::U64,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes in binary files.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// The largest value of an integer type, as Mitsuba normalises by it; none for floats.
    pub(super) fn integer_max(self) -> Option<f64> {
        match self {
            Scalar::I8 => Some(i8::MAX as f64),
            Scalar::U8 => Some(u8::MAX as f64),
            Scalar::I16 => Some(i16::MAX as f64),
            Scalar::U16 => Some(u16::MAX as f64),
            Scalar::I32 => Some(i32::MAX as f64),
            Scalar::U32 => Some(u32::MAX as f64),
            Scalar::I64 => Some(i64::MAX as f64),
            Scalar::U64 => Some(u64::MAX as f64),
            Scalar::F32 | Scalar::F64 => None,
        }
    }
}

/// One number, or a counted list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Bytes up to and with the line `end_header`.
    pub(super) length: usize,
}

/// Reads the header at the start of `bytes`.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, Fault> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut position = 0;
    let mut number = 0;
    loop {
        number += 1;
        let fail =
            |message: String| Err(Fault::new(Place::Line(number), MeshCause::Header(message)));
        let rest = &bytes[position..];
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return match number {
                1 => fail("not a PLY file: its first line is not `ply`".into()),
                _ => Err(Fault::new(Place::Line(number), MeshCause::Truncated)),
            };
        };
        position += end + 1;
        let line = String::from_utf8_lossy(&rest[..end]);
        let mut words = line.split_ascii_whitespace();
        let keyword = words.next().unwrap_or("");
        if number == 1 {
            if keyword != "ply" || words.next().is_some() {
                return fail("not a PLY file: its first line is not `ply`".into());
            }
            continue;
        }
        let words: Vec<&str> = words.collect();
        match (keyword, words.as_slice()) {
            ("" | "comment" | "obj_info", _) => {}
            ("format", [name, version]) => {
                if encoding.is_some() {
                    return fail("`format` stands here a second time".into());
                }
                encoding = match *name {
                    "ascii" => Some(Encoding::Ascii),
                    "binary_little_endian" => Some(Encoding::LittleEndian),
                    "binary_big_endian" => Some(Encoding::BigEndian),
                    other => return fail(format!("unknown format `{other}`")),
                };
                if *version != "1.0" {
                    return fail(format!("unknown version `{version}`, expected 1.0"));
                }
            }
            ("element", [name, count]) => {
                let Ok(count) = count.parse::<u64>() else {
                    return fail(format!("`{count}` is not a count of elements"));
                };
                if elements.iter().any(|e| e.name == *name) {
                    return fail(format!("element `{name}` stands here a second time"));
                }
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ("property", words) => {
                let Some(element) = elements.last_mut() else {
                    return fail("`property` before the first `element`".into());
                };
                let property = match property(words) {
                    Ok(property) => property,
                    Err(message) => return fail(message),
                };
                if element.properties.iter().any(|p| p.name == property.name) {
                    let (name, of) = (&property.name, &element.name);
                    return fail(format!("`{of}` has property `{name}` a second time"));
                }
                element.properties.push(property);
            }
            ("end_header", []) => break,
            ("format" | "element" | "end_header", _) => {
                return fail(format!("`{keyword}` with {} words after it", words.len()));
            }
            _ => return fail(format!("unknown header keyword `{keyword}`")),
        }
    }
    let Some(encoding) = encoding else {
        let cause = MeshCause::Header("the header has no `format`".into());
        return Err(Fault::new(Place::Line(number), cause));
    };
    Ok(Header { encoding, elements, length: position })
}

/// The words after `property`: `TYPE NAME` or `list TYPE TYPE NAME`.
fn property(words: &[&str]) -> Result<Property, String> {
    let scalar =
        |name: &str| Scalar::from_name(name).ok_or_else(|| format!("unknown type `{name}`"));
    let (kind, name) = match *words {
        ["list", count, item, name] => {
            let (count, item) = (scalar(count)?, scalar(item)?);
            if count.integer_max().is_none() {
                return Err("the count of a list must be an integer".into());
            }
            (Kind::List { count, item }, name)
        }
        [of, name] => (Kind::Number(scalar(of)?), name),
        _ => return Err("expected `property TYPE NAME` or `property list TYPE TYPE NAME`".into()),
    };
    Ok(Property { name: name.to_owned(), kind })
}
