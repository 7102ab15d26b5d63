//! Same seed, same bits: on any number of threads, stopped and resumed, or in shares.

use crate::kit::{Place, assert_same_bits, differing_values};
use kaustika::formats::gltf::read_gltf;
use kaustika::formats::mesh::{MeshOptions, read_mesh};

#[test]
fn threads_do_not_change_the_picture() {
    let p = Place::new();
    for (threads, out) in [(1, "one.exr"), (2, "two.exr"), (5, "five.exr")] {
        p.ok(&format!("render ball.pbrt -q --spp 5 --aov all -t {threads} -o {out}"));
    }
    assert_same_bits(&p.picture("one.exr"), &p.picture("two.exr"));
    assert_same_bits(&p.picture("one.exr"), &p.picture("five.exr"));
    // The comparison can fail: another seed is another picture.
    p.ok("render ball.pbrt -q --spp 5 --seed 7 -o other.exr");
    assert!(differing_values(&p.picture("one.exr"), &p.picture("other.exr")) > 500);
}

#[test]
fn every_method_gives_the_same_bits_on_any_threads_and_in_shares() {
    let p = Place::new();
    let two_sided = ["path", "light", "bdpt", "vcm", "sppm", "photonmap", "vpl", "erpt"];
    let others = ["backward", "whitted", "distributed", "zbuffer", "radiosity"];
    let hybrid = "hybrid -p patches=200 -p form_rays=64 -p photons=2000";
    for method in two_sided.into_iter().chain(others).chain([hybrid]) {
        // Filters that reach other pixels, so that splats of several bands meet.
        let common = format!("render ball.pbrt -q -m {method} --spp 4 --filter gaussian");
        p.ok(&format!("{common} -t 1 -o one.exr"));
        p.ok(&format!("{common} -t 5 -o five.exr"));
        assert_same_bits(&p.picture("one.exr"), &p.picture("five.exr"));
        p.ok(&format!("{common} --passes 0..1 -o a.exr"));
        p.ok(&format!("{common} --passes 1..4 -o b.exr"));
        p.ok("merge a.exr b.exr -o merged.exr");
        assert_same_bits(&p.picture("merged.exr"), &p.picture("one.exr"));
    }
}

#[test]
fn chains_go_on_where_they_stopped_on_any_threads() {
    let p = Place::new();
    for method in ["pssmlt --layer direct", "mmlt --layer direct", "mlt --layer direct"] {
        let common = format!(
            "render ball.pbrt -q --sampler sobol --filter gaussian --aov depth -p bootstrap=2000 -m {method}"
        );
        p.ok(&format!("{common} --spp 5 -t 1 -o whole.exr"));
        p.ok(&format!("{common} --spp 5 -t 5 -o five.exr"));
        assert_same_bits(&p.picture("whole.exr"), &p.picture("five.exr"));
        for spp in [2, 3, 5] {
            p.ok(&format!("{common} --spp {spp} --resume -t 3 -o parts.exr"));
        }
        assert_same_bits(&p.picture("parts.exr"), &p.picture("whole.exr"));
        std::fs::remove_file(p.path("parts.ckpt")).unwrap();
        let error = p.fails(2, &format!("{common} --spp 5 --passes 1..3 -o part.exr"));
        assert!(error.contains("can't be dealt out"), "{error}");
    }
}

