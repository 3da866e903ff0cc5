//! Two eyes' pictures as one: side by side, or an anaglyph.

use crate::scene::stereo::Eyes;

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

/// What the left eye's linear colour gives to red, green and blue (Dubois, "A projection method to generate anaglyph
/// stereo images", ICASSP 2001: least squares in CIE XYZ through red and cyan glasses, for the primaries of sRGB).
const LEFT: [[f32; 3]; 3] = [
    [0.456_1, 0.500_484, 0.176_381],
    [-0.040_082_2, -0.037_824_6, -0.015_758_9],
    [-0.015_216_1, -0.020_597_1, -0.005_468_56],
];
/// What the right eye's gives.
const RIGHT: [[f32; 3]; 3] = [
    [-0.043_470_6, -0.087_938_8, -0.001_555_29],
    [0.378_476, 0.733_64, -0.018_450_3],
    [-0.072_152_7, -0.112_961, 1.226_4],
];

/// What the luma of the left eye gives to red, and that of the right eye to green and blue.
const GREY_LEFT: [[f32; 3]; 3] = [LUMA, [0.0; 3], [0.0; 3]];
const GREY_RIGHT: [[f32; 3]; 3] = [[0.0; 3], LUMA, LUMA];
/// Of linear sRGB.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// What an anaglyph keeps of the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glasses {
    /// As much as red and cyan glasses let through, with little of the other eye (Dubois).
    Coloured,
    /// Nothing: each eye has the luma, and none of the other eye's as far as the glasses hold.
    Grey,
}

impl Glasses {
    /// For which an anaglyph is made; none where it is not one.
    pub fn of(eyes: Eyes) -> Option<Self> {
        match eyes {
            Eyes::Anaglyph => Some(Self::Coloured),
            Eyes::GreyAnaglyph => Some(Self::Grey),
            _ => None,
        }
    }
}

/// A picture for a red glass before the left eye and a cyan one before the right.
pub fn anaglyph(left: &[[f32; 4]], right: &[[f32; 4]], glasses: Glasses) -> Vec<[f32; 4]> {
    let (of_left, of_right) = match glasses {
        Glasses::Coloured => (&LEFT, &RIGHT),
        Glasses::Grey => (&GREY_LEFT, &GREY_RIGHT),
    };
    let part = |matrix: &[[f32; 3]; 3], color: &[f32; 4], channel: usize| -> f32 {
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
