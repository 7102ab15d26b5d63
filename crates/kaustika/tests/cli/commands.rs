//! What the commands write.

use crate::kit::{Place, assert_same_bits, differing_values};
use kaustika::film::MetaValue;
use kaustika::film::path_expression::PathLayer;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn every_output_format_is_written() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --spp 2 -o a.exr -o a.png -o a.jpg -o a.hdr -o a.pfm");
    for name in ["a.exr", "a.png", "a.jpg", "a.hdr", "a.pfm"] {
        let picture = p.picture(name);
        assert_eq!((picture.width, picture.height), (24, 18), "{name}");
    }
    assert_eq!(differing_values(&p.picture("a.exr"), &p.picture("a.pfm")), 0);
    // A stop more makes the picture brighter, and a tone curve another one.
    let mean = |name: &str| {
        let picture = p.picture(name);
        let pixels: Vec<f32> = picture.rgb().unwrap().pixels().flatten().collect();
        pixels.iter().sum::<f32>() / pixels.len() as f32
    };
    p.ok("render ball.pbrt -q --spp 2 --exposure -1 -o dark.png");
    p.ok("render ball.pbrt -q --spp 2 --tonemap agx -o agx.png");
    assert!(mean("dark.png") < 0.7 * mean("a.png"));
    assert!(mean("agx.png") != mean("a.png"));
}

#[test]
fn the_scene_names_the_output_and_the_picture_says_how_it_was_made() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --spp 2 --seed 3 -p max_depth=2 --filter box");
    let picture = p.picture("ball.exr");
    let text = |key: &str| match picture.meta(key) {
        Some(MetaValue::Text(t)) => t.clone(),
        other => panic!("{key}: {other:?}"),
    };
    assert_eq!(picture.meta("samplesPerPixel"), Some(&MetaValue::Int(2)));
    assert!(matches!(picture.meta("worldToCamera"), Some(MetaValue::Matrix(_))));
    assert!(matches!(picture.meta("renderTimeSeconds"), Some(MetaValue::Float(t)) if *t > 0.0));
    assert!(text("generatedBy").starts_with("Kaustika"));
    assert_eq!(text("kaustika.method"), "path");
    assert_eq!(text("kaustika.seed"), "3");
    assert_eq!(text("kaustika.filter"), "box:0.5");
    assert_eq!(text("kaustika.mode"), "spectral");
    assert!(text("kaustika.scene").ends_with("ball.pbrt"));
    assert_eq!(json(&text("kaustika.parameters"))["max_depth"], 2);
}

#[test]
fn layers_by_path_are_written() {
    let p = Place::new();
    let layers = "--layer direct --layer rest=lpe:C.{2,}[LO] --layer seen=LE";
    p.ok(&format!("render ball.pbrt -q --spp 4 {layers} -o a.exr"));
    let picture = p.picture("a.exr");
    let expression = |name: &str| picture.meta(&format!("kaustika.layer.{name}")).cloned();
    assert_eq!(expression("direct"), Some(MetaValue::Text("C.L".into())));
    assert_eq!(expression("rest"), Some(MetaValue::Text("lpe:C.{2,}[LO]".into())));
    let sum = |name: &str| -> f32 {
        let channel = picture.channels.iter().find(|c| c.name == name);
        channel.unwrap_or_else(|| panic!("{name}")).data.iter().sum()
    };
    let parts = sum("direct.G") + sum("rest.G") + sum("seen.G");
    assert!((parts - sum("G")).abs() < 1e-4 * sum("G"), "{parts} of {}", sum("G"));
    let error = p.fails(2, "render ball.pbrt -q --layer x=C<RX>L -o b.exr");
    assert!(error.contains("expected a scattering: D G S or `.`\n  C<RX>L\n     ^"), "{error}");
    let error = p.fails(2, "render ball.pbrt -q --layer diffuse_dir -o b.exr");
    assert!(error.contains("diffuse_direct"), "{error}");
}

