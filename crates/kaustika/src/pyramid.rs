//! The contact sheet of a pyramid of strategies (Veach 1997, fig. 10.2).

use kaustika_film::Picture;

/// Widest small picture, pixels.
const WIDEST: u32 = 160;
/// Between small pictures, pixels.
const GAP: u32 = 4;

/// One picture of the layers that `bdpt` adds for its strategies, if there are such: a row for each
/// length of path, s growing to the right; weighted on the left, unweighted on the right.
pub fn sheet(picture: &Picture) -> Option<Picture> {
    let plane = |kind: &str, s: u32, t: u32, c: char| {
        let name = format!("{kind}.s{s}t{t}.{c}");
        picture.channels.iter().find(|channel| channel.name == name).map(|c| &c.data)
    };
    let rows = (0..).take_while(|depth| plane("weighted", 0, depth + 2, 'R').is_some()).count();
    if rows == 0 {
        return None;
    }
    let (rows, shrink) = (rows as u32, picture.width.div_ceil(WIDEST));
    let (w, h) = (picture.width / shrink, picture.height / shrink);
    let columns = rows + 2;
    let half = columns * (w + GAP) + GAP;
    let (width, height) = (2 * half, rows * (h + GAP) + GAP);
    let mut sheet = Picture::new(width, height);
    for c in ['R', 'G', 'B'] {
        let mut all = vec![0.02; (width * height) as usize];
        for (side, kind) in ["weighted", "unweighted"].into_iter().enumerate() {
            for depth in 0..rows {
                let count = depth + 3;
                let margin = (columns - count) * (w + GAP) / 2 + GAP + side as u32 * half;
                for s in 0..count {
                    let Some(data) = plane(kind, s, depth + 2 - s, c) else { continue };
                    let at = [margin + s * (w + GAP), GAP + depth * (h + GAP)];
                    for i in 0..w * h {
                        let [x, y] = [i % w, i / w];
                        let to = (at[1] + y) * width + at[0] + x;
                        let from = [x, y].map(|v| v * shrink);
                        all[to as usize] = mean(data, picture.width, from, shrink);
                    }
                }
            }
        }
        sheet.push(c.to_string(), all);
    }
    Some(sheet)
}

/// The mean of a square of pixels.
fn mean(data: &[f32], width: u32, [x, y]: [u32; 2], size: u32) -> f32 {
    let row = |r: u32| {
        let at = ((y + r) * width + x) as usize;
        data[at..at + size as usize].iter().sum::<f32>()
    };
    (0..size).map(row).sum::<f32>() / (size * size) as f32
}
