//! Round trips, the textures' formats, and files that are broken on purpose.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use half::f16;
use image::codecs::tga::TgaEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::*;
use crate::{Channel, ChannelKind, MetaValue};

/// A folder of its own for one test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("kaustika-film-{test}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn with(&self, name: &str, bytes: &[u8]) -> PathBuf {
        fs::write(self.file(name), bytes).unwrap();
        self.file(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Every pixel different, values from 0 to 2, row 0 darkest.
fn gradient(width: u32, height: u32) -> Picture {
    let n = (width * height) as f32;
    let pixel = |i: u32| {
        let t = i as f32 / n;
        [2.0 * t, t * t, 0.25 + 0.5 * t]
    };
    let pixels: Vec<[f32; 3]> = (0..width * height).map(pixel).collect();
    Picture::from_rgb(width, height, &pixels)
}

fn max_difference(a: &Picture, b: &Picture) -> f32 {
    let (a, b) = (a.rgb().unwrap(), b.rgb().unwrap());
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pairs = a.pixels().flatten().zip(b.pixels().flatten());
    pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

#[test]
fn exr_keeps_channels_kinds_windows_and_metadata() {
    let folder = Folder::new("exr");
    let mut p = gradient(5, 3);
    p.push("Albedo.R", (0..15).map(|i| i as f32 * 1e6).collect());
    p.push("S0.550,938nm", vec![-1.0; 15]);
    p.channels.push(Channel { name: "h".into(), data: vec![0.5; 15], kind: ChannelKind::Half });
    p.channels.push(Channel {
        name: "id".into(),
        data: (0..15).map(|i| i as f32).collect(),
        kind: ChannelKind::Uint,
    });
    p.display_window = Some([0, 0, 20, 10]);
    p.data_origin = [7, 4];
    let mut matrix = [0.0; 16];
    for (i, m) in matrix.iter_mut().enumerate() {
        *m = i as f32;
    }
    let white = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
    p.metadata = vec![
        ("chromaticities".into(), MetaValue::Chromaticities(white)),
        ("emissiveUnits".into(), MetaValue::Text("W.m^-2.sr^-1 é".into())),
        ("near".into(), MetaValue::Float(0.5)),
        ("renderTimeSeconds".into(), MetaValue::Float(1.5)),
        ("samplesPerPixel".into(), MetaValue::Int(64)),
        ("seconds".into(), MetaValue::Double(0.1)),
        ("software".into(), MetaValue::Text("kaustika".into())),
        ("worldToCamera".into(), MetaValue::Matrix(matrix)),
    ];
    let path = folder.file("all.exr");
    write_picture(&path, &p, &WriteOptions::default()).unwrap();
    let mut back = read_picture(&path).unwrap();
    // The format sorts channels by name.
    back.channels.sort_by(|a, b| a.name.cmp(&b.name));
    p.channels.sort_by(|a, b| a.name.cmp(&b.name));
    assert_eq!(back, p);

    let half = WriteOptions { half: true, ..WriteOptions::default() };
    write_picture(&path, &p, &half).unwrap();
    let back = read_picture(&path).unwrap();
    assert!(back.channels.iter().all(|c| c.kind != ChannelKind::Float32));
    assert!(max_difference(&back, &p) < 1e-3);
}

#[test]
fn parts_of_a_file_become_layers() {
    use ::exr::prelude::*;
    let part = |name: &str, size: usize, value: f32| {
        let samples = FlatSamples::F32(vec![value; size * size]);
        let channels = AnyChannels::sort(SmallVec::from_vec(vec![AnyChannel::new("Y", samples)]));
        let attributes = LayerAttributes::named(name);
        Layer::new((size, size), attributes, Encoding::SMALL_LOSSLESS, channels)
    };
    let layers = vec![part("beauty", 4, 1.0), part("depth", 4, 2.0), part("small", 2, 3.0)];
    let window = IntegerBounds::from_dimensions((4, 4));
    let image = Image::from_layers(ImageAttributes::new(window), layers);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let folder = Folder::new("parts");
    let p = read_picture(folder.with("parts.exr", bytes.get_ref())).unwrap();
    let names: Vec<_> = p.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Y", "depth.Y"]);
    assert_eq!(p.channel("depth.Y").unwrap()[0], 2.0);
}

/// 64 x 40 grey half floats in every compression, as scan lines and as tiles.
fn compressed_exrs() -> (Vec<f16>, Vec<(String, Vec<u8>)>) {
    use ::exr::prelude::*;
    let mut files = Vec::new();
    let values: Vec<f16> = (0..64 * 40).map(|i| f16::from_f32((i % 64) as f32 / 64.0)).collect();
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let channel = AnyChannel::new("Y", FlatSamples::F16(values.clone()));
            let channels = AnyChannels::sort(SmallVec::from_vec(vec![channel]));
            let layer = Layer::new((64, 40), LayerAttributes::default(), encoding, channels);
            let mut bytes = Cursor::new(Vec::new());
            Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
            files.push((format!("{compression:?}.exr"), bytes.into_inner()));
        }
    }
    (values, files)
}

