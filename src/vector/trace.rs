//! A picture of ink → the lines of a pen that draws it.
//!
//! ```text
//! ink ─ thin ─▶ lines of pixels ─ follow ─▶ chains ─ measure ─▶ polylines with widths
//! ```
//!
//! Marks that come from a texture are known as pixels alone, which are full of ink or darker than those to both sides
//! (ridges, by second differences as Steger 1998, "An unbiased detector of curvilinear structures"). They are thinned
//! to lines of one pixel (Guo and Hall 1989, "Parallel thinning with two-subiteration algorithms", which keeps oblique
//! lines of two pixels whole), these are followed, through crossings straight on, and each pixel of ink is given to the
//! nearest pixel of a line. So a line lies where the mean of its ink lies, between pixels, and is as wide as its ink by
//! its length: what is drawn has the ink of the picture, whatever its borders are.

mod follow;
mod measure;
mod thin;

use crate::lines::strokes::polylines::Polyline;

/// Ink by pixels, row by row: 0 none, 1 full.
#[derive(Clone, Debug)]
pub struct InkPicture {
    /// Width and height.
    pub size_px: [u32; 2],
    /// As many as there are pixels.
    pub ink: Vec<f32>,
}

impl InkPicture {
    fn width(&self) -> usize {
        self.size_px[0] as usize
    }
}

/// Ink of a dot.
const DOT: f32 = 0.35;

/// Dots that have the ink of a picture, in no order: round, as large as the marks that they stand for. They are lines
/// of hardly any length. Coordinates are pixels of this picture.
pub fn dots(picture: &InkPicture) -> Vec<Polyline> {
    let dots = thin::Mask::darker(picture, DOT).areas();
    measure::dots(picture, &dots)
}

/// Lines that have the ink of a picture, in no order; dots are lines of hardly any length. Coordinates are pixels of
/// this picture.
pub fn lines(picture: &InkPicture) -> Vec<Polyline> {
    let mask = thin::Mask::of(picture);
    let depth = mask.depth();
    let chains = follow::chains(&mask.thinned(), &depth);
    measure::polylines(picture, &chains)
}
