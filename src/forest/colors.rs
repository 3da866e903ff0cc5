//! The colours that trees have of their own: palettes, which the corners of a tree number.
//!
//! What is here are hues. How light a tree is says its lightness, in every style; a style that wants colours takes from
//! these how what is so light is coloured.

use super::model::TreeModel;
use super::species::{Grown, Part};
use crate::mesh::linear_from_srgb;
use crate::scene::forest::Species;

/// Red, green and blue in linear light, 0 to 1.
pub type Color = [f32; 3];

/// What leaves and bark of a species have, unless a scene says otherwise; in sRGB.
const CONIFER: [u32; 2] = [0x45_60_4e, 0x6b_50_3f];
const BROADLEAF: [u32; 2] = [0x5f_80_38, 0x66_55_44];
const BIRCH: [u32; 2] = [0x98_a8_48, 0xf0_ed_e6];
const SNAG: [u32; 2] = [0x8d_89_83, 0x8d_89_83];

/// The number of a part in the palette of a species that is grown.
pub fn paint_of(part: Part) -> u8 {
    match part {
        Part::Leaf => 0,
        Part::Bark => 1,
    }
}

/// The palette of a species that is grown: of leaves, and of bark.
pub fn of_grown(grown: Grown, species: &Species) -> Vec<Color> {
    let [leaf, bark] = own(grown);
    vec![species.color_srgb.map_or(leaf, linear), species.bark_srgb.map_or(bark, linear)]
}

/// The palette of a model: of its materials, then of its canopy. What has no colour has that of leaves, which are those of
/// the grown species whose outline is like the model's.
pub fn of_model(model: &TreeModel, species: &Species) -> Vec<Color> {
    let leaf = species.color_srgb.map_or(own(model.clump)[0], linear);
    let mut palette: Vec<Color> = model.paints.iter().map(|paint| paint.unwrap_or(leaf)).collect();
    let mut canopy = [0.0; 3];
    for (paint, share) in palette.iter().zip(&model.crown) {
        for (sum, channel) in canopy.iter_mut().zip(paint) {
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
