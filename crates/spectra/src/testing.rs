//! Random numbers for tests.

/// PCG-XSH-RR 64/32 (O'Neill 2014).
pub struct Pcg(pub u64);

impl Pcg {
    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f32 {
        let s = self.0;
        self.0 = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let x = (((s >> 18) ^ s) >> 27) as u32;
        (x.rotate_right((s >> 59) as u32) >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Three of them.
    pub fn rgb(&mut self) -> [f32; 3] {
        [self.uniform(), self.uniform(), self.uniform()]
    }
}
