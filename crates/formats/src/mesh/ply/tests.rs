//! Files that threads share.

use super::*;

/// Vertices, enough for several tasks.
const N: usize = 40_000;

/// `N` vertices with normals and texture coordinates in binary, then faces in binary as given.
fn file(position: impl Fn(usize) -> f32, faces: &[&[u32]]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {N}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property float u\nproperty float v\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        faces.len()
    )
    .into_bytes();
    for i in 0..N {
        let nz = if i % 20_000 == 1 { f32::NAN } else { -2.0 };
        let record = [position(i), 1.0, 2.0, 0.0, 0.0, nz, i as f32, 0.25];
        bytes.extend(record.iter().flat_map(|v| v.to_le_bytes()));
    }
    for face in faces {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

fn read_with(threads: usize, bytes: &[u8]) -> (Result<TriMesh, Fault>, Vec<MeshNote>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut notes = Vec::new();
    let mesh = pool.install(|| parse(bytes, &MeshOptions::default(), &mut notes));
    (mesh, notes)
}

/// As many triangles as make several tasks.
fn triangles() -> Vec<[u32; 3]> {
    (0..30_000).map(|i| [i, i + 1, (7 * i) % N as u32]).collect()
}

#[test]
fn every_thread_reads_its_part() {
    let triangles = triangles();
    let faces: Vec<&[u32]> = triangles.iter().map(|t| t.as_slice()).collect();
    let bytes = file(|i| i as f32, &faces);
    for threads in [1, 3] {
        let (mesh, notes) = read_with(threads, &bytes);
        let mesh = mesh.unwrap();
        assert_eq!(notes, [MeshNote::NormalsDropped(2)]);
        assert_eq!(mesh.indices, triangles);
        for i in 0..N {
            assert_eq!(mesh.positions[i].x, i as f32);
            assert_eq!((mesh.uvs[i].x, mesh.uvs[i].y), (i as f32, 0.25));
            let nz = if i % 20_000 == 1 { 0.0 } else { -1.0 };
            assert_eq!(mesh.normals[i].z, nz, "{i}");
        }
    }
}

#[test]
fn the_first_fault_is_told_whoever_finds_it() {
    let triangle: &[u32] = &[0, 1, 2];
    for threads in [1, 3] {
        let bytes = file(|i| if i == 20_123 || i == 39_999 { f32::NAN } else { 0.0 }, &[triangle]);
        let fault = read_with(threads, &bytes).0.unwrap_err();
        assert_eq!(fault.place, Place::entry("vertex", 20_123));

        let mut triangles = triangles();
        triangles[12_345][1] = N as u32;
        triangles[29_999][1] = u32::MAX;
        let faces: Vec<&[u32]> = triangles.iter().map(|t| t.as_slice()).collect();
        let fault = read_with(threads, &file(|_| 0.0, &faces)).0.unwrap_err();
        assert_eq!(fault.place, Place::entry("face", 12_345));
    }
}

#[test]
fn polygons_among_triangles_are_cut() {
    let quad: &[u32] = &[4, 5, 6, 7];
    let mut faces: Vec<&[u32]> = vec![&[0, 1, 2]; 20_000];
    faces.push(quad);
    faces.push(&[8, 9]);
    let (mesh, notes) = read_with(2, &file(|_| 0.0, &faces));
    let mesh = mesh.unwrap();
    assert_eq!(mesh.indices.len(), 20_002);
    assert_eq!(mesh.indices[20_000..], [[4, 5, 6], [4, 6, 7]]);
    assert!(notes.contains(&MeshNote::ThinFacesSkipped(1)));
}
