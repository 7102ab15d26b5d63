//! Broken scenes and the whole text of what is said about them.

use super::{messages, read};

/// Checks the messages about a text.
#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(messages(&read(text)), expected, "for:\n{text}");
}

/// Checks the messages about what stands behind `WorldBegin`, from line 2 on.
#[track_caller]
fn check_world(text: &str, expected: &str) {
    check(&format!("WorldBegin\n{text}"), expected);
}

#[test]
fn directives() {
    check_world(
        "Shap \"sphere\"",
        "error 2:1 <Shap> unknown directive `Shap`; did you mean `Shape`?\n",
    );
    check_world("Banana 1 2 3", "error 2:1 <Banana> unknown directive `Banana`\n");
    check_world("[ 1 2 ]", "error 2:1 <[> expected a directive, found `[`\n");
    check_world("Shape sphere", "error 2:7 <sphere> expected a kind in quotes, found `sphere`\n");
    check_world("Shape", "error 2:6 <> the file ends where a kind is expected\n");
}

#[test]
fn strings() {
    check_world(
        "Shape \"sphere\nShape \"disk\"",
        "error 2:7 <\"sphere> the string does not end on its line; add a closing `\"`\n",
    );
    check_world(
        "NamedMaterial \"a\\qb\"",
        "error 2:15 <\"a\\qb\"> unknown escape `\\q` in a string\n",
    );
}

#[test]
fn order_of_things() {
    check(
        "Shape \"sphere\"\nWorldBegin",
        "error 1:1 <Shape> `Shape` is not allowed before `WorldBegin`; move it after `WorldBegin`\n",
    );
    check_world(
        "Camera \"perspective\"",
        "error 2:1 <Camera> `Camera` is not allowed after `WorldBegin`; move it before `WorldBegin`\n",
    );
    check_world("WorldBegin", "error 2:1 <WorldBegin> second `WorldBegin`\n");
    check(
        "Camera \"perspective\"\n",
        "error 2:1 <> the scene ends before `WorldBegin`; put `WorldBegin` between the camera and \
         the shapes\n",
    );
    check(
        "",
        "error 1:1 <> the scene ends before `WorldBegin`; put `WorldBegin` between the camera \
         and the shapes\n",
    );
}

#[test]
fn nesting() {
    check_world(
        "AttributeEnd",
        "error 2:1 <AttributeEnd> `AttributeEnd` without `AttributeBegin`\n",
    );
    check_world(
        "AttributeBegin\nAttributeBegin Shape \"sphere\" AttributeEnd",
        "error 2:1 <AttributeBegin> this `AttributeBegin` is never closed\n",
    );
    check_world("ObjectEnd", "error 2:1 <ObjectEnd> `ObjectEnd` without `ObjectBegin`\n");
    check_world(
        "ObjectBegin \"a\" AttributeEnd ObjectEnd",
        "error 2:17 <AttributeEnd> `AttributeEnd` inside an object; `ObjectEnd` is missing\n",
    );
    check_world(
        "ObjectBegin \"a\" ObjectBegin \"b\" ObjectInstance \"a\" ObjectEnd",
        "error 2:17 <ObjectBegin> `ObjectBegin` inside an object\n\
         error 2:33 <ObjectInstance> `ObjectInstance` inside an object\n",
    );
    check_world(
        "ObjectBegin \"a\" AttributeBegin ObjectEnd",
        "error 2:17 <AttributeBegin> this `AttributeBegin` is never closed\n",
    );
}

#[test]
fn transforms() {
    check_world(
        "Scale 1 0 1",
        "error 2:1 <Scale> `Scale 1 0 1` is singular; no factor may be 0; a very small one flattens \
         too\n",
    );
    check_world("Rotate 30 0 0 0", "error 2:1 <Rotate> the axis of `Rotate` is zero\n");
    check(
        "LookAt 0 0 0 0 0 0 0 1 0 WorldBegin",
        "error 1:1 <LookAt> `LookAt` is singular: eye and target are the same point\n",
    );
    check(
        "LookAt 0 0 0 0 1 0 0 1 0 WorldBegin",
        "error 1:1 <LookAt> `LookAt` is singular: the up vector lies along the viewing direction\n",
    );
    check_world(
        "Transform [ 1 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 ]",
        "error 2:1 <Transform> the matrix of `Transform` is singular\n",
    );
    check_world(
        "ConcatTransform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 ]",
        "error 2:49 <]> expected number 16 of 16, found `]`\n",
    );
    check_world("Transform 1 0 0", "error 2:11 <1> expected `[`, found `1`\n");
    check_world(
        "Translate 1 two 3 Shape \"sphere\"",
        "error 2:13 <two> expected number 2 of 3, found `two`\n",
    );
    check_world(
        "ActiveTransform Start",
        "error 2:17 <Start> expected `All`, `StartTime` or `EndTime`, found `Start`; known: All, \
         StartTime, EndTime\n",
    );
    check_world(
        "CoordSysTransform \"wold\"",
        "warning 2:19 <\"wold\"> no coordinate system is called `wold`, nothing is changed; did you \
         mean `world`?\n",
    );
}

