//! Two eyes' pictures as one: side by side, or an anaglyph.

use super::Band;
use crate::scene::anaglyph::{Glasses, Mix};
use crate::scene::stereo::Eyes;

/// What is shown of the bands of a pair: those of the eyes that are asked for, those of an anaglyph as one.
pub fn shown(eyes: Eyes, bands: Vec<Band>) -> Vec<Band> {
    let asked = bands.into_iter().enumerate().filter(|(eye, _)| eyes.of_pair().contains(eye));
    let mut asked: Vec<_> = asked.map(|(_, band)| band).collect();
    if let (Some(glasses), [left, right]) = (Glasses::of(eyes), asked.as_mut_slice()) {
        left.picture = anaglyph(&left.picture, &right.picture, glasses);
        asked.truncate(1);
    }
    asked
}

/// The rows of one eye, or of two side by side, as those of one picture of `width` pixels.
pub fn joined(width: u32, mut bands: Vec<Band>) -> Vec<[f32; 4]> {
    match bands.as_mut_slice() {
        [left, right] => side_by_side(&left.picture, &right.picture, width / 2),
        [band, ..] => std::mem::take(&mut band.picture),
        [] => Vec::new(),
    }
}

/// Rows of `width` pixels: the left eye's on the left of the right eye's.
pub fn side_by_side<T: Copy>(left: &[T], right: &[T], width: u32) -> Vec<T> {
    let width = width as usize;
    left.chunks_exact(width)
        .zip(right.chunks_exact(width))
        .flat_map(|(left, right)| [left, right])
        .flatten()
        .copied()
        .collect()
}

/// A picture for a red glass before the left eye and a cyan one before the right.
pub fn anaglyph(left: &[[f32; 4]], right: &[[f32; 4]], glasses: Glasses) -> Vec<[f32; 4]> {
    let [of_left, of_right] = glasses.mixes();
    let part = |matrix: &Mix, color: &[f32; 4], channel: usize| -> f32 {
        matrix[channel].iter().zip(color).map(|(weight, value)| weight * value).sum()
    };
    let merged = |(left, right): (&[f32; 4], &[f32; 4])| {
        let channel = |i: usize| (part(of_left, left, i) + part(of_right, right, i)).clamp(0.0, 1.0);
        [channel(0), channel(1), channel(2), left[3].max(right[3])]
    };
    left.iter().zip(right).map(merged).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_eye_has_its_half() {
        assert_eq!(side_by_side(&[1, 2, 3, 4], &[5, 6, 7, 8], 2), [1, 2, 5, 6, 3, 4, 7, 8]);
    }

    #[test]
    fn white_stays_white_and_each_glass_passes_one_eye() {
        for glasses in [Glasses::Coloured, Glasses::Grey] {
            passes_one_eye(glasses);
        }
    }

    fn passes_one_eye(glasses: Glasses) {
        let (white, black) = ([[1.0_f32; 4]], [[0.0, 0.0, 0.0, 1.0]]);
        let both = anaglyph(&white, &white, glasses)[0];
        assert!(both[..3].iter().all(|value| (value - 1.0).abs() < 0.01), "{both:?}");
        // A line that only the left eye has is dark where red passes, and nowhere else; and the other way round.
        let left = anaglyph(&black, &white, glasses)[0];
        assert!(left[0] < 0.05 && left[1] > 0.95 && left[2] > 0.95, "{left:?}");
        let right = anaglyph(&white, &black, glasses)[0];
        assert!(right[0] > 0.95 && right[1] < 0.05 && right[2] < 0.05, "{right:?}");
    }
}
