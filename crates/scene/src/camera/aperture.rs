//! Forms of a lens's opening.

use crate::description::ApertureShape;
use crate::texture::ImageMap;
use kaustika_math::Vec2;
use kaustika_spectra::ColorSpace;
use std::f32::consts::PI;

/// Samples along a side that the scale is found with.
const SIDE: u32 = 256;

/// What a place of the opening lets through.
#[derive(Debug)]
pub struct Aperture {
    form: Form,
    /// So that the mean over the square is that of a disc, π/4.
    scale: f32,
}

#[derive(Debug)]
enum Form {
    Gaussian,
    Square,
    /// Corners.
    Polygon(Vec<Vec2>),
    Image(ImageMap),
}

impl Aperture {
    /// Prepares a description; `None` where it lets nothing through.
    pub fn new(desc: &ApertureShape) -> Option<Aperture> {
        let on_circle = |turn: f32, r: f32| {
            let (s, c) = (2.0 * PI * turn).sin_cos();
            Vec2::new(r * c, r * s)
        };
        let form = match desc {
            ApertureShape::Gaussian => Form::Gaussian,
            ApertureShape::Square => Form::Square,
            ApertureShape::Pentagon => {
                Form::Polygon((0..5).map(|i| on_circle(0.25 + 0.2 * i as f32, 0.8)).collect())
            }
            ApertureShape::Star => {
                // Where the sides of a pentagram cross.
                let inner = (0.4 * PI).cos() / (0.2 * PI).cos();
                let r = |i| if i % 2 == 1 { 1.0 } else { inner };
                Form::Polygon((0..10).map(|i| on_circle(0.1 * i as f32, r(i))).collect())
            }
            ApertureShape::Image(bitmap) => Form::Image(ImageMap::new(bitmap, ColorSpace::Srgb)),
        };
        let mut aperture = Aperture { form, scale: 1.0 };
        let at = |i: u32| 2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0;
        let sum: f64 = (0..SIDE * SIDE)
            .map(|i| f64::from(aperture.transmittance(Vec2::new(at(i % SIDE), at(i / SIDE)))))
            .sum();
        let mean = sum / f64::from(SIDE * SIDE);
        aperture.scale = (f64::from(0.25 * PI) / mean) as f32;
        (mean > 0.0).then_some(aperture)
    }

    /// What the place `p` of [-1, 1]² lets through; on average π/4. Pictures stand upside down, as
    /// pbrt has them.
    pub fn transmittance(&self, p: Vec2) -> f32 {
        let p = Vec2::new(p.x, -p.y);
        let value = match &self.form {
            Form::Gaussian => ((-p.dot(p)).exp() - (-1.0f32).exp()).max(0.0),
            Form::Square => f32::from(u8::from(p.x.abs().max(p.y.abs()) < 0.5)),
            Form::Polygon(corners) => f32::from(u8::from(inside(corners, p))),
            Form::Image(image) => {
                let [r, g, b] = image.bilinear(Vec2::new(0.5 * (p.x + 1.0), 0.5 * (p.y + 1.0)));
                (r + g + b) / 3.0
            }
        };
        value * self.scale
    }
}

/// True if a line from `p` to the right crosses the outline an odd number of times.
fn inside(corners: &[Vec2], p: Vec2) -> bool {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = |(a, b): &(&Vec2, &Vec2)| {
        (a.y <= p.y) != (b.y <= p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    sides.filter(crossed).count() % 2 == 1
}
