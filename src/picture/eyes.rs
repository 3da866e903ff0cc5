//! Combines the pictures of a stereo pair: side by side, or as an anaglyph.

use super::Band;
use crate::scene::anaglyph::{Glasses, Mix};
use crate::scene::stereo::Eyes;

/// Selects the bands of the requested eyes of a stereo pair; an anaglyph merges both into one.
pub(crate) fn shown(eyes: Eyes, bands: Vec<Band>) -> Vec<Band> {
    let asked = bands.into_iter().enumerate().filter(|(eye, _)| eyes.of_pair().contains(eye));
    let mut asked: Vec<_> = asked.map(|(_, band)| band).collect();
    if let (Some(glasses), [left, right]) = (Glasses::of(eyes), asked.as_mut_slice()) {
        left.picture = anaglyph(&left.picture, &right.picture, glasses);
        asked.truncate(1);
    }
    asked
}

/// Returns the rows of one eye, or of two side by side, as rows of one picture of `width` pixels.
pub(crate) fn joined(width: u32, mut bands: Vec<Band>) -> Vec<[f32; 4]> {
    match bands.as_mut_slice() {
        [left, right] => side_by_side(&left.picture, &right.picture, width / 2),
        [band, ..] => std::mem::take(&mut band.picture),
        [] => Vec::new(),
    }
}

/// Joins rows of `width` pixels each: those of the left eye on the left, those of the right eye on the right.
pub(crate) fn side_by_side<T: Copy>(left: &[T], right: &[T], width: u32) -> Vec<T> {
    let width = width as usize;
    left.chunks_exact(width)
        .zip(right.chunks_exact(width))
        .flat_map(|(left, right)| [left, right])
        .flatten()
        .copied()
        .collect()
}

/// Returns an anaglyph for glasses with a red filter for the left eye and a cyan one for the right.
pub(crate) fn anaglyph(left: &[[f32; 4]], right: &[[f32; 4]], glasses: Glasses) -> Vec<[f32; 4]> {
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
        // A line of the left eye alone is dark only in the red channel, one of the right eye only in the others.
        let left = anaglyph(&black, &white, glasses)[0];
        assert!(left[0] < 0.05 && left[1] > 0.95 && left[2] > 0.95, "{left:?}");
        let right = anaglyph(&white, &black, glasses)[0];
        assert!(right[0] > 0.95 && right[1] < 0.05 && right[2] < 0.05, "{right:?}");
    }
}
