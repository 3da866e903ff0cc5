//! Anaglyphs: two eyes in the same pixels, for a red glass before the left eye and a cyan one before the right.

use super::stereo::Eyes;

/// A 3 × 3 matrix; its rows give linear red, green and blue.
pub(crate) type Mix = [[f32; 3]; 3];

/// How an anaglyph treats colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Glasses {
    /// Coloured: as much colour as red-cyan glasses let through, with little crosstalk (Dubois).
    Coloured,
    /// Greyscale: each eye sees the luma of its picture, without crosstalk as far as the glasses separate the colours.
    Grey,
}

/// Contribution of the left eye's linear colour to red, green and blue (Dubois, "A projection method to generate
/// anaglyph stereo images", ICASSP 2001: least squares in CIE XYZ through red and cyan glasses, for the sRGB
/// primaries).
const LEFT: Mix = [
    [0.456_1, 0.500_484, 0.176_381],
    [-0.040_082_2, -0.037_824_6, -0.015_758_9],
    [-0.015_216_1, -0.020_597_1, -0.005_468_56],
];
/// Contribution of the right eye's linear colour.
const RIGHT: Mix = [
    [-0.043_470_6, -0.087_938_8, -0.001_555_29],
    [0.378_476, 0.733_64, -0.018_450_3],
    [-0.072_152_7, -0.112_961, 1.226_4],
];
/// Weights of luma for linear sRGB.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// The left eye's luma goes to red, the right eye's to green and blue.
const GREY_LEFT: Mix = [LUMA, [0.0; 3], [0.0; 3]];
const GREY_RIGHT: Mix = [[0.0; 3], LUMA, LUMA];

impl Glasses {
    /// Returns the kind of anaglyph for a choice of eyes; `None` if it is not an anaglyph.
    pub(crate) fn of(eyes: Eyes) -> Option<Self> {
        match eyes {
            Eyes::Anaglyph => Some(Self::Coloured),
            Eyes::GreyAnaglyph => Some(Self::Grey),
            _ => None,
        }
    }

    /// Returns the matrices of the left eye's and the right eye's colour.
    pub(crate) fn mixes(self) -> [&'static Mix; 2] {
        match self {
            Self::Coloured => [&LEFT, &RIGHT],
            Self::Grey => [&GREY_LEFT, &GREY_RIGHT],
        }
    }
}
