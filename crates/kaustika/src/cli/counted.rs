//! Numbers of things as people write them.

/// `1 pass`, `2 passes`.
pub fn passes(n: u64) -> String {
    counted(n, "pass", "passes")
}

/// `1 frame`, `2 frames`.
pub fn frames(n: usize) -> String {
    counted(n as u64, "frame", "frames")
}

fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!([passes(0), passes(1), passes(2)], ["0 passes", "1 pass", "2 passes"]);
        assert_eq!([frames(1), frames(21)], ["1 frame", "21 frames"]);
    }
}
