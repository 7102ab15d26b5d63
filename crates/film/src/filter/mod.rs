//! Reconstruction filters: how a sample's value spreads over the pixels around it.
//!
//! All are products f(x, y) = k(x; rₓ) k(y; r_y) of a kernel k that is even and zero beyond the
//! radius. Offsets are in pixels from the pixel's centre. Only ratios of f matter, as a pixel is
//! ∫ f L / ∫ f; [`FilterDesc::integral`] gives the denominator.

mod kernel;
mod sampler;

use std::fmt;
use std::str::FromStr;

use kaustika_math::Vec2;

pub use sampler::{FilterSample, FilterSampler};

/// A reconstruction filter and its parameters. Radii are half widths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterDesc {
    /// Constant inside the radius.
    Box {
        /// Half width along x and y; ½ covers the pixel exactly.
        radius: Vec2,
    },
    /// k(x) = 1 - |x|/r.
    Tent {
        /// Half width along x and y.
        radius: Vec2,
    },
    /// k(x) = exp(-x²/2σ²) - exp(-r²/2σ²): zero at the border (pbrt's and Mitsuba's form).
    Gaussian {
        /// Half width along x and y.
        radius: Vec2,
        /// Standard deviation in pixels before the offset.
        sigma: f32,
    },
    /// The piecewise cubics of Mitchell and Netravali (1988, "Reconstruction Filters in Computer
    /// Graphics", eq. 8), stretched so that their support [-2, 2] becomes [-r, r].
    /// B = C = ⅓ is their recommendation, B = 0 and C = ½ the Catmull-Rom spline.
    Mitchell {
        /// Half width along x and y; 2 is the unstretched cubic.
        radius: Vec2,
        /// Their B: blur.
        b: f32,
        /// Their C: ringing.
        c: f32,
    },
    /// k(x) = sinc(x) sinc(x/τ) with sinc(x) = sin(πx)/(πx), cut at the radius.
    Lanczos {
        /// Half width along x and y.
        radius: Vec2,
        /// Lobes of the windowing sinc on either side.
        tau: f32,
    },
}

impl FilterDesc {
    /// The box over one pixel.
    pub const BOX: FilterDesc = FilterDesc::Box { radius: Vec2::splat(0.5) };

    /// Mitsuba's tent, radius 1.
    pub const TENT: FilterDesc = FilterDesc::Tent { radius: Vec2::splat(1.0) };

    /// pbrt's default Gaussian: radius 1.5, σ = 0.5.
    pub const GAUSSIAN: FilterDesc = FilterDesc::Gaussian { radius: Vec2::splat(1.5), sigma: 0.5 };

    /// Mitchell and Netravali's recommendation, radius 2.
    pub const MITCHELL: FilterDesc =
        FilterDesc::Mitchell { radius: Vec2::splat(2.0), b: 1.0 / 3.0, c: 1.0 / 3.0 };

    /// The Catmull-Rom spline, radius 2.
    pub const CATMULL_ROM: FilterDesc =
        FilterDesc::Mitchell { radius: Vec2::splat(2.0), b: 0.0, c: 0.5 };

    /// Mitsuba's Lanczos filter, three lobes.
    pub const LANCZOS: FilterDesc = FilterDesc::Lanczos { radius: Vec2::splat(3.0), tau: 3.0 };

    /// Mitsuba's Gaussian of this standard deviation (its default is 0.5), cut at 4σ.
    pub const fn gaussian_of_stddev(sigma: f32) -> FilterDesc {
        FilterDesc::Gaussian { radius: Vec2::splat(4.0 * sigma), sigma }
    }

    /// Half width along x and y; f is zero beyond.
    pub fn radius(&self) -> Vec2 {
        match *self {
            FilterDesc::Box { radius }
            | FilterDesc::Tent { radius }
            | FilterDesc::Gaussian { radius, .. }
            | FilterDesc::Mitchell { radius, .. }
            | FilterDesc::Lanczos { radius, .. } => radius,
        }
    }

    /// f(x, y) at an offset from the pixel's centre; 1 at the centre of box and tent.
    pub fn evaluate(&self, offset: Vec2) -> f32 {
        let [kx, ky] = self.kernels();
        (kx.evaluate(offset.x as f64) * ky.evaluate(offset.y as f64)) as f32
    }

