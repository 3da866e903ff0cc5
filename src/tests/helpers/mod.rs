//! Helpers of the tests of drawing, as `common`, but with private items of the library.

pub mod forest;
pub mod probe;
pub mod shapes;
pub mod stroke_lines;
pub mod styles;
pub mod tones;
