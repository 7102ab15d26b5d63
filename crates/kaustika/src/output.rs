//! From summed passes to pictures.

use crate::setup::Setup;
use kaustika_film::accumulate::PassTree;
use kaustika_film::{ChannelKind, MetaValue, Picture};
use kaustika_sampling::SamplerKind;

/// The picture of all passes in `tree`: R, G, B, the features, `Variance` (of one sample) and,
/// where samples are independent, `StdError` (of the mean).
///
/// Without passes the picture is black.
pub fn picture(tree: &PassTree, setup: &Setup) -> Picture {
    let (width, height) = (tree.width(), tree.height());
    let pixels = width as usize * height as usize;
    let mut picture = Picture::new(width, height);
    let Some(total) = tree.total() else {
        for c in ["R", "G", "B"] {
            picture.push(c, vec![0.0; pixels]);
        }
        return picture;
    };
    let plane = |f: &dyn Fn(usize) -> f32| (0..pixels).map(f).collect::<Vec<f32>>();
    for (c, name) in ["R", "G", "B"].iter().enumerate() {
        picture.push(*name, plane(&|i| total.rgb(i)[c]));
    }
    for feature in tree.layers().features() {
        let Some(offset) = tree.layers().offset(*feature) else { continue };
        for (c, name) in feature.channels().iter().enumerate() {
            if feature.is_id() {
                picture.push(*name, plane(&|i| total.id(i, offset + c)));
                if let Some(channel) = picture.channels.last_mut() {
                    channel.kind = ChannelKind::Uint;
                }
            } else {
                picture.push(*name, plane(&|i| total.value(i, offset + c)));
            }
        }
    }
    for (c, name) in ["Variance.R", "Variance.G", "Variance.B"].iter().enumerate() {
        picture.push(*name, plane(&|i| total.variance(i)[c]));
    }
    let config = setup.frame.sampler.config();
    if config.kind == SamplerKind::Independent && total.passes >= 8 {
        for (c, name) in ["StdError.R", "StdError.G", "StdError.B"].iter().enumerate() {
            let n = total.passes as f32;
            picture.push(*name, plane(&|i| (total.variance(i)[c] / n).sqrt()));
        }
    }
    let [x0, y0, ..] = setup.frame.region;
    let [w, h] = setup.frame.resolution;
    picture.display_window = Some([0, 0, w as i32, h as i32]);
    picture.data_origin = [x0 as i32, y0 as i32];
    let mut text = |key: &str, value: String| picture.set_meta(key, MetaValue::Text(value));
    text("generatedBy", format!("Kaustika {}", env!("CARGO_PKG_VERSION")));
    text("kaustika.method", setup.method.info().name.into());
    text("kaustika.parameters", serde_json::Value::Object(setup.parameters.clone()).to_string());
    text("kaustika.sampler", config.kind.to_string());
    text("kaustika.filter", setup.frame.filter_desc.to_string());
    text("kaustika.seed", setup.seed.to_string());
    text("kaustika.mode", format!("{:?}", setup.scene.mode).to_lowercase());
    picture.set_meta("samplesPerPixel", MetaValue::Int(total.passes.min(i32::MAX as u64) as i32));
    picture
}
