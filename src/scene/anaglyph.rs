//! Two eyes in the same pixels, for a red glass before the left eye and a cyan one before the right.

use super::stereo::Eyes;

/// Rows that give red, green and blue of linear colour.
pub type Mix = [[f32; 3]; 3];

/// What an anaglyph keeps of the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glasses {
    /// As much as red and cyan glasses let through, with little of the other eye (Dubois).
    Coloured,
    /// Nothing: each eye has the luma, and none of the other eye's as far as the glasses hold.
    Grey,
}

/// What the left eye's linear colour gives to red, green and blue (Dubois, "A projection method to generate anaglyph
/// stereo images", ICASSP 2001: least squares in CIE XYZ through red and cyan glasses, for the primaries of sRGB).
const LEFT: Mix = [
    [0.456_1, 0.500_484, 0.176_381],
    [-0.040_082_2, -0.037_824_6, -0.015_758_9],
    [-0.015_216_1, -0.020_597_1, -0.005_468_56],
];
/// What the right eye's gives.
const RIGHT: Mix = [
    [-0.043_470_6, -0.087_938_8, -0.001_555_29],
    [0.378_476, 0.733_64, -0.018_450_3],
    [-0.072_152_7, -0.112_961, 1.226_4],
];
/// Of linear sRGB.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// What the luma of the left eye gives to red, and that of the right eye to green and blue.
const GREY_LEFT: Mix = [LUMA, [0.0; 3], [0.0; 3]];
const GREY_RIGHT: Mix = [[0.0; 3], LUMA, LUMA];

impl Glasses {
    /// For which an anaglyph is made; none where it is not one.
    pub fn of(eyes: Eyes) -> Option<Self> {
        match eyes {
            Eyes::Anaglyph => Some(Self::Coloured),
            Eyes::GreyAnaglyph => Some(Self::Grey),
            _ => None,
        }
    }

    /// What the left eye's colour and the right eye's give to the picture.
    pub fn mixes(self) -> [&'static Mix; 2] {
        match self {
            Self::Coloured => [&LEFT, &RIGHT],
            Self::Grey => [&GREY_LEFT, &GREY_RIGHT],
        }
    }
}
