//! Meshes written as PLY.

use super::*;
use kaustika_math::Vec2;

#[test]
fn a_written_mesh_reads_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let bare =
        TriMesh { positions: sample().positions, indices: sample().indices, ..TriMesh::default() };
    for mesh in [sample(), bare, TriMesh::default()] {
        write_ply(&path, &mesh).unwrap();
        let mut notes = Vec::new();
        let read = read_mesh_noting(&path, &MeshOptions::default(), &mut notes).unwrap();
        assert_eq!(read, mesh);
        assert_eq!(notes, []);
    }
    // Nothing else is left behind.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |change: fn(&mut TriMesh)| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        let mut mesh = sample();
        change(&mut mesh);
        let error = write_ply(&path, &mesh).unwrap_err();
        assert!(matches!(error.cause, MeshCause::Unwritable(_)), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    };
    refused(|m| m.uvs.push(Vec2::ZERO));
    refused(|m| m.normals.truncate(1));
    refused(|m| m.indices[0][1] = 4);
    refused(|m| m.attributes[0].values.truncate(1));
    refused(|m| m.attributes[0].channels = 4);
    refused(|m| m.attributes[1].name = "heat".into());
    refused(|m| m.attributes[1].name = "vertex_a b".into());
    refused(|m| m.attributes[1].name = "face_heat".into());
}

#[test]
fn a_folder_that_does_not_exist_is_an_error() {
    let error = write_ply(Path::new("/no/such/folder/a.ply"), &sample()).unwrap_err();
    assert!(matches!(error.cause, MeshCause::Io(_)), "{error}");
}
