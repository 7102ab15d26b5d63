//! Damaged files: any result but a panic, or a mesh far larger than the file.

use super::files::{ORDERS, of_mesh, ply_file, serialized_content, serialized_file};
use super::*;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// One to four changes: a flipped bit, another byte, a piece cut out or doubled.
fn damage(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        match random.below(6) {
            0 | 1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = random.next() as u8,
            3 => bytes[at] = b"0123456789-/. \n"[random.below(15)],
            4 => {
                let end = (at + random.below(8)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                let end = (at + random.below(8)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}

/// Bytes that a mesh keeps allocated.
fn size(mesh: &TriMesh) -> usize {
    mesh.positions.capacity() * 12
        + mesh.normals.capacity() * 12
        + mesh.uvs.capacity() * 8
        + mesh.indices.capacity() * 12
        + mesh.attributes.iter().map(|a| a.values.capacity() * 4).sum::<usize>()
}

fn check(mesh: &TriMesh) {
    let n = mesh.positions.len();
    assert!(mesh.indices.iter().flatten().all(|&v| (v as usize) < n));
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.normals.is_empty() || mesh.normals.len() == n);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == n);
    for a in &mesh.attributes {
        let elements = if a.per_face { mesh.indices.len() } else { n };
        assert_eq!(a.values.len(), elements * a.channels as usize);
    }
}

fn fuzz(bytes: &[u8], format: MeshFormat, rounds: usize, seed: u64) {
    let mut random = Random(seed);
    let mut sound = 0;
    for round in 0..rounds {
        let damaged = damage(bytes, &mut random);
        let options = match round % 3 {
            0 => MeshOptions::default(),
            1 => MeshOptions::mitsuba(format),
            _ => MeshOptions {
                normals: NormalPolicy::SmoothBelow(40.0),
                shape_index: 1,
                ..MeshOptions::default()
            },
        };
        if let Ok(mesh) = parse_mesh(&damaged, format, &options, &mut Vec::new()) {
            check(&mesh);
            // 64 KiB of headroom a list, and what a byte of PLY can stand for.
            assert!(size(&mesh) < 64 * damaged.len() + (1 << 22), "{}", size(&mesh));
            sound += 1;
        }
    }
    // Some damage goes unnoticed (another coordinate) and some does not, or this tests nothing.
    assert!(sound > rounds / 1000 && sound < rounds, "{sound} of {rounds}");
}

#[test]
fn damaged_ply_files_never_panic() {
    for (i, order) in ORDERS.into_iter().enumerate() {
        let file = ply_file(order, &of_mesh(&sample()));
        fuzz(&file, MeshFormat::Ply, 20_000, 11 + i as u64);
    }
}

#[test]
fn damaged_obj_files_never_panic() {
    let text = "# x\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
                o a\nusemtl b\nf 1/1/1 2/2/1 3/3/1 -1/1/-1\nf 1//1 2//1 3\nf 1 2 3 4\n";
    fuzz(text.as_bytes(), MeshFormat::Obj, 40_000, 21);
}

#[test]
fn damaged_serialized_files_never_panic() {
    let mut mesh = sample();
    mesh.attributes.truncate(1);
    let content = serialized_content(4, false, 0, &mesh);
    let file = serialized_file(4, &[content.clone(), content.clone()]);
    fuzz(&file, MeshFormat::Serialized, 20_000, 31);
    // Damage before compression, which the checksum cannot see.
    let mut random = Random(41);
    for _ in 0..20_000 {
        let file = serialized_file(4, &[damage(&content, &mut random)]);
        let options = MeshOptions::mitsuba(MeshFormat::Serialized);
        if let Ok(mesh) = parse_mesh(&file, MeshFormat::Serialized, &options, &mut Vec::new()) {
            check(&mesh);
            assert!(size(&mesh) < 1 << 22);
        }
    }
}
