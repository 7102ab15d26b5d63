//! Points that fill the unit square evenly, the same in every run.

use kaustika_math::Vec2;
use kaustika_sampling::hash::{halves, unit};

/// Point `i` of the additive recurrence by the plastic number (Roberts 2018).
pub fn r2(i: u32) -> Vec2 {
    // 2³² / g and 2³² / g², g = 1.3247...
    let turn = |step: u32| unit(step.wrapping_mul(i).wrapping_add(1 << 31));
    Vec2::new(turn(3_242_174_889), turn(2_447_445_414))
}

/// A point shifted around the square by a well-mixed key (Cranley & Patterson 1976).
pub fn rotated(u: Vec2, key: u64) -> Vec2 {
    let (x, y) = halves(key);
    let around = |a: f32, b: f32| if a + b < 1.0 { a + b } else { a + b - 1.0 };
    let inside = |x: f32| x.clamp(0.0, kaustika_math::ONE_MINUS_EPSILON);
    Vec2::new(inside(around(u.x, unit(x))), inside(around(u.y, unit(y))))
}