    /// ∫∫ f(x, y) dx dy, negative lobes counted as negative.
    pub fn integral(&self) -> f32 {
        let [kx, ky] = self.kernels();
        (kx.integral() * ky.integral()) as f32
    }

    /// The kernels along x and y.
    fn kernels(&self) -> [kernel::Kernel; 2] {
        let r = self.radius();
        [r.x, r.y].map(|radius| kernel::Kernel::new(self, radius))
    }

    /// What is wrong with the parameters, if anything: radii and widths must be positive and
    /// finite, and the integral positive (a filter that cancels itself divides by zero).
    pub fn defect(&self) -> Option<&'static str> {
        let positive = |v: f32| v > 0.0 && v.is_finite();
        let r = self.radius();
        if !positive(r.x) || !positive(r.y) {
            return Some("the filter's radius must be positive");
        }
        match *self {
            FilterDesc::Gaussian { sigma, .. } if !positive(sigma) => {
                Some("the Gaussian's standard deviation must be positive")
            }
            FilterDesc::Mitchell { b, c, .. } if !b.is_finite() || !c.is_finite() => {
                Some("the cubic's B and C must be finite")
            }
            FilterDesc::Lanczos { tau, .. } if !positive(tau) => {
                Some("the number of lobes must be positive")
            }
            _ if self.integral() > 0.0 => None,
            _ => Some("the filter's integral is not positive"),
        }
    }
}

/// The filter from `name[:radius[,parameters]]`: `box`, `tent:2`, `gaussian:1.5,0.5`
/// (radius, σ), `mitchell:2,0.333,0.333` (radius, B, C), `catmullrom`, `lanczos:3,3`
/// (radius, τ). `triangle` and `sinc` are pbrt's names with pbrt's defaults.
impl FromStr for FilterDesc {
    type Err = FilterParseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let error = |cause: String| FilterParseError { text: text.into(), cause };
        let (name, list) = text.split_once(':').unwrap_or((text, ""));
        let mut numbers = Vec::new();
        for word in list.split(',').filter(|_| !list.is_empty()) {
            let not_a_number = |_| error(format!("'{}' is not a number", word.trim()));
            numbers.push(word.trim().parse::<f32>().map_err(not_a_number)?);
        }
        // The longest list of parameters each name takes.
        let mut parameters = numbers.iter().copied();
        let mut next = |default: f32| parameters.next().unwrap_or(default);
        let square = Vec2::splat;
        let desc = match name.trim().to_ascii_lowercase().as_str() {
            "box" => FilterDesc::Box { radius: square(next(0.5)) },
            "tent" => FilterDesc::Tent { radius: square(next(1.0)) },
            "triangle" => FilterDesc::Tent { radius: square(next(2.0)) },
            "gaussian" => FilterDesc::Gaussian { radius: square(next(1.5)), sigma: next(0.5) },
            "mitchell" => FilterDesc::Mitchell {
                radius: square(next(2.0)),
                b: next(1.0 / 3.0),
                c: next(1.0 / 3.0),
            },
            "catmullrom" | "catmull-rom" => {
                FilterDesc::Mitchell { radius: square(next(2.0)), b: 0.0, c: 0.5 }
            }
            "lanczos" => FilterDesc::Lanczos { radius: square(next(3.0)), tau: next(3.0) },
            "sinc" => FilterDesc::Lanczos { radius: square(next(4.0)), tau: next(3.0) },
            _ => {
                let known = "box, tent, triangle, gaussian, mitchell, catmullrom, lanczos, sinc";
                return Err(error(format!("the filters are {known}")));
            }
        };
        if parameters.next().is_some() {
            return Err(error("too many parameters".into()));
        }
        match desc.defect() {
            None => Ok(desc),
            Some(defect) => Err(error(defect.into())),
        }
    }
}

/// Writes what [`FromStr`] reads; of unequal radii only that along x.
impl fmt::Display for FilterDesc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let r = self.radius().x;
        match self {
            FilterDesc::Box { .. } => write!(f, "box:{r}"),
            FilterDesc::Tent { .. } => write!(f, "tent:{r}"),
            FilterDesc::Gaussian { sigma, .. } => write!(f, "gaussian:{r},{sigma}"),
            FilterDesc::Mitchell { b, c, .. } => write!(f, "mitchell:{r},{b},{c}"),
            FilterDesc::Lanczos { tau, .. } => write!(f, "lanczos:{r},{tau}"),
        }
    }
}