#[test]
fn all_exr_compressions_are_read() {
    let folder = Folder::new("compressions");
    let (values, files) = compressed_exrs();
    for (name, bytes) in files {
        let bitmap = read_bitmap(folder.with("c.exr", &bytes)).unwrap();
        let Texels::F32(texels) = &bitmap.texels else {
            panic!("{name}: float texels expected");
        };
        assert_eq!((bitmap.channels, bitmap.encoding), (1, Encoding::Linear));
        for (t, v) in texels.iter().zip(&values) {
            assert!((t - v.to_f32()).abs() < 0.05, "{name}: {t} is not {v}");
        }
    }
}

#[test]
fn linear_formats_round_trip() {
    let folder = Folder::new("linear");
    let p = gradient(13, 7);
    for (name, tolerance) in [("a.pfm", 0.0), ("a.hdr", 2.0 / 128.0), ("a.exr", 0.0)] {
        let path = folder.file(name);
        write_picture(&path, &p, &WriteOptions::default()).unwrap();
        let back = read_picture(&path).unwrap();
        assert!(max_difference(&back, &p) <= tolerance, "{name}");
        assert_eq!(read_bitmap(&path).unwrap().encoding, Encoding::Linear);
    }
    let mut grey = Picture::new(2, 2);
    grey.push("Y", vec![1.0, 2.0, 3.0, 4.0]);
    let path = folder.file("grey.pfm");
    write_picture(&path, &grey, &WriteOptions::default()).unwrap();
    assert_eq!(read_picture(&path).unwrap(), grey);
}

#[test]
fn display_formats_apply_exposure_tone_and_srgb() {
    let folder = Folder::new("display");
    let p = Picture::from_rgb(3, 1, &[[0.25; 3], [8.0, f32::NAN, -1.0], [0.0, 0.5, 1.0]]);
    let tone = |c: [f32; 3]| c.map(|v| 0.5 * v);
    let options = WriteOptions { exposure: 1.0, tone: Some(&tone), ..WriteOptions::default() };
    // Twice the exposure and half by the curve: sRGB of 0.25, of clamped values, of 0, 0.5, 1.
    let codes = [137, 137, 137, 255, 0, 0, 0, 188, 255];
    let path = folder.file("a.png");
    write_picture(&path, &p, &options).unwrap();
    let bitmap = read_bitmap(&path).unwrap();
    assert_eq!(bitmap.texels, Texels::U8(codes.to_vec()));
    assert_eq!((bitmap.channels, bitmap.encoding), (3, Encoding::Srgb));

    let deep = WriteOptions { sixteen_bit: true, ..options };
    write_picture(&path, &p, &deep).unwrap();
    let back = read_picture(&path).unwrap();
    let expected = [0.25, 0.25, 0.25, 1.0, 0.0, 0.0, 0.0, 0.5, 1.0];
    for (v, e) in back.rgb().unwrap().pixels().flatten().zip(expected) {
        assert!((v - e).abs() < 2e-5, "{v} {e}");
    }

    let flat = Picture::from_rgb(8, 8, &[[0.25, 0.5, 0.75]; 64]);
    let path = folder.file("a.jpg");
    write_picture(&path, &flat, &WriteOptions::default()).unwrap();
    assert!(max_difference(&read_picture(&path).unwrap(), &flat) < 0.02);
}

