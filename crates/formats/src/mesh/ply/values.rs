//! The numbers after a PLY header, one by one or by blocks, from text or from bytes.

use rayon::prelude::*;

use super::header::{Element, Kind, Property, Scalar};
use crate::mesh::error::{Fault, MeshCause, Place};

/// Records read at once: a block of columns stays in the first-level cache.
pub(super) const BLOCK: usize = 256;

/// One property over a block of records.
pub(super) type Column = [f32; BLOCK];

/// A cursor over stored numbers.
pub(super) trait Values: Send {
    /// Fewest bytes that a number takes, with its separator (which the last may lack).
    fn least_bytes(of: Scalar) -> u64;

    /// Bytes not yet read.
    fn left(&self) -> u64;

    /// Bytes not yet read that are more than space, for when there should be none.
    fn trailing(&self) -> u64 {
        self.left()
    }

    /// The next number, rounded to `f32`.
    fn number(&mut self, of: Scalar) -> Result<f32, MeshCause>;

    /// The next number, which must be whole.
    fn integer(&mut self, of: Scalar) -> Result<i64, MeshCause>;

    /// Passes over `n` numbers.
    fn skip(&mut self, of: Scalar, n: u64) -> Result<(), MeshCause>;

    /// The next three numbers without passing over them, if they are 32-bit integers in binary;
    /// negative ones as numbers from 2^31 on. The fast way through triangles.
    fn peek_triangle(&self, _of: Scalar) -> Option<[u32; 3]> {
        None
    }

    /// Cursors at every `each`th record of `element`, and passes over all of it; if its records
    /// are equally long and all there. So that threads can share the work.
    fn share(&mut self, _element: &Element, _each: usize) -> Option<Vec<Self>>
    where
        Self: Sized,
    {
        None
    }

    /// All of `element`, and passes over it, if it is nothing but binary lists of three 32-bit
    /// vertex numbers below `vertices` <= 2^31. In parallel.
    fn triangles(&mut self, _element: &Element, _vertices: u32) -> Option<Vec<[u32; 3]>> {
        None
    }

    /// Where to look for a fault in entry `number` of `list`.
    fn fault(&self, cause: MeshCause, list: &str, number: u64) -> Fault;

    /// The count in front of a list.
    #[inline]
    fn count(&mut self, of: Scalar) -> Result<u64, MeshCause> {
        let n = self.integer(of)?;
        u64::try_from(n).map_err(|_| MeshCause::Syntax(format!("a list of {n} entries")))
    }

    /// Reads `n <= BLOCK` records of `element`; property i goes to column `slots[i]`, lists and
    /// properties without a slot are passed over. `first` numbers the first record in errors.
    fn block(
        &mut self,
        element: &Element,
        slots: &[Option<usize>],
        columns: &mut [Column],
        first: u64,
        n: usize,
    ) -> Result<(), Fault> {
        walk(self, element, slots, columns, first, n)
    }
}

/// [`Values::block`], record by record.
fn walk<V: Values + ?Sized>(
    values: &mut V,
    element: &Element,
    slots: &[Option<usize>],
    columns: &mut [Column],
    first: u64,
    n: usize,
) -> Result<(), Fault> {
    for (i, number) in (first..).take(n).enumerate() {
        for (property, slot) in element.properties.iter().zip(slots) {
            let read = match (property.kind, slot) {
                (Kind::Number(of), Some(slot)) => {
                    values.number(of).map(|value| columns[*slot][i] = value)
                }
                (Kind::Number(of), None) => values.skip(of, 1),
                (Kind::List { count, item }, _) => {
                    values.count(count).and_then(|n| values.skip(item, n))
                }
            };
            read.map_err(|cause| values.fault(cause, &element.name, number))?;
        }
    }
    Ok(())
}

/// Bytes of a binary record, if all are equally long.
fn record_size(properties: &[Property]) -> Option<usize> {
    properties.iter().try_fold(0, |sum, p| match p.kind {
        Kind::Number(of) => Some(sum + of.size()),
        Kind::List { .. } => None,
    })
}

/// A floating-point number as the integer that it must be.
fn whole(value: f64) -> Result<i64, MeshCause> {
    if value.fract() == 0.0 && value.abs() < 2f64.powi(53) {
        Ok(value as i64)
    } else {
        Err(MeshCause::Syntax(format!("expected an integer, found {value}")))
    }
}

/// Numbers as bytes, least significant first or (`BIG`) last.
pub(super) struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub(super) fn new(body: &'a [u8]) -> Self {
        Binary { rest: body }
    }

    /// The next `N` bytes, least significant first.
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshCause> {
        // Not ok_or(): making and dropping the unused error costs as much as the rest.
        let Some((head, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(MeshCause::Truncated);
        };
        self.rest = rest;
        Ok(little::<N, BIG>(*head))
    }
}

