//! How much light comes back from a half space of scattering matter under a smooth dielectric
//! boundary, and which matter gives back a share that is asked for.
//!
//! ```text
//! 1/H(μ) = √(1-α) + (α/2) ∫₀¹ ν H(ν) / (μ + ν) dν                                (1)
//! U(μ)   = (α/2) H(μ) ∫₀¹ ν H(ν) D(ν) / (μ + ν) dν                              (2)
//! D(μ)   = E(μ) + F(μ) U(μ)                                                      (3)
//! A      = ∫₀¹ (1 - F) U μ dμ / ∫₀¹ E μ dμ                                       (4)
//! α'     = α (1 - g) / (1 - α g)                                                 (5)
//! ```
//!
//! D is the radiance going down below the boundary, U that going up, E what has just entered: even
//! light from all directions outside, refracted; F is the boundary's reflectance from below. (1) and
//! (2) are exact for isotropic scattering (Chandrasekhar 1960, "Radiative transfer", ch. V, with
//! Ψ = α/2; light of all azimuths). (5) is the similarity relation (van de Hulst 1980, "Multiple
//! light scattering", ch. 14), close to the truth for other g.

/// Nodes of each quadrature.
const NODES: usize = 24;

/// The single-scattering albedo α with which a half space of index `eta` and mean cosine `g` gives
/// back the share `reflectance` of the light that has entered it, under even light. In [0, 1].
pub(crate) fn albedo_for(reflectance: f32, eta: f32, g: f32) -> f32 {
    if reflectance >= 1.0 {
        return 1.0;
    }
    let boundary = Boundary::new(f64::from(eta));
    let (mut low, mut high) = (0.0, 1.0);
    // Until the last bit of single precision.
    for _ in 0..32 {
        let middle = 0.5 * (low + high);
        if boundary.reflectance(middle) < f64::from(reflectance) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (reduced, g) = (0.5 * (low + high), f64::from(g));
    (reduced / (1.0 - g + reduced * g)) as f32 // (5)
}

/// A direction below the boundary.
#[derive(Clone, Copy)]
struct Node {
    /// Cosine.
    mu: f64,
    /// Weight in ∫ dμ.
    weight: f64,
    /// F(μ).
    reflected: f64,
    /// E(μ), of any unit.
    entered: f64,
}

/// The boundary by the directions below it.
struct Boundary(Vec<Node>);

impl Boundary {
    /// Of an index of refraction, at least 1.
    fn new(eta: f64) -> Boundary {
        let eta = eta.max(1.0);
        let critical = (1.0 - 1.0 / (eta * eta)).sqrt();
        // Below the critical angle's cosine all is reflected and nothing enters.
        let total = gauss().map(|(x, w)| Node {
            mu: critical * x,
            weight: critical * w,
            reflected: 1.0,
            entered: 0.0,
        });
        // Above it by the cosine outside: μ dμ = x dx / η².
        let open = gauss().map(|(x, w)| {
            let mu = (1.0 - (1.0 - x * x) / (eta * eta)).sqrt();
            let reflected = fresnel(x, mu, eta);
            Node { mu, weight: w * x / (eta * eta * mu), reflected, entered: 1.0 - reflected }
        });
        let total = total.filter(|n| n.mu > 0.0);
        Boundary(total.chain(open).collect())
    }

    /// (4) for isotropic scattering of albedo `alpha`.
    fn reflectance(&self, alpha: f64) -> f64 {
        let nodes = &self.0;
        let h = self.h_function(alpha);
        let mut up = vec![0.0; nodes.len()];
        // What goes down comes back weakened, at least by what leaves: the series converges.
        for _ in 0..400 {
            let down: Vec<f64> =
                nodes.iter().zip(&up).map(|(n, u)| n.entered + n.reflected * u).collect(); // (3)
            let scattered = |i: usize| {
                let sum: f64 = nodes
                    .iter()
                    .zip(&h)
                    .zip(&down)
                    .map(|((n, h), d)| n.weight * n.mu * h * d / (nodes[i].mu + n.mu))
                    .sum();
                0.5 * alpha * h[i] * sum // (2)
            };
            let next: Vec<f64> = (0..nodes.len()).map(scattered).collect();
            let change = next.iter().zip(&up).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            up = next;
            if change < 1e-12 {
                break;
            }
        }
        let flux = |f: &dyn Fn(usize) -> f64| -> f64 {
            nodes.iter().enumerate().map(|(i, n)| n.weight * n.mu * f(i)).sum()
        };
        flux(&|i| (1.0 - nodes[i].reflected) * up[i]) / flux(&|i| nodes[i].entered)
    }

    /// (1), by iteration.
    fn h_function(&self, alpha: f64) -> Vec<f64> {
        let nodes = &self.0;
        let mut h = vec![1.0; nodes.len()];
        for _ in 0..1000 {
            let next: Vec<f64> = nodes
                .iter()
                .map(|at| {
                    let sum: f64 = nodes
                        .iter()
                        .zip(&h)
                        .map(|(n, h)| n.weight * n.mu * h / (at.mu + n.mu))
                        .sum();
                    1.0 / ((1.0 - alpha).sqrt() + 0.5 * alpha * sum)
                })
                .collect();
            // The mean of two steps: single ones swing about the answer where α is near 1.
            let mut change = 0.0f64;
            for (h, next) in h.iter_mut().zip(next) {
                change = change.max((next - *h).abs());
                *h = 0.5 * (*h + next);
            }
            if change < 1e-11 {
                break;
            }
        }
        h
    }
}

/// Reflectance of unpolarized light whose cosines are `outside` and `inside` (Fresnel 1823).
fn fresnel(outside: f64, inside: f64, eta: f64) -> f64 {
    let s = (outside - eta * inside) / (outside + eta * inside);
    let p = (eta * outside - inside) / (eta * outside + inside);
    0.5 * (s * s + p * p)
}

/// Nodes and weights of Gauss's quadrature on [0, 1] (Newton's steps to the zeros of Legendre's
/// polynomial).
fn gauss() -> impl Iterator<Item = (f64, f64)> {
    (0..NODES).map(|i| {
        let n = NODES as f64;
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut before) = (1.0, 0.0);
            for k in 0..NODES {
                let k = k as f64;
                (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedos_without_a_boundary_are_the_known_ones() {
        // van de Hulst's fit of the spherical albedo, s = √(1-α): within 0.003.
        let matched = Boundary::new(1.0);
        for alpha in [0.0f64, 0.2, 0.5, 0.8, 0.9, 0.99, 0.999, 1.0] {
            let s = (1.0 - alpha).sqrt();
            let fit = (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
            let found = matched.reflectance(alpha);
            assert!((found - fit).abs() < 3e-3, "{alpha}: {found}, expected {fit}");
        }
        // H(1) of white matter is 2.9078 (Chandrasekhar 1960, table XI).
        let last = matched.h_function(1.0);
        let largest = last.iter().cloned().fold(0.0, f64::max);
        assert!((2.88..2.9078).contains(&largest), "{largest}");
    }

    #[test]
    fn white_matter_gives_all_back_and_black_matter_nothing() {
        for eta in [1.0, 1.33, 1.5, 2.4] {
            let boundary = Boundary::new(eta);
            assert!((boundary.reflectance(1.0) - 1.0).abs() < 1e-3, "{eta}");
            assert_eq!(boundary.reflectance(0.0), 0.0);
        }
        assert_eq!(albedo_for(1.0, 1.33, 0.0), 1.0);
        assert!(albedo_for(0.0, 1.33, 0.0) < 1e-6);
    }

    #[test]
    fn inverses_are_inverse() {
        for eta in [1.0f32, 1.33, 1.6] {
            for r in [0.05f32, 0.3, 0.5, 0.8, 0.95] {
                let alpha = albedo_for(r, eta, 0.0);
                let back = Boundary::new(f64::from(eta)).reflectance(f64::from(alpha));
                assert!((back as f32 - r).abs() < 1e-5, "{eta} {r}: {back}");
                // The same reduced coefficients.
                let g = 0.7;
                let forward = albedo_for(r, eta, g);
                assert!((forward * (1.0 - g) / (1.0 - forward * g) - alpha).abs() < 1e-5);
            }
        }
    }

    /// The matter that `transport/tests/proofs/subsurface.rs` walks through at random.
    #[test]
    fn the_matter_that_is_measured() {
        assert!((albedo_for(0.5, 1.33, 0.0) - MEASURED).abs() < 1e-5);
    }

    const MEASURED: f32 = 0.970_500_8;
}
