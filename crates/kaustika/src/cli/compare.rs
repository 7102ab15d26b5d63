//! `kaustika compare`.

use super::args::CompareArgs;
use super::failure::Failure;
use super::stdout;
use kaustika::film::metrics::{
    CompareOptions, Comparison, VarianceReport, VarianceTestOptions, compare, variance_test,
};
use kaustika::film::{MetaValue, Picture, RgbView, read_picture};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Measures how far an image is from a reference.
///
/// # Errors
/// If the images can't be read or compared. A large difference is no failure.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    let image = read_picture(&args.image).map_err(Failure::input)?;
    let reference = read_shown(&args.reference, &image)?;
    let test = colour(&image, &args.image)?;
    let truth = colour(&reference, &args.reference)?;
    if (test.width, test.height) != (truth.width, truth.height) {
        let size =
            |path: &Path, v: &RgbView| format!("{} is {} x {}", path.display(), v.width, v.height);
        let (a, b) = (size(&args.image, &test), size(&args.reference, &truth));
        return Err(Failure::Input(format!("the sizes differ: {a}, {b}")));
    }
    let options = CompareOptions { exposure: args.exposure, flip: true };
    let figures = compare(&truth, &test, &options).map_err(Failure::input)?;
    let tests = match &args.variance {
        None => None,
        Some(path) => Some(statistics(args, path, &image, &truth, &test)?),
    };
    match args.json {
        true => stdout::write_json(&Value::Object(to_json(&figures, tests.as_ref()))),
        false => stdout::write(&table(&figures, tests.as_ref())),
    }
}

fn colour<'a>(picture: &'a Picture, path: &Path) -> Result<RgbView<'a>, Failure> {
    picture.rgb().ok_or_else(|| Failure::Input(format!("{}: it has no colour", path.display())))
}

fn statistics(
    args: &CompareArgs,
    path: &Path,
    image: &Picture,
    truth: &RgbView,
    test: &RgbView,
) -> Result<VarianceReport, Failure> {
    let of_image = match image.meta("samplesPerPixel") {
        Some(MetaValue::Int(n)) if *n > 0 => Some(*n as f32),
        _ => None,
    };
    let spp = args.spp.or(of_image).ok_or_else(|| {
        Failure::Usage("how many samples a pixel has the image? say it with --spp N".into())
    })?;
    let file = read_shown(path, image)?;
    let variance = variance_of(&file).map_or_else(|| colour(&file, path), Ok)?;
    let options = VarianceTestOptions {
        spp: spp as f64,
        ref_spp: args.ref_spp.map_or(f64::INFINITY, f64::from),
        tile: args.tile,
        space: args.space,
    };
    variance_test(truth, &variance, test, &options).map_err(Failure::input)
}

/// A picture to hold beside `image`: of a whole one the part that a crop shows.
fn read_shown(path: &Path, image: &Picture) -> Result<Picture, Failure> {
    let picture = read_picture(path).map_err(Failure::input)?;
    Ok(picture.part_shown_by(image).unwrap_or(picture))
}

/// The variance layer of a rendered image; other files are variance all over.
fn variance_of(picture: &Picture) -> Option<RgbView<'_>> {
    let channel = |c: &str| picture.channel(&format!("Variance.{c}"));
    let channels = [channel("R")?, channel("G")?, channel("B")?];
    Some(RgbView { width: picture.width as usize, height: picture.height as usize, channels })
}

fn to_json(c: &Comparison, tests: Option<&VarianceReport>) -> Map<String, Value> {
    let mut map = Map::new();
    let mut put = |key: &str, value: Value| map.insert(key.into(), value);
    put("mse", c.mse.into());
    put("rel_mse", c.rel_mse.into());
    put("rel_mse_trimmed", c.rel_mse_trimmed.into());
    put("mape", c.mape.into());
    put("flip", c.flip.into());
    put("mean_ratio", c.mean_ratio.into());
    put("mean_ratio_rgb", json!(c.mean_ratio_rgb));
    put("non_finite", c.non_finite.into());
    put("reference_non_finite", c.reference_non_finite.into());
    if let Some(t) = tests {
        let (p, s, m) = (&t.pixels, &t.tiles, &t.mean);
        put("accept", (p.accept && s.accept && m.accept).into());
        put(
            "pixels",
            json!({
                "accept": p.accept, "passed": p.passed, "alpha": p.alpha,
                "min_p": p.min_p, "max_z": p.max_z,
            }),
        );
        put(
            "tiles",
            json!({
                "accept": s.accept, "alpha": s.alpha, "min_p": s.min_p,
                "failed": s.failed, "tiles": s.tiles,
            }),
        );
        put("mean", json!({ "accept": m.accept, "z": m.z }));
        put("chi2_per_dof", t.chi2_per_dof.into());
    }
    map
}

fn table(c: &Comparison, tests: Option<&VarianceReport>) -> String {
    let [r, g, b] = c.mean_ratio_rgb;
    let mut rows = vec![
        ("MSE", format!("{:.6e}", c.mse)),
        ("relMSE", format!("{:.6e}", c.rel_mse)),
        ("relMSE trimmed", format!("{:.6e}", c.rel_mse_trimmed)),
        ("MAPE", format!("{:.4} %", 100.0 * c.mape)),
        ("FLIP", c.flip.map_or("-".into(), |f| format!("{f:.5}"))),
        ("mean ratio", format!("{:.5}  (red {r:.5}, green {g:.5}, blue {b:.5})", c.mean_ratio)),
    ];
    if c.non_finite + c.reference_non_finite > 0 {
        let (here, there) = (c.non_finite, c.reference_non_finite);
        rows.push(("not finite", format!("{here} pixels, reference {there}")));
    }
    if let Some(t) = tests {
        let word = |accept| if accept { "pass" } else { "FAIL" };
        let (p, s, m) = (&t.pixels, &t.tiles, &t.mean);
        let (passed, [x, y, z]) = (100.0 * p.passed, m.z);
        let pixels = format!("{}  {passed:.3} % within, max |z| {:.2}", word(p.accept), p.max_z);
        rows.push(("pixels", pixels));
        rows.push(("tiles", format!("{}  {} of {} off", word(s.accept), s.failed, s.tiles)));
        rows.push(("mean", format!("{}  z {x:.2} {y:.2} {z:.2}", word(m.accept))));
        rows.push(("chi2 / dof", format!("{:.4}", t.chi2_per_dof)));
    }
    rows.into_iter().map(|(name, value)| format!("{name:16} {value}\n")).collect()
}