/// The bytes of a number, least significant first.
#[inline]
fn little<const N: usize, const BIG: bool>(mut bytes: [u8; N]) -> [u8; N] {
    if BIG {
        bytes.reverse();
    }
    bytes
}

/// Evaluates `$body` with `$T` standing for the Rust type of `$scalar`.
macro_rules! with_type {
    ($scalar:expr, $T:ident => $body:expr) => {
        match $scalar {
            Scalar::I8 => with_type!(@ $T i8 $body),
            Scalar::U8 => with_type!(@ $T u8 $body),
            Scalar::I16 => with_type!(@ $T i16 $body),
            Scalar::U16 => with_type!(@ $T u16 $body),
            Scalar::I32 => with_type!(@ $T i32 $body),
            Scalar::U32 => with_type!(@ $T u32 $body),
            Scalar::I64 => with_type!(@ $T i64 $body),
            Scalar::U64 => with_type!(@ $T u64 $body),
            Scalar::F32 => with_type!(@ $T f32 $body),
            Scalar::F64 => with_type!(@ $T f64 $body),
        }
    };
    (@ $T:ident $rust:ident $body:expr) => {{
        type $T = $rust;
        // A conversion in the body is one from its own type in one of the cases.
        #[allow(clippy::unnecessary_cast)]
        let value = $body;
        value
    }};
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    fn least_bytes(of: Scalar) -> u64 {
        of.size() as u64
    }

    fn left(&self) -> u64 {
        self.rest.len() as u64
    }

    #[inline]
    fn number(&mut self, of: Scalar) -> Result<f32, MeshCause> {
        with_type!(of, T => Ok(T::from_le_bytes(self.take()?) as f32))
    }

    #[inline]
    fn integer(&mut self, of: Scalar) -> Result<i64, MeshCause> {
        match of {
            // Lists of triangles are nearly always counted and indexed by these.
            Scalar::U8 => Ok(self.take::<1>()?[0] as i64),
            Scalar::I32 => Ok(i32::from_le_bytes(self.take()?) as i64),
            Scalar::U32 => Ok(u32::from_le_bytes(self.take()?) as i64),
            Scalar::F32 | Scalar::F64 => whole(match of {
                Scalar::F32 => f32::from_le_bytes(self.take()?) as f64,
                _ => f64::from_le_bytes(self.take()?),
            }),
            // Beyond i64 is beyond any vertex number: negative, thus out of range as well.
            other => with_type!(other, T => Ok(T::from_le_bytes(self.take()?) as i64)),
        }
    }

    #[inline]
    fn skip(&mut self, of: Scalar, n: u64) -> Result<(), MeshCause> {
        let bytes = n.saturating_mul(of.size() as u64);
        let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
        let Some(rest) = self.rest.get(bytes..) else {
            return Err(MeshCause::Truncated);
        };
        self.rest = rest;
        Ok(())
    }

    #[inline]
    fn peek_triangle(&self, of: Scalar) -> Option<[u32; 3]> {
        if !matches!(of, Scalar::I32 | Scalar::U32) {
            return None;
        }
        let (words, _) = self.rest.first_chunk::<12>()?.as_chunks::<4>();
        let word = |i: usize| u32::from_le_bytes(little::<4, BIG>(words[i]));
        Some([word(0), word(1), word(2)])
    }

    fn share(&mut self, element: &Element, each: usize) -> Option<Vec<Self>> {
        let stride = record_size(&element.properties)?;
        let bytes = stride.checked_mul(usize::try_from(element.count).ok()?)?;
        let (records, rest) = self.rest.split_at_checked(bytes)?;
        let size = stride.checked_mul(each).filter(|&size| size > 0)?;
        self.rest = rest;
        Some(records.chunks(size).map(Binary::new).collect())
    }

    fn triangles(&mut self, element: &Element, vertices: u32) -> Option<Vec<[u32; 3]>> {
        /// Bytes of a count and three vertex numbers.
        const RECORD: usize = 13;
        /// Records a task at least.
        const TASK: usize = 1 << 12;
        let [property] = element.properties.as_slice() else {
            return None;
        };
        let (Scalar::U8 | Scalar::I8, Scalar::U32 | Scalar::I32) = (match property.kind {
            Kind::List { count, item } => (count, item),
            Kind::Number(_) => return None,
        }) else {
            return None;
        };
        let bytes = RECORD.checked_mul(usize::try_from(element.count).ok()?)?;
        let (body, rest) = self.rest.split_at_checked(bytes)?;
        let (records, _) = body.as_chunks::<RECORD>();
        let triangle = |record: &[u8; RECORD]| {
            let (words, _) = record[1..].as_chunks::<4>();
            [0, 1, 2].map(|i| u32::from_le_bytes(little::<4, BIG>(words[i])))
        };
        // A second look at the bytes is cheaper than leaving half-filled lists behind.
        let all = records.par_chunks(TASK).all(|task| {
            task.iter().all(|r| r[0] == 3 && triangle(r).iter().all(|&v| v < vertices))
        });
        if !all {
            return None;
        }
        self.rest = rest;
        Some(records.par_iter().with_min_len(TASK).map(triangle).collect())
    }

    fn fault(&self, cause: MeshCause, list: &str, number: u64) -> Fault {
        Fault::new(Place::entry(list, number), cause)
    }

    /// Column by column if all records are equally long, record by record otherwise.
    fn block(
        &mut self,
        element: &Element,
        slots: &[Option<usize>],
        columns: &mut [Column],
        first: u64,
        n: usize,
    ) -> Result<(), Fault> {
        let Some(stride) = record_size(&element.properties) else {
            return walk(self, element, slots, columns, first, n);
        };
        let Some((block, rest)) = self.rest.split_at_checked(stride * n) else {
            let whole = self.rest.len() / stride.max(1);
            return Err(self.fault(MeshCause::Truncated, &element.name, first + whole as u64));
        };
        self.rest = rest;
        let mut offset = 0;
        for (property, slot) in element.properties.iter().zip(slots) {
            let Kind::Number(of) = property.kind else {
                continue; // record_size() found none
            };
            if let Some(slot) = slot {
                let column = &mut columns[*slot][..n];
                with_type!(of, T => {
                    const SIZE: usize = size_of::<T>();
                    for (value, record) in column.iter_mut().zip(block[offset..].chunks(stride)) {
                        if let Some(bytes) = record.first_chunk::<SIZE>() {
                            *value = T::from_le_bytes(little::<SIZE, BIG>(*bytes)) as f32;
                        }
                    }
                });
            }
            offset += of.size();
        }
        Ok(())
    }
}