#[test]
fn pfm_byte_orders_rows_and_scale() {
    let folder = Folder::new("pfm");
    let mut big = b"PF 1 2 2.0\n".to_vec();
    for v in [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0] {
        big.extend(v.to_be_bytes());
    }
    let p = read_picture(folder.with("big.pfm", &big)).unwrap();
    assert_eq!(p.rgb().unwrap().pixel(0), [8.0, 10.0, 12.0]);
    assert_eq!(p.rgb().unwrap().pixel(1), [2.0, 4.0, 6.0]);
    let mut little = b"Pf\n2 1\n-1\n".to_vec();
    for v in [1.0f32, 2.0] {
        little.extend(v.to_le_bytes());
    }
    let p = read_picture(folder.with("little.pfm", &little)).unwrap();
    assert_eq!(p.channel("Y").unwrap(), [1.0, 2.0]);
}

/// A PNG of stored (uncompressed) blocks. `rows` holds the filter bytes too.
fn raw_png(header: [u8; 13], extra: &[(&[u8; 4], &[u8])], rows: &[u8]) -> Vec<u8> {
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &b| {
            (0..8).fold(crc ^ b as u32, |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
        })
    }
    fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
        out.extend((data.len() as u32).to_be_bytes());
        let body = [kind.as_slice(), data].concat();
        out.extend(&body);
        out.extend(crc(&body).to_be_bytes());
    }
    let (mut a, mut b) = (1u32, 0u32);
    for &byte in rows {
        a = (a + byte as u32) % 65521;
        b = (b + a) % 65521;
    }
    let length = rows.len() as u16;
    let mut zlib = vec![0x78, 0x01, 0x01];
    zlib.extend(length.to_le_bytes());
    zlib.extend((!length).to_le_bytes());
    zlib.extend(rows);
    zlib.extend((b << 16 | a).to_be_bytes());

    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut out, b"IHDR", &header);
    for (kind, data) in extra {
        chunk(&mut out, kind, data);
    }
    chunk(&mut out, b"IDAT", &zlib);
    chunk(&mut out, b"IEND", &[]);
    out
}

/// 2 x 2 pixels of a bit depth and colour type.
fn png_header(depth: u8, color: u8) -> [u8; 13] {
    [0, 0, 0, 2, 0, 0, 0, 2, depth, color, 0, 0, 0]
}

#[test]
fn png_kinds_of_pixels() {
    let folder = Folder::new("png");
    let read = |bytes: &[u8]| {
        let b = read_bitmap(folder.with("a.png", bytes)).unwrap();
        assert_eq!((b.width, b.height, b.encoding), (2, 2, Encoding::Srgb));
        (b.channels, b.texels)
    };
    let grey = raw_png(png_header(8, 0), &[], &[0, 1, 2, 0, 3, 4]);
    assert_eq!(read(&grey), (1, Texels::U8(vec![1, 2, 3, 4])));
    let bits = raw_png(png_header(1, 0), &[], &[0, 0b1000_0000, 0, 0b0100_0000]);
    assert_eq!(read(&bits), (1, Texels::U8(vec![255, 0, 0, 255])));
    let grey16 = raw_png(png_header(16, 0), &[], &[0, 1, 2, 3, 4, 0, 5, 6, 7, 8]);
    assert_eq!(read(&grey16), (1, Texels::U16(vec![0x0102, 0x0304, 0x0506, 0x0708])));
    let grey_alpha = raw_png(png_header(8, 4), &[], &[0, 1, 2, 3, 4, 0, 5, 6, 7, 8]);
    assert_eq!(read(&grey_alpha), (2, Texels::U8((1..=8).collect())));
    let rows: Vec<u8> = [0].into_iter().chain(1..=8).chain([0]).chain(9..=16).collect();
    let rgba = raw_png(png_header(8, 6), &[], &rows);
    assert_eq!(read(&rgba), (4, Texels::U8((1..=16).collect())));

    let palette: (&[u8; 4], &[u8]) = (b"PLTE", &[10, 20, 30, 40, 50, 60]);
    let indexed = raw_png(png_header(8, 3), &[palette], &[0, 0, 1, 0, 1, 0]);
    let expected = vec![10, 20, 30, 40, 50, 60, 40, 50, 60, 10, 20, 30];
    assert_eq!(read(&indexed), (3, Texels::U8(expected)));
    let see_through = raw_png(png_header(8, 3), &[palette, (b"tRNS", &[0])], &[0, 0, 1, 0, 1, 0]);
    let expected = vec![10, 20, 30, 0, 40, 50, 60, 255, 40, 50, 60, 255, 10, 20, 30, 0];
    assert_eq!(read(&see_through), (4, Texels::U8(expected)));
}

