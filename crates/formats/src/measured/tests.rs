use super::*;

/// A field of a file: name, code of its type, sizes, data.
type Field<'a> = (&'a str, u8, Vec<u64>, Vec<u8>);

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A field of floats with numbers counted up.
fn counted(name: &'static str, shape: &[u64]) -> Field<'static> {
    let n = shape.iter().product::<u64>();
    (name, 10, shape.to_vec(), floats(&(0..n).map(|i| i as f32).collect::<Vec<_>>()))
}

fn fields() -> Vec<Field<'static>> {
    vec![
        ("description", 1, vec![4], b"test".to_vec()),
        ("phi_i", 10, vec![1], floats(&[0.0])),
        ("theta_i", 10, vec![2], floats(&[0.0, 1.0])),
        counted("ndf", &[3, 2]),
        counted("sigma", &[2, 2]),
        counted("vndf", &[1, 2, 2, 3]),
        counted("luminance", &[1, 2, 2, 2]),
        counted("rgb", &[1, 2, 3, 2, 2]),
        ("jacobian", 1, vec![1], vec![1]),
    ]
}

fn written(fields: &[Field]) -> Vec<u8> {
    let mut out = b"tensor_file\0\x01\0".to_vec();
    out.extend((fields.len() as u32).to_le_bytes());
    let directory: usize = fields.iter().map(|f| 2 + f.0.len() + 3 + 8 + 8 * f.2.len()).sum();
    let mut offset = (out.len() + directory) as u64;
    for (name, kind, shape, data) in fields {
        out.extend((name.len() as u16).to_le_bytes());
        out.extend(name.as_bytes());
        out.extend((shape.len() as u16).to_le_bytes());
        out.push(*kind);
        out.extend(offset.to_le_bytes());
        shape.iter().for_each(|n| out.extend(n.to_le_bytes()));
        offset += data.len() as u64;
    }
    fields.iter().for_each(|f| out.extend(&f.3));
    out
}

/// A small isotropic measurement in RGB.
pub(crate) fn file() -> Vec<u8> {
    written(&fields())
}

#[test]
fn rgb_and_spectral_files_are_read() {
    let brdf = parse(file()).expect("a good file");
    assert_eq!((brdf.phi, brdf.theta), (vec![0.0], vec![0.0, 1.0]));
    assert_eq!((brdf.vndf.width, brdf.vndf.height), (3, 2));
    assert_eq!((brdf.ndf.width, brdf.ndf.height), (2, 3));
    assert_eq!((brdf.reflectance.values[23], brdf.channels), (23.0, MeasuredChannels::Rgb));
    assert!(brdf.jacobian);
    let mut spectral = fields();
    spectral[7] = counted("spectra", &[1, 2, 2, 2, 2]);
    spectral.push(("wavelengths", 10, vec![2], floats(&[400.0, 700.0])));
    let brdf = parse(written(&spectral)).expect("a good file");
    assert_eq!(brdf.channels, MeasuredChannels::Wavelengths(vec![400.0, 700.0]));
}

#[test]
fn faults_are_named() {
    let fault = |change: &dyn Fn(&mut Vec<Field<'static>>)| {
        let mut fields = fields();
        change(&mut fields);
        parse(written(&fields)).expect_err("a bad file")
    };
    assert_eq!(fault(&|f| drop(f.remove(5))), "it has no field `vndf`");
    assert_eq!(fault(&|f| drop(f.remove(7))), "it has no field `rgb`");
    assert_eq!(
        fault(&|f| f[3] = counted("ndf", &[6])),
        "field `ndf` is float32 of 1 dimensions, not float32 of 2"
    );
    assert_eq!(fault(&|f| f[8].1 = 2), "field `jacobian` is int8 of 1 dimensions, not uint8 of 1");
    assert_eq!(
        fault(&|f| f[5] = counted("vndf", &[2, 2, 2, 3])),
        "field `vndf` has 2 by 2 directions, `phi_i` and `theta_i` 1 by 2"
    );
    assert_eq!(
        fault(&|f| f[4] = counted("sigma", &[1, 4])),
        "field `sigma` has 1 by 4 values, fewer than 2 by 2"
    );
    assert_eq!(
        fault(&|f| f[7] = counted("rgb", &[1, 2, 2, 2, 2])),
        "field `rgb` has 2 channels, not 3"
    );
    assert_eq!(
        fault(&|f| f[2].3 = floats(&[1.0, 1.0])),
        "number 1 of field `theta_i` is not above the one before"
    );
    assert_eq!(
        fault(&|f| f[4].3 = floats(&[1.0, f32::NAN, 0.0, 0.0])),
        "number 1 of field `sigma` is not finite"
    );
    assert_eq!(fault(&|f| f[1].1 = 12), "field `phi_i` has the unknown type 12");
    assert_eq!(
        fault(&|f| f[4].2 = vec![u64::MAX, 4]),
        "the data of field `sigma` go beyond the end of the file"
    );
}

/// Cut anywhere and with any byte changed, a file is refused or read, and nothing panics.
#[test]
fn damaged_files_do_no_harm() {
    let good = file();
    for end in 0..good.len() {
        assert!(parse(good[..end].to_vec()).is_err(), "cut at {end}");
    }
    for at in 0..good.len() {
        for byte in [0, 1, 0x7f, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[at] = byte;
            let _ = parse(bad);
        }
    }
}
