//! Numbers in buffers: accessors of every component type, sparse ones too.

use super::buffers::Buffers;
use super::json::{Fault, Json};

/// Most elements of an accessor that no bytes stand for.
const MOST_UNBACKED: usize = 1 << 22;

/// Component types of glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(json: &Json) -> Result<Component, Fault> {
        Ok(match json.whole()? {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            other => {
                return Err(json.fault(format!("unknown component type {other}")).hint(
                    "known: 5120 byte, 5121 unsigned byte, 5122 short, 5123 unsigned short, \
                     5125 unsigned int, 5126 float",
                ));
            }
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number in the first bytes, of which there are enough.
    fn read(self, b: &[u8], normalized: bool) -> f32 {
        let (value, most) = match self {
            Component::I8 => (f32::from(b[0] as i8), 127.0),
            Component::U8 => (f32::from(b[0]), 255.0),
            Component::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Component::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Component::U32 => {
                (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32)
            }
            Component::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        if normalized { (value / most).max(-1.0) } else { value }
    }

    fn read_whole(self, b: &[u8]) -> Option<u32> {
        match self {
            Component::U8 => Some(u32::from(b[0])),
            Component::U16 => Some(u32::from(u16::from_le_bytes([b[0], b[1]]))),
            Component::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            _ => None,
        }
    }
}

/// Elements in the bytes of a view.
struct Elements<'b> {
    bytes: &'b [u8],
    stride: usize,
}

impl<'b> Elements<'b> {
    /// `count` elements of `size` bytes from `offset` on; the last may end before its stride does.
    fn new(
        at: &Json,
        bytes: &'b [u8],
        (offset, stride, size, count): (usize, usize, usize, usize),
    ) -> Result<Elements<'b>, Fault> {
        let stride = stride.max(size);
        let needed = match count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride).and_then(|v| v.checked_add(size)),
        };
        let needed = needed.and_then(|n| n.checked_add(offset));
        match needed {
            Some(n) if n <= bytes.len() => Ok(Elements { bytes: &bytes[offset.min(bytes.len())..], stride }),
            _ => Err(at.fault(format!(
                "{count} elements of {size} bytes, {stride} apart, from byte {offset} of a view of {} bytes",
                bytes.len()
            ))),
        }
    }

    fn element(&self, i: usize) -> &'b [u8] {
        &self.bytes[i * self.stride..]
    }
}

/// Numbers that belong together.
#[derive(Debug)]
pub(super) struct Numbers {
    /// Numbers an element.
    pub width: usize,
    /// The elements.
    pub values: Vec<f32>,
}

impl Numbers {
    /// The elements as arrays of the first N numbers.
    pub fn arrays<const N: usize>(&self) -> impl Iterator<Item = [f32; N]> {
        self.values
            .chunks_exact(self.width.max(1))
            .map(|c| std::array::from_fn(|i| c.get(i).copied().unwrap_or(0.0)))
    }

    /// How many elements there are.
    pub fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }
}

/// How many numbers an element of this type has.
fn width(accessor: &Json) -> Result<usize, Fault> {
    let ty = accessor.require("type")?;
    Ok(match ty.text() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        Some("VEC4") => 4,
        _ => return Err(ty.fault("expected SCALAR, VEC2, VEC3 or VEC4")),
    })
}

/// What the elements of an accessor are.
struct Layout {
    component: Component,
    width: usize,
    count: usize,
}

fn layout(accessor: &Json) -> Result<Layout, Fault> {
    Ok(Layout {
        component: Component::of(&accessor.require("componentType")?)?,
        width: width(accessor)?,
        count: accessor.require("count")?.whole()?,
    })
}

impl Buffers<'_> {
    /// The elements of an accessor, `None` where no view stands behind them.
    fn elements(&self, accessor: &Json, l: &Layout) -> Result<Option<Elements<'_>>, Fault> {
        let Some((_, view)) = accessor.refer("bufferView", self.views(), "buffer view")? else {
            if l.count > MOST_UNBACKED {
                return Err(accessor.fault(format!("{} elements without a buffer view", l.count)));
            }
            return Ok(None);
        };
        let range = (
            accessor.size("byteOffset", 0)?,
            view.size("byteStride", 0)?,
            l.component.size() * l.width,
            l.count,
        );
        Elements::new(accessor, self.view(view)?, range).map(Some)
    }

    /// The numbers of an accessor whose elements have one of these `widths`.
    pub fn numbers(&self, accessor: &Json, widths: &[usize]) -> Result<Numbers, Fault> {
        let l = layout(accessor)?;
        if !widths.contains(&l.width) {
            let known: Vec<_> = widths.iter().map(ToString::to_string).collect();
            let known = known.join(" or ");
            return Err(
                accessor.fault(format!("{known} numbers an element expected, found {}", l.width))
            );
        }
        let normalized = accessor.truth("normalized", false)?;
        let size = l.component.size();
        let read = |b: &[u8], out: &mut [f32]| {
            for (o, b) in out.iter_mut().zip(b.chunks_exact(size)) {
                *o = l.component.read(b, normalized);
            }
        };
        let elements = self.elements(accessor, &l)?;
        let mut values = vec![0.0; l.count * l.width];
        if let Some(elements) = elements {
            for (i, out) in values.chunks_exact_mut(l.width).enumerate() {
                read(elements.element(i), out);
            }
        }
        if let Some(sparse) = accessor.get("sparse") {
            let count = sparse.require("count")?.whole()?;
            let (places, stored) = (sparse.require("indices")?, sparse.require("values")?);
            let component = Component::of(&places.require("componentType")?)?;
            let places_view = places.require("bufferView")?;
            let (_, view) = places_view.pick(self.views(), "buffer view")?;
            let range = (places.size("byteOffset", 0)?, 0, component.size(), count);
            let indices = Elements::new(&places, self.view(view)?, range)?;
            let stored_view = stored.require("bufferView")?;
            let (_, view) = stored_view.pick(self.views(), "buffer view")?;
            let range = (stored.size("byteOffset", 0)?, 0, size * l.width, count);
            let replaced = Elements::new(&stored, self.view(view)?, range)?;
            for k in 0..count {
                let at = component.read_whole(indices.element(k)).unwrap_or(u32::MAX) as usize;
                let Some(out) =
                    at.checked_mul(l.width).and_then(|i| values.get_mut(i..i + l.width))
                else {
                    return Err(places.fault(format!("index {k} is {at}, of {} elements", l.count)));
                };
                read(replaced.element(k), out);
            }
        }
        Ok(Numbers { width: l.width, values })
    }

    /// The indices of an accessor, all below `limit`.
    pub fn indices(&self, accessor: &Json, limit: usize) -> Result<Vec<u32>, Fault> {
        let l = layout(accessor)?;
        if l.width != 1 {
            return Err(accessor.fault("indices are SCALAR"));
        }
        let Some(elements) = self.elements(accessor, &l)? else {
            return Err(accessor.fault("indices without a buffer view"));
        };
        (0..l.count)
            .map(|i| match l.component.read_whole(elements.element(i)) {
                Some(v) if (v as usize) < limit => Ok(v),
                Some(v) => {
                    Err(accessor.fault(format!("index {i} is {v}, but there are {limit} vertices")))
                }
                None => Err(accessor.fault("indices are unsigned integers (5121, 5123 or 5125)")),
            })
            .collect()
    }
}
