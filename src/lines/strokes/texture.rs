//! Stroke textures: a tile that is grown from a recipe, and the rule by which it takes ink.
//!
//! A tile holds two numbers for each pixel along and across a stroke. The *threshold* is the depth of the place: of
//! paper grain, or of a gap between a brush's hairs. A lightly pressed tool touches only high places, so ink is left
//! where the felt pressure is above the threshold (graphite on grains of paper: Sousa and Buchanan 2000; dry brush:
//! Curtis and others 1997; strokes against a height field: Kalnins and others 2002). The *pigment* is the amount of ink
//! that is left where the tool touches. Pressure falls towards a stroke's border, so borders break up by the same rule.
//!
//! **Growing.** Marks are white noise blurred by boxes ([`field`]), which wrap around: the tile repeats without a seam
//! (textures for painting from filtered noise: Lewis 1984). The sum of the marks is replaced by its rank, so that
//! thresholds are uniform and the inked fraction of the paper is the felt pressure, whatever the marks are.
//!
//! **Levels.** Each coarser level is an average of four texels. An average has less contrast, and against a threshold
//! that changes the mean: a light stroke would vanish. So thresholds are ranked again on every level (as alpha is
//! scaled to preserve its coverage: Castaño 2010), and every level takes the same amount of ink at every pressure.
//!
//! A texel is a pixel: strokes have a width in pixels, and so has the grain. `spread` widens marks with the stroke.
//!
//! **Pictures of a stroke.** A user's picture ([`picture`]) is drawn from border to border, and keeps its ratio of length
//! to width (Northrup and Markosian 2000; Pietrok 2021, section 4.2.4). Its darkness is the pigment. Its thresholds are
//! ranks too, by the share of the ink that is darker: with full pressure the stroke is as in the picture, and with less
//! its pale parts disappear first, so that the ink decreases in proportion.
//!
//! Why: `docs/decisions/stroke-textures.md`.

pub mod field;
mod gpu_tile;
mod picture;

pub use gpu_tile::{StrokeTexture, TILE_FORMAT};

use self::field::Field;
pub use crate::gpu::wgsl::shared::brush::Brush;
use crate::style::texture::{Recipe, Touch};

/// Largest number of levels of a tile: the last one still has 4 × 1 texels for the smallest tile.
const MAX_LEVELS: usize = 6;
/// Whole tiles of a picture fit into this length, in pixels, after which the coordinates along lines repeat.
pub(crate) const REPEATS_PX: f32 = 4096.0;

impl Brush {
    /// Returns the brush of a recipe.
    pub fn of(recipe: &Recipe) -> Self {
        let Touch { nominal_width_px, spread, softness, response, fill, border_px, border_part, border_pressure } =
            recipe.touch;
        let tile_px = match &recipe.picture {
            Some(picture) => {
                let length_px = picture.length_to_width() * nominal_width_px;
                [REPEATS_PX / (REPEATS_PX / length_px).round().max(1.0), nominal_width_px]
            }
            None => [recipe.tile.along_px as f32, recipe.tile.across_px as f32],
        };
        Self {
            tile_px,
            nominal_half_width_px: 0.5 * nominal_width_px,
            spread,
            softness,
            response,
            fill,
            border_px,
            border_part,
            border_pressure,
            fills: if recipe.picture.is_some() { 1.0 } else { 0.0 },
            half_texel: 0.5 / recipe.tile.across_px as f32,
        }
    }

    /// Returns the position of a place of a stroke on the tile, in tiles: `brush_uv` of the shader. `across_px` is
    /// signed.
    pub fn uv(&self, along_px: f32, across_px: f32, half_width_px: f32, id: u32) -> [f32; 2] {
        let [u, v] = offset(id);
        if self.fills > 0.5 {
            let across = (0.5 + 0.5 * across_px / half_width_px).clamp(self.half_texel, 1.0 - self.half_texel);
            return [along_px / self.tile_px[0] + u, across];
        }
        let widening = (self.nominal_half_width_px / half_width_px).powf(self.spread);
        [along_px / self.tile_px[0] + u, across_px * widening / self.tile_px[1] + v]
    }

