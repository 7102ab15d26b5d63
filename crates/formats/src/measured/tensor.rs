//! The container of measured materials: named arrays of numbers.
//!
//! ```text
//! "tensor_file\0", version (2 bytes), number of fields (u32), then for each field:
//! length of its name (u16), name, dimensions (u16), type (u8), offset (u64), sizes (u64 each)
//! ```
//!
//! Little endian; data lie at the offsets, the last dimension running fastest. Written by
//! Mitsuba's `tensor_io`; the format of the RGL material database (Dupuy & Jakob 2018).

/// First bytes of a file.
const MAGIC: &[u8] = b"tensor_file\0";

/// Types of numbers by their code, with their sizes in bytes.
const TYPES: [(&str, usize); 11] = [
    ("uint8", 1),
    ("int8", 1),
    ("uint16", 2),
    ("int16", 2),
    ("uint32", 4),
    ("int32", 4),
    ("uint64", 8),
    ("int64", 8),
    ("float16", 2),
    ("float32", 4),
    ("float64", 8),
];

/// A file in memory and its directory.
#[derive(Debug)]
pub struct TensorFile {
    bytes: Vec<u8>,
    fields: Vec<Field>,
}

/// One array.
#[derive(Debug)]
struct Field {
    name: String,
    kind: &'static str,
    shape: Vec<usize>,
    /// Where its numbers lie in the file.
    start: usize,
    end: usize,
}

/// What is not yet read of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let found = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        self.at += N;
        found.copied().ok_or_else(|| "the file ends within its directory".to_string())
    }

    fn u16(&mut self) -> Result<usize, String> {
        Ok(u16::from_le_bytes(self.take()?) as usize)
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.take()?))
    }
}

impl TensorFile {
    /// Reads the directory; checks that all data lie in the file.
    ///
    /// # Errors
    /// A one-line cause.
    pub fn new(bytes: Vec<u8>) -> Result<TensorFile, String> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err("not a tensor file: it does not begin with `tensor_file`".into());
        };
        let mut cursor = Cursor { bytes: rest, at: 0 };
        let [major, minor] = cursor.take()?;
        if major != 1 {
            return Err(format!(
                "version {major}.{minor} of tensor files is unknown, 1.0 is known"
            ));
        }
        let count = u32::from_le_bytes(cursor.take()?);
        let mut fields = Vec::new();
        for _ in 0..count {
            fields.push(field(&mut cursor, bytes.len())?);
        }
        Ok(TensorFile { bytes, fields })
    }

    /// True if there is an array of that name.
    pub fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|f| f.name == name)
    }

    /// The bytes and the shape of the array `name` of type `kind` with `dimensions`.
    fn find(&self, name: &str, kind: &str, dimensions: usize) -> Result<(&[u8], &[usize]), String> {
        let Some(f) = self.fields.iter().find(|f| f.name == name) else {
            return Err(format!("it has no field `{name}`"));
        };
        if f.kind != kind || f.shape.len() != dimensions {
            let what = format!("{} of {} dimensions", f.kind, f.shape.len());
            return Err(format!("field `{name}` is {what}, not {kind} of {dimensions}"));
        }
        Ok((&self.bytes[f.start..f.end], &f.shape))
    }

    /// The numbers and sizes of an array of floats, all finite.
    ///
    /// # Errors
    /// If there is none of that name, type and number of dimensions; a one-line cause.
    pub fn floats<const N: usize>(&self, name: &str) -> Result<(Vec<f32>, [usize; N]), String> {
        let (values, shape) = self.floats_or_nan(name)?;
        match values.iter().position(|v| !v.is_finite()) {
            Some(i) => Err(format!("number {i} of field `{name}` is not finite")),
            None => Ok((values, shape)),
        }
    }

    /// As [`TensorFile::floats`] of any numbers.
    ///
    /// # Errors
    /// As [`TensorFile::floats`], but for their kind.
    pub fn floats_or_nan<const N: usize>(
        &self,
        name: &str,
    ) -> Result<(Vec<f32>, [usize; N]), String> {
        let (bytes, shape) = self.find(name, "float32", N)?;
        let (chunks, _) = bytes.as_chunks::<4>();
        let values = chunks.iter().map(|c| f32::from_le_bytes(*c)).collect();
        // `find` has checked that there are N.
        Ok((values, std::array::from_fn(|i| shape[i])))
    }

    /// The numbers of a list of 16-bit integers.
    ///
    /// # Errors
    /// As [`TensorFile::floats`].
    pub fn shorts(&self, name: &str) -> Result<Vec<u16>, String> {
        let (bytes, _) = self.find(name, "uint16", 1)?;
        Ok(bytes.as_chunks::<2>().0.iter().map(|c| u16::from_le_bytes(*c)).collect())
    }

    /// The first of an array of bytes.
    ///
    /// # Errors
    /// As [`TensorFile::floats`], or if it is empty.
    pub fn byte(&self, name: &str) -> Result<u8, String> {
        let (bytes, _) = self.find(name, "uint8", 1)?;
        bytes.first().copied().ok_or_else(|| format!("field `{name}` is empty"))
    }
}

/// An entry of the directory of a file with `length` bytes.
fn field(cursor: &mut Cursor, length: usize) -> Result<Field, String> {
    let n = cursor.u16()?;
    let name = cursor.bytes.get(cursor.at..).and_then(|rest| rest.get(..n));
    let name = name.ok_or("the file ends within its directory")?;
    let name = String::from_utf8_lossy(name).into_owned();
    cursor.at += n;
    let dimensions = cursor.u16()?;
    let [code] = cursor.take()?;
    let Some((kind, size)) = (code as usize).checked_sub(1).and_then(|i| TYPES.get(i)) else {
        return Err(format!("field `{name}` has the unknown type {code}"));
    };
    let start = cursor.u64()?;
    let mut shape = Vec::new();
    let mut bytes = Some(*size as u64);
    for _ in 0..dimensions {
        let n = cursor.u64()?;
        bytes = bytes.and_then(|b| b.checked_mul(n));
        shape.push(n as usize);
    }
    let end = bytes.and_then(|b| b.checked_add(start)).filter(|end| *end <= length as u64);
    let Some(end) = end else {
        return Err(format!("the data of field `{name}` go beyond the end of the file"));
    };
    Ok(Field { name, kind, shape, start: start as usize, end: end as usize })
}
