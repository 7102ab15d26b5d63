//! Perlin's noise (Perlin 2002, "Improving Noise") and what pbrt builds from it.

use crate::description::NoiseKind;
use kaustika_math::{Vec3, mix_bits};

/// Gradient noise in about [-1, 1], zero at lattice points. The lattice is hashed rather than
/// read from Perlin's permutation, so the pattern differs from other programs' in detail.
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

/// One of the twelve edge directions of a cube, by hash, times the offset.
fn gradient(cell: Vec3, d: Vec3) -> f32 {
    let bits = |v: f32| (v as i64 as u64) & 0x1f_ffff;
    let h = mix_bits(bits(cell.x) | bits(cell.y) << 21 | bits(cell.z) << 42) & 15;
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