#[test]
fn light_on_surfaces_is_baked() {
    let p = Place::new();
    p.ok("render ball.pbrt -q -m radiosity -p patches=500 --spp 1 -o a.exr --bake a.ply");
    p.ok("render ball.pbrt -q -m radiosity -p patches=500 --spp 1 -o a.exr --bake a.glb");
    p.ok("render ball.pbrt -q -m radiosity -p patches=500 --spp 1 -o a.exr --bake map.exr");
    let map = p.picture("map.exr");
    assert!(map.channel("Irradiance.G").is_some_and(|h| h.iter().any(|h| *h > 0.0)));
    let with_uv = read_mesh(&p.path("map.uv.ply"), &MeshOptions::default()).unwrap();
    assert_eq!(with_uv.uvs.len(), with_uv.positions.len());
    // Parameters that go together, and that do not.
    let extended =
        "render ball.pbrt -q -m radiosity -p patches=100 --spp 1 -o b.exr -p extended=true";
    p.ok(extended);
    let error = p.fails(2, &format!("{extended} -p solver=hierarchical"));
    assert!(error.contains("set `solver` to southwell"), "{error}");
    let mesh = read_mesh(&p.path("a.ply"), &MeshOptions::default()).unwrap();
    let colors = mesh.attributes.iter().find(|a| a.name == "vertex_color").unwrap();
    assert!(colors.values.iter().all(|c| *c >= 0.0) && colors.values.iter().any(|c| *c > 0.0));
    let read = read_gltf(&p.path("a.glb"));
    assert!(!read.diagnostics.has_errors());
    assert!(p.fails(2, "render ball.pbrt --bake a.ply -o a.exr").contains("use `-m radiosity`"));
    let error = p.fails(2, "render ball.pbrt -m radiosity --bake a.obj -o a.exr");
    assert!(error.contains("only ply, glb and exr can be written"), "{error}");
    let error = p.fails(1, "render ball.pbrt -q --spectral -m radiosity -o a.exr");
    assert!(error.contains("leave out `--spectral`"), "{error}");
}

#[test]
fn layers_by_path_are_shared_and_resumed_like_the_picture() {
    let p = Place::new();
    let layers = "--layer direct --layer rest=C.{2,}L --layer caustic=LS+DS*E --aov depth";
    for method in ["path", "light", "bdpt", "vcm", "sppm", "vpl"] {
        let common =
            format!("render ball.pbrt -q -m {method} --sampler sobol --filter gaussian {layers}");
        p.ok(&format!("{common} --spp 4 -t 1 -o one.exr"));
        p.ok(&format!("{common} --passes 0..1 -t 5 -o a.exr"));
        p.ok(&format!("{common} --passes 1..4 -t 5 -o b.exr"));
        p.ok("merge a.exr b.exr -o merged.exr");
        assert_same_bits(&p.picture("merged.exr"), &p.picture("one.exr"));
        p.ok(&format!("{common} --spp 2 --resume -o parts.exr"));
        p.ok(&format!("{common} --spp 4 --resume -o parts.exr"));
        assert_same_bits(&p.picture("parts.exr"), &p.picture("one.exr"));
        std::fs::remove_file(p.path("parts.ckpt")).unwrap();
    }
    p.ok("render ball.pbrt -q --sampler sobol --passes 0..1 --layer x=CDL -o a.exr");
    p.ok("render ball.pbrt -q --sampler sobol --passes 1..2 --layer x=CDDL -o b.exr");
    let error = p.fails(1, "merge a.exr b.exr -o merged.exr");
    assert!(error.contains("another layers by path: x=CDL here, x=CDDL there"), "{error}");
}

#[test]
fn a_resumed_render_equals_one_that_was_not_stopped() {
    let p = Place::new();
    let common = "render ball.pbrt -q --sampler sobol --aov depth,shape_id";
    p.ok(&format!("{common} --spp 11 -o whole.exr"));
    assert!(!p.has("whole.ckpt"), "nothing is left of a render that ended normally");
    for spp in [3, 4, 11] {
        p.ok(&format!("{common} --spp {spp} --resume -o parts.exr"));
        assert!(p.has("parts.ckpt"));
    }
    assert_same_bits(&p.picture("parts.exr"), &p.picture("whole.exr"));
}

#[test]
fn a_render_stopped_by_time_can_be_resumed() {
    let p = Place::new();
    let common = "render ball.pbrt -q --sampler independent";
    // No file's or default number of samples counts beside a time budget.
    p.ok(&format!("{common} --time 0.001s -o timed.exr --stats a.json"));
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(p.path("a.json")).unwrap()).unwrap();
    let done = stats["passes"].as_u64().unwrap();
    assert!(done >= 1, "no time is too short for a first picture");
    let spp = done + 3;
    p.ok(&format!("{common} --spp {spp} --resume -o timed.exr"));
    p.ok(&format!("{common} --spp {spp} -o whole.exr"));
    assert_same_bits(&p.picture("timed.exr"), &p.picture("whole.exr"));
}

