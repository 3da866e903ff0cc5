//! Colours of trees: palettes that the corners of a tree index.
//!
//! The palettes supply hues only. The lightness of a tree is the same in every style; a style with colours takes from
//! the palette how a surface of that lightness is coloured.

use super::model::TreeModel;
use super::species::{Grown, Part};
use crate::mesh::linear_from_srgb;
use crate::scene::forest::Species;

/// Red, green and blue in linear light, 0 to 1.
pub(crate) type Color = [f32; 3];

/// Default colours of leaves and bark of each species, in sRGB.
const CONIFER: [u32; 2] = [0x45_60_4e, 0x6b_50_3f];
const BROADLEAF: [u32; 2] = [0x5f_80_38, 0x66_55_44];
const BIRCH: [u32; 2] = [0x98_a8_48, 0xf0_ed_e6];
const SNAG: [u32; 2] = [0x8d_89_83, 0x8d_89_83];

/// Returns the palette index of a part of a generated species.
pub(crate) fn color_index_of(part: Part) -> u8 {
    match part {
        Part::Leaf => 0,
        Part::Bark => 1,
    }
}

/// Returns the palette of a generated species: leaves, bark.
pub(crate) fn of_grown(grown: Grown, species: &Species) -> Vec<Color> {
    let [leaf, bark] = own(grown);
    vec![species.color_srgb.map_or(leaf, linear), species.bark_srgb.map_or(bark, linear)]
}

/// Returns the palette of a model: its materials, then its canopy. Materials without a colour get the colour of leaves,
/// by default those of the generated species with the most similar outline.
pub(crate) fn of_model(model: &TreeModel, species: &Species) -> Vec<Color> {
    let leaf = species.color_srgb.map_or(own(model.clump)[0], linear);
    let mut palette: Vec<Color> = model.colors.iter().map(|color| color.unwrap_or(leaf)).collect();
    let mut canopy = [0.0; 3];
    for (color, share) in palette.iter().zip(&model.crown) {
        for (sum, channel) in canopy.iter_mut().zip(color) {
            *sum += *share as f32 * channel;
        }
    }
    palette.push(canopy);
    palette
}

fn own(grown: Grown) -> [Color; 2] {
    let pair = match grown {
        Grown::Conifer => CONIFER,
        Grown::Broadleaf => BROADLEAF,
        Grown::Birch => BIRCH,
        Grown::Snag => SNAG,
    };
    pair.map(|srgb| linear([16, 8, 0].map(|shift| (srgb >> shift & 0xff) as f32 / 255.0)))
}

fn linear(srgb: Color) -> Color {
    srgb.map(|value| linear_from_srgb(f64::from(value)) as f32)
}
