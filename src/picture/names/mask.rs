//! The letters of a label as pixels, for a window.

use glam::DVec2;

use super::{Ground, HALO, LEADER, LEADER_GAPS, LETTERS, Labels, halo};
use crate::lettering::Line;
use crate::picture::Band;
use crate::picture::title::Block;
use crate::style::Color;

/// Distance of a leader from its name and from its summit, in pixels of the style.
pub(crate) const LETTER_GAP: f64 = LEADER_GAPS[0];
/// Room for accents above capitals and for descenders below the base line, in heights of capitals.
const ROOM: [f64; 2] = [0.6, 0.5];

/// How much of each pixel the letters of a label cover, 0 to 1.
pub(crate) struct LetterMask {
    pub size_px: [u32; 2],
    pub ink: Vec<f32>,
    /// The letters with a margin around them.
    pub halo: Vec<f32>,
    /// Left end of the base line.
    pub origin_px: DVec2,
}

/// Returns the width of a leader, in pixels.
pub(crate) fn leader_px(px: f64) -> f64 {
    LEADER * px
}

/// Draws the letters of a label.
pub(crate) fn letter_mask(text: &str, ground: &Ground<'_>) -> LetterMask {
    let (px, height_px) = (ground.px, LETTERS[0] * ground.px);
    let line = Line::small(text, ground.paper.typeface);
    let margin_px = HALO * px + 2.0;
    let origin_px = DVec2::new(margin_px, margin_px + (1.0 + ROOM[0]) * height_px).ceil();
    let size = origin_px + DVec2::new(line.width() * height_px, ROOM[1] * height_px) + margin_px;
    let size_px = size.ceil().to_array().map(|side| side as u32);
    let mut drawn = Labels::default();
    drawn.write(&line, origin_px, height_px, px);
    let around = halo(&drawn.strokes, &drawn.areas, HALO * px);
    let white = Block::empty(Color::WHITE);
    let covered = |block: Block| {
        let picture = vec![[0.0; 4]; size_px[0] as usize * size_px[1] as usize];
        let mut band = Band { first_row: 0, rows: size_px[1], picture, planes: Vec::new() };
        block.draw(&mut band, size_px[0] as usize);
        band.picture.iter().map(|texel| texel[0]).collect()
    };
    let halo = covered(Block { strokes: around, ..white.clone() });
    let ink = covered(Block { strokes: drawn.strokes, areas: drawn.areas, ..white });
    LetterMask { size_px, ink, halo, origin_px }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::style::Style;

    #[test]
    fn letters_are_inside_of_their_pixels() {
        let paper = Style::load("pen").unwrap().paper;
        for px in [1.0, 1.5, 2.0] {
            let ground = Ground { area_px: [DVec2::ZERO, DVec2::splat(900.0)], paper: &paper, px };
            let mask = letter_mask("Ågjy 4\u{2009}478", &ground);
            let [width, height] = mask.size_px.map(|side| side as usize);
            let sum = |covered: &[f32]| covered.iter().sum::<f32>();
            assert!(sum(&mask.ink) > 30.0 && sum(&mask.halo) > 1.5 * sum(&mask.ink));
            let edge = |i: usize| [0, width - 1].contains(&(i % width)) || [0, height - 1].contains(&(i / width));
            let cut = |covered: &[f32]| (0..covered.len()).filter(|i| edge(*i)).any(|i| covered[i] > 0.0);
            assert!(!cut(&mask.ink) && !cut(&mask.halo), "{px}");
            // Planted: the letters are higher, and the upper ends of accents are cut off.
            let high: Vec<f32> = mask.ink[width * (height / 3)..].to_vec();
            assert!(high[..width].iter().any(|part| *part > 0.0));
        }
    }
}
