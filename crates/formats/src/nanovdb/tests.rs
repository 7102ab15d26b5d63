use super::*;
use kaustika_math::Vec3;

/// Bytes that are written out of order.
struct Writer(Vec<u8>);

impl Writer {
    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.0.resize(self.0.len().max(at + bytes.len()), 0);
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
    }
}

const ROOT: usize = 736;
const UPPER: usize = ROOT + 64 + 2 * 32;
const LOWER: usize = UPPER + 270_400;
const LEAF: usize = LOWER + 33_856;
/// The box of the grid's indices.
const MIN: [i32; 3] = [-4, 10, 7];
const MAX: [i32; 3] = [1, 12, 16];

/// Number of a place in a node of side 2^log2.
fn number([x, y, z]: [usize; 3], log2: usize) -> usize {
    (x << log2 | y) << log2 | z
}

/// A grid of a leaf at (-8, 8, 0), one tile of 7 at (-8, 8, 8), the rest 0.25, and 3 in a tile of
/// the root where x >= 0. Its voxels are 2 wide, the first at (1, 0, 0).
fn grid() -> Vec<u8> {
    let mut w = Writer(Vec::new());
    for k in 0..3 {
        w.put(384 + 8 * (3 * k + k), &2f64.to_le_bytes());
        w.put(528 + 8 * k, &f64::from(u8::from(k == 0)).to_le_bytes());
    }
    w.put(672 + 24, &(ROOT as i64 - 672).to_le_bytes());
    for (i, v) in MIN.iter().chain(&MAX).enumerate() {
        w.put(ROOT + 4 * i, &v.to_le_bytes());
    }
    w.put(ROOT + 24, &2u32.to_le_bytes());
    w.put(ROOT + 28, &0.25f32.to_le_bytes());
    // The part of the tree from -4096 to -1 in x, and a tile from 0 on.
    let key = |x: i32| u64::from(x as u32 >> 12) << 42;
    w.put(ROOT + 64, &key(-4096).to_le_bytes());
    w.put(ROOT + 72, &(UPPER as i64 - ROOT as i64).to_le_bytes());
    w.put(ROOT + 96, &key(0).to_le_bytes());
    w.put(ROOT + 96 + 20, &3f32.to_le_bytes());
    for n in 0..32 * 32 * 32 {
        w.put(UPPER + 8256 + 8 * n, &0.25f32.to_le_bytes());
    }
    for n in 0..16 * 16 * 16 {
        w.put(LOWER + 1088 + 8 * n, &0.25f32.to_le_bytes());
    }
    let mut child = |node: usize, mask: usize, table: usize, n: usize, to: usize| {
        w.put(node + mask + n / 8, &[1 << (n % 8)]);
        w.put(node + table + 8 * n, &(to as i64 - node as i64).to_le_bytes());
    };
    child(UPPER, 32 + 4096, 8256, number([31, 0, 0], 5), LOWER);
    child(LOWER, 32 + 512, 1088, number([15, 1, 0], 4), LEAF);
    w.put(LOWER + 1088 + 8 * number([15, 1, 1], 4), &7f32.to_le_bytes());
    for n in 0..512 {
        w.put(LEAF + 96 + 4 * n, &(n as f32).to_le_bytes());
    }
    w.0
}

/// A file of one grid.
fn file(name: &str, grid: &[u8], codec: u16, kind: u32) -> Vec<u8> {
    let mut packed = grid.to_vec();
    if codec == 1 {
        use std::io::Write;
        let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        zip.write_all(grid).expect("vectors can be written");
        let deflated = zip.finish().expect("vectors can be written");
        packed = (deflated.len() as u64).to_le_bytes().to_vec();
        packed.extend(deflated);
    }
    let mut w = Writer(b"NanoVDB0".to_vec());
    w.put(8, &(32u32 << 21 | 3 << 10).to_le_bytes());
    w.put(12, &[1, 0, codec as u8, 0]);
    w.put(16, &(grid.len() as u64).to_le_bytes());
    w.put(24, &(packed.len() as u64).to_le_bytes());
    w.put(48, &kind.to_le_bytes());
    w.put(52, &2u32.to_le_bytes());
    w.put(152, &(name.len() as u32 + 1).to_le_bytes());
    w.put(184, &codec.to_le_bytes());
    w.put(188, &[0; 4]);
    w.put(192, name.as_bytes());
    w.put(192 + name.len(), &[0]);
    w.0.extend(packed);
    w.0
}