#[test]
fn cmyk_jpeg_becomes_rgb() {
    // 16 x 8, left half pure cyan, right half (0, 0, 128, 64) of 255, as Pillow 12 writes it.
    let bytes = include_bytes!("../../tests/data/cmyk.jpg");
    let b = read_bitmap(Folder::new("cmyk").with("cmyk.jpg", bytes)).unwrap();
    let Texels::U8(texels) = &b.texels else {
        panic!("8-bit texels expected");
    };
    assert_eq!(b.channels, 3);
    let near = |i: usize, c: [i32; 3]| {
        let t = &texels[3 * i..3 * i + 3];
        assert!(t.iter().zip(c).all(|(&a, b)| (a as i32 - b).abs() < 8), "{t:?} is not {c:?}");
    };
    near(2 * 16 + 2, [0, 255, 255]);
    near(4 * 16 + 12, [191, 191, 95]);
}

fn tga(width: u32, height: u32) -> Vec<u8> {
    let texels: Vec<u8> = (0..width * height * 3).map(|i| (i / 7) as u8).collect();
    let mut out = Vec::new();
    let encoder = TgaEncoder::new(&mut out);
    encoder.write_image(&texels, width, height, ExtendedColorType::Rgb8).unwrap();
    out
}

fn bmp(width: u32, height: u32) -> Vec<u8> {
    let texels: Vec<u8> = (0..width * height * 3).map(|i| (i * 7 % 251) as u8).collect();
    let mut out = Vec::new();
    let mut encoder = image::codecs::bmp::BmpEncoder::new(&mut out);
    encoder.encode(&texels, width, height, image::ExtendedColorType::Rgb8).unwrap();
    out
}

#[test]
fn bmp_rows_run_down() {
    let folder = Folder::new("bmp");
    let b = read_bitmap(folder.with("a.bmp", &bmp(9, 4))).unwrap();
    assert_eq!((b.width, b.height, b.channels, b.encoding), (9, 4, 3, Encoding::Srgb));
    let texels = (0..9 * 4 * 3).map(|i| (i * 7 % 251) as u8).collect();
    assert_eq!(b.texels, Texels::U8(texels));
    assert_eq!(
        message(&folder.with("short.bmp", b"BM")),
        "short.bmp: the BMP data ends early (truncated file)"
    );
}

#[test]
fn tga_and_content_before_extension() {
    let folder = Folder::new("tga");
    let b = read_bitmap(folder.with("a.tga", &tga(9, 4))).unwrap();
    let expected = (0..9 * 4 * 3).map(|i| (i / 7) as u8).collect();
    assert_eq!((b.channels, b.texels), (3, Texels::U8(expected)));

    let png = raw_png(png_header(8, 0), &[], &[0, 1, 2, 0, 3, 4]);
    let b = read_bitmap(folder.with("really_a_png.jpg", &png)).unwrap();
    assert_eq!(b.texels, Texels::U8(vec![1, 2, 3, 4]));
}

/// The message without the folder.
fn message(path: &Path) -> String {
    let error = read_bitmap(path).unwrap_err().to_string();
    let folder = format!("{}/", path.parent().unwrap().display());
    assert!(error.starts_with(&folder), "{error}");
    error.replace(&folder, "")
}

