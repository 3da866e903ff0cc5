//! Traces an image of ink: finds lines that reproduce it when drawn with a pen.
//!
//! ```text
//! ink ─ thin ─▶ lines one pixel wide ─ follow ─▶ chains ─ measure ─▶ polylines with widths
//! ```
//!
//! Marks from a texture exist only as pixels. A pixel belongs to a mark if it is full of ink or darker than the pixels
//! on both sides (ridges, by second differences as in Steger 1998, "An unbiased detector of curvilinear structures").
//! The marks are thinned to lines one pixel wide (Guo and Hall 1989, "Parallel thinning with two-subiteration
//! algorithms", which preserves oblique lines of two pixels). The lines are followed, straight on through crossings,
//! and each pixel of ink is assigned to the nearest pixel of a line. A line then runs through the means of its ink,
//! with sub-pixel accuracy, and its width is its ink divided by its length. So the drawing has as much ink as the
//! image, whatever the borders of the marks.

mod follow;
mod measure;
mod thin;

use crate::lines::strokes::polylines::Polyline;

/// An image of ink, row by row: 0 is none, 1 is full.
#[derive(Clone, Debug)]
pub(crate) struct InkPicture {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Ink of each pixel, width × height values.
    pub ink: Vec<f32>,
}

impl InkPicture {
    fn width(&self) -> usize {
        self.size_px[0] as usize
    }
}

/// Least ink of a pixel of a dot.
const DOT: f32 = 0.35;

/// Traces an image of dots. Each dot becomes a very short line, round and with the ink of the mark that it replaces.
/// Coordinates are pixels of this image; the order is arbitrary.
pub(crate) fn dots(picture: &InkPicture) -> Vec<Polyline> {
    let dots = thin::Mask::darker(picture, DOT).areas();
    measure::dots(picture, &dots)
}

/// Traces an image of lines. Dots become very short lines. Coordinates are pixels of this image; the order is
/// arbitrary.
pub(crate) fn lines(picture: &InkPicture) -> Vec<Polyline> {
    let mask = thin::Mask::of(picture);
    let depth = mask.depth();
    let chains = follow::chains(&mask.thinned(), &depth);
    measure::polylines(picture, &chains)
}