#[test]
fn shares_merge_to_the_bits_of_one_run() {
    let p = Place::new();
    for spp_and_cuts in [[0, 4, 8, 8], [0, 3, 4, 11]] {
        let [a, b, c, spp] = spp_and_cuts;
        let common = format!("render ball.pbrt -q --spp {spp} --aov albedo");
        p.ok(&format!("{common} -o whole.exr"));
        let shares = [(a, b), (b, c), (c, spp)];
        let mut names = String::new();
        for (i, (from, to)) in shares.into_iter().enumerate().filter(|(_, (a, b))| a < b) {
            p.ok(&format!("{common} --passes {from}..{to} -o share{i}.exr"));
            // Given in reverse, once as image and once as checkpoint.
            let extension = if i == 0 { "ckpt" } else { "exr" };
            names = format!("share{i}.{extension} {names}");
        }
        p.ok(&format!("merge {names} -o merged.exr"));
        assert_same_bits(&p.picture("merged.exr"), &p.picture("whole.exr"));
    }
}

#[test]
fn a_merged_render_can_be_resumed() {
    let p = Place::new();
    let common = "render ball.pbrt -q --sampler halton";
    p.ok(&format!("{common} --passes 0..2 -o a.exr"));
    p.ok(&format!("{common} --passes 2..5 -o b.exr"));
    p.ok("merge a.exr b.exr -o m.exr");
    p.ok(&format!("{common} --spp 6 --resume -o m.exr"));
    p.ok(&format!("{common} --spp 6 -o whole.exr"));
    assert_same_bits(&p.picture("m.exr"), &p.picture("whole.exr"));
}

#[test]
fn shares_that_do_not_fit_are_refused() {
    let p = Place::new();
    let share = |options: &str, out: &str| p.ok(&format!("render ball.pbrt -q {options} -o {out}"));
    share("--spp 8 --passes 0..3", "a.exr");
    share("--spp 8 --passes 2..5", "overlap.exr");
    share("--spp 8 --passes 4..8", "gap.exr");
    share("--spp 8 --passes 3..8 --seed 9", "seed.exr");
    share("--spp 8 --passes 3..8 -p max_depth=1", "depth.exr");
    share("--spp 16 --passes 3..8", "plan.exr");
    std::fs::create_dir(p.path("moved")).unwrap();
    p.write("moved/ball.pbrt", &crate::kit::SCENE.replace("0.7 0.4 0.2", "0.7 0.4 0.3"));
    p.ok("render moved/ball.pbrt -q --spp 8 --passes 3..8 -o scene.exr");
    for (part, said) in [
        ("overlap.exr", "both hold pass 2"),
        ("gap.exr", "passes 3..4"),
        ("seed.exr", "seed: 0 here, 9 there"),
        ("depth.exr", "parameters"),
        ("plan.exr", "samples planned"),
        ("scene.exr", "another scene"),
        ("a.exr", "both hold pass 0"),
    ] {
        let text = p.fails(1, &format!("merge a.exr {part} -o out.exr"));
        assert!(text.contains(said), "{part}: {text}");
    }
    let text = p.fails(1, "merge gap.exr -o out.exr");
    assert!(text.contains("passes 0..4"), "{text}");
    assert!(!p.has("out.exr"));
    // The same scene elsewhere is the same scene.
    p.write("moved/ball.pbrt", crate::kit::SCENE);
    p.ok("render moved/ball.pbrt -q --spp 8 --passes 3..8 -o same.exr");
    p.ok("merge a.exr same.exr -o out.exr");
}