/// Why a text is no filter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{text}' is no filter: {cause}")]
pub struct FilterParseError {
    text: String,
    cause: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_filters_and_back() {
        for (text, desc) in [
            ("box", FilterDesc::BOX),
            ("tent:1", FilterDesc::TENT),
            ("Gaussian:1.5", FilterDesc::GAUSSIAN),
            ("gaussian:2, 0.5", FilterDesc::gaussian_of_stddev(0.5)),
            ("mitchell", FilterDesc::MITCHELL),
            ("catmullrom", FilterDesc::CATMULL_ROM),
            ("lanczos", FilterDesc::LANCZOS),
        ] {
            assert_eq!(text.parse(), Ok(desc));
            assert_eq!(desc.to_string().parse(), Ok(desc));
        }
        for (text, message) in [
            (
                "boxx",
                "'boxx' is no filter: the filters are box, tent, triangle, gaussian, mitchell, catmullrom, lanczos, sinc",
            ),
            ("box:a", "'box:a' is no filter: 'a' is not a number"),
            ("box:1,2", "'box:1,2' is no filter: too many parameters"),
            ("tent:0", "'tent:0' is no filter: the filter's radius must be positive"),
            (
                "gaussian:1,-1",
                "'gaussian:1,-1' is no filter: the Gaussian's standard deviation must be positive",
            ),
        ] {
            let error = text.parse::<FilterDesc>().unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }

    #[test]
    fn known_values() {
        let at = |text: &str, x: f32, y: f32| {
            text.parse::<FilterDesc>().unwrap().evaluate(Vec2::new(x, y))
        };
        let near = |a: f32, b: f64| assert!((a as f64 - b).abs() < 1e-6, "{a} {b}");
        near(at("box", 0.4, -0.4), 1.0);
        near(at("tent:2", 0.5, -1.0), 0.75 * 0.5);
        near(at("gaussian:1.5,0.5", 0.5, 0.0), {
            let border = (-4.5f64).exp();
            ((-0.5f64).exp() - border) * (1.0 - border)
        });
        // Mitchell-Netravali with B = C = 1/3: 8/9 at 0, 1/18 at 1; Catmull-Rom interpolates.
        near(at("mitchell", 0.0, 1.0), 8.0 / 9.0 / 18.0);
        near(at("mitchell:4", 0.0, 2.0), 8.0 / 9.0 / 18.0);
        near(at("catmullrom", 0.0, 0.0), 1.0);
        near(at("catmullrom", 1.0, 0.0), 0.0);
        near(at("catmullrom", 1.5, 0.0), -1.0 / 16.0);
        // sinc(1/2) sinc(1/6) = 2/π · 3/π.
        near(at("lanczos", 0.5, 0.0), 6.0 / std::f64::consts::PI.powi(2));
        near(at("sinc", 3.5, 0.0), {
            let (a, b) = (3.5 * std::f64::consts::PI, 3.5 / 3.0 * std::f64::consts::PI);
            a.sin() / a * b.sin() / b
        });
    }

    #[test]
    fn zero_beyond_the_radius_and_normalised() {
        for text in FILTERS {
            let filter: FilterDesc = text.parse().unwrap();
            let r = filter.radius();
            for far in [1.0001, 1.5, 10.0] {
                assert_eq!(filter.evaluate(Vec2::new(far * r.x, 0.0)), 0.0, "{text}");
                assert_eq!(filter.evaluate(Vec2::new(0.0, -far * r.y)), 0.0, "{text}");
            }
            // Midpoint rule over the support.
            let n = 400;
            let at = |i: usize, r: f32| ((i as f32 + 0.5) / n as f32 * 2.0 - 1.0) * r;
            let values =
                (0..n * n).map(|i| filter.evaluate(Vec2::new(at(i % n, r.x), at(i / n, r.y))));
            let sum: f64 = values.map(|v| v as f64).sum();
            let integral = sum * (4.0 * r.x * r.y) as f64 / (n * n) as f64;
            let relative = filter.integral() as f64 / integral;
            assert!((relative - 1.0).abs() < 1e-4, "{text}: {relative}");
        }
    }

    /// One of each kind, and stretched ones.
    pub(super) const FILTERS: &[&str] = &[
        "box",
        "box:2",
        "tent",
        "triangle",
        "gaussian",
        "gaussian:2,0.5",
        "mitchell",
        "mitchell:1.5,0,1",
        "catmullrom",
        "lanczos",
        "sinc",
    ];
}