#[test]
fn a_pyramid_has_a_layer_for_each_strategy_and_a_sheet() {
    let p = Place::new();
    let common = "render ball.pbrt -q -m bdpt --sampler sobol -p pyramid=true -p max_depth=2";
    p.ok(&format!("{common} --layer direct --spp 4 -o a.exr"));
    let picture = p.picture("a.exr");
    let sum = |kind: &str| -> f64 {
        let of_kind = picture.channels.iter().filter(|c| c.name.starts_with(kind));
        let green = of_kind.filter(|c| c.name.ends_with('G'));
        green.flat_map(|c| &c.data).map(|v| f64::from(*v)).sum()
    };
    assert!((sum("weighted.") - sum("G")).abs() < 1e-4 * sum("G"));
    assert!(sum("unweighted.") > 1.5 * sum("G"), "several strategies make the same light");
    assert!(picture.channels.iter().any(|c| c.name == "unweighted.s3t1.B"));
    // Three rows, of three to five strategies, on both sides.
    let sheet = p.picture("a.pyramid.png");
    assert_eq!((sheet.width, sheet.height), (2 * (5 * 28 + 4), 3 * 22 + 4));
    // Shares and checkpoints keep the layers.
    p.ok(&format!("{common} --layer direct --spp 4 --passes 0..1 -o b.exr"));
    p.ok(&format!("{common} --layer direct --spp 4 --passes 1..4 -o c.exr"));
    p.ok("merge b.exr c.exr -o merged.exr");
    assert_same_bits(&p.picture("merged.exr"), &picture);
    let error = p.fails(1, "render ball.pbrt -q -m bdpt -p pyramid=true -p max_depth=-1");
    assert!(error.contains("max_depth"), "{error}");
}

#[test]
fn a_crop_is_compared_with_what_it_shows() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --sampler independent --spp 2 -o whole.exr");
    p.ok("render ball.pbrt -q --sampler independent --spp 2 --crop 5,3,17,11 -o crop.exr");
    let figures = |image: &str, reference: &str| {
        json(&p.ok(&format!("compare {image} {reference} --json")))["mse"].as_f64().unwrap()
    };
    assert_eq!(figures("crop.exr", "whole.exr"), 0.0);
    p.ok("render ball.pbrt -q --sampler independent --spp 2 --crop 6,3,18,11 -o other.exr");
    assert!(figures("other.exr", "crop.exr") > 0.0, "both are crops: pixel by pixel");
    let error = p.fails(1, "compare whole.exr crop.exr");
    assert!(error.contains("the sizes differ"), "{error}");
}

#[test]
fn scene_variables_are_set_from_outside() {
    let p = Place::new();
    let text = r#"<scene version="3.0.0">
        <default name="wide" value="8"/>
        <sensor type="perspective"><film type="hdrfilm">
            <integer name="width" value="$wide"/><integer name="height" value="6"/>
        </film></sensor>
        <emitter type="constant"/>
    </scene>"#;
    p.write("sky.xml", text);
    // A scene that names no file is written under the program's name.
    p.ok("render sky.xml -q --spp 1");
    assert_eq!((p.picture("kaustika.exr").width, p.picture("kaustika.exr").height), (8, 6));
    p.ok("render sky.xml -q --spp 1 -D wide=20 -o wide.exr");
    assert_eq!(p.picture("wide.exr").width, 20);
    let info = json(&p.ok("info sky.xml -D wide=30 --json"));
    assert_eq!(info["cameras"][0]["resolution"][0], 30);
}

#[test]
fn without_a_scene_the_built_in_one_is_rendered() {
    let p = Place::new();
    p.ok("render -q --spp 1 --resolution 30x20");
    for name in ["kaustika.png", "kaustika.exr"] {
        assert_eq!((p.picture(name).width, p.picture(name).height), (30, 20), "{name}");
    }
    let scene = p.picture("kaustika.exr").meta("kaustika.scene").cloned();
    assert_eq!(scene, Some(MetaValue::Text("built-in".into())));
}