#[test]
fn checkpoints_of_other_renders_and_damaged_ones_are_refused() {
    let p = Place::new();
    let common = "render ball.pbrt -q --sampler sobol --resume -o a.exr";
    p.ok(&format!("{common} --spp 2"));
    let whole = std::fs::read(p.path("a.ckpt")).unwrap();
    let text = p.fails(1, &format!("{common} --spp 4 --seed 5"));
    assert!(text.contains("another seed: 5 here, 0 there"), "{text}");
    assert_eq!(std::fs::read(p.path("a.ckpt")).unwrap(), whole, "it is still there");
    for (what, bytes) in [
        ("cut short", whole[..whole.len() - 100].to_vec()),
        ("cut to its magic number", whole[..8].to_vec()),
        ("with a flipped bit", {
            let mut b = whole.clone();
            b[whole.len() / 2] ^= 4;
            b
        }),
        ("empty", vec![]),
        ("of another kind", b"PF 2 2".to_vec()),
    ] {
        std::fs::write(p.path("a.ckpt"), &bytes).unwrap();
        let text = p.fails(1, &format!("{common} --spp 4"));
        assert!(text.contains("a.ckpt"), "{what}: {text}");
        assert_eq!(std::fs::read(p.path("a.ckpt")).unwrap(), bytes, "{what}");
    }
}

#[test]
fn a_checkpoint_that_is_not_resumed_is_moved_aside() {
    let p = Place::new();
    p.ok("render ball.pbrt -q --spp 8 --passes 0..2 -o a.exr");
    p.ok("render ball.pbrt -q --spp 2 -o a.exr");
    assert!(p.has("a.ckpt.old") && !p.has("a.ckpt"));
}

/// A render without end of 48 x 36 pixels to `a.exr`, a pass of which is done, and what it tells its viewer.
#[cfg(unix)]
fn endless(p: &Place, options: &str) -> (std::process::Child, std::net::TcpStream) {
    use std::io::Read;
    use std::net::TcpListener;
    use std::process::{Command, Stdio};
    // A viewer that receives a picture knows that a pass is done.
    let viewer = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = viewer.local_addr().unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_kaustika"))
        .args(format!("{options} --spp 100000000 -o a.exr --display {address}").split_whitespace())
        .current_dir(p.path("."))
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (mut stream, _) = viewer.accept().unwrap();
    stream.read_exact(&mut vec![0; 48 * 36 * 3 * 4]).unwrap();
    (child, stream)
}

#[cfg(unix)]
fn send(signal: &str, child: &std::process::Child) {
    let mut kill = std::process::Command::new("kill");
    assert!(kill.args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_writes_picture_and_checkpoint_and_goes_on() {
    use std::io::Read;
    let p = Place::new();
    let common = "render ball.pbrt --sampler sobol --resolution 48x36";
    let (mut child, mut stream) = endless(&p, &format!("{common} --stats a.json"));
    send("-INT", &child);
    // Until the program closes the line.
    let mut received = Vec::new();
    stream.read_to_end(&mut received).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let name = b"a.exr";
    assert!(received.windows(name.len()).any(|w| w == name), "the viewer is told the name");

    assert!(p.has("a.exr") && p.has("a.ckpt"));
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(p.path("a.json")).unwrap()).unwrap();
    let spp = stats["passes"].as_u64().unwrap();
    p.ok(&format!("{common} -q --spp {spp} -o whole.exr"));
    assert_same_bits(&p.picture("a.exr"), &p.picture("whole.exr"));
    p.ok(&format!("{common} -q --spp {} --resume -o a.exr", spp + 1));
    p.ok(&format!("{common} -q --spp {} -o whole.exr", spp + 1));
    assert_same_bits(&p.picture("a.exr"), &p.picture("whole.exr"));
}

/// As `timeout` sends them, to the program and to its group.
#[cfg(unix)]
#[test]
fn signals_at_once_are_one() {
    let p = Place::new();
    let (mut child, stream) = endless(&p, "render ball.pbrt --resolution 48x36");
    // Of two kinds: the system may deliver two of the same as one.
    send("-TERM", &child);
    send("-INT", &child);
    // Nobody need look on.
    drop(stream);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(p.has("a.exr") && p.has("a.ckpt"));
}
