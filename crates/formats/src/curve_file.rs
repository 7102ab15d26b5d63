//! Files of curves: a control point a line, `x y z radius`; an empty line begins a new curve
//! (Mitsuba 3, documentation of `bsplinecurve`).

use std::path::Path;

/// x, y, z, radius.
pub type ControlPoint = [f32; 4];

/// Reads the curves of a file, each of at least `least` control points. An error is a one-line
/// cause with the file and the line.
pub fn read_curves(path: &Path, least: usize) -> Result<Vec<Vec<ControlPoint>>, String> {
    let at = |line: usize, cause: String| format!("{}:{line}: {cause}", path.display());
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let text = String::from_utf8_lossy(&bytes);
    let mut curves: Vec<Vec<ControlPoint>> = Vec::new();
    let mut open = false;
    let too_short = |curves: &[Vec<ControlPoint>], line: usize| match curves.last() {
        Some(c) if c.len() < least => {
            Err(at(line, format!("a curve ends after {} of at least {least} points", c.len())))
        }
        _ => Ok(()),
    };
    let mut number = 0;
    for line in text.lines() {
        number += 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if words.is_empty() {
            too_short(&curves, number)?;
            open = false;
            continue;
        }
        let point = control_point(&words).map_err(|cause| at(number, cause))?;
        match curves.last_mut().filter(|_| open) {
            Some(curve) => curve.push(point),
            None => curves.push(vec![point]),
        }
        open = true;
    }
    too_short(&curves, number)?;
    match curves.is_empty() {
        true => Err(format!("{}: the file holds no control points", path.display())),
        false => Ok(curves),
    }
}

fn control_point(words: &[&str]) -> Result<ControlPoint, String> {
    let mut point = [0.0; 4];
    if words.len() != point.len() {
        return Err(format!("expected `x y z radius`, found {} numbers", words.len()));
    }
    for (v, word) in point.iter_mut().zip(words) {
        match word.parse::<f32>() {
            Ok(number) if number.is_finite() => *v = number,
            _ => return Err(format!("expected a number, found `{word}`")),
        }
    }
    if point[3] < 0.0 {
        return Err(format!("the radius {} is negative", point[3]));
    }
    Ok(point)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<ControlPoint>>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hair.txt");
        std::fs::write(&path, text).unwrap();
        let prefix = format!("{}/", folder.path().display());
        read_curves(&path, 2).map_err(|e| e.replace(&prefix, ""))
    }

    #[test]
    fn empty_lines_part_curves() {
        let curves = read("0 0 0 1\r\n1 0 0 .5\n\n \n0 1 0 1\n1 1e0 0 2\n2 1 0 2").unwrap();
        assert_eq!(curves.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(curves[0][1], [1.0, 0.0, 0.0, 0.5]);
    }

    #[test]
    fn faults_are_told_with_their_line() {
        let fault = |text: &str| read(text).unwrap_err();
        assert_eq!(
            fault("0 0 0 1\n0 0 1\n"),
            "hair.txt:2: expected `x y z radius`, found 3 numbers"
        );
        assert_eq!(fault("0 0 0 1\n0 0 x 1\n"), "hair.txt:2: expected a number, found `x`");
        assert_eq!(fault("0 0 0 1\n0 0 inf 1\n"), "hair.txt:2: expected a number, found `inf`");
        assert_eq!(fault("0 0 0 1\n0 1 0 -1\n"), "hair.txt:2: the radius -1 is negative");
        assert_eq!(fault("0 0 0 1\n\n"), "hair.txt:2: a curve ends after 1 of at least 2 points");
        assert_eq!(fault("0 0 0 1"), "hair.txt:1: a curve ends after 1 of at least 2 points");
        assert_eq!(fault("\n\n"), "hair.txt: the file holds no control points");
    }
}
