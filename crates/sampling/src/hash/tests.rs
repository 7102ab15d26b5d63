//! Nesting and bijectivity are exact; randomness is tested by chi-square at a family-wise level
//! of 1 % a test (Šidák), with fixed keys.

use super::*;
use kaustika_math::special::gamma_q;

fn p_value(counts: &[u32]) -> f64 {
    let n: u32 = counts.iter().sum();
    let e = n as f64 / counts.len() as f64;
    assert!(e >= 5.0);
    let chi2: f64 = counts.iter().map(|&c| (c as f64 - e).powi(2) / e).sum();
    gamma_q((counts.len() - 1) as f64 / 2.0, chi2 / 2.0)
}

fn level(tests: usize) -> f64 {
    1.0 - 0.99f64.powf(1.0 / tests as f64)
}

#[test]
fn permute_is_a_bijection() {
    for n in (1..300).chain([1000, 4095, 4096, 4097, 100_003]) {
        for key in 0..4 {
            let key = nth(7, key);
            let mut seen = vec![false; n as usize];
            (0..n).for_each(|i| seen[permute(i, n, key) as usize] = true);
            assert!(seen.iter().all(|&s| s), "n {n} key {key:x}");
        }
    }
    assert!(permute(1 << 30, 1 << 31, 3) < 1 << 31);
}

#[test]
fn permute_places_pairs_uniformly() {
    // Ordered pairs of images over random keys; n = 2 has only the first kind of cell.
    let lengths = [2u32, 3, 4, 5, 6, 7, 8, 9, 13, 16, 17, 25, 31, 32, 36];
    let mut worst: (f64, u32, u32, u32) = (1.0, 0, 0, 0);
    let mut tests = 0;
    for n in lengths {
        let places = [(0, 1), (0, n - 1), (n / 2, n - 1), (n / 2, n / 3)];
        for (i, j) in places.into_iter().filter(|(i, j)| i != j) {
            let mut counts = vec![0u32; (n * n) as usize];
            for k in 0..20 * n * n {
                let key = nth(u64::from(n), k);
                counts[(permute(i, n, key) * n + permute(j, n, key)) as usize] += 1;
            }
            let off_diagonal: Vec<u32> =
                (0..n * n).filter(|c| c / n != c % n).map(|c| counts[c as usize]).collect();
            let p = p_value(&off_diagonal);
            tests += 1;
            if p < worst.0 {
                worst = (p, n, i, j);
            }
        }
    }
    assert!(worst.0 > level(tests), "{worst:?}");
}

#[test]
fn scrambles_are_nested() {
    for k in 0..10_000 {
        let h = nth(1, k);
        let (x, seed) = (nth(2, k), nth(3, k));
        // Digits from `cut` on do not change the images of those before.
        let cut = k % 32;
        let low = ((1u64 << cut) - 1) as u32;
        let (a, b) = (x as u32, (x as u32 & low) | (h as u32 & !low));
        let s = seed as u32;
        assert_eq!(owen_reversed(a, s) & low, owen_reversed(b, s) & low);
        let low = (1u64 << (2 * cut)) - 1;
        let (a, b) = (x, (x & low) | (h & !low));
        assert_eq!(owen4_reversed(a, seed) & low, owen4_reversed(b, seed) & low);
        // And the digit at the cut takes a bijection.
        let images = (0..4u64).map(|d| {
            let v = (x & low) | d << (2 * cut);
            owen4_reversed(v, seed) >> (2 * cut) & 3
        });
        assert_eq!(images.fold(0, |set, i| set | 1 << i), 15);
        let bit = |v: u32| owen_reversed(v, s) >> cut & 1;
        assert_ne!(bit(x as u32 & !(1 << cut)), bit(x as u32 | 1 << cut));
    }
}

#[test]
fn owen_flips_are_fair_and_pairwise_independent() {
    // Over random seeds, the flips of two nodes of a level whose paths part at an earlier bit.
    let mut worst = (1.0f64, 0, 0);
    let mut tests = 0;
    for level_bit in [1u32, 2, 3, 4, 6, 8, 11, 15] {
        for part in 0..level_bit {
            let path = nth(u64::from(level_bit), part) as u32 & ((1 << level_bit) - 1);
            let mut counts = [0u32; 4];
            for k in 0..4000 {
                let seed = halves(nth(99, k)).0;
                let flip = |p: u32| owen_reversed(p, seed) >> level_bit & 1;
                counts[(flip(path) * 2 + flip(path ^ 1 << part)) as usize] += 1;
            }
            let p = p_value(&counts);
            tests += 1;
            if p < worst.0 {
                worst = (p, level_bit, part);
            }
        }
    }
    assert!(worst.0 > level(tests), "p, level, parting bit: {worst:?}");
}

#[test]
fn owen4_digits_are_permuted_in_all_ways_and_pairwise_independently() {
    let mut worst = (1.0f64, "", 0, 0);
    let mut tests = 0;
    let mut record = |counts: &[u32], what, digit, part| {
        let p = p_value(counts);
        tests += 1;
        if p < worst.0 {
            worst = (p, what, digit, part);
        }
    };
    for digit in 0..8u32 {
        let image = |path: u64, d: u64, seed: u64| {
            owen4_reversed(path | d << (2 * digit), seed) >> (2 * digit) & 3
        };
        let path = nth(5, digit) & ((1 << (2 * digit)) - 1);
        let mut permutations = std::collections::BTreeMap::new();
        let mut images = [[0u32; 4]; 4];
        let n = 24 * 1000;
        for k in 0..n {
            let seed = nth(1234, k);
            let p = [0, 1, 2, 3].map(|d| image(path, d, seed));
            *permutations.entry(p).or_insert(0) += 1;
            (0..4).for_each(|d| images[d][p[d] as usize] += 1);
        }
        assert_eq!(permutations.len(), 24, "digit {digit}");
        for (p, count) in &permutations {
            assert!((n / 48..n / 12).contains(count), "digit {digit} {p:?} {count}");
        }
        images.iter().enumerate().for_each(|(d, counts)| record(counts, "image", digit, d as u32));
        for part in 0..2 * digit {
            let mut counts = [0u32; 16];
            for k in 0..4000 {
                let seed = nth(4321, k);
                let other = path ^ 1 << part;
                counts[(image(path, 0, seed) * 4 + image(other, 0, seed)) as usize] += 1;
            }
            record(&counts, "pair", digit, part);
        }
    }
    assert!(worst.0 > level(tests), "{worst:?}");
}
