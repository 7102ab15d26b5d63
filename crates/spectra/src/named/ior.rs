//! Indices of refraction of dielectrics.

/// The index of refraction of a material by the name Mitsuba's `int_ior` uses, case ignored:
/// mostly at 589 nm and room temperature (Hecht, "Optics", 4th edition).
pub fn ior_by_name(name: &str) -> Option<f32> {
    IOR.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, ior)| ior)
}

/// All names that [`ior_by_name`] knows.
pub fn ior_names() -> impl Iterator<Item = &'static str> {
    IOR.iter().map(|&(n, _)| n)
}

const IOR: [(&str, f32); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_case() {
        assert_eq!(ior_by_name("BK7"), Some(1.5046));
        assert_eq!(ior_by_name("Water Ice"), Some(1.31));
        assert_eq!(ior_by_name("wood"), None);
        assert_eq!(ior_names().count(), 23);
    }
}
