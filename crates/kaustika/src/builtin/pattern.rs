//! Pictures for textures, painted by formulas.

use kaustika_math::mix_bits;
use kaustika_math::{Vec2, sqr};
use kaustika_scene::description::{Bitmap, Encoding, Texels};

/// Paints sRGB-coded texels from colours in sRGB code values over (x right, y up) in [0,1]²,
/// 2 x 2 points a texel.
fn paint(width: u32, height: u32, color: impl Fn(Vec2) -> [f32; 3]) -> Bitmap {
    let mut texels = Vec::with_capacity(3 * width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let mut sum = [0.0; 3];
            for k in 0..4 {
                let x = column as f32 + ((k % 2) as f32 + 0.5) / 2.0;
                let y = row as f32 + ((k / 2) as f32 + 0.5) / 2.0;
                let c = color(Vec2::new(x / width as f32, 1.0 - y / height as f32));
                (0..3).for_each(|i| sum[i] += c[i] / 4.0);
            }
            texels.extend(sum.map(|v| (v * 255.0).round().clamp(0.0, 255.0) as u8));
        }
    }
    Bitmap { width, height, channels: 3, texels: Texels::U8(texels), encoding: Encoding::Srgb }
}

/// A number in [0,1) that belongs to `key`.
fn random(key: u64) -> f32 {
    (mix_bits(key.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 40) as f32 / (1u64 << 24) as f32
}

/// A chip of stone in terrazzo: a convex polygon.
struct Chip {
    center: Vec2,
    /// Outward directions of the sides and their distances from the centre.
    sides: Vec<(Vec2, f32)>,
    color: [f32; 3],
}

/// What the stones lie in, sRGB code values.
const MORTAR: [f32; 3] = [0.885, 0.865, 0.83];
/// Stones in terrazzo, sRGB code values, rarer ones last; half mortar, for the floor is to carry caustics.
const STONES: [[f32; 3]; 7] = [
    [0.95, 0.94, 0.91],
    [0.79, 0.77, 0.73],
    [0.83, 0.66, 0.53],
    [0.55, 0.62, 0.62],
    [0.76, 0.47, 0.35],
    [0.43, 0.50, 0.51],
    [0.31, 0.30, 0.30],
];

impl Chip {
    fn new(number: u64) -> Chip {
        let dice = |k: u64| random(number * 64 + k);
        let size = 0.006 + 0.022 * dice(0) * dice(0) * dice(0) + 0.004 * dice(1);
        let corners = 4 + (3.0 * dice(2)) as u64;
        let turn = dice(3);
        let sides = (0..corners)
            .map(|k| {
                let a = (turn + (k as f32 + 0.6 * dice(8 + k)) / corners as f32)
                    * std::f32::consts::TAU;
                (Vec2::new(a.cos(), a.sin()), size * (0.55 + 0.45 * dice(20 + k)))
            })
            .collect();
        let stone = (STONES.len() as f32 * dice(4) * dice(5).sqrt()) as usize;
        let shade = 0.96 + 0.08 * dice(6);
        Chip {
            center: Vec2::new(dice(40), dice(41)),
            sides,
            color: std::array::from_fn(|i| (0.5 * (STONES[stone][i] + MORTAR[i]) * shade).min(1.0)),
        }
    }

    /// Whether it covers `p`, the plane repeating with period 1.
    fn covers(&self, p: Vec2) -> bool {
        let d = p - self.center;
        let d = Vec2::new(d.x - d.x.round(), d.y - d.y.round());
        self.sides.iter().all(|(n, r)| n.dot(d) < *r)
    }
}

/// Pale terrazzo that repeats seamlessly.
pub fn terrazzo(size: u32) -> Bitmap {
    const CHIPS: u64 = 900;
    /// Chips are looked up by the cell of their middle; none reaches farther than one cell.
    const CELLS: i32 = 16;
    let mut cells: Vec<Vec<Chip>> = (0..CELLS * CELLS).map(|_| Vec::new()).collect();
    let cell = |x: f32| (x * CELLS as f32).floor() as i32;
    let index = |i: i32, j: i32| (j.rem_euclid(CELLS) * CELLS + i.rem_euclid(CELLS)) as usize;
    for number in 0..CHIPS {
        let chip = Chip::new(number);
        cells[index(cell(chip.center.x), cell(chip.center.y))].push(chip);
    }
    paint(size, size, |p| {
        let (i, j) = (cell(p.x), cell(p.y));
        (-1..=1)
            .flat_map(|dj| (-1..=1).map(move |di| (di, dj)))
            .flat_map(|(di, dj)| &cells[index(i + di, j + dj)])
            .find(|chip| chip.covers(p))
            .map_or(MORTAR, |chip| chip.color)
    })
}

/// Glaze of a vase: bands of waves, leaves and lines in cobalt on cream; x runs around, y up.
pub fn glaze(width: u32, height: u32) -> Bitmap {
    const CREAM: [f32; 3] = [0.93, 0.90, 0.82];
    const COBALT: [f32; 3] = [0.11, 0.20, 0.46];
    const RUST: [f32; 3] = [0.72, 0.33, 0.18];
    paint(width, height, |p| {
        let band = |from: f32, to: f32| (from..to).contains(&p.y);
        // Position within the repeat of a motif, in [-1/2, 1/2).
        let repeat = |n: f32, shift: f32| (p.x * n + shift).rem_euclid(1.0) - 0.5;
        let lines = [0.145, 0.30, 0.335, 0.475, 0.51, 0.60];
        if lines.iter().any(|y| band(*y, y + 0.012)) || band(0.0, 0.10) {
            return COBALT;
        }
        if band(0.157, 0.30) {
            // Leaves: lenses that lean to either side in turn.
            let x = repeat(20.0, 0.0);
            let y = (p.y - 0.2285) / 0.143;
            let lean = if (p.x * 20.0) as i32 % 2 == 0 { 0.25 } else { -0.25 };
            let across = (x - lean * y) / 0.26;
            return if sqr(across) + sqr(y * 2.2).powf(0.75) < 1.0 { COBALT } else { CREAM };
        }
        if band(0.347, 0.475) {
            // Zigzag with a lozenge in each turn.
            let x = repeat(16.0, 0.0);
            let y = (p.y - 0.411) / 0.128;
            let fold = 1.3 * (x.abs() - 0.25);
            let lozenge = |x: f32, y: f32| (1.9 * x.abs() + 1.2 * y.abs()) < 0.24;
            let upper = lozenge(repeat(16.0, 0.5), y - 0.22);
            return match () {
                _ if (y - fold).abs() < 0.11 => COBALT,
                _ if upper || lozenge(x, y + 0.22) => RUST,
                _ => CREAM,
            };
        }
        if band(0.522, 0.60) {
            let (x, y) = (repeat(28.0, 0.0), (p.y - 0.561) / 0.078);
            return if sqr(x) + sqr(y * 0.9) < sqr(0.27) { RUST } else { CREAM };
        }
        CREAM
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terrazzo_repeats_seamlessly() {
        let bitmap = terrazzo(256);
        let Texels::U8(t) = &bitmap.texels else { panic!("8 bits a channel expected") };
        let step = |a: usize, b: usize| {
            (0..3).map(|c| (t[3 * a + c] as f32 - t[3 * b + c] as f32).abs()).sum::<f32>()
        };
        let mean = |pairs: &dyn Fn(usize) -> (usize, usize)| {
            (0..256).map(pairs).map(|(a, b)| step(a, b)).sum::<f32>() / 256.0
        };
        // Steps over the seam are like steps inside.
        let seam = mean(&|i| (256 * i, 256 * i + 255));
        let inside = (0..16).map(|k| mean(&|i| (256 * i + 16 * k, 256 * i + 16 * k + 1))).sum();
        let inside: f32 = inside;
        assert!(seam < 2.0 * inside / 16.0, "seam {seam}, inside {}", inside / 16.0);
        assert!(inside > 0.0);
    }
}
