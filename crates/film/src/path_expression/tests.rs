use super::*;
use Kind::*;
use Way::*;

/// The events of a path from the camera to its light, by letters: `d g s` reflect, `D G S`
/// transmit, `v` a volume; then the light: `l` a lamp, `o` a surface, `b` the background.
fn events(path: &str) -> (Vec<Event>, Source) {
    let mut letters: Vec<char> = path.chars().collect();
    let source = match letters.pop() {
        Some('l') => Source::Lamp,
        Some('o') => Source::Surface,
        Some('b') => Source::Background,
        Some('m') => Source::Medium,
        c => panic!("no light: {c:?}"),
    };
    let event = |c| match c {
        'd' => Event::Surface(Reflection, Diffuse),
        'g' => Event::Surface(Reflection, Glossy),
        's' => Event::Surface(Reflection, Singular),
        'D' => Event::Surface(Transmission, Diffuse),
        'G' => Event::Surface(Transmission, Glossy),
        'S' => Event::Surface(Transmission, Singular),
        'v' => Event::Volume,
        c => panic!("no event: {c}"),
    };
    (letters.into_iter().map(event).collect(), source)
}

/// Whether a path is of the class, found with the parts joined at every place: all must agree.
fn matches_labelled(expression: &str, path: &str, label: Option<usize>) -> bool {
    let layer = PathLayer::parse(&format!("x={expression}")).expect(expression);
    let classes = PathClasses::new(vec![layer]).expect(expression);
    let (events, source) = events(path);
    let answers: Vec<bool> = (0..=events.len())
        .map(|k| {
            let front = events[..k].iter().fold(classes.camera(), |f, e| classes.onward(f, *e));
            let light = classes.light(source, label);
            let back = events[k..].iter().rev().fold(light, |b, e| classes.backward(b, *e));
            classes.met(front, back) != 0
        })
        .collect();
    assert!(answers.iter().all(|a| *a == answers[0]), "{expression} {path}: {answers:?}");
    answers[0]
}

fn matches(expression: &str, path: &str) -> bool {
    matches_labelled(expression, path, None)
}

#[test]
fn paths_of_their_classes() {
    let table: [(&str, &[&str], &[&str]); 24] = [
        ("C.*L", &["l", "dl", "gSvb", "ddddo"], &[]),
        ("C.*", &["l", "dl"], &[]),
        ("CL", &["l", "o", "b", "m"], &["dl"]),
        ("CO", &["o", "m"], &["l", "b", "do"]),
        ("CB", &["b"], &["o", "db"]),
        ("CDL", &["dl", "Do"], &["gl", "ddl", "l", "vl"]),
        ("C<RD>L", &["dl"], &["Dl", "gl"]),
        ("C<T.>L", &["Dl", "Gl", "Sl"], &["dl", "vl"]),
        ("C<TS>.*L", &["Sl", "SSdo"], &["dSl", "l"]),
        ("C[SG]*D*L", &["l", "sgdl", "ddo", "Sl"], &["dsl"]),
        ("C[SG]*D{2,3}L", &["ddl", "sdddl"], &["dl", "ddddl"]),
        ("C[^D]L", &["gl", "vl", "sl"], &["dl", "l"]),
        ("C<R[GS]>L", &["gl", "sl"], &["dl", "Gl"]),
        ("C<R[^S]>L", &["gl", "dl"], &["sl"]),
        ("C(<RD>|V)+L", &["dvdl", "vl"], &["l", "gl"]),
        ("CD+<Ts>L", &[], &["dl", "dSl"]),
        ("lpe:C<RD>[LO]", &["dl", "do"], &["dgl"]),
        ("C D ? L", &["l", "dl"], &["ddl"]),
        ("LDE", &["dl", "Do"], &["gl", "ddl"]),
        ("LS+DS*E", &["dsl", "SdSSo", "gdgl"], &["dl", "sl", "ddsl"]),
        ("L(D|S)*E", &["l", "dsgSl"], &["vl"]),
        ("L[D|S]S_M*E", &["l", "dl", "sSdl", "sgl"], &["dsl", "ggl"]),
        ("LS_M*E", &["sSl", "l"], &["gl"]),
        ("LVE", &["vl"], &["dl", "vvl"]),
    ];
    for (expression, inside, outside) in table {
        for path in inside {
            assert!(matches(expression, path), "{expression} {path}");
        }
        for path in outside {
            assert!(!matches(expression, path), "{expression} {path}");
        }
    }
}