#[test]
fn a_crop_shows_the_same_pixels() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --spp 3 --aov depth -o full.exr");
    let [x0, y0, x1, y1] = [5usize, 4, 17, 12];
    for option in ["--crop 5,4,17,12", "--pixelbounds 5,17,4,12"] {
        p.ok(&format!("render ball.pbrt -q --spp 3 --aov depth {option} -o crop.exr"));
        let (full, crop) = (p.picture("full.exr"), p.picture("crop.exr"));
        assert_eq!((crop.width, crop.height), (12, 8));
        assert_eq!((crop.data_origin, crop.display_window), ([5, 4], Some([0, 0, 24, 18])));
        for channel in &crop.channels {
            let of_full = full.channel(&channel.name).unwrap();
            for (y, x) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (y, x))) {
                let here = channel.data[(y - y0) * 12 + x - x0];
                assert_eq!(
                    here.to_bits(),
                    of_full[y * 24 + x].to_bits(),
                    "{} {x} {y}",
                    channel.name
                );
            }
        }
    }
    p.ok("render ball.pbrt -q --spp 3 --aov depth --cropwindow 0.2,0.7,0.2,0.66 -o window.exr");
    assert_same_bits(&p.picture("window.exr"), &p.picture("crop.exr"));
}

#[test]
fn statistics_have_all_keys() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --spp 4 -t 2 --seed 11 -o a.exr --stats s.json");
    let s = json(&std::fs::read_to_string(p.path("s.json")).unwrap());
    for key in ["load", "build", "render", "write"] {
        assert!(s["seconds"][key].as_f64().unwrap() >= 0.0, "{key}");
    }
    for (key, value) in [("passes", 4), ("spp", 4), ("threads", 2), ("seed", 11)] {
        assert_eq!(s[key], value, "{key}");
    }
    for key in ["samples_per_second", "rays_per_second"] {
        assert!(s[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(s["rays"]["closest"].as_u64().unwrap() >= 4 * 24 * 18);
    assert!(s["rays"]["shadow"].as_u64().unwrap() > 0);
    assert!(s["relative_error"]["mean"].as_f64().unwrap() > 0.0);
    assert!(s["relative_error"]["p95"].as_f64().unwrap() > 0.0);
    assert_eq!(s["method"], "path");
    assert_eq!(s["version"], env!("CARGO_PKG_VERSION"));
    assert!(s["scene"].as_str().unwrap().ends_with("ball.pbrt"));
    let memory = &s["peak_memory_bytes"];
    assert!(memory.is_null() || memory.as_u64().unwrap() > 1 << 20);
}

#[test]
fn noise_ends_a_render_and_more_noise_ends_it_earlier() {
    let p = Place::new();
    let passes = |noise: f32| {
        p.ok(&format!(
            "render ball.pbrt -q --sampler independent --noise {noise} -o a.exr --stats s.json"
        ));
        let s = json(&std::fs::read_to_string(p.path("s.json")).unwrap());
        assert!(s["relative_error"]["p95"].as_f64().unwrap() <= noise as f64);
        s["passes"].as_u64().unwrap()
    };
    let (coarse, fine) = (passes(0.5), passes(0.1));
    assert!(coarse >= 16 && fine > coarse, "{coarse} {fine}");
}

#[test]
fn an_environment_replaces_the_scenes() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --rgb --spp 2 -o file.exr");
    p.ok("render ball.pbrt -q --rgb --spp 2 --environment 0.2,0.3,0.4 -o same.exr");
    p.ok("render ball.pbrt -q --rgb --spp 2 --environment 0,0,0 -o dark.exr");
    p.ok("render ball.pbrt -q --rgb --spp 2 --environment file.exr -o image.exr");
    // The corner looks at the sky.
    let corner = |name: &str| p.picture(name).rgb().unwrap().pixel(0);
    assert!(corner("same.exr").iter().zip([0.2, 0.3, 0.4]).all(|(a, b)| (a - b).abs() < 0.01));
    assert_eq!(corner("dark.exr"), [0.0; 3]);
    assert!(corner("image.exr") != corner("same.exr"));
}

#[test]
fn an_image_compared_with_itself_is_right() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --sampler independent --spp 16 -o a.exr");
    p.ok("render ball.pbrt -q --sampler independent --spp 16 --seed 1 -o b.exr");
    let same = json(&p.ok("compare a.exr a.exr --json"));
    for key in ["mse", "rel_mse", "rel_mse_trimmed", "mape", "flip"] {
        assert_eq!(same[key], 0.0, "{key}");
    }
    assert_eq!(same["mean_ratio"], 1.0);
    let variance = "--variance a.exr --space rgb --ref-spp 16 --json";
    let same = json(&p.ok(&format!("compare a.exr a.exr {variance}")));
    assert_eq!((&same["accept"], &same["chi2_per_dof"]), (&true.into(), &0.0.into()));
    let other = json(&p.ok(&format!("compare b.exr a.exr {variance}")));
    assert!(other["mse"].as_f64().unwrap() > 0.0);
    // Two renders differ by as much as their variances say, roughly: these are estimates.
    let chi2 = other["chi2_per_dof"].as_f64().unwrap();
    assert!((0.5..3.0).contains(&chi2), "{chi2}");
    assert!(p.ok("compare a.exr b.exr").contains("relMSE"));
}

