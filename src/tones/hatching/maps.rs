//! The tonal art maps of a style on the GPU, prepared for interpolated look-ups.
//!
//! **Calibration.** A map's texels are uniformly distributed, so that darkness d inks the fraction d of them. The
//! shader's look-up is bilinear between texels, and averages are not uniform: thin marks would lose ink in light tones,
//! and so would gaps in dark ones. So each threshold is replaced by the fraction of all places *between* texels whose
//! value is below it, repeatedly, until those are uniform. The order is preserved, and with it the nesting of tones.
//!
//! **Steepness.** The width of a pixel's border, in thresholds, follows from how steeply they change. Between texels
//! that jumps wherever a mark's flat middle meets its flank, and marks had steps along their sides; so the steepness is
//! computed for each texel, as the mean over its neighbours on both sides, and looked up as thresholds are. A line that
//! is just appearing is then thin and pale. Dots must not be pale, nor shine through before they appear: for them the
//! steepness is how thresholds *fall* from a texel toward the dot that it would belong to, which is zero in a dot's
//! middle and the whole slope on its flank; for gaps in dark tones it is how they rise.
//!
//! **Quads.** A texel holds the four thresholds around a place and their steepness, a byte each: a look-up is one load.

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::GrowingBuffer;
use crate::style::hatching::Hatching;
use crate::style::marks::{Kind, Recipe};
use crate::style::{Style, StyleError};
use crate::tones::tonal_art_map::TonalArtMap;

/// Places between texels, along each side, at which calibration samples.
const BETWEEN: usize = 4;

/// Bins of a distribution.
const STEPS: usize = 2048;

/// Rounds of calibration, after which the distribution is uniform within half a hundredth.
const ROUNDS: usize = 8;

/// Thresholds of the marks of every set.
pub(crate) struct Maps {
    quads: GrowingBuffer,
    /// Side of a tile, in texels.
    pub side_px: u32,
}

/// The maps of a style; or none if they cannot be made, which is logged once.
pub(crate) struct MadeMaps {
    recipes: Vec<Recipe>,
    maps: Option<Maps>,
}

impl MadeMaps {
    /// Makes the maps as [`Maps::new`] does, and logs an error.
    pub(crate) fn new(gpu: &Gpu, hatching: &Hatching) -> Self {
        // The pictures were checked when the style was loaded, so one has been removed since.
        let maps = Maps::new(gpu, hatching).inspect_err(|error| tracing::warn!("{error}; the hatching is not drawn"));
        Self { recipes: recipes(hatching), maps: maps.ok() }
    }

    /// Returns whether these are the maps of `hatching`.
    pub(crate) fn are_of(&self, hatching: &Hatching) -> bool {
        self.recipes == recipes(hatching)
    }

    /// Returns the maps, if they could be made.
    pub(crate) fn maps(&self) -> Option<&Maps> {
        self.maps.as_ref()
    }
}

/// Returns the recipes of the sets, in order.
fn recipes(hatching: &Hatching) -> Vec<Recipe> {
    hatching.sets.iter().filter_map(|set| set.recipe.clone()).collect()
}

/// Checks that the marks of a style can be made, so that errors in a user's pictures are reported before they are
/// needed. The maps are in the cache afterwards.
///
/// # Errors
/// [`StyleError`], which names the picture.
pub(crate) fn check(style: &Style) -> Result<(), StyleError> {
    style.hatching().into_iter().flat_map(recipes).try_for_each(|recipe| TonalArtMap::cached(&recipe).map(|_| ()))
}

impl Maps {
    /// Makes the maps, or reads them from the cache, and uploads them.
    ///
    /// # Errors
    /// [`StyleError`] when a stack of images cannot be read any more.
    pub(crate) fn new(gpu: &Gpu, hatching: &Hatching) -> Result<Self, StyleError> {
        let recipes = recipes(hatching);
        let maps = recipes.iter().map(TonalArtMap::cached).collect::<Result<Vec<_>, _>>()?;
        let side_px = maps.iter().map(|map| map.side_px).max().unwrap_or(1);
        let mut content = Vec::new();
        for (map, recipe) in maps.iter().zip(&recipes) {
            content.extend(quads(
                &calibrated(map),
                map.side_px,
                side_px,
                matches!(recipe.kind, Kind::Stipple | Kind::Dots),
            ));
        }
        let mut quads = GrowingBuffer::new(gpu, "tonal art maps", wgpu::BufferUsages::STORAGE);
        quads.write(gpu, &content);
        Ok(Self { quads, side_px })
    }

