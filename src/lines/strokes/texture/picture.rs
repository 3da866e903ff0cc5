//! The tile of a picture of a stroke.

use super::field::Field;
use super::{Level, MAX_LEVELS};
use crate::style::texture::Tile;
use crate::style::texture::picture::StrokePicture;

/// Size of the grain, in texels, that decides which of equally dark places lose their ink first.
const GRAIN_PX: [f32; 2] = [4.0, 2.0];
/// Share of the order that follows this grain: a scan has a few levels of darkness where the ink is full.
const GRAIN: f32 = 0.04;

/// Returns the levels of the tile, finest first: the darkness of the picture, and the thresholds at which it is left.
pub(super) fn levels(picture: &StrokePicture, tile: Tile) -> Vec<Level> {
    let size_px = [tile.along_px, tile.across_px].map(|side| side as usize);
    let mut darkness = Field::of(size_px, picture.resampled(size_px));
    let mut grain = Field::noise(size_px, GRAIN_PX, tile.seed, 0);
    let mut levels = Vec::new();
    loop {
        let byte = |value: f32| (255.0 * value.clamp(0.0, 1.0)).round() as u8;
        let thresholds = thresholds(&darkness, &grain);
        let texels =
            darkness.values().iter().zip(thresholds).map(|(pigment, threshold)| [byte(*pigment), byte(threshold)]);
        levels.push(Level { size_px: darkness.size_px().map(|side| side as u32), texels: texels.collect() });
        if levels.len() == MAX_LEVELS || darkness.size_px().contains(&1) {
            return levels;
        }
        (darkness, grain) = (darkness.halved(), grain.halved());
    }
}

/// Returns for each place the share of the ink that is darker.
fn thresholds(darkness: &Field, grain: &Field) -> Vec<f32> {
    let (darkness, grain) = (darkness.values(), grain.values());
    let key = |place: u32| darkness[place as usize] + GRAIN * grain[place as usize];
    let mut order: Vec<u32> = (0..darkness.len() as u32).collect();
    order.sort_by(|a, b| key(*b).total_cmp(&key(*a)));
    let total = darkness.iter().map(|ink| f64::from(*ink)).sum::<f64>().max(1e-9);
    let mut thresholds = vec![0.0; darkness.len()];
    let mut darker = 0.0;
    for place in order {
        let own = f64::from(darkness[place as usize]);
        thresholds[place as usize] = ((darker + 0.5 * own) / total) as f32;
        darker += own;
    }
    thresholds
}
