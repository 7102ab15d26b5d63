//! Lobes as a drawing: one panel a material and angle of incidence.
//!
//! ```text
//! r = R f / f_max,   or   r = R max(0, 1 + log₁₀(f / f_max) / 3)  for three decades         (1)
//! ```
//!
//! f is the luminance; blue what is diffuse, orange what is glossy, black the sum, red lines what
//! mirrors and clear glass single out, as long as their part of the power. The grey line is where the light
//! comes from.

use super::brdf::Lobe;
use std::fmt::Write;

/// A panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What stands above it.
    pub title: String,
    /// What it shows.
    pub lobe: Lobe,
}

/// R, in units of the drawing.
const RADIUS: f32 = 100.0;
/// Around a panel's half circle.
const MARGIN: f32 = 20.0;
/// Letters of a title.
const LONGEST: usize = 38;
/// Decades that a logarithmic drawing shows.
const DECADES: f32 = 3.0;

/// (1) of a value above 0, as a part of R.
pub fn radius(f: f32, most: f32, log: bool) -> f32 {
    match (f > 0.0 && most > 0.0, log) {
        (false, _) => 0.0,
        (true, false) => f / most,
        (true, true) => (1.0 + (f / most).log10() / DECADES).max(0.0),
    }
}

/// Luminance of linear RGB.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The drawing, `columns` panels a row.
pub fn draw(panels: &[Panel], columns: usize, log: bool) -> String {
    let columns = columns.clamp(1, panels.len().max(1));
    let width = 2.0 * (RADIUS + MARGIN);
    let rows = panels.chunks(columns).map(|row| {
        let behind = row.iter().any(|p| passes(&p.lobe));
        (row, 3.0 * MARGIN + if behind { 2.0 * RADIUS } else { RADIUS })
    });
    let (mut drawn, mut y) = (String::new(), 0.0);
    for (row, height) in rows {
        for (i, panel) in row.iter().enumerate() {
            let x = i as f32 * width + MARGIN + RADIUS;
            draw_panel(&mut drawn, panel, [x, y + 1.5 * MARGIN + RADIUS], log);
        }
        y += height;
    }
    let w = columns as f32 * width;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {y}\" width=\"{w}\" \
         height=\"{y}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{w}\" height=\"{y}\" fill=\"white\"/>\n{drawn}</svg>\n"
    )
}

/// True if something goes through the surface.
fn passes(lobe: &Lobe) -> bool {
    let smooth = lobe.angles.iter().zip(lobe.diffuse.iter().zip(&lobe.glossy));
    let mut smooth = smooth.filter(|(a, _)| a.abs() > 90.0);
    let mut singular = lobe.singular.iter().filter(|(a, _)| a.abs() > 90.0);
    let is_some = |c: &[f32; 3]| luminance(*c) > 0.0;
    smooth.any(|(_, (d, g))| is_some(d) || is_some(g)) || singular.any(|(_, c)| is_some(c))
}

fn draw_panel(svg: &mut String, panel: &Panel, [x, y]: [f32; 2], log: bool) {
    let lobe = &panel.lobe;
    let sum: Vec<[f32; 3]> = lobe
        .diffuse
        .iter()
        .zip(&lobe.glossy)
        .map(|(d, g)| std::array::from_fn(|k| d[k] + g[k]))
        .collect();
    let most = sum.iter().map(|c| luminance(*c)).fold(0.0, f32::max);
    // Writing to a string does not fail.
    let mut add = |text: std::fmt::Arguments| {
        let _ = svg.write_fmt(text);
    };
    let title = escaped(&panel.title);
    let below = y - RADIUS - 0.6 * MARGIN;
    add(format_args!("<g transform=\"translate({x} {y})\">\n"));
    add(format_args!("<text y=\"{:.1}\" text-anchor=\"middle\">{title}</text>\n", below - y));
    add(format_args!(
        "<path d=\"M{0} 0A{1} {1} 0 0 1 {1} 0\" fill=\"none\" stroke=\"#ddd\"/>\n\
         <path d=\"M{0} 0H{1}M0 0V{0}\" stroke=\"#bbb\"/>\n",
        -RADIUS, RADIUS
    ));
    let place = |degrees: f32, r: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        format!("{:.1} {:.1}", RADIUS * r * sin, -RADIUS * r * cos)
    };
    add(format_args!(
        "<path d=\"M{}L0 0\" stroke=\"#888\" stroke-dasharray=\"4 3\"/>\n",
        place(-lobe.incidence, 1.0)
    ));
    for (values, style) in [
        (&lobe.diffuse, "fill=\"#3b75af\" fill-opacity=\"0.55\""),
        (&lobe.glossy, "fill=\"#ef8636\" fill-opacity=\"0.55\""),
        (&sum, "fill=\"none\" stroke=\"black\" stroke-width=\"0.8\""),
    ] {
        let radii: Vec<f32> = values.iter().map(|c| radius(luminance(*c), most, log)).collect();
        if radii.iter().all(|r| *r == 0.0) {
            continue;
        }
        let points = lobe.angles.iter().zip(&radii);
        // The middle stands for all directions without light; a lobe all around has none.
        let around = radii.iter().all(|r| *r > 0.0);
        let mut path = String::new();
        let mut is_middle = true;
        for (angle, r) in points {
            if *r > 0.0 || !is_middle {
                path += match path.is_empty() {
                    true if around => "M",
                    true => "M0 0L",
                    false => "L",
                };
                path += &place(*angle, *r);
            }
            is_middle = *r == 0.0;
        }
        add(format_args!("<path d=\"{path}Z\" {style}/>\n"));
    }
    for (angle, part) in lobe.singular.iter().filter(|(_, c)| luminance(*c) > 0.0) {
        let part = luminance(*part);
        add(format_args!(
            "<path d=\"M0 0L{}\" stroke=\"#c0392b\" stroke-width=\"1.5\"/>\n",
            place(*angle, part.min(1.0))
        ));
    }
    let singular: Vec<String> = lobe
        .singular
        .iter()
        .map(|(_, c)| luminance(*c))
        .filter(|part| *part > 0.0)
        .map(|part| format!("{part:.3}"))
        .collect();
    let scale = if log { ", 3 decades" } else { "" };
    let mut legend = format!("{:.0}°", lobe.incidence);
    if most > 0.0 {
        legend += &format!(": at most {most:.3}/sr{scale}");
    }
    if !singular.is_empty() {
        legend += &format!("; mirrored and refracted {}", singular.join(", "));
    }
    let under = if passes(lobe) { RADIUS } else { 0.0 } + 0.7 * MARGIN;
    add(format_args!(
        "<text y=\"{under:.1}\" text-anchor=\"middle\" fill=\"#555\">{legend}</text>\n</g>\n"
    ));
}

/// Text as XML has it, not longer than a panel is wide.
fn escaped(text: &str) -> String {
    let text = match text.chars().count() > LONGEST {
        true => text.chars().take(LONGEST - 1).chain(['…']).collect(),
        false => text.to_string(),
    };
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_decades_or_one_scale() {
        assert_eq!(radius(0.5, 2.0, false), 0.25);
        assert!((radius(2.0, 2.0, true) - 1.0).abs() < 1e-6);
        assert!((radius(0.02, 2.0, true) - 1.0 / 3.0).abs() < 1e-6);
        assert_eq!(radius(1e-6, 2.0, true), 0.0);
        assert_eq!(radius(0.0, 2.0, true), 0.0);
        assert_eq!(radius(0.0, 0.0, false), 0.0);
    }
}
