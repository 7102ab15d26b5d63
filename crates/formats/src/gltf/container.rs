//! The file: JSON, or the binary container around JSON and one buffer.

use super::json::Fault;
use kaustika_scene::description::Severity;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

fn fault(message: impl Into<String>) -> Fault {
    let (path, hint) = (String::new(), None);
    Fault { path, message: message.into(), hint, severity: Severity::Error }
}

/// The JSON text of a file's contents, and the binary chunk of a `.glb`.
pub(super) fn open(bytes: Vec<u8>) -> Result<(String, Option<Vec<u8>>), Fault> {
    if !bytes.starts_with(MAGIC) {
        let text = String::from_utf8(bytes)
            .map_err(|e| fault(format!("not UTF-8 from byte {}", e.utf8_error().valid_up_to())))?;
        // A byte order mark is none of JSON's.
        return Ok((text.trim_start_matches('\u{feff}').to_string(), None));
    }
    let number = |at: usize| -> Result<u32, Fault> {
        let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        four.map(u32::from_le_bytes)
            .ok_or_else(|| fault(format!("the file ends at byte {}, within a header", bytes.len())))
    };
    let version = number(4)?;
    if version != 2 {
        return Err(fault(format!("byte 4: container version 2 expected, found {version}"))
            .hint("converters from older versions exist"));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    let end = bytes.len().min(number(8)? as usize);
    while at + 8 <= end {
        let (length, kind) = (number(at)? as usize, number(at + 4)?);
        let chunk = bytes.get(at + 8..at + 8 + length).ok_or_else(|| {
            let left = bytes.len() - at - 8;
            fault(format!("byte {at}: a chunk of {length} bytes, but {left} are left"))
        })?;
        match kind {
            JSON if json.is_none() => {
                let text = std::str::from_utf8(chunk)
                    .map_err(|e| fault(format!("byte {}: not UTF-8", at + 8 + e.valid_up_to())))?;
                json = Some(text.to_string());
            }
            BIN if binary.is_none() => binary = Some(chunk.to_vec()),
            _ => {}
        }
        at += 8 + length;
    }
    let json = json.ok_or_else(|| fault("the container holds no JSON"))?;
    Ok((json, binary))
}
