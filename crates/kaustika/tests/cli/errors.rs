//! Bad input and wrong usage: what is said, and the exit code.

use crate::kit::{Place, SCENE};

#[test]
fn wrong_usage_ends_with_2() {
    let p = Place::new();
    for (args, said) in [
        ("", "Usage"),
        ("paint", "paint"),
        ("render ball.pbrt --spp none", "none"),
        ("render ball.pbrt -o a.gif", "exr, png, jpg, hdr and pfm"),
        ("render ball.pbrt -q -m magic -o a.exr", "known: path"),
        ("render ball.pbrt -q -p depth=3 -o a.exr", "max_depth"),
        ("render ball.pbrt -q --camera 7 -o a.exr", "no camera `7`"),
        ("render ball.pbrt -q --crop 30,0,40,10 -o a.exr", "empty within 24 x 18"),
        ("render ball.pbrt -q --spp 4 --passes 0..5 -o a.exr", "plans only 4"),
        ("render ball.pbrt -q -m hybrid -p terms=path:L[D]S*E -o a.exr", "no term makes `LDDE`"),
        ("render ball.pbrt -q -m hybrid -p terms=path -o a.exr", "nor a preset; known: chen"),
        ("render ball.pbrt -q -m hybrid -p terms=path(max_deth=3):LE", "did you mean `max_depth`?"),
        (
            "render ball.pbrt -q -m hybrid -p terms=path(max_depth=a):LE",
            "expected a whole number, found string \"a\"",
        ),
        ("render ball.pbrt -q -m hybrid -p terms=dots:LE", "radiosity@N, cache@N"),
        ("render ball.pbrt -q -m chen -p nearest=1 -o a.exr", "2 or more are needed"),
        ("render ball.pbrt -q -m radiosity -p shots=3 -o a.exr", "set `solver` to southwell"),
        ("render ball.pbrt -q -m radiosity -p ambient=true -o a.exr", "set `solver` to southwell"),
        (
            "render ball.pbrt -q -m radiosity -p form_factors=area -o a.exr",
            "takes no notice of `form_factors`",
        ),
        ("render ball.pbrt -q -m radiosity -p gather=9 -o a.exr", "`display=gather`"),
        ("render ball.pbrt -q --layer words:9 -o a.exr", "from 0 to 3"),
        ("methods magic", "known: path"),
    ] {
        let text = p.fails(2, args);
        assert!(text.contains(said), "{args}: {text}");
    }
    assert!(!p.has("a.exr"));
}

#[test]
fn bad_input_ends_with_1() {
    let p = Place::new();
    p.write("text.txt", "no scene");
    p.write("empty.pbrt", "WorldBegin\n");
    for args in [
        "render missing.pbrt -o a.exr",
        "render text.txt -o a.exr",
        "render ball.pbrt -q -o nowhere/a.exr",
        "render ball.pbrt -q --environment missing.hdr -o a.exr",
        "render ball.pbrt -q --display 127.0.0.1:1 -o a.exr",
        "merge missing.exr -o a.exr",
        "compare ball.pbrt ball.pbrt",
        "info missing.pbrt",
        "rays missing.ply missing.f32",
    ] {
        let text = p.fails(1, args);
        assert!(!text.trim().is_empty(), "{args} says nothing");
    }
    let text = p.fails(1, "render ball.pbrt -q -m whitted --layer a=LDE -o a.exr");
    assert!(text.contains("use one of path, light, bdpt, vcm, sppm, vpl, pssmlt"), "{text}");
    assert!(!p.has("a.exr"));
}

#[test]
fn scene_errors_show_file_line_and_excerpt() {
    let p = Place::new();
    p.write("typo.pbrt", &SCENE.replace("Shape \"trianglemesh\"", "Shape \"trianglemsh\""));
    let text = p.fails(1, "render typo.pbrt -o a.exr");
    for part in
        ["typo.pbrt:20:7", "Shape \"trianglemsh\"", "did you mean `trianglemesh`", "1 error, "]
    {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}