fn read(bytes: Vec<u8>, name: &str) -> Result<Option<DenseGrid>, String> {
    let file = NanoVdbFile { bytes };
    file.grids()?;
    file.grid(name)
}

#[test]
fn leaves_tiles_and_the_map() {
    for codec in [0, 1] {
        let mut bytes = file("temperature", &grid(), codec, 1);
        bytes.extend(file("density", &grid(), 0, 1));
        let names = NanoVdbFile { bytes: bytes.clone() }.names();
        assert_eq!(names, ["temperature", "density"]);
        assert_eq!(read(bytes.clone(), "smoke"), Ok(None));
        for name in ["temperature", "density"] {
            let dense = read(bytes.clone(), name).expect("a sound file").expect("this grid");
            assert_eq!((dense.min, dense.resolution), (MIN, [6, 3, 10]));
            for (i, v) in dense.values.iter().enumerate() {
                let [x, y, z] = [i % 6, i / 6 % 3, i / 18];
                let [x, y, z] = [x as i32 + MIN[0], y as i32 + MIN[1], z as i32 + MIN[2]];
                let expected = match (x, z) {
                    (0.., _) => 3.0,
                    (_, ..8) => number([x + 8, y - 8, z].map(|v| v as usize), 3) as f32,
                    (_, 8..16) => 7.0,
                    _ => 0.25,
                };
                assert_eq!(*v, expected, "{x} {y} {z}");
            }
            assert_eq!(dense.to_world.point(Vec3::new(0.0, 1.0, 3.0)), Vec3::new(1.0, 2.0, 6.0));
            assert_eq!(dense.index_box()[1], Vec3::new(2.0, 13.0, 17.0));
        }
    }
}

#[test]
fn damaged_files_say_why() {
    let why = |bytes: Vec<u8>| read(bytes, "d").expect_err("must be refused");
    let whole = grid();
    assert_eq!(why(b"VOL".to_vec()), "the file ends too early");
    let not = "not a NanoVDB file: a segment does not begin with `NanoVDB`";
    assert_eq!(why(b"VOL, and more of the same".to_vec()), not);
    let of = |kind, codec| file("d", &whole, codec, kind);
    assert_eq!(why(of(2, 0)), "grid `d`: its values are of type 2, expected 1 (float)");
    let blosc =
        "grid `d`: codec 2 is not supported, only 0 (none) and 1 (zip): write it again with one";
    assert_eq!(why(of(1, 2)), blosc);
    let mut huge = whole.clone();
    huge[ROOT..ROOT + 4].copy_from_slice(&(-2_000_000_000i32).to_le_bytes());
    assert!(why(file("d", &huge, 0, 1)).contains("is too large, at most 2^28 are kept"));
    let mut nan = whole.clone();
    nan[LEAF + 96..LEAF + 96 + 2048].fill(0xff);
    assert_eq!(why(file("d", &nan, 0, 1)), "grid `d`: a sample is NaN");
    let mut zip = of(1, 1);
    zip.truncate(zip.len() - 40);
    assert_eq!(why(zip), "the file ends too early");
    // Every shorter file is refused; every flipped byte of the heads is refused or read, without
    // a panic.
    let sound = of(1, 0);
    for end in (1..sound.len()).step_by(997) {
        assert!(read(sound[..end].to_vec(), "d").is_err(), "{end}");
        assert!(read(file("d", &whole[..end.min(whole.len() - 1)], 0, 1), "d").is_err(), "{end}");
    }
    for i in (0..194 + ROOT + 128).chain(194 + UPPER + 8200..194 + UPPER + 8300) {
        let mut bytes = sound.clone();
        bytes[i] ^= 0xff;
        let _ = read(bytes, "d");
    }
}