    /// Returns the binding of the shader.
    pub(crate) fn binding(&self) -> Resource {
        self.quads.binding()
    }
}

/// Returns the four thresholds around each place of a tile of side `side_px`, in which a smaller map repeats (sides are
/// powers of two), and their steepness. From the lowest byte: this texel, the next along, the next across, the next
/// along and across.
fn quads(thresholds: &[u8], own_px: u32, side_px: u32, is_dots: bool) -> Vec<[u32; 2]> {
    let (side, own) = (side_px as usize, own_px as usize);
    let steep = steepness(thresholds, own, is_dots);
    let quad = |bytes: &[u8], x: usize, y: usize| {
        let at = |x: usize, y: usize| bytes[(y % own) * own + x % own];
        u32::from_le_bytes([at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)])
    };
    let places = (0..side * side).map(|i| (i % side, i / side));
    places.map(|(x, y)| [quad(thresholds, x, y), quad(&steep, x, y)]).collect()
}

/// Returns how steeply thresholds change at each texel, per texel, as square roots: that of ink in the lower half of a
/// byte, that of gaps in the upper half.
fn steepness(thresholds: &[u8], side: usize, is_dots: bool) -> Vec<u8> {
    let at = |x: usize, y: usize| f32::from(thresholds[(y % side) * side + x % side]) / 255.0;
    let places = (0..side * side).map(|i| (i % side, i / side));
    let roots = |(x, y): (usize, usize)| {
        let here = at(x, y);
        let along = [at(x + 1, y) - here, at(x + side - 1, y) - here];
        let across = [at(x, y + 1) - here, at(x, y + side - 1) - here];
        let root = |of: &dyn Fn([f32; 2]) -> f32| (of(along).hypot(of(across)).min(1.0).sqrt() * 15.0).round() as u8;
        let falls = |sign: f32| root(&|steps| (sign * steps[0]).max(sign * steps[1]).max(0.0));
        let both = root(&|steps| 0.5 * (steps[0].abs() + steps[1].abs()));
        if is_dots { falls(-1.0) | falls(1.0) << 4 } else { both | both << 4 }
    };
    places.map(roots).collect()
}

/// Returns thresholds whose bilinear averages are uniform.
pub(crate) fn calibrated(map: &TonalArtMap) -> Vec<u8> {
    let mut values: Vec<f32> = map.thresholds.iter().map(|byte| (f32::from(*byte) + 0.5) / 256.0).collect();
    for _ in 0..ROUNDS {
        let below = distribution(&values, map.side_px as usize);
        for value in &mut values {
            let at = *value * STEPS as f32;
            let cell = (at as usize).min(STEPS - 1);
            *value = below[cell] + (below[cell + 1] - below[cell]) * (at - cell as f32);
        }
    }
    values.iter().map(|value| (value * 255.0).round() as u8).collect()
}

/// Returns the fraction of all places whose value is below k / STEPS, for each k from 0 to STEPS.
pub(crate) fn distribution(values: &[f32], side: usize) -> Vec<f32> {
    let mut counts = vec![0_u32; STEPS];
    for y in 0..side {
        let (row, next) = (&values[y * side..][..side], &values[(y + 1) % side * side..][..side]);
        for x in 0..side {
            let right = (x + 1) % side;
            let [a, b, c, d] = [row[x], row[right], next[x], next[right]];
            for i in 0..BETWEEN {
                let t = (i as f32 + 0.5) / BETWEEN as f32;
                let (upper, lower) = (a + (b - a) * t, c + (d - c) * t);
                for j in 0..BETWEEN {
                    let s = (j as f32 + 0.5) / BETWEEN as f32;
                    counts[(((upper + (lower - upper) * s) * STEPS as f32) as usize).min(STEPS - 1)] += 1;
                }
            }
        }
    }
    let whole = (side * side * BETWEEN * BETWEEN) as f32;
    let mut below = 0_u64;
    let parts = counts.iter().map(|count| {
        below += u64::from(*count);
        below as f32 / whole
    });
    std::iter::once(0.0).chain(parts).collect()
}
