//! Parameter names of Mitsuba 0.6 as Mitsuba 3 spells them.

use super::document::Object;

/// Turns `camelCase` parameters into `snake_case` ones.
pub(super) fn parameter_names(object: &mut Object) {
    for parameter in &mut object.parameters {
        parameter.name = snake_case(&parameter.name);
    }
}

/// `intIOR` becomes `int_ior`: an underscore where an upper case letter follows a lower case one,
/// and the run of upper case letters lowered.
pub(super) fn snake_case(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut lowering = false;
    let mut previous = ' ';
    for c in name.chars() {
        if c.is_ascii_uppercase() {
            if previous.is_ascii_lowercase() {
                out.push('_');
                lowering = true;
            }
            out.push(if lowering { c.to_ascii_lowercase() } else { c });
        } else {
            lowering = false;
            out.push(c);
        }
        previous = c;
    }
    out
}

/// The way back, for messages: `int_ior` is `intIOR`, `to_world` is `toWorld`.
pub(super) fn camel_case(name: &str) -> String {
    let mut parts = name.split('_');
    let mut out = parts.next().unwrap_or_default().to_string();
    for part in parts {
        if part == "ior" {
            out.push_str("IOR");
            continue;
        }
        let mut letters = part.chars();
        out.extend(letters.next().map(|c| c.to_ascii_uppercase()));
        out.push_str(letters.as_str());
    }
    out
}
