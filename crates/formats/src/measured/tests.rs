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

/// A pBRDF with two values of each angle and one wavelength.
fn polarized_fields() -> Vec<Field<'static>> {
    let two = || floats(&[0.0, 1.0]);
    vec![
        ("theta_h", 10, vec![1, 2], two()),
        ("theta_d", 10, vec![1, 2], two()),
        ("phi_d", 10, vec![1, 2], two()),
        ("wvls", 3, vec![1], 550u16.to_le_bytes().to_vec()),
        counted("M", &[2, 2, 2, 1, 4, 4]),
    ]
}

#[test]
fn polarized_files_are_read() {
    let table = parse_polarized(written(&polarized_fields())).expect("a good file");
    assert_eq!((table.wavelengths, table.phi_d), (vec![550.0], vec![0.0, 1.0]));
    assert_eq!((table.values.len(), table.values[17]), (128, 17.0));
    let mut unknown = polarized_fields();
    unknown[4].3[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(parse_polarized(written(&unknown)).expect("a good file").values[0].is_nan());
}

#[test]
fn faults_of_polarized_files_are_named() {
    let fault = |change: &dyn Fn(&mut Vec<Field<'static>>)| {
        let mut fields = polarized_fields();
        change(&mut fields);
        parse_polarized(written(&fields)).expect_err("a bad file")
    };
    assert_eq!(fault(&|f| drop(f.remove(3))), "it has no field `wvls`");
    assert_eq!(
        fault(&|f| f[4] = counted("M", &[2, 2, 2, 2, 4, 4])),
        "field `M` is 2 x 2 x 2 x 2 x 4 x 4, not 2 x 2 x 2 x 1 x 4 x 4"
    );
    assert_eq!(
        fault(&|f| f[1] = counted("theta_d", &[2, 2])),
        "field `theta_d` has 2 rows, not one"
    );
    assert_eq!(
        fault(&|f| f[2].3 = floats(&[1.0, 1.0])),
        "number 1 of field `phi_d` is not above the one before"
    );
    assert_eq!(fault(&|f| f[3].1 = 1), "field `wvls` is uint8 of 1 dimensions, not uint16 of 1");
    for end in 0..written(&polarized_fields()).len() {
        assert!(parse_polarized(written(&polarized_fields())[..end].to_vec()).is_err());
    }
}