#[test]
fn declarations() {
    check_world(
        "Shape \"sphere\" \"radius\" 3",
        "error 2:16 <\"radius\"> `radius` is no parameter declaration; a parameter is written \"type \
         name\", such as \"float radius\"\n",
    );
    check_world(
        "Shape \"sphere\" \"flot radius\" [ 3 4 ]",
        "error 2:16 <\"flot radius\"> unknown parameter type `flot`; did you mean `float`?\n",
    );
    check_world(
        "Shape \"sphere\" \"integer radius\" 3",
        "error 2:16 <\"integer radius\"> parameter `radius` has type `integer`, expected `float`; \
         write \"float radius\"\n",
    );
    check_world(
        "Material \"diffuse\" \"float reflectance\" .3",
        "error 2:20 <\"float reflectance\"> parameter `reflectance` has type `float`, expected `rgb` \
         or `spectrum` or `texture` or `blackbody`; write \"rgb reflectance\"\n",
    );
    check_world(
        "Shape \"sphere\" \"float radios\" 3",
        "warning 2:16 <\"float radios\"> unknown parameter `radios` of shape `sphere` is ignored; did \
         you mean `radius`?\n",
    );
    check_world(
        "Material \"diffuse\" \"rgb kd\" [ 1 1 1 ]",
        "warning 2:20 <\"rgb kd\"> unknown parameter `kd` of material `diffuse` is ignored; known: \
         displacement, normalmap, reflectance\n",
    );
}

#[test]
fn values() {
    check_world(
        "Shape \"sphere\" \"float radius\" \"big\"",
        "error 2:31 <\"big\"> expected a number for `radius`, found `\"big\"`\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\" [ 1 x 2 ] Shape \"disk\"",
        "error 2:35 <x> expected a number for `radius`, found `x`\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\" [ 1 Shape \"disk\"",
        "error 2:35 <Shape> expected a number for `radius`, found `Shape`; a `]` seems to be missing \
         before it\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\" [ 1 2 ]",
        "error 2:16 <\"float radius\"> parameter `radius` needs 1 value, 2 given\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\" [ ]",
        "error 2:33 <]> parameter `radius` has no values\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\" 1e99",
        "error 2:31 <1e99> the number is too large for `radius`\n",
    );
    check_world(
        "Shape \"sphere\" \"float radius\"",
        "error 2:30 <> the file ends where a value is expected\n",
    );
    check_world(
        "LightSource \"point\" \"rgb I\" [ 1 2 ]",
        "error 2:21 <\"rgb I\"> parameter `I` needs 3 values, 2 given\n",
    );
    check_world(
        "LightSource \"point\" \"rgb I\" [ 1 -2 3 ]",
        "error 2:21 <\"rgb I\"> colour `I` has a negative component\n",
    );
    check_world(
        "LightSource \"point\" \"spectrum I\" [ 400 1 500 ]",
        "error 2:21 <\"spectrum I\"> a spectrum is pairs of wavelength and value, 3 numbers given\n",
    );
    check_world(
        "LightSource \"point\" \"spectrum I\" [ 500 1 400 1 ]",
        "error 2:21 <\"spectrum I\"> not a spectrum: wavelength of sample 1 is not greater than the \
         one before\n",
    );
    check_world(
        "LightSource \"point\" \"blackbody I\" 0",
        "error 2:21 <\"blackbody I\"> a black body needs a temperature above 0 K\n",
    );
    check_world(
        "AreaLightSource \"diffuse\" \"bool twosided\" 1 Shape \"sphere\"",
        "error 2:43 <1> expected `true` or `false` for `twosided`, found `1`\n",
    );
    check(
        "Sampler \"halton\" \"integer pixelsamples\" 1.5 WorldBegin",
        "error 1:41 <1.5> expected an integer for `pixelsamples`, found `1.5`\n",
    );
    check(
        "Sampler \"halton\" \"integer pixelsamples\" 3000000000 WorldBegin",
        "error 1:41 <3000000000> the integer does not fit into 32 bits in `pixelsamples`\n",
    );
}

