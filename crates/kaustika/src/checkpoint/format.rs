//! The bytes of a checkpoint, little endian:
//!
//! ```text
//! magic            8   "KAUSTCKP"
//! version          u32
//! header length    u32
//! header               JSON: record, nodes, lengths
//! payload              zlib of: per node its sums and M2 as f32; then the method's state
//! checksum         u64 of everything before
//! ```

use crate::fingerprint::Fingerprint;
use crate::record::Record;
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use kaustika_film::accumulate::{Feature, Layers, Node, PassTree};
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};

use super::Checkpoint;

const MAGIC: &[u8; 8] = b"KAUSTCKP";
const VERSION: u32 = 2;
/// Fast; noise does not compress well at any level.
const LEVEL: Compression = Compression::fast();

#[derive(Serialize, Deserialize)]
struct Header {
    record: Record,
    /// First pass, level and weight of each node, in the order of the payload.
    nodes: Vec<(u64, u32, f32)>,
    method_state_bytes: u64,
    seconds: f64,
}

pub(super) fn encode(
    record: &Record,
    tree: &PassTree,
    method_state: &[u8],
    seconds: f64,
) -> io::Result<Vec<u8>> {
    let header = Header {
        record: record.clone(),
        nodes: tree.nodes().iter().map(|n| (n.start, n.level, n.weight)).collect(),
        method_state_bytes: method_state.len() as u64,
        seconds,
    };
    let header = serde_json::to_vec(&header)?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((header.len() as u32).to_le_bytes());
    bytes.extend(&header);
    let mut payload = ZlibEncoder::new(bytes, LEVEL);
    for node in tree.nodes() {
        write_floats(&mut payload, &node.sum)?;
        write_floats(&mut payload, &node.m2)?;
    }
    payload.write_all(method_state)?;
    let mut bytes = payload.finish()?;
    let checksum = checksum(&bytes);
    bytes.extend(checksum.to_le_bytes());
    Ok(bytes)
}

pub(super) fn decode(bytes: &[u8]) -> Result<Checkpoint, String> {
    let damaged = || "the checkpoint is damaged or cut short".to_string();
    if !bytes.starts_with(MAGIC) {
        return Err("not a checkpoint".into());
    }
    let (body, sum) = bytes.split_last_chunk::<8>().ok_or_else(damaged)?;
    if checksum(body) != u64::from_le_bytes(*sum) {
        return Err(damaged());
    }
    let mut rest = &body[MAGIC.len()..];
    let version = read_u32(&mut rest).ok_or_else(damaged)?;
    if version != VERSION {
        return Err(format!("a checkpoint of format {version}; this program reads {VERSION}"));
    }
    let length = read_u32(&mut rest).ok_or_else(damaged)? as usize;
    let (header, payload) = rest.split_at_checked(length).ok_or_else(damaged)?;
    let header: Header =
        serde_json::from_slice(header).map_err(|e| format!("its header can't be read: {e}"))?;
    let broken = |e: io::Error| format!("its contents can't be read: {e}");
    let mut payload = ZlibDecoder::new(payload);

    let [width, height] = header.record.size();
    let layers: Result<Vec<Feature>, String> =
        header.record.layers.iter().map(|l| l.parse()).collect();
    let paths = header.record.path_layers.iter();
    let paths = paths.map(|l| l.split_once('=').map_or(l.as_str(), |(name, _)| name).to_owned());
    let layers = Layers::new(&layers?).with_paths(paths.collect());
    let layers = layers.with_bands(header.record.bands.len());
    let pixels = width as usize * height as usize;
    let mut nodes = Vec::new();
    for (start, level, weight) in header.nodes {
        if level > 62 || start.checked_add(1 << level).is_none() {
            return Err("its passes are numbered impossibly".into());
        }
        if !(weight > 0.0 && weight.is_finite()) {
            return Err("its passes are weighed impossibly".into());
        }
        let sum = read_floats(&mut payload, pixels * layers.stride()).map_err(broken)?;
        let m2 = read_floats(&mut payload, pixels * 3).map_err(broken)?;
        nodes.push(Node { start, level, weight, sum, m2 });
    }
    let tree = PassTree::from_nodes(width, height, layers, nodes).map_err(|e| e.to_string())?;
    let mut method_state = Vec::new();
    payload.take(header.method_state_bytes).read_to_end(&mut method_state).map_err(broken)?;
    if method_state.len() as u64 != header.method_state_bytes {
        return Err(damaged());
    }
    Ok(Checkpoint { record: header.record, tree, method_state, seconds: header.seconds })
}

fn checksum(bytes: &[u8]) -> u64 {
    let mut print = Fingerprint::default();
    print.bytes(bytes);
    print.finish()
}

fn read_u32(bytes: &mut &[u8]) -> Option<u32> {
    let (word, rest) = bytes.split_first_chunk::<4>()?;
    *bytes = rest;
    Some(u32::from_le_bytes(*word))
}

/// Floats converted at a time.
const BLOCK: usize = 1 << 14;

fn write_floats(out: &mut impl Write, values: &[f32]) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(4 * BLOCK);
    for block in values.chunks(BLOCK) {
        buffer.clear();
        buffer.extend(block.iter().flat_map(|v| v.to_le_bytes()));
        out.write_all(&buffer)?;
    }
    Ok(())
}

/// Reads block by block, so that a length no data stand behind allocates nothing.
fn read_floats(from: &mut impl Read, count: usize) -> io::Result<Vec<f32>> {
    let mut values = Vec::new();
    let mut buffer = [0; 4 * BLOCK];
    while values.len() < count {
        let block = &mut buffer[..4 * BLOCK.min(count - values.len())];
        from.read_exact(block)?;
        let floats = block.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        values.extend(floats);
    }
    Ok(values)
}