#[test]
fn errors_name_the_file_and_the_cause() {
    let folder = Folder::new("errors");
    assert_eq!(message(&folder.file("none.png")), "none.png: no such file");
    assert_eq!(
        message(&folder.with("a.txt", b"hello, world")),
        "a.txt: not an image format known here (png, jpg, tga, bmp, exr, hdr, pfm)"
    );
    assert_eq!(
        message(&folder.with("short.pfm", b"PF\n2 2\n-1.0\n1234")),
        "short.pfm: the PFM data ends early (truncated file)"
    );
    assert_eq!(
        message(&folder.with("empty.tga", b"")),
        "empty.tga: the TGA data ends early (truncated file)"
    );
    assert_eq!(
        message(&folder.with("odd.pfm", b"PF 1 x 1 ")),
        "odd.pfm: broken PFM data: height 'x' is not a number"
    );
    assert_eq!(
        message(&folder.with("huge.pfm", b"PF\n99999999 99999999\n-1.0\n1234")),
        "huge.pfm: the header claims 99999999 x 99999999 pixels, more than the 2^31 allowed"
    );
    let mut header = png_header(8, 0);
    header[1] = 1;
    header[5] = 1;
    assert_eq!(
        message(&folder.with("lie.png", &raw_png(header, &[], &[0, 0]))),
        "lie.png: the header claims 65538 x 65538 pixels, more than the 2^31 allowed"
    );
    header[1] = 0;
    header[2] = 0x7f;
    assert_eq!(
        message(&folder.with("lie.png", &raw_png(header, &[], &[0, 0]))),
        "lie.png: the header claims 32514 x 65538 pixels, more than a file of this length can hold"
    );
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40000 +X 40000\n";
    assert_eq!(
        message(&folder.with("lie.hdr", hdr)),
        "lie.hdr: the header claims 40000 x 40000 pixels, more than a file of this length can hold"
    );
    let write = |name: &str| {
        let path = folder.file(name);
        let error = write_picture(&path, &gradient(2, 2), &WriteOptions::default()).unwrap_err();
        error.to_string()
    };
    assert!(write("a.gif").ends_with("(exr, png, jpg, hdr and pfm can be written)"));
    assert!(write("missing/a.png").ends_with("missing/a.png: no such file"));
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = Folder::new("atomic");
    let path = folder.with("a.exr", b"old");
    let mut bad = gradient(2, 2);
    bad.channels[1].data.pop();
    let error = write_picture(&path, &bad, &WriteOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with("a.exr: channel 'G' has 3 values, not 2 x 2"));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    // A folder in the way: the rename itself fails.
    let blocked = folder.file("folder.png");
    fs::create_dir(&blocked).unwrap();
    write_picture(&blocked, &gradient(2, 2), &WriteOptions::default()).unwrap_err();
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 2);
    write_picture(&path, &gradient(2, 2), &WriteOptions::default()).unwrap();
    assert_eq!(read_picture(&path).unwrap().width, 2);
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 2);
}

/// Files of all formats, cut short and with bytes changed: errors or pictures, never a panic,
/// and never an image that the length of the file does not justify.
#[test]
fn broken_files_never_panic() {
    let folder = Folder::new("broken");
    let p = gradient(40, 30);
    let mut samples: Vec<(String, Vec<u8>)> = vec![
        ("a.tga".into(), tga(40, 30)),
        ("a.bmp".into(), bmp(40, 30)),
        ("p.png".into(), {
            let palette: (&[u8; 4], &[u8]) = (b"PLTE", &[10, 20, 30, 40, 50, 60]);
            raw_png(png_header(8, 3), &[palette, (b"tRNS", &[0])], &[0, 0, 1, 0, 1, 0])
        }),
        ("c.jpg".into(), include_bytes!("../../tests/data/cmyk.jpg").to_vec()),
    ];
    for name in ["a.exr", "a.png", "a.jpg", "a.hdr", "a.pfm"] {
        let path = folder.file(name);
        write_picture(&path, &p, &WriteOptions::default()).unwrap();
        samples.push((name.into(), fs::read(&path).unwrap()));
    }
    samples.extend(compressed_exrs().1);
    let try_reading = |name: &str, bytes: &[u8]| -> Result<Bitmap, ImageError> {
        let path = Path::new(name);
        let format = Format::detect(path, bytes)
            .ok_or_else(|| ImageError::UnknownFormat { path: path.into() })?;
        // Not `shielded`: a panic of a decoder should be seen here.
        decode_bitmap(path, format, bytes)
    };
    for (name, bytes) in &samples {
        let whole = try_reading(name, bytes).unwrap();
        let step = (bytes.len() / 97).clamp(1, 50);
        for end in (0..bytes.len()).step_by(step) {
            if let Ok(cut) = try_reading(name, &bytes[..end]) {
                // Only a footer may be missed.
                assert_eq!(cut, whole, "{name} cut at {end}");
            }
        }
        let mut state = 0x9e37_79b9u32;
        for round in 0..300 {
            let mut broken = bytes.clone();
            for _ in 0..1 + round % 3 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // The first half of the rounds aims at the header.
                let range = if round < 150 { broken.len().min(400) } else { broken.len() };
                let at = (state >> 8) as usize % range;
                broken[at] ^= 1 << (state % 8);
                if round % 5 == 0 {
                    broken[at] = 0xff;
                }
            }
            if let Err(e) = try_reading(name, &broken) {
                assert!(!e.to_string().contains('\n'), "{e}");
            }
        }
    }
}