#[test]
fn info_counts_what_is_there() {
    let p = Place::new();
    let i = json(&p.ok("info ball.pbrt --json"));
    for (key, count) in [("shapes", 3), ("triangles", 2), ("emitting_shapes", 1), ("lights", 1)] {
        assert_eq!(i[key], count, "{key}");
    }
    assert_eq!(i["shape_kinds"]["sphere"], 2);
    assert_eq!(i["material_kinds"]["conductor"], 1);
    assert_eq!(i["cameras"][0]["resolution"], Value::from(vec![24, 18]));
    assert_eq!(i["cameras"][0]["kind"], "perspective");
    assert_eq!(i["integrator"]["max_depth"], 3);
    assert_eq!(i["errors"], 0);
    assert!(p.ok("info ball.pbrt").contains("triangles"));
}

/// The file says `maxdepth` 3.
#[test]
fn a_limit_that_is_not_obeyed_is_told() {
    let p = Place::new();
    for (method, told) in [("path", false), ("zbuffer", false), ("radiosity", true)] {
        let out = p.run(&format!("render ball.pbrt --spp 1 -m {method} -o a.exr"));
        let text = String::from_utf8(out.stderr).unwrap();
        assert_eq!(text.contains("limit of 3 bounces is not obeyed"), told, "{method}: {text}");
    }
}

#[test]
fn methods_tell_their_parameters() {
    let p = Place::new();
    let all = json(&p.ok("methods --json"));
    let path = all.as_array().unwrap().iter().find(|m| m["name"] == "path").unwrap();
    assert_eq!(path, &json(&p.ok("methods path --json")));
    let keys: Vec<&str> =
        path["parameters"].as_array().unwrap().iter().filter_map(|k| k["key"].as_str()).collect();
    assert!(keys.contains(&"max_depth") && keys.contains(&"mis"), "{keys:?}");
    assert!(p.ok("methods").contains("whitted      L[D|S]S_M*E"));
    assert!(p.ok("methods path").contains("max_depth="));
    // Every method says which paths it finds, in letters that layers by path understand.
    for method in all.as_array().unwrap() {
        let (name, class) =
            (method["name"].as_str().unwrap(), method["path_class"].as_str().unwrap());
        assert!(
            p.ok(&format!("methods {name}")).contains(&format!("paths      {class}\n")),
            "{name}"
        );
        PathLayer::parse(&format!("class={class}")).expect(name);
    }
}

