//! Perlin's noise (Perlin 2002, "Improving Noise") and what pbrt builds from it.

use crate::description::NoiseKind;
use kaustika_math::Vec3;

/// Gradient noise in about [-1, 1], zero at lattice points; the pattern of pbrt's.
pub fn perlin(p: Vec3) -> f32 {
    let cell = Vec3::new(p.x.floor(), p.y.floor(), p.z.floor());
    let f = p - cell;
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v, w) = (fade(f.x), fade(f.y), fade(f.z));
    let corner = |dx: f32, dy: f32, dz: f32| {
        gradient(cell + Vec3::new(dx, dy, dz), f - Vec3::new(dx, dy, dz))
    };
    let lerp = kaustika_math::lerp;
    let face = |dz: f32| {
        lerp(
            v,
            lerp(u, corner(0.0, 0.0, dz), corner(1.0, 0.0, dz)),
            lerp(u, corner(0.0, 1.0, dz), corner(1.0, 1.0, dz)),
        )
    };
    lerp(w, face(0.0), face(1.0))
}

/// Perlin's permutation of 0 to 255 (Perlin 2002).
#[rustfmt::skip]
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225,
    140, 36, 103, 30, 69, 142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148,
    247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122,
    60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54,
    65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169,
    200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64,
    52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212,
    207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213,
    119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9,
    129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104,
    218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241,
    81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157,
    184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93,
    222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78, 66, 215, 61, 156, 180,
];

/// One of the edge directions of a cube, by the lattice point's number, times the offset. Which
/// of them is pbrt's choice (noise.cpp, `Grad`); Perlin's differs for four of sixteen.
fn gradient(cell: Vec3, d: Vec3) -> f32 {
    let turn = |at: u8| PERMUTATION[usize::from(at)];
    let wrapped = |v: f32| v as i64 as u8;
    // The permutation goes on from its start.
    let xy = turn(wrapped(cell.x)).wrapping_add(wrapped(cell.y));
    let h = turn(turn(xy).wrapping_add(wrapped(cell.z))) & 15;
    let u = if h < 8 || h == 12 || h == 13 { d.x } else { d.y };
    let v = if h < 4 || h == 12 || h == 13 { d.y } else { d.z };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

/// Σ ωⁱ noise(2ⁱ p) over the octaves; absolute values if `turbulent`.
fn octave_sum(p: Vec3, omega: f32, octaves: u32, turbulent: bool) -> f32 {
    let (mut sum, mut amplitude, mut frequency) = (0.0, 1.0, 1.0);
    for _ in 0..octaves {
        let n = perlin(p * frequency);
        sum += amplitude * if turbulent { n.abs() } else { n };
        // Slightly off two, so that the lattices do not coincide.
        frequency *= 1.99;
        amplitude *= omega;
    }
    sum
}

/// The value of a noise texture; grey but for marble.
pub fn evaluate(
    kind: NoiseKind,
    p: Vec3,
    octaves: u32,
    roughness: f32,
    scale: f32,
    variation: f32,
) -> [f32; 3] {
    match kind {
        NoiseKind::Fbm => [octave_sum(p, roughness, octaves, false); 3],
        NoiseKind::Wrinkled => [octave_sum(p, roughness, octaves, true); 3],
        NoiseKind::Windy => {
            let strength = octave_sum(p * 0.1, 0.5, 3, false);
            [strength.abs() * octave_sum(p, 0.5, 6, false); 3]
        }
        NoiseKind::Marble => {
            let q = p * scale;
            let t = 0.5 + 0.5 * (q.y + variation * octave_sum(q, roughness, octaves, false)).sin();
            marble_spline(t).map(|c| 1.5 * c)
        }
    }
}

/// A uniform cubic B-spline through pbrt's marble colours at `t` in [0,1].
fn marble_spline(t: f32) -> [f32; 3] {
    const COLORS: [[f32; 3]; 9] = [
        [0.58, 0.58, 0.6],
        [0.58, 0.58, 0.6],
        [0.58, 0.58, 0.6],
        [0.5, 0.5, 0.5],
        [0.6, 0.59, 0.58],
        [0.58, 0.58, 0.6],
        [0.58, 0.58, 0.6],
        [0.2, 0.2, 0.33],
        [0.58, 0.58, 0.6],
    ];
    let segments = COLORS.len() - 3;
    let first = ((t * segments as f32) as usize).min(segments - 1);
    let t = t * segments as f32 - first as f32;
    let s = 1.0 - t;
    let w = [
        s * s * s,
        3.0 * t * t * t - 6.0 * t * t + 4.0,
        3.0 * s * s * s - 6.0 * s * s + 4.0,
        t * t * t,
    ];
    std::array::from_fn(|c| (0..4).map(|i| w[i] / 6.0 * COLORS[first + i][c]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of pbrt's formula, evaluated apart in double precision; the second is also Perlin's own.
    #[test]
    fn noise_is_pbrt_s() {
        for (p, n) in [
            ((0.3, 0.4, 0.7), -0.059_766_95),
            ((314.0 / 100.0, 42.0, 7.0), 0.136_919_96),
            ((-1.7, 255.25, 300.5), -0.035_502),
            ((100.1, -77.7, 0.2), 0.028_606_22),
        ] {
            let found = perlin(Vec3::new(p.0, p.1, p.2));
            assert!((found - n).abs() < 1e-5, "{p:?}: {found}, expected {n}");
        }
    }

    #[test]
    fn noise_vanishes_on_the_lattice_and_is_continuous() {
        assert_eq!(perlin(Vec3::new(3.0, -2.0, 7.0)), 0.0);
        let p = Vec3::new(0.999_99, 0.4, 0.2);
        let q = Vec3::new(1.000_01, 0.4, 0.2);
        assert!((perlin(p) - perlin(q)).abs() < 1e-3);
        let mean: f32 = (0..4000)
            .map(|i| perlin(Vec3::new(i as f32 * 0.37, i as f32 * 0.11, i as f32 * 0.71)))
            .sum::<f32>()
            / 4000.0;
        assert!(mean.abs() < 0.02, "{mean}");
    }
}
