//! Numbers for events of which nobody knows how many there will be.

use kaustika_sampling::hash::{combine, nth, unit};

/// Numbers in [0, 1) that depend on a few others.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    key: u64,
    drawn: u32,
}

impl Stream {
    /// The stream that belongs to these numbers.
    pub fn new(numbers: &[f32]) -> Stream {
        let key = numbers.iter().fold(0, |key, u| combine(key, u64::from(u.to_bits())));
        Stream { key, drawn: 0 }
    }

    /// The next number.
    #[inline]
    pub fn draw(&mut self) -> f32 {
        self.drawn = self.drawn.wrapping_add(1);
        unit((nth(self.key, self.drawn) >> 32) as u32)
    }

    /// An optical distance with density e⁻ˣ.
    #[inline]
    pub fn distance(&mut self) -> f32 {
        optical_distance(self.draw())
    }
}

/// The optical distance that `u` stands for, with density e⁻ˣ.
#[inline]
pub fn optical_distance(u: f32) -> f32 {
    -(-u).ln_1p()
}
