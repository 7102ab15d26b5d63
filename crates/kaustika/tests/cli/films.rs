//! Films that keep more than colour.

use crate::kit::{Place, assert_same_bits};
use kaustika::film::{MetaValue, Picture};

const SCENE: &str = "Translate 0 0 3
Camera \"perspective\" \"float fov\" 40
Film \"FILM\" \"integer xresolution\" 8 \"integer yresolution\" 6 MORE
WorldBegin
LightSource \"infinite\"
Material \"diffuse\" \"rgb reflectance\" [ .7 .3 .2 ]
Shape \"sphere\"";

fn channel<'a>(picture: &'a Picture, name: &str) -> &'a [f32] {
    let found = picture.channels.iter().find(|c| c.name == name);
    &found.unwrap_or_else(|| panic!("no channel {name}")).data
}

#[test]
fn a_spectral_film_keeps_bins_that_shares_agree_on() {
    let p = Place::new();
    let more = "\"integer nbuckets\" 4 \"float lambdamin\" 400 \"float lambdamax\" 700";
    p.write("s.pbrt", &SCENE.replace("FILM", "spectral").replace("MORE", more));
    p.ok("render s.pbrt -q --spp 64 -o a.exr --threads 1");
    let picture = p.picture("a.exr");
    let text = |key: &str| picture.meta(key).cloned();
    assert_eq!(text("spectralLayoutVersion"), Some(MetaValue::Text("1.0".into())));
    assert_eq!(text("emissiveUnits"), Some(MetaValue::Text("W.m^-2.sr^-1".into())));
    let names = ["S0.437,500nm", "S0.512,500nm", "S0.587,500nm", "S0.662,500nm"];
    // The red sphere, and the white sky about it.
    let [sphere, sky] = [3 * 8 + 4, 0].map(|i| names.map(|n| channel(&picture, n)[i]));
    assert!(sphere[3] > 2.0 * sphere[0] && sphere[3] < sky[3], "{sphere:?} {sky:?}");
    p.ok("render s.pbrt -q --spp 64 -o b.exr --threads 2");
    assert_same_bits(&picture, &p.picture("b.exr"));
    let why = p.fails(2, "render s.pbrt -q --spp 1 -m bdpt -o c.exr");
    assert!(why.contains("channels by wavelength"), "{why}");
}

#[test]
fn a_gbuffer_is_in_the_space_it_asks_for() {
    let p = Place::new();
    for space in ["camera", "world"] {
        let more = format!("\"string coordinatesystem\" \"{space}\"");
        let text = SCENE.replace("FILM", "gbuffer").replace("MORE", &more);
        p.write(&format!("{space}.pbrt"), &text);
        p.ok(&format!("render {space}.pbrt -q --spp 16 -o {space}.exr"));
    }
    let (camera, world) = (p.picture("camera.exr"), p.picture("world.exr"));
    // The camera looks along z, from z = -3 in the world of the sphere.
    let middle = 3 * 8 + 4;
    let z = |picture: &Picture, name: &str| channel(picture, name)[middle];
    assert!((z(&camera, "P.Z") - z(&world, "P.Z") - 3.0).abs() < 1e-4);
    assert!((z(&camera, "N.Z") - z(&world, "N.Z")).abs() < 1e-5 && z(&camera, "N.Z") < -0.8);
    for name in ["Albedo.R", "Ns.X", "u", "v", "Variance.R", "RelativeVariance.B"] {
        channel(&camera, name);
    }
}
