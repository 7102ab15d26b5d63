//! Broken scenes of glTF 2.0.

use super::case::Case;

pub fn cases() -> Vec<Case> {
    let gltf = |name, text: &str| Case::new(name, "render s.gltf -o a.exr").file("s.gltf", text);
    let glb = |name, bytes: &[u8]| Case::new(name, "render s.glb -o a.exr").file("s.glb", bytes);
    vec![
        Case::new("gltf-missing-file", "render gone.gltf -o a.exr"),
        gltf("gltf-malformed", "{\n  \"asset\": {\"version\": \"2.0\",}\n}\n"),
        gltf("gltf-of-version-1", "{\n  \"asset\": {\"version\": \"1.0\"}\n}\n"),
        gltf(
            "gltf-missing-buffer",
            "{\n  \"asset\": {\"version\": \"2.0\"},\n  \"buffers\": [\n    {\"byteLength\": 36, \"uri\": \
             \"gone.bin\"}\n  ],\n  \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],\n  \
             \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"type\": \"VEC3\", \"count\": 3}],\n  \
             \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}],\n  \"nodes\": \
             [{\"mesh\": 0}]\n}\n",
        ),
        gltf(
            "gltf-no-such-mesh",
            "{\n  \"asset\": {\"version\": \"2.0\"},\n  \"nodes\": [\n    {\"mesh\": 4}\n  ]\n}\n",
        ),
        gltf(
            "gltf-compressed",
            "{\n  \"asset\": {\"version\": \"2.0\"},\n  \"extensionsRequired\": \
             [\"KHR_draco_mesh_compression\"]\n}\n",
        ),
        glb("glb-cut", b"glTF\x02\0\0\0\x60\0\0\0\x40\0\0\0JSON{"),
        glb("glb-of-version-1", b"glTF\x01\0\0\0\x0c\0\0\0"),
    ]
}