#[test]
fn lights_have_names() {
    for expression in ["C.*<L.'key'>", "C.*<L'key'>", "C.*'key'", "C.*<.'key'>"] {
        assert!(matches_labelled(expression, "dl", Some(0)), "{expression}");
        assert!(matches_labelled(expression, "do", Some(0)), "{expression}");
        assert!(!matches_labelled(expression, "dl", None), "{expression}");
    }
    // Lights of a name are lights; those of another are not this one.
    assert!(matches_labelled("CDL|C<.'key'>", "dl", Some(0)));
    let layers = ["a=C.*<L.'a'>", "b=C.*<L.'b'>", "not=C.*[^<L.'a'>]"];
    let layers = layers.map(|l| PathLayer::parse(l).expect(l)).to_vec();
    let classes = PathClasses::new(layers).expect("layers");
    assert_eq!(classes.labels(), ["a", "b"]);
    let met = |label| classes.met(classes.camera(), classes.light(Source::Lamp, label));
    assert_eq!([met(None), met(Some(0)), met(Some(1))], [0b100, 0b001, 0b110]);
}

#[test]
fn reversed_expressions_are_the_same_classes() {
    // Every path of up to five events.
    let letters = ['d', 'g', 's', 'S', 'v'];
    let mut paths = vec![String::new()];
    for _ in 0..4 {
        let longer: Vec<String> =
            paths.iter().flat_map(|p| letters.iter().map(move |c| format!("{p}{c}"))).collect();
        paths.extend(longer);
    }
    paths.sort();
    paths.dedup();
    for (osl, heckbert) in [
        ("C[GS]*D[GS]+L", "LS+DS*E"),
        ("C(D[GS]|[GS])*V?L", "L[V](SD|S)*E"),
        // S alone is glossy light for Heckbert, not for OSL.
        ("C(DS|G)*.L", "L.(SD|S)*E"),
    ] {
        let layers = [format!("a={osl}"), format!("b={heckbert}")];
        let layers = layers.map(|l| PathLayer::parse(&l).expect("sound")).to_vec();
        let classes = PathClasses::new(layers).expect("layers");
        let mut seen = [0; 4];
        for path in &paths {
            let (events, source) = events(&format!("{path}l"));
            let front = events.iter().fold(classes.camera(), |f, e| classes.onward(f, *e));
            seen[classes.met(front, classes.light(source, None)) as usize] += 1;
        }
        let differ = osl.starts_with("C(DS|G)");
        assert_eq!(seen[1] + seen[2] != 0, differ, "{osl} {heckbert}: {seen:?}");
        assert!(seen[3] > 0 && seen[0] > 0);
    }
}

#[test]
fn arnolds_names() {
    let layer = PathLayer::parse("diffuse_direct").expect("known");
    assert_eq!((layer.name.as_str(), layer.text.as_str()), ("diffuse_direct", "C<RD>L"));
    assert_eq!(layer.channels(), ["diffuse_direct.R", "diffuse_direct.G", "diffuse_direct.B"]);
    for name in names::all() {
        PathClasses::new(vec![PathLayer::parse(name).expect(name)]).expect(name);
    }
}

#[test]
fn errors_say_where() {
    for (text, message, at) in [
        ("x=D.L", "an expression begins with C", 0),
        ("x=C<RX>L", "expected a scattering: D G S or `.`", 3),
        ("x=C[DL", "expected `]`", 4),
        ("x=C(D", "expected `)`", 3),
        ("x=CD)L", "`)` closes nothing", 2),
        ("x=CQL", "`Q` is no event", 1),
        ("x=C<RD'wall'>L", "only lights have names", 11),
        ("x=C.{3,1}L", "1 is less than 3", 6),
        ("x=C.{999}L", "expected a number of times, at most 64", 6),
        ("x=LXE", "`X` is no letter of a path", 2),
        ("x=C<L.'key>", "a name in quotes does not end", 5),
        ("diffus", "expected NAME=EXPRESSION", 0),
        ("a b=CL", "a layer's name", 0),
    ] {
        let e = PathLayer::parse(text).expect_err(text);
        assert!(e.message.starts_with(message), "{text}: {e}");
        assert_eq!(e.at, at, "{text}: {e}");
    }
    let deep = format!("x=C{}D{}L", "(".repeat(40), ")".repeat(40));
    assert!(PathLayer::parse(&deep).is_err());
    let long = PathLayer::parse("x=C((.{64}){64}){64}L").expect("well formed");
    let e = PathClasses::new(vec![long]).expect_err("too long");
    assert!(e.message.contains("too long"), "{e}");
    let twice = ["x=CL", "x=CDL"].map(|l| PathLayer::parse(l).expect(l)).to_vec();
    assert!(PathClasses::new(twice).is_err());
}