/// Parameters that only make sense together are not judged alone.
#[test]
fn parameters_go_together() {
    let p = Place::new();
    let radiosity = "-m radiosity -p extended=true -p patches=100 -p samples=64";
    let told =
        p.fails(2, &format!("render ball.pbrt -q {radiosity} -p solver=hierarchical -o a.exr"));
    assert!(told.contains("extended form factors are found by rays"), "{told}");
    p.ok(&format!("render ball.pbrt -q {radiosity} -p solver=southwell --spp 1 -o a.exr"));
    let parted = "-m hybrid -p of=L[D]E -p terms=path:L[D]E";
    p.ok(&format!("render ball.pbrt -q {parted} --spp 1 -o a.exr"));
}

/// The terms of the Neumann series as layers add up to the picture, and so do words of D and S.
#[test]
fn the_neumann_series_is_written_as_layers() {
    let p = Place::new();
    for (series, names) in [
        ("bounces:1", ["bounces0", "bounces1", "more_bounces"].as_slice()),
        ("words:1", &["LE", "LDE", "LSE", "more_words"]),
    ] {
        p.ok(&format!("render ball.pbrt -q --spp 4 --layer {series} -o a.exr"));
        let picture = p.picture("a.exr");
        let layer = |name: &str, c: &str| {
            let name = if name.is_empty() { c.into() } else { format!("{name}.{c}") };
            picture.channel(&name).unwrap_or_else(|| panic!("{name}")).to_vec()
        };
        for c in ["R", "G", "B"] {
            for (i, all) in layer("", c).iter().enumerate() {
                let sum: f32 = names.iter().map(|name| layer(name, c)[i]).sum();
                assert!((sum - all).abs() <= 1e-4 * all.max(1e-2), "{series}: {sum} {all}");
            }
        }
    }
}