#[test]
fn kinds() {
    check_world(
        "Shape \"spere\"",
        "error 2:7 <\"spere\"> unknown shape `spere`; did you mean `sphere`?\n",
    );
    check_world(
        "Material \"difuse\"",
        "error 2:10 <\"difuse\"> unknown material `difuse`; did you mean `diffuse`?\n",
    );
    check_world(
        "LightSource \"area\"",
        "error 2:13 <\"area\"> unknown light `area`; a light on a surface is an `AreaLightSource`\n",
    );
    check_world(
        "AreaLightSource \"difuse\" Shape \"sphere\" Shape \"sphere\"",
        "error 2:17 <\"difuse\"> unknown area light `difuse`; did you mean `diffuse`?\n",
    );
    check_world(
        "Texture \"t\" \"float\" \"marble\"",
        "error 2:21 <\"marble\"> unknown float texture `marble`; known: bilerp, checkerboard, \
         constant, directionmix, dots, fbm, imagemap, mix, ptex, scale, windy, wrinkled\n",
    );
    check_world(
        "Texture \"t\" \"colour\" \"constant\"",
        "error 2:13 <\"colour\"> unknown texture type `colour`; known: float, spectrum\n",
    );
    check_world(
        "Attribute \"shapes\" \"float radius\" 3",
        "error 2:11 <\"shapes\"> unknown attribute target `shapes`; did you mean `shape`?\n",
    );
    check(
        "Camera \"perspectiv\" Film \"rgbb\" PixelFilter \"gauss\" ColorSpace \"sRGBB\" \
         Option \"seeed\" 3 WorldBegin",
        "error 1:64 <\"sRGBB\"> unknown colour space `sRGBB`; did you mean `srgb`?\n\
         error 1:79 <\"seeed\"> unknown option `seeed`; did you mean `seed`?\n\
         error 1:45 <\"gauss\"> unknown filter `gauss`; known: box, gaussian, mitchell, sinc, \
         triangle\n\
         error 1:26 <\"rgbb\"> unknown film `rgbb`; did you mean `rgb`?\n\
         error 1:8 <\"perspectiv\"> unknown camera `perspectiv`; did you mean `perspective`?\n",
    );
}

#[test]
fn names() {
    check_world(
        "MakeNamedMaterial \"Glass\" \"string type\" \"dielectric\"\nNamedMaterial \"glas\" \
         Shape \"sphere\" Shape \"sphere\"",
        "error 3:15 <\"glas\"> no material is called `glas`; did you mean `Glass`?\n",
    );
    check_world(
        "Texture \"t\" \"float\" \"constant\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"",
        "error 3:42 <\"t\"> no spectrum texture is called `t`; there is a float texture of this name, \
         spectrum is needed\n",
    );
    check_world(
        "ObjectBegin \"tree\" ObjectEnd ObjectInstance \"treee\"",
        "error 2:45 <\"treee\"> no object is called `treee`; did you mean `tree`?\n",
    );
    check_world(
        "MediumInterface \"fog\" \"\" Shape \"sphere\" Shape \"sphere\"",
        "error 2:17 <\"fog\"> no medium is called `fog`; none is defined\n",
    );
    check_world(
        "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n\
         MakeNamedMaterial \"a\" \"string type\" \"diffuse\"",
        "error 3:19 <\"a\"> material `a` is defined twice; give it another name\n",
    );
    check_world(
        "MakeNamedMaterial \"a\"",
        "error 2:19 <\"a\"> material `a` has no type; add \"string type\" \"diffuse\" or another kind\n",
    );
    check_world(
        "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"a\" ]",
        "error 2:64 <\"a\"> material `a` is made of itself\n\
         error 2:68 <\"a\"> material `a` is made of itself\n",
    );
    check_world(
        "Material \"mix\" \"string materials\" \"a\"",
        "error 2:16 <\"string materials\"> material `mix` needs two names in \"string materials\", 1 \
         given\n",
    );
    check_world(
        "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\"\n\
         Texture \"b\" \"float\" \"scale\" \"texture tex\" \"a\"",
        "error 3:43 <\"a\"> texture `a` is made of itself\n",
    );
}

