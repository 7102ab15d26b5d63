//! Pictures whose truth is known.

use super::*;

const W: usize = 96;
const H: usize = 64;

/// Independent standard normal numbers (Box & Muller 1958), the same for a seed.
fn normal(seed: u64, i: usize) -> f32 {
    let uniform = |k: u64| {
        let bits = kaustika_math::mix_bits(seed << 40 | (2 * i as u64 + k));
        ((bits >> 40) as f32 + 0.5) / (1u64 << 24) as f32
    };
    (-2.0 * uniform(0).ln()).sqrt() * (std::f32::consts::TAU * uniform(1)).cos()
}

/// A picture made of a value at each column and row, with noise of this deviation.
fn noisy(seed: u64, sigma: f32, truth: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    (0..W * H).map(|i| truth(i % W, i / W) + sigma * normal(seed, i)).collect()
}

fn filtered(mean: &[f32], variance: Option<&[f32]>, features: &Features) -> Vec<f32> {
    let noisy = Noisy { width: W, height: H, mean: [mean], variance: variance.map(|v| [v]) };
    denoise(&noisy, features).pixels.into_iter().map(|[v]| v).collect()
}

fn mean(v: impl IntoIterator<Item = f32>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for v in v {
        (sum, n) = (sum + f64::from(v), n + 1.0);
    }
    sum / n
}

#[test]
fn what_is_constant_stays() {
    for value in [1e-6, 0.5, 3e4] {
        let picture = vec![value; W * H];
        for variance in [None, Some(vec![value * value; W * H])] {
            let out = filtered(&picture, variance.as_deref(), &Features::default());
            assert!(out.iter().all(|v| (v / value - 1.0).abs() < 1e-4), "{value}");
        }
    }
    assert!(filtered(&vec![0.0; W * H], None, &Features::default()).iter().all(|v| *v == 0.0));
}

#[test]
fn pictures_smaller_than_a_window_are_filtered() {
    for (width, height) in [(1, 1), (2, 3), (5, 1), (1, 40)] {
        let picture = vec![0.5; width * height];
        let noisy = Noisy { width, height, mean: [&picture; 3], variance: None };
        let out = denoise(&noisy, &Features::default());
        assert!(out.pixels.iter().flatten().all(|v| (v - 0.5).abs() < 1e-4), "{width} x {height}");
    }
}

#[test]
fn noise_falls_to_what_the_window_allows() {
    // A fit of a constant and two slopes to 529 pixels leaves 1/529 of the variance at its centre,
    // and 3/529 on average over the window; windows overlap, which takes from that, and are cut at
    // the border, which adds. Were all weights 1, the interior would be at 0.19 % to 0.57 %.
    let sigma = 0.2;
    let picture = noisy(1, sigma, |_, _| 1.0);
    let variance = vec![sigma * sigma; W * H];
    let out = filtered(&picture, Some(&variance), &Features::default());
    let left = mean(out.iter().map(|v| (v - 1.0) * (v - 1.0))) as f32 / (sigma * sigma);
    assert!((0.001..0.015).contains(&left), "{left}");
    // The mean of the picture has a standard error of σ/√(W H) = 0.0026.
    assert!((mean(out) - mean(picture)).abs() < 0.0026);
}

#[test]
fn gradients_are_no_noise() {
    let truth = |x: usize, y: usize| 1.0 + 0.02 * x as f32 + 0.01 * y as f32;
    let sigma = 0.1;
    let out = filtered(&noisy(2, sigma, truth), None, &Features::default());
    for y in 4..H - 4 {
        for x in 4..W - 4 {
            assert!((out[y * W + x] - truth(x, y)).abs() < sigma, "{x} {y}");
        }
    }
}

#[test]
fn edges_of_features_stay() {
    // The step is half of the noise's deviation: the picture alone does not show it, pixel by pixel.
    let right = |x: usize| x >= W / 2;
    let truth = |x: usize, _: usize| if right(x) { 1.3 } else { 1.0 };
    let sigma = 0.6;
    let picture = noisy(3, sigma, truth);
    let variance = vec![sigma * sigma; W * H];
    let column = |v: &[f32], x: usize| mean((0..H).map(|y| v[y * W + x]));
    let axis = |turned: bool| -> Vec<f32> {
        (0..W * H).map(|i| if right(i % W) == turned { 1.0 } else { 0.0 }).collect()
    };
    let (nx, ny, nz) = (axis(true), axis(false), vec![0.0; W * H]);
    let features = Features { normal: Some([&nx, &ny, &nz]), ..Features::default() };
    let led = filtered(&picture, Some(&variance), &features);
    let step = |v: &[f32]| column(v, W / 2) - column(v, W / 2 - 1);
    assert!((step(&led) - 0.3).abs() < 0.1, "{}", step(&led));
    // Without them it is lost, which shows that this test can fail.
    let blind = filtered(&picture, Some(&variance), &Features::default());
    assert!(step(&blind) < 0.15, "{}", step(&blind));
}

#[test]
fn textures_of_the_albedo_stay() {
    let albedo: Vec<f32> =
        (0..W * H).map(|i| if (i % W + i / W).is_multiple_of(2) { 0.8 } else { 0.2 }).collect();
    let picture: Vec<f32> =
        noisy(4, 0.1, |_, _| 1.0).iter().zip(&albedo).map(|(v, a)| v * a).collect();
    let features = Features { albedo: Some([&albedo; 3]), ..Features::default() };
    let out = filtered(&picture, None, &features);
    assert!(out.iter().zip(&albedo).all(|(v, a)| (v / a - 1.0).abs() < 0.08));
}