#[test]
fn rays_are_counted() {
    let p = Place::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
               property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    p.write("square.ply", ply);
    // Two rays meet the square at distances 2 and 3, one stops short of it, one misses.
    let rays: [[f32; 7]; 4] = [
        [0.3, 0.2, 2.0, 0.0, 0.0, -1.0, 1e30],
        [0.2, 0.7, -3.0, 0.0, 0.0, 1.0, 1e30],
        [0.3, 0.2, 2.0, 0.0, 0.0, -1.0, 1.5],
        [0.3, 0.2, 2.0, 0.0, 0.0, 1.0, 1e30],
    ];
    let bytes: Vec<u8> = rays.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(p.path("rays.f32"), bytes).unwrap();
    let r = json(&p.ok("rays square.ply rays.f32 --json -t 2"));
    assert_eq!((&r["rays"], &r["hits"], &r["t_sum"]), (&4.into(), &2.into(), &5.0.into()));
    assert_eq!(
        (&r["kind"], &r["threads"], &r["triangles"]),
        (&"closest".into(), &2.into(), &2.into())
    );
    for key in ["best_mrays", "median_mrays", "build_seconds", "load_seconds", "bytes_per_triangle"]
    {
        assert!(r[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(r["best_mrays"].as_f64() >= r["median_mrays"].as_f64());
    let r = json(&p.ok("rays square.ply rays.f32 --json --occlusion"));
    assert_eq!((&r["hits"], &r["t_sum"], &r["kind"]), (&2.into(), &0.0.into(), &"any".into()));
    // Several files, each with its own query, over one tree.
    let out = p
        .ok("rays square.ply any:rays.f32 closest:rays.f32 rays.f32 --json --occlusion --repeat 1");
    let kinds: Vec<_> = out.lines().map(|line| json(line)["kind"].clone()).collect();
    assert_eq!(kinds, ["any", "closest", "any"]);
    assert!(p.ok("rays square.ply rays.f32").contains("2 of 4 rays hit, sum of distances 5.000"));
    p.write("odd.f32", "12345");
    assert!(p.fails(1, "rays square.ply odd.f32").contains("7 floats"));
}

#[test]
fn polarization_is_asked_for_by_the_scene_or_by_name() {
    let p = Place::new();
    let text = r#"<scene version="3.0.0">
        <integrator type="stokes"><integrator type="path"/></integrator>
        <sensor type="perspective">
            <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
            <film type="hdrfilm">
                <integer name="width" value="8"/><integer name="height" value="6"/>
            </film>
        </sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="9"/></transform>
            <bsdf type="polarizer"/></shape>
        <emitter type="constant"/>
    </scene>"#;
    p.write("filter.xml", text);
    p.ok("render filter.xml -q --spp 2 -o filter.exr");
    let picture = p.picture("filter.exr");
    let mean = |name: &str| {
        let values = picture.channel(name).unwrap_or_else(|| panic!("no {name}"));
        values.iter().sum::<f32>() / values.len() as f32
    };
    // Horizontal, and half of the light.
    for (name, expected) in
        [("S0.G", 0.5), ("S1.G", 0.5), ("S2.G", 0.0), ("S3.B", 0.0), ("DoP.R", 1.0), ("G", 0.5)]
    {
        assert!((mean(name) - expected).abs() < 1e-4, "{name}: {}", mean(name));
    }
    p.ok("render filter.xml -q --spp 2 -p polarized=false -o plain.exr");
    assert!(p.picture("plain.exr").channel("S0.R").is_none());
    p.ok("render ball.pbrt -q --spp 2 -p polarized=true -o ball.exr");
    assert!(p.picture("ball.exr").channel("DoP.B").is_some());
}

#[test]
fn a_flight_is_drawn_and_timed() {
    let p = Place::new();
    std::fs::create_dir(p.path("frames")).unwrap();
    let fly = "fly ball.pbrt --frames 3 --resolution 32x24 --swing 10";
    let told = p.ok(&format!("{fly} -o frames"));
    assert!(told.contains("3 frames of 32 x 24: median"), "{told}");
    let frames = ["frames/0000.png", "frames/0001.png", "frames/0002.png"].map(|f| p.picture(f));
    assert!(!p.has("frames/0003.png"));
    for frame in &frames {
        assert_eq!((frame.width, frame.height), (32, 24));
        assert!(frame.rgb().unwrap().pixels().flatten().any(|c| c > 0.0));
    }
    // The first is what the camera shows, the others are from elsewhere.
    assert!(differing_values(&frames[0], &frames[1]) > 100);
    let told = json(&p.ok(&format!("{fly} --json -t 1")));
    assert_eq!((&told["frames"], &told["threads"]), (&3.into(), &1.into()));
    assert!(told["median_ms"].as_f64().unwrap() <= told["p99_ms"].as_f64().unwrap());

    // Light that was baked is shown instead of the scene's.
    p.ok("render ball.pbrt -q -m radiosity -p patches=500 --spp 1 -o a.exr --bake a.ply");
    std::fs::create_dir(p.path("baked")).unwrap();
    p.ok(&format!("{fly} --baked a.ply -o baked"));
    let baked = p.picture("baked/0000.png");
    assert!(baked.rgb().unwrap().pixels().flatten().any(|c| c > 0.0));
    assert!(differing_values(&baked, &frames[0]) > 100);
    p.ok("render ball.pbrt -q -m radiosity -p patches=500 --spp 1 -o a.exr --bake a.glb");
    std::fs::create_dir(p.path("glb")).unwrap();
    p.ok(&format!("{fly} --baked a.glb -o glb"));
    assert_eq!(differing_values(&p.picture("glb/0000.png"), &baked), 0);

    p.write("bare.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    assert!(p.fails(1, &format!("{fly} --baked bare.ply")).contains("no colours at its vertices"));
    assert!(p.fails(1, &format!("{fly} -o nowhere")).contains("make it first"));
    assert!(p.fails(2, &format!("{fly} -p model=cubist")).contains("cubist"));
}
