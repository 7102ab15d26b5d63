//! Outliers: what they have too much, and what of it comes back.
//!
//! ```text
//! limit = max( third largest of the 24 pixels around, u - 2σ )                              (6)
//! g     = E max(0, 1 - M / n) / S,    n = (Σ e)² / Σ e²                                     (7)
//! ```
//!
//! A pixel above its limit is lowered to it. Where one sample of n is all the light, σ is u, and the
//! limit is what is around; a small light that every sample sees has a small σ and stays. What was
//! taken off, e, has the mean E over a wide square, in which the filtered picture has the mean S: where
//! as many as n like outliers are there they are light that was seen seldom, and the picture is made
//! brighter by 1 + g; fewer are luck and left out.

use super::plane::{Plane, box_mean};
use rayon::prelude::*;

/// For each pixel the factor, at most 1, that brings it to its limit (6).
pub fn clip(grey: &[f32], variance: &[f32], size @ (width, _): (usize, usize)) -> Vec<f32> {
    let around = Plane::new(size, |x, y| grey[y * width + x]);
    let limited = |i: usize| {
        let (u, centre) = (grey[i], around.at((i % width) as isize, (i / width) as isize));
        let lowest = u - 2.0 * variance[i].sqrt();
        let mut top = [lowest; 3];
        for dy in 0..5 {
            for dx in 0..5 {
                let at = centre + dy * around.stride() + dx - 2 * around.stride() - 2;
                let v = around.get(at);
                if at == centre || v <= top[2] {
                    continue;
                }
                top[2] = v;
                if top[2] > top[1] {
                    top.swap(1, 2);
                }
                if top[1] > top[0] {
                    top.swap(0, 1);
                }
            }
        }
        let limit = top[2];
        if u > limit && u > 0.0 { (limit / u).max(0.0) } else { 1.0 }
    };
    (0..grey.len()).into_par_iter().map(limited).collect()
}

/// Radius of the squares of (7).
const WIDE: usize = 24;

/// M of (7).
const FEW: f32 = 8.0;

/// Gives back to `picture` what (7) says, and returns the share of all light that stays out.
pub fn give_back<const C: usize>(
    picture: &mut [[f32; C]],
    excess: &[[f32; C]],
    size: (usize, usize),
) -> f64 {
    let grey = |v: &[f32; C]| v.iter().sum::<f32>() / C as f32;
    let e: Vec<f32> = excess.iter().map(grey).collect();
    let all: f64 = e.iter().map(|v| f64::from(*v)).sum();
    let sum = |picture: &[[f32; C]]| picture.iter().map(|v| f64::from(grey(v))).sum::<f64>();
    let before = sum(picture);
    if all <= 0.0 {
        return 0.0;
    }
    let pixels = ((2 * WIDE + 1) * (2 * WIDE + 1)) as f32;
    let mean = box_mean(&e, size, WIDE);
    let square = box_mean(&e.iter().map(|e| e * e).collect::<Vec<_>>(), size, WIDE);
    let light = box_mean(&picture.iter().map(grey).collect::<Vec<_>>(), size, WIDE);
    let gain: Vec<f32> = (0..e.len())
        .map(|i| {
            if mean[i] <= 0.0 || square[i] <= 0.0 || light[i] <= 0.0 {
                return 0.0;
            }
            let alike = pixels * mean[i] / square[i] * mean[i];
            mean[i] * (1.0 - FEW / alike).max(0.0) / light[i]
        })
        .collect();
    let gain = box_mean(&gain, size, WIDE);
    picture.iter_mut().zip(&gain).for_each(|(v, g)| *v = v.map(|v| v * (1.0 + g)));
    (all - (sum(picture) - before)) / (before + all)
}