#[test]
fn shapes() {
    check_world(
        "Shape \"sphere\" \"float radius\" 0",
        "error 2:16 <\"float radius\"> the radius of the sphere must be above 0, not 0\n",
    );
    check_world(
        "Shape \"trianglemesh\"",
        "error 2:7 <\"trianglemesh\"> shape `trianglemesh` needs \"point3 P\"\n",
    );
    check_world(
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 1 ]",
        "error 2:7 <\"trianglemesh\"> shape `trianglemesh` needs \"integer indices\"\n",
    );
    check_world(
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 ]",
        "error 2:22 <\"point3 P\"> parameter `P` needs 3 numbers a value, 8 given in all\n",
    );
    check_world(
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 3 ]",
        "error 2:55 <\"integer indices\"> index 3 is out of range, `P` has 3 points\n",
    );
    check_world(
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 0 ]\n\
         \"normal N\" [ 0 0 1 ]",
        "warning 2:55 <\"integer indices\"> 4 indices are no multiple of 3, 1 ignored\n\
         warning 3:1 <\"normal N\"> 1 values of `N` for 3 points are ignored\n",
    );
    check_world(
        "Shape \"plymesh\"",
        "error 2:7 <\"plymesh\"> shape `plymesh` needs \"string filename\"\n",
    );
}

#[test]
fn options() {
    check(
        "Camera \"perspective\" \"float fov\" 180 WorldBegin",
        "error 1:22 <\"float fov\"> `fov` must lie between 0 and 180 degrees, not 180\n",
    );
    check(
        "Camera \"perspective\" \"float shutteropen\" 2 WorldBegin",
        "error 1:1 <Camera> the shutter opens at 2 and closes at 1; `shutterclose` must be later than \
         `shutteropen`\n",
    );
    check(
        "Film \"rgb\" \"float cropwindow\" [ .5 .5 0 1 ] WorldBegin",
        "error 1:12 <\"float cropwindow\"> `cropwindow` leaves no pixel; write x0 x1 \
         y0 y1 as fractions of the film, from 0 to 1\n",
    );
    check(
        "Film \"rgb\" \"integer xresolution\" 0 WorldBegin",
        "error 1:12 <\"integer xresolution\"> the film has 0 x 720 pixels; \
         `xresolution` and `yresolution` must be at least 1\n",
    );
}

#[test]
fn several_errors_are_found_in_one_run() {
    check_world(
        "Shpe \"sphere\"\nShape \"spher\"\nScale 0 1 1\nMaterial \"diffuse\" \"rgb reflectance\" [ 1 1 ]\n\
         Shape \"sphere\"",
        "error 2:1 <Shpe> unknown directive `Shpe`; did you mean `Shape`?\n\
         error 4:1 <Scale> `Scale 0 1 1` is singular; no factor may be 0; a very small one flattens \
         too\n\
         error 5:20 <\"rgb reflectance\"> parameter `reflectance` needs 3 values, 2 given\n\
         error 3:7 <\"spher\"> unknown shape `spher`; did you mean `sphere`?\n",
    );
}

#[test]
fn garbage_is_not_read_to_its_end() {
    let s = read(&"banana Shape \"sphere\" ".repeat(1000));
    assert!(s.diagnostics.entries.len() < 60, "{}", s.diagnostics.entries.len());
    assert!(messages(&s).contains("stopped reading after 50 errors"));
}

#[test]
fn long_chains_of_definitions_do_not_overflow_the_stack() {
    let n = 20_000;
    let chain: String = (0..n)
        .map(|i| format!("Texture \"{i}\" \"float\" \"scale\" \"texture tex\" \"{}\"\n", i + 1))
        .collect();
    let s = read(&format!("WorldBegin\n{chain}Texture \"{n}\" \"float\" \"constant\""));
    let first = messages(&s).lines().next().unwrap().to_string();
    assert!(first.ends_with("more than 200 definitions refer to one another in a row"), "{first}");
}

/// Whatever is cut off or changed in a scene, the reader comes back.
#[test]
fn damaged_scenes_do_not_panic() {
    let text =
        "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" [ 45 ] # c\nWorldBegin
        AttributeBegin Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ .1 .2 .3 ]
        Material \"coateddiffuse\" \"texture reflectance\" \"t\" \"spectrum eta\" \"glass-BK7\"
        AreaLightSource \"diffuse\" \"blackbody L\" 5000 \"float power\" 10 \"bool twosided\" true
        Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ]
        AttributeEnd ObjectBegin \"o\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\"";
    assert_eq!(messages(&read(text)), "");
    let replacements = ["", "\"", "[", "]", "-1", "1e40", " x ", "\u{e9}", "\\", "#", "\0"];
    let mut state = 7u64;
    for i in 0..text.len() {
        read(&text[..i]);
        state = kaustika_math::mix_bits(state.wrapping_add(0x9e37_79b9_7f4a_7c15));
        let by = replacements[(state % replacements.len() as u64) as usize];
        let cut = (state >> 32) as usize % 12;
        let end = (i + cut).min(text.len());
        read(&format!("{}{by}{}", &text[..i], &text[end..]));
    }
}
