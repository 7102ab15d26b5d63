//! Fingerprints: are these the same bytes, is this the same scene?
//!
//! Not for keeping secrets: 128 bits tell files apart that differ by accident, not by malice.

use kaustika_math::{Vec2, Vec3, mix_bits};
use kaustika_scene::description::{
    Bitmap, Curves, GeometryDesc, LightKind, SceneDescription, ShapeDesc, Texels, TextureNode,
    TriMesh,
};
use std::collections::HashSet;
use std::fmt::Debug;
use std::sync::Arc;

/// A running hash of words and bytes.
#[derive(Clone, Debug)]
pub struct Fingerprint {
    state: [u64; 2],
}

impl Default for Fingerprint {
    fn default() -> Self {
        Fingerprint { state: [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344] }
    }
}

impl Fingerprint {
    /// Adds a word.
    #[inline]
    pub fn word(&mut self, w: u64) {
        let [a, b] = self.state;
        self.state = [
            mix_bits(a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ w),
            mix_bits(b.rotate_left(23).wrapping_add(w).wrapping_mul(0xd6e8_feb8_6659_fd93)),
        ];
    }

    /// Adds bytes and their number.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        let words = bytes.chunks_exact(8);
        let mut rest = [0; 8];
        rest[..words.remainder().len()].copy_from_slice(words.remainder());
        for w in words {
            let mut word = [0; 8];
            word.copy_from_slice(w);
            self.word(u64::from_le_bytes(word));
        }
        self.word(u64::from_le_bytes(rest));
    }

    /// 64 bits of it.
    pub fn finish(&self) -> u64 {
        self.state[0] ^ self.state[1].rotate_left(32)
    }

    /// All of it, as 32 hexadecimal digits.
    pub fn hex(&self) -> String {
        format!("{:016x}{:016x}", self.state[0], self.state[1])
    }

    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        for v in values {
            self.word(v.to_bits() as u64);
        }
    }

    /// Small things, by what their `Debug` says.
    fn debug(&mut self, value: &impl Debug) {
        self.bytes(format!("{value:?}").as_bytes());
    }
}

/// The fingerprint of a scene: of the texts of its files, of the values substituted in them, and
/// of the meshes and images they name. Where the files lie does not matter.
pub fn of_scene(d: &SceneDescription) -> String {
    let mut scene = SceneHash { print: Fingerprint::default(), bitmaps: HashSet::new() };
    for file in &d.sources.files {
        scene.print.bytes(file.text.as_bytes());
    }
    scene.print.debug(&d.format);
    scene.print.debug(&d.cameras);
    scene.print.debug(&d.integrator);
    scene.print.debug(&d.materials);
    scene.print.debug(&d.media);
    for texture in &d.textures {
        match &texture.node {
            TextureNode::Bitmap(b) => {
                scene.bitmap(&b.bitmap);
                scene.print.debug(&(b.channels, b.filter, b.wrap, &b.mapping, b.space));
                scene.print.debug(&(b.scale, b.invert, b.raw));
            }
            node => scene.print.debug(node),
        }
    }
    for light in &d.lights {
        match &light.kind {
            LightKind::Image { bitmap, scale, .. }
            | LightKind::Portal { bitmap, scale, .. }
            | LightKind::Projection { bitmap, scale, .. } => {
                scene.bitmap(bitmap);
                scene.print.floats([*scale]);
            }
            LightKind::Goniometric { bitmap, scale, intensity, .. } => {
                scene.bitmap(bitmap);
                scene.print.floats([*scale]);
                scene.print.debug(intensity);
            }
            kind => scene.print.debug(kind),
        }
        scene.print.debug(&light.transform);
    }
    scene.shapes(&d.shapes);
    for group in &d.groups {
        scene.shapes(&group.shapes);
    }
    scene.print.debug(&d.instances);
    scene.print.hex()
}

struct SceneHash {
    print: Fingerprint,
    /// Images seen, by address: many textures share one.
    bitmaps: HashSet<*const Bitmap>,
}

impl SceneHash {
    fn shapes(&mut self, shapes: &[ShapeDesc]) {
        let print = &mut self.print;
        print.word(shapes.len() as u64);
        for s in shapes {
            print.floats(s.transform.m.into_iter().flatten());
            print.word(s.flip_normals as u64);
            print.word(s.material.0 as u64);
            print.debug(&s.emission);
            print.debug(&(s.alpha, s.interior, s.exterior));
            match &s.geometry {
                GeometryDesc::Mesh(mesh) => self::mesh(print, mesh),
                GeometryDesc::Displaced(of) => {
                    self::mesh(print, &of.mesh);
                    print.debug(&(of.height, of.edge_length));
                }
                GeometryDesc::Curves(c) => curves(print, c),
                GeometryDesc::SdfGrid(grid) => {
                    print.debug(&(grid.resolution, grid.normals));
                    print.floats(grid.values.iter().copied());
                }
                geometry => print.debug(geometry),
            }
        }
    }

    fn bitmap(&mut self, b: &Arc<Bitmap>) {
        self.print.debug(&(b.width, b.height, b.channels, b.encoding));
        if self.bitmaps.insert(Arc::as_ptr(b)) {
            match &b.texels {
                Texels::U8(t) => self.print.bytes(t),
                Texels::U16(t) => t.iter().for_each(|&v| self.print.word(v as u64)),
                Texels::F32(t) => self.print.floats(t.iter().copied()),
            }
        }
    }
}

fn curves(print: &mut Fingerprint, c: &Curves) {
    print.debug(&c.profile);
    print.word(c.segments.len() as u64);
    for s in &c.segments {
        print.floats(s.points.iter().flat_map(|p| [p.x, p.y, p.z]).chain(s.radii));
    }
    print.floats(c.normals.iter().flatten().flat_map(|n| [n.x, n.y, n.z]));
}

fn mesh(print: &mut Fingerprint, m: &TriMesh) {
    let of_vec3 = |v: &Vec3| [v.x, v.y, v.z];
    let of_vec2 = |v: &Vec2| [v.x, v.y];
    let lengths = [m.positions.len(), m.normals.len(), m.uvs.len(), m.indices.len()];
    lengths.iter().for_each(|&n| print.word(n as u64));
    print.floats(m.positions.iter().flat_map(of_vec3));
    print.floats(m.normals.iter().flat_map(of_vec3));
    print.floats(m.uvs.iter().flat_map(of_vec2));
    m.indices.iter().flatten().for_each(|&i| print.word(i as u64));
    for a in &m.attributes {
        print.debug(&(&a.name, a.channels, a.per_face));
        print.floats(a.values.iter().copied());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8]) -> String {
        let mut f = Fingerprint::default();
        f.bytes(bytes);
        f.hex()
    }

    #[test]
    fn every_bit_and_the_length_count() {
        let base = [7u8; 19];
        let mut seen = HashSet::from([of(&base), of(&base[..18]), of(&[])]);
        assert_eq!(seen.len(), 3);
        for bit in 0..8 * base.len() {
            let mut changed = base;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(seen.insert(of(&changed)), "bit {bit}");
        }
        // Zeros at the end are not lost in the padding.
        assert_ne!(of(&[1, 0]), of(&[1]));
    }
}
