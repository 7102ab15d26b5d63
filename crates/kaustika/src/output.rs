//! From summed passes to pictures.

use crate::record::Record;
use kaustika_film::accumulate::{Feature, PassTree, Total};
use kaustika_film::{ChannelKind, Picture};
use kaustika_sampling::SamplerKind;
use kaustika_transport::Trust;

/// Fewest independent passes from which a standard error is estimated.
const MIN_GROUPS: u64 = 8;

/// The picture of all passes in `tree`: R, G, B, the features (with Stokes vectors their degree of
/// polarization, `DoP`), `Variance` (of one sample) and,
/// where samples are independent, `StdError` (of the mean), with the metadata of `record`.
/// `seconds` is the time spent rendering.
///
/// Where the method knows its errors itself, `trust`, `StdError` and `Variance` are those, and its layers
/// come last. Without passes the picture is black.
pub fn picture(tree: &PassTree, trust: Option<&Trust>, record: &Record, seconds: f64) -> Picture {
    let mut picture = preview(tree);
    if let Some(total) = tree.total() {
        add_bands(&mut picture, &total, &record.bands, tree.layers().offset_of_bands());
        add_features(&mut picture, tree, &total);
        add_paths(&mut picture, tree, &total);
        let names = ["Variance.R", "Variance.G", "Variance.B"];
        let n = total.passes as f32;
        add_rgb(&mut picture, names, |i| match trust {
            Some(trust) => trust.error[i].map(|e| n * e * e),
            None => total.variance(i),
        });
        if let Some(camera_space) = record.gbuffer {
            add_relative_variance(&mut picture, &total);
            if camera_space {
                to_camera(&mut picture, &record.world_to_camera);
            }
        }
        let independent = record.sampler == SamplerKind::Independent.name();
        let names = ["StdError.R", "StdError.G", "StdError.B"];
        if let Some(trust) = trust {
            add_rgb(&mut picture, names, |i| trust.error[i]);
            for (name, layer) in &trust.layers {
                picture.push(name.as_str(), layer.clone());
            }
        } else if independent && total.passes >= MIN_GROUPS {
            add_rgb(&mut picture, names, |i| total.variance(i).map(|v| (v / n).sqrt()));
        }
    }
    record.describe(&mut picture, tree.passes(), seconds);
    picture
}

/// The colour alone.
pub fn preview(tree: &PassTree) -> Picture {
    let mut picture = Picture::new(tree.width(), tree.height());
    let total = tree.total();
    add_rgb(&mut picture, ["R", "G", "B"], |i| total.as_ref().map_or([0.0; 3], |t| t.rgb(i)));
    picture
}

fn add_rgb(picture: &mut Picture, names: [&str; 3], pixel: impl Fn(usize) -> [f32; 3]) {
    let pixels = picture.pixel_count();
    let mut planes = [(); 3].map(|_| Vec::with_capacity(pixels));
    for i in 0..pixels {
        for (plane, v) in planes.iter_mut().zip(pixel(i)) {
            plane.push(v);
        }
    }
    for (name, plane) in names.into_iter().zip(planes) {
        picture.push(name, plane);
    }
}

/// Variance over mean, as pbrt's gbuffer film has it.
fn add_relative_variance(picture: &mut Picture, total: &Total) {
    let names = ["RelativeVariance.R", "RelativeVariance.G", "RelativeVariance.B"];
    add_rgb(picture, names, |i| {
        let (variance, mean) = (total.variance(i), total.rgb(i));
        std::array::from_fn(|c| if mean[c] == 0.0 { 0.0 } else { variance[c] / mean[c] })
    });
}

/// Turns mean positions and normals; where nothing was met they are zero, and stay so.
fn to_camera(picture: &mut Picture, world_to_camera: &[[f32; 4]; 4]) {
    for (layer, is_point) in [("P", true), ("N", false), ("Ns", false)] {
        let index = ["X", "Y", "Z"].map(|axis| {
            let name = format!("{layer}.{axis}");
            picture.channels.iter().position(|c| c.name == name)
        });
        let [Some(x), Some(y), Some(z)] = index else { continue };
        for i in 0..picture.pixel_count() {
            let v = [x, y, z].map(|channel| picture.channels[channel].data[i]);
            if v == [0.0; 3] {
                continue;
            }
            let turned = world_to_camera.map(|row| {
                let offset = if is_point { row[3] } else { 0.0 };
                row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + offset
            });
            for (channel, value) in [x, y, z].into_iter().zip(turned) {
                picture.channels[channel].data[i] = value;
            }
        }
    }
}

/// (1) of [`Bands`](kaustika_film::accumulate::Bands).
fn add_bands(picture: &mut Picture, total: &Total, names: &[String], offset: usize) {
    for (band, name) in names.iter().enumerate() {
        let at = offset + 2 * band;
        let value = |i| match (total.id(i, at), total.id(i, at + 1)) {
            (_, 0.0) => 0.0,
            (above, below) => above / below,
        };
        picture.push(name, (0..picture.pixel_count()).map(value).collect());
    }
}

fn add_features(picture: &mut Picture, tree: &PassTree, total: &Total) {
    let pixels = picture.pixel_count();
    for feature in tree.layers().features() {
        let Some(offset) = tree.layers().offset(*feature) else { continue };
        for (c, name) in feature.channels().iter().enumerate() {
            let value = |i| match feature.is_id() {
                true => total.id(i, offset + c),
                false => total.value(i, offset + c),
            };
            picture.push(*name, (0..pixels).map(value).collect());
            if let (true, Some(channel)) = (feature.is_id(), picture.channels.last_mut()) {
                channel.kind = ChannelKind::Uint;
            }
        }
        if *feature == Feature::Stokes {
            add_rgb(picture, ["DoP.R", "DoP.G", "DoP.B"], |i| {
                std::array::from_fn(|c| {
                    degree_of_polarization([0, 3, 6, 9].map(|s| total.value(i, offset + s + c)))
                })
            });
        }
    }
}

/// The layers by path.
fn add_paths(picture: &mut Picture, tree: &PassTree, total: &Total) {
    for (k, name) in tree.layers().paths().iter().enumerate() {
        let offset = tree.layers().path_offset(k);
        let names = ["R", "G", "B"].map(|c| format!("{name}.{c}"));
        add_rgb(picture, names.each_ref().map(String::as_str), |i| {
            std::array::from_fn(|c| total.value(i, offset + c))
        });
    }
}

/// √(S₁² + S₂² + S₃²)/S₀, 0 where there is no light; of noisy Stokes vectors it is too large.
fn degree_of_polarization([s0, s1, s2, s3]: [f32; 4]) -> f32 {
    if s0 > 0.0 { (s1 * s1 + s2 * s2 + s3 * s3).sqrt() / s0 } else { 0.0 }
}