#[test]
fn silhouettes_before_a_background_stay() {
    // A surface of albedo 0.2 that covers ever more of the pixels of a column, under a light of 1
    // before a sky of 1: nothing is noise, though the samples of a mixed pixel differ.
    let part = |x: usize| [0.0, 0.05, 0.5, 0.95, 1.0][(x + 2).saturating_sub(W / 2).min(4)];
    let plane =
        |f: &dyn Fn(f32) -> f32| -> Vec<f32> { (0..W * H).map(|i| f(part(i % W))).collect() };
    let (albedo, cover) = (plane(&|c| 0.2 * c), plane(&|c| c));
    let picture = plane(&|c| 0.2 * c + 1.0 - c);
    let variance = plane(&|c| 0.64 * c * (1.0 - c) / 16.0);
    let nothing = vec![0.0; W * H];
    let features = Features {
        albedo: Some([&albedo; 3]),
        normal: Some([&nothing, &nothing, &cover]),
        depth: None,
    };
    let out = filtered(&picture, Some(&variance), &features);
    assert!(out.iter().zip(&picture).all(|(a, b)| (a - b).abs() < 0.03));
}

#[test]
fn what_is_no_number_does_not_spread() {
    let sigma = 0.1;
    let clean = noisy(5, sigma, |_, _| 1.0);
    let mut broken = clean.clone();
    let variance = vec![sigma * sigma; W * H];
    let mut doubtful = variance.clone();
    for (i, v) in [(0, f32::NAN), (W * 20 + 30, f32::INFINITY), (W * 40 + 50, f32::NEG_INFINITY)] {
        (broken[i], doubtful[i]) = (v, f32::NAN);
    }
    let a = filtered(&clean, Some(&variance), &Features::default());
    let b = filtered(&broken, Some(&doubtful), &Features::default());
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 0.03));
    let nothing = filtered(&vec![f32::NAN; W * H], None, &Features::default());
    assert!(nothing.iter().all(|v| *v == 0.0));
    let odd = vec![f32::INFINITY; W * H];
    let features = Features { albedo: Some([&odd; 3]), normal: Some([&odd; 3]), depth: Some(&odd) };
    assert!(filtered(&clean, None, &features).iter().all(|v| v.is_finite()));
}

/// Outliers of 400 where `is` says so, each from one sample of 16 that was 6400.
fn with_outliers(is: impl Fn(usize) -> bool) -> (Vec<f32>, Vec<f32>) {
    let mut picture = noisy(6, 0.1, |_, _| 1.0);
    let mut variance = vec![0.01; W * H];
    for i in (0..W * H).filter(|i| is(*i)) {
        (picture[i], variance[i]) = (400.0, 400.0 * 400.0);
    }
    (picture, variance)
}

#[test]
fn lone_fireflies_leave_no_blob() {
    let (picture, variance) = with_outliers(|i| i == 30 * W + 40 || i == 30 * W + 70);
    let noisy = Noisy { width: W, height: H, mean: [&picture], variance: Some([&variance]) };
    let out = denoise(&noisy, &Features::default());
    assert!(out.pixels.iter().all(|[v]| (v - 1.0).abs() < 0.15));
    let light = 798.0 / (798.0 + (W * H) as f64);
    assert!((out.left_out - light).abs() < 0.01, "{} {light}", out.left_out);
}

#[test]
fn light_of_many_fireflies_is_not_lost() {
    // One pixel in 50 has nearly all light.
    let is = |i: usize| kaustika_math::mix_bits(i as u64).is_multiple_of(50);
    let (picture, variance) = with_outliers(is);
    let out = filtered(&picture, Some(&variance), &Features::default());
    let kept = mean(out) / mean(picture);
    assert!((0.7..1.05).contains(&kept), "{kept}");
}

#[test]
fn lights_smaller_than_a_pixel_of_noise_stay() {
    // Every sample sees it: its variance is small.
    let mut picture = noisy(7, 0.1, |_, _| 1.0);
    let mut variance = vec![0.01; W * H];
    (picture[30 * W + 40], variance[30 * W + 40]) = (100.0, 4.0);
    let out = filtered(&picture, Some(&variance), &Features::default());
    assert!(out[30 * W + 40] > 80.0, "{}", out[30 * W + 40]);
}

#[test]
fn threads_do_not_matter() {
    let picture = noisy(8, 0.5, |x, y| 1.0 + ((x / 9 + y / 7) % 2) as f32);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filtered(&picture, None, &Features::default()))
    };
    let one = on(1);
    for threads in [2, 5] {
        let many = on(threads);
        assert!(one.iter().zip(&many).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn luminances_for_ratios_are_never_zero() {
    let features = Features::default();
    let half: Vec<f32> = (0..W * H).map(|i| if i % W < 40 { 0.0 } else { 1.0 }).collect();
    for picture in [vec![0.0; W * H], vec![f32::NAN; W * H], half] {
        let out = filter_luminance(&picture, &vec![0.0; W * H], &features, (W, H));
        assert!(out.iter().all(|v| *v > 0.0 && v.is_finite()));
    }
}
