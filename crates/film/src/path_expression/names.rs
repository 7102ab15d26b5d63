//! Arnold's names of common expressions. Its specular light is glossy light and what single
//! directions reflect.

const NAMES: [(&str, &str); 16] = [
    ("direct", "C.L"),
    ("indirect", "C.{2,}L"),
    ("emission", "CO"),
    ("background", "CB"),
    ("diffuse", "C<RD>.*"),
    ("diffuse_direct", "C<RD>L"),
    ("diffuse_indirect", "C<RD>.+L"),
    ("specular", "C<R[GS]>.*"),
    ("specular_direct", "C<R[GS]>L"),
    ("specular_indirect", "C<R[GS]>.+L"),
    ("transmission", "C<T.>.*"),
    ("transmission_direct", "C<T.>L"),
    ("transmission_indirect", "C<T.>.+L"),
    ("volume", "CV.*"),
    ("volume_direct", "CVL"),
    ("volume_indirect", "CV.+L"),
];

/// The expression of this name.
pub(super) fn known(name: &str) -> Option<&'static str> {
    NAMES.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
}

/// All names.
pub(super) fn all() -> impl Iterator<Item = &'static str> {
    NAMES.iter().map(|(name, _)| *name)
}
