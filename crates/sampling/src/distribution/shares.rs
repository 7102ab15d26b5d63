//! Probabilities as shares of a whole number of units.
//!
//! A table says where each share begins: the sum of the shares before it. It can be of 16 or 32
//! bits, and what is computed from it is the same to the bit for whoever asks.

use kaustika_math::ONE_MINUS_EPSILON;

/// Where the shares of the weights begin that divide `units` among them, told by index: one unit
/// for each positive weight, the others in proportion. All begin at 0 if no weight is positive.
///
/// # Panics
/// If there are more positive weights than units.
pub fn fill_starts(weights: &[f64], units: u32, mut set: impl FnMut(usize, u32)) {
    let positive = weights.iter().filter(|&&w| w > 0.0).count() as u32;
    assert!(positive <= units, "{positive} shares of {units} units");
    let sum: f64 = weights.iter().sum();
    let (mut before, mut count) = (0.0, 0);
    for (i, &w) in weights.iter().enumerate() {
        let proportional = if sum > 0.0 { before / sum * f64::from(units - positive) } else { 0.0 };
        set(i, (count + proportional.round() as u32).min(units));
        before += w;
        count += u32::from(w > 0.0);
    }
}

/// With more shares than this they are halved until the one is found.
const FEW: usize = 64;

/// The last share that begins at or before `u` in [0, 1), what is left of `u`, and the share.
#[inline]
pub fn choose<T: Copy + Into<u32>>(starts: &[T], units: u32, u: f32) -> (usize, f32, f32) {
    let at = u * units as f32;
    let unit = (at as u32).min(units - 1);
    // An empty share begins where the next does.
    let count = match starts.len() <= FEW {
        true => starts.iter().map(|&s| usize::from(s.into() <= unit)).sum::<usize>(),
        false => starts.partition_point(|&s| s.into() <= unit),
    };
    let i = count - 1;
    let (start, p) = (starts[i].into(), share(starts, units, i));
    let rest = (at - start as f32) / (p * units as f32);
    (i, rest.min(ONE_MINUS_EPSILON), p)
}

/// The share that begins at `starts[i]`, as a probability.
#[inline]
pub fn share<T: Copy + Into<u32>>(starts: &[T], units: u32, i: usize) -> f32 {
    let end = starts.get(i + 1).map_or(units, |&s| s.into());
    (end - starts[i].into()) as f32 / units as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_whole_and_none_is_forgotten() {
        for n in [1usize, 3, 8, 100, 600] {
            let weights: Vec<f64> =
                (0..n).map(|i| if i % 3 == 2 { 0.0 } else { 0.1f64.powi(i as i32 % 40) }).collect();
            let units = 1 << 15;
            let mut starts = vec![0u16; n];
            fill_starts(&weights, units, |i, start| starts[i] = start as u16);
            let total: f32 = (0..n).map(|i| share(&starts, units, i)).sum();
            assert_eq!(total, 1.0);
            for (i, &w) in weights.iter().enumerate() {
                assert_eq!(share(&starts, units, i) > 0.0, w > 0.0, "{i} of {n}");
            }
            for unit in 0..units {
                let u = (unit as f32 + 0.25) / units as f32;
                let (i, rest, p) = choose(&starts, units, u);
                assert!(weights[i] > 0.0 && p == share(&starts, units, i));
                let back = (f32::from(starts[i]) + rest * p * units as f32) / units as f32;
                assert!((back - u).abs() < 1e-6 && (0.0..1.0).contains(&rest));
            }
        }
    }
}