/// Numbers as words of text; line ends count as any other space.
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    position: usize,
    /// Where the last word began.
    word: usize,
}

impl<'a> Ascii<'a> {
    /// Starts `position` bytes into the file.
    pub(super) fn new(bytes: &'a [u8], position: usize) -> Self {
        Ascii { bytes, position, word: position }
    }

    #[inline]
    fn word(&mut self) -> Result<&'a str, MeshCause> {
        let rest = &self.bytes[self.position..];
        let start =
            rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or(MeshCause::Truncated)?;
        let rest = &rest[start..];
        let length = rest.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len());
        self.word = self.position + start;
        self.position = self.word + length;
        std::str::from_utf8(&rest[..length]).map_err(|_| {
            MeshCause::Syntax("expected a number, found bytes that are no text".into())
        })
    }
}

impl Values for Ascii<'_> {
    fn least_bytes(_: Scalar) -> u64 {
        2
    }

    fn left(&self) -> u64 {
        (self.bytes.len() - self.position) as u64
    }

    fn trailing(&self) -> u64 {
        self.bytes[self.position..].trim_ascii().len() as u64
    }

    fn number(&mut self, _: Scalar) -> Result<f32, MeshCause> {
        let word = self.word()?;
        word.parse()
            .map_err(|_| MeshCause::Syntax(format!("expected a number, found `{}`", shorten(word))))
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, MeshCause> {
        let word = self.word()?;
        if let Ok(value) = word.parse() {
            return Ok(value);
        }
        match word.parse::<f64>() {
            Ok(value) => whole(value),
            Err(_) => {
                Err(MeshCause::Syntax(format!("expected an integer, found `{}`", shorten(word))))
            }
        }
    }

    fn skip(&mut self, _: Scalar, n: u64) -> Result<(), MeshCause> {
        for _ in 0..n {
            self.word()?;
        }
        Ok(())
    }

    /// The line for wrong text, the entry for anything else.
    fn fault(&self, cause: MeshCause, list: &str, number: u64) -> Fault {
        let place = match cause {
            MeshCause::Syntax(_) => {
                let before = &self.bytes[..self.word];
                Place::Line(1 + before.iter().filter(|&&b| b == b'\n').count())
            }
            _ => Place::entry(list, number),
        };
        Fault::new(place, cause)
    }
}

/// The start of a word, for messages.
fn shorten(word: &str) -> &str {
    word.char_indices().nth(40).map_or(word, |(end, _)| &word[..end])
}