    /// Returns the ink that a place takes, 0 to 1: `brush_ink` of the shader. `texel` is pigment and threshold,
    /// `from_middle_px` the distance from the stroke's middle. The coverage of pixels at the border is not included.
    pub fn ink(&self, texel: [f32; 2], pressure: f32, from_middle_px: f32, half_width_px: f32) -> f32 {
        let border_px = self.border_px.min(self.border_part * half_width_px).max(1e-3);
        let inside = ((half_width_px + 0.5 - from_middle_px) / border_px).clamp(0.0, 1.0);
        let rounded = inside * (2.0 - inside);
        let pressed = if pressure > 0.0 { pressure.min(1.0).powf(self.response) } else { 0.0 };
        let felt = pressed * self.fill * (self.border_pressure + (1.0 - self.border_pressure) * rounded);
        let threshold = self.softness + (1.0 - 2.0 * self.softness) * texel[1];
        let t = ((felt - threshold) / (2.0 * self.softness) + 0.5).clamp(0.0, 1.0);
        texel[0] * t * t * (3.0 - 2.0 * t)
    }
}

/// Returns the start of a stroke on the tile, in tiles: strokes side by side must not show the same marks.
fn offset(id: u32) -> [f32; 2] {
    let [x, y] = field::hash([id, 0x9e37_79b9]);
    [x, y].map(|bits| (bits >> 8) as f32 / 16_777_216.0)
}

/// One mip level: pigment and threshold of each texel, in rows along the stroke.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Size along and across the stroke, in texels.
    pub size_px: [u32; 2],
    /// Pigment and threshold; 255 is 1.
    pub texels: Vec<[u8; 2]>,
}

impl Level {
    /// Returns the mean ink in the middle of a wide stroke at `pressure`, 0 to 1.
    pub fn mean_ink(&self, brush: &Brush, pressure: f32) -> f64 {
        let ink = |texel: &[u8; 2]| f64::from(brush.ink(texel.map(|byte| f32::from(byte) / 255.0), pressure, 0.0, 1e3));
        self.texels.iter().map(ink).sum::<f64>() / self.texels.len() as f64
    }
}

/// Grows the levels of a recipe's tile, finest first, or makes them of its picture. The result is bit-identical on every
/// machine.
pub fn grow(recipe: &Recipe) -> Vec<Level> {
    let tile = recipe.tile;
    if let Some(picture) = &recipe.picture {
        return picture::levels(picture, tile);
    }
    let size_px = [tile.along_px, tile.across_px].map(|side| side as usize);
    let pigment = &recipe.pigment;
    let tone = Field::noise(size_px, [pigment.along_px, pigment.across_px], tile.seed, 0).ranks();
    let tone = tone.map(|rank| (pigment.density + pigment.variation * (2.0 * rank - 1.0)).clamp(0.0, 1.0));
    let mut height = Field::zero(size_px);
    for (marks, stream) in recipe.marks.iter().zip(1..) {
        let noise = Field::noise(size_px, [marks.along_px, marks.across_px], tile.seed, stream);
        height.add(&noise.swerved(marks.wander_px, tile.seed, stream), marks.weight);
    }
    // From here on both are averaged, and nothing is rounded before it is stored.
    let (mut tone, mut threshold) = (tone, height.ranks());
    let mut levels = Vec::new();
    loop {
        let byte = |value: f32| (value * 255.0).round() as u8;
        let ranks = threshold.ranks();
        let texels = tone.values().iter().zip(ranks.values()).map(|(a, b)| [byte(*a), byte(*b)]);
        levels.push(Level { size_px: tone.size_px().map(|side| side as u32), texels: texels.collect() });
        if levels.len() == MAX_LEVELS || tone.size_px().contains(&1) {
            return levels;
        }
        (tone, threshold) = (tone.halved(), threshold.halved());
    }
}
