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
    let table: [(&str, &[&str], &[&str]); 25] = [
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
        ("L(D|S)*(D|S_G)E", &["dl", "gsl"], &["l", "sl", "Sdl"]),
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
        ("x=LS_XE", "expected `S_M` or `S_G`", 4),
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

fn classes(expressions: &[&str]) -> PathClasses {
    let parse = |(i, e): (usize, &&str)| PathLayer::parse(&format!("l{i}={e}")).expect(e);
    PathClasses::new(expressions.iter().enumerate().map(parse).collect()).expect("layers")
}

/// Which sets of layers have paths, and shortest ones.
#[test]
fn sets_of_layers_and_their_shortest_paths() {
    let [a, b, c] = ["L[D]S*E", "LS+DS*E", "L(D|S)*DS*DS*E"];
    // Chen's classes are disjoint, and without media complete.
    let sets = classes(&[a, b, c, "L(D|S)*E"]).sets();
    assert_eq!(sets.keys().copied().collect::<Vec<_>>(), [0b1001, 0b1010, 0b1100]);
    let shortest = |set| sets[&set].to_string();
    assert_eq!(shortest(0b1001), "`LE` (from the camera `CO`)");
    assert_eq!(shortest(0b1010), "`LSDE` (from the camera `C<RD><RG>O`)");
    assert_eq!(shortest(0b1100), "`LDDE` (from the camera `C<RD><RD>O`)");
    // With one left out, or one too much, there are other sets.
    let sets = classes(&[a, c, "L(D|S)*E"]).sets();
    assert_eq!(sets[&0b100].to_string(), "`LSDE` (from the camera `C<RD><RG>O`)");
    let sets = classes(&[a, "LS*DS_M*E"]).sets();
    assert_eq!(sets[&0b11].to_string(), "`LDE` (from the camera `C<RD>O`)");
    assert_eq!(sets[&0b10].to_string(), "`LSDE` (from the camera `C<RD><RG>O`)");
    // Only a light of a name, and only the background, tell these apart.
    let sets = classes(&["C.*L", "C.*<L.'key'>"]).sets();
    assert_eq!(sets[&0b11].to_string(), "`LE` (from the camera `C<O.'key'>`)");
    let sets = classes(&["CD*L", "CD*[OB]", "CD*B"]).sets();
    assert_eq!(sets[&0b001].to_string(), "`LE` (from the camera `CL`)");
    assert_eq!(sets[&0b111].to_string(), "`LE` (from the camera `CB`)");
}

/// Each random word of up to eight letters belongs to one of Chen's classes (1991), and a search
/// that finds all sets of layers misses none of these words'.
#[test]
fn random_words_belong_to_one_class() {
    let classes = classes(&["L[D]S*E", "LS+DS*E", "L(D|S)*DS*DS*E"]);
    let sets = classes.sets();
    let mut state = 1u64;
    let mut random = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) % n
    };
    let letters = ["d", "g", "s", "D", "G", "S"];
    let mut seen = [0; 3];
    for _ in 0..10_000 {
        let length = random(9);
        let word: String = (0..length).map(|_| letters[random(6) as usize]).collect();
        let (events, source) = events(&format!("{word}l"));
        let front = events.iter().fold(classes.camera(), |f, e| classes.onward(f, *e));
        let set = classes.met(front, classes.light(source, None));
        assert_eq!(set.count_ones(), 1, "{word}");
        assert!(sets.contains_key(&set));
        seen[set.trailing_zeros() as usize] += 1;
    }
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
}

/// Terms of the Neumann series part all paths, and so do words, without media.
#[test]
fn series_part_the_paths() {
    for (argument, number, names) in [
        ("bounces:0", 2, ["bounces0", "more_bounces"].as_slice()),
        ("bounces:30", 32, &[]),
        ("words:2", 8, &["LE", "LDE", "LSE", "LDDE", "LDSE", "LSDE", "LSSE", "more_words"]),
        ("words:3", 16, &[]),
    ] {
        let layers = PathLayer::parse_all(argument).expect(argument);
        assert_eq!(layers.len(), number, "{argument}");
        for (layer, name) in layers.iter().zip(names) {
            assert_eq!(layer.name, *name);
        }
        let sets = PathClasses::new(layers).expect(argument).sets();
        assert_eq!(sets.len(), number, "{argument}");
        assert!(sets.keys().all(|set| set.count_ones() == 1), "{argument}");
    }
    // Tᵏ e is the sum of all words of k letters: each path of words and bounces is of one of both.
    let layers = ["words:3", "bounces:3"].map(|s| PathLayer::parse_all(s).expect(s)).concat();
    let length = |name: &str| match name.strip_prefix("bounces") {
        Some(k) => k.parse().unwrap_or(usize::MAX),
        None if name == "more_bounces" || name == "more_words" => 4,
        None => name.len() - 2,
    };
    let lengths: Vec<usize> = layers.iter().map(|l| length(&l.name)).collect();
    let sets = PathClasses::new(layers).expect("layers").sets();
    assert_eq!(sets.len(), 16);
    for set in sets.keys() {
        let of: Vec<usize> = (0..32).filter(|k| set >> k & 1 != 0).map(|k| lengths[k]).collect();
        assert!(of.len() == 2 && of[0] == of[1], "{of:?}");
    }
    assert!(matches("C.{2}[LOB]", "dvb") && !matches("C.{2}[LOB]", "dl"));
    for wrong in ["bounces:31", "words:4", "words:-1", "words:"] {
        let e = PathLayer::parse_all(wrong).expect_err(wrong);
        assert!(e.message.starts_with("expected a number from 0 to"), "{e}");
    }
    assert_eq!(PathLayer::parse_all("a=LDE").map(|l| l.len()), Ok(1));
}
