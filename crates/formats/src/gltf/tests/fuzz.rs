//! Damaged files: any result but a panic, or a description far larger than the file.

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

/// One to three changes: a flipped bit, another digit, a piece cut out or doubled.
fn damage(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(3) {
        let at = random.below(bytes.len().max(1)).min(bytes.len().saturating_sub(1));
        match random.below(6) {
            0 => bytes[at] ^= 1 << random.below(8),
            1..=3 => bytes[at] = b"0123456789-.e[]{}\",:"[random.below(20)],
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

/// What the builder relies on.
fn check(d: &SceneDescription) {
    let groups = d.groups.iter().flat_map(|g| &g.shapes);
    for s in d.shapes.iter().chain(groups) {
        assert!((s.material.0 as usize) < d.materials.len());
        let GeometryDesc::Mesh(m) = &s.geometry else { panic!() };
        let n = m.positions.len();
        assert!(m.indices.iter().flatten().all(|&v| (v as usize) < n));
        assert!(m.positions.iter().all(|p| p.is_finite()));
        assert!(m.normals.is_empty() || m.normals.len() == n);
        assert!(m.uvs.is_empty() || m.uvs.len() == n);
        assert!(n < 10_000);
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut file = triangle();
    file.add(&[0, 1, 2], 5121, "SCALAR", 3, "");
    file.add(&[255; 12], 5121, "VEC4", 3, r#","normalized":true"#);
    let places = file.view(&[1]);
    file.accessors[0] = file.accessors[0].replace(
        r#""count":3"#,
        &format!(
            r#""count":3,"sparse":{{"count":1,"indices":{{"bufferView":{places},"componentType":5121}},"values":{{"bufferView":0}}}}"#
        ),
    );
    let rest = r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{"outerConeAngle":0.5}}]}},
        "cameras":[{"type":"perspective","perspective":{"yfov":0.5,"aspectRatio":1.5,"znear":0.1}}],
        "materials":[{"alphaMode":"MASK","normalTexture":{"index":0},"extensions":{"KHR_materials_ior":{"ior":1.4},
            "KHR_materials_sheen":{"sheenColorFactor":[1,1,1]},"KHR_materials_dispersion":{"dispersion":0.5},
            "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":1.5}}}],
        "textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":10497,"minFilter":9987}],
        "images":[{"bufferView":1,"mimeType":"image/png"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":3},"indices":2,"material":0,"mode":5}]}],
        "scenes":[{"nodes":[0]}],"scene":0,
        "nodes":[{"mesh":0,"children":[1,2],"rotation":[0,0,1,1]},{"camera":0,"scale":[1,2,3]},
                 {"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1],"extensions":{"KHR_lights_punctual":{"light":0}}}]"#;
    let text = file.json(Some(uri(&file.bytes)), rest).into_bytes();
    for (k, bytes) in [text, file.binary(rest)].into_iter().enumerate() {
        let mut random = Random(17 + k as u64);
        let mut sound = 0;
        for _ in 0..20_000 {
            let d = parse_gltf(Path::new("a.gltf"), damage(&bytes, &mut random));
            check(&d);
            sound += usize::from(!d.shapes.is_empty());
        }
        assert!(sound > 100 && sound < 19_900, "{sound}");
    }
}
