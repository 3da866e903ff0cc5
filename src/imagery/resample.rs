//! Resamples images to a tile. The mapping from texels to pixels is computed on a lattice of 17 × 17 points and linear
//! in between. Of each image the level is read whose pixels are no larger than the texels; a texel is the mean of as many
//! points, each interpolated linearly between pixels, as pixels fit into it along a side.

use glam::DVec2;

use super::{BORDER, ImageTile, Imagery, PlacedImage, TILE_STRIDE};
use crate::source::SourceError;
use crate::source::Window;
use crate::source::color_image::{Premultiplied, Rgba};

/// Intervals of the lattice along a side.
const INTERVALS: usize = 16;
/// Largest number of points along each side of a texel.
const MOST_POINTS: f64 = 4.0;
/// Largest number of pixels that are read for a tile.
const MOST_PX: u64 = 1 << 22;

/// The texels of a tile, row by row: linear colour times opacity in sRGB, and opacity.
pub(super) type Texels = Vec<Rgba>;

impl Imagery {
    /// Resamples all images to a tile with its border.
    ///
    /// # Errors
    /// An image cannot be read.
    pub(super) fn resample(&self, tile: ImageTile) -> Result<Texels, SourceError> {
        let count = (TILE_STRIDE * TILE_STRIDE) as usize;
        let mut sums = vec![Premultiplied::default(); count];
        for image in &self.images {
            image.draw(self, tile, &mut sums)?;
        }
        Ok(sums.into_iter().map(Premultiplied::texel).collect())
    }
}

impl PlacedImage {
    /// Draws the image over the texels of a tile.
    fn draw(&self, imagery: &Imagery, tile: ImageTile, sums: &mut [Premultiplied]) -> Result<(), SourceError> {
        let [first, end] = imagery.rectangle(tile);
        let texel = imagery.texel_samples(tile.level);
        let margin = texel * f64::from(BORDER);
        if (first - margin).cmpge(self.high).any() || (end + margin).cmple(self.low).any() {
            return Ok(());
        }
        let lattice = Lattice::new(|part| {
            let at = first - margin + part * (end - first + 2.0 * margin);
            DVec2::from_array(self.way.map(at.x, at.y))
        });
        let Some([low, high]) = lattice.extent() else { return Ok(()) };
        let size = DVec2::from_array(self.image.size().map(f64::from));
        let pixels_per_texel = lattice.step(self.per_sample * texel);
        // The level whose pixels are no larger than a texel, or a smaller one if too many pixels would be read.
        let mut level = 0;
        let mut factor = DVec2::ONE;
        let of_level = |level: usize| size / DVec2::from_array(self.image.level_size(level).map(f64::from));
        let window_of = |level: usize, factor: DVec2| {
            let own = self.image.level_size(level);
            let to = |at: DVec2| (at + 0.5) / factor - 0.5;
            let (low, high) = (to(low).floor() - 1.0, to(high).ceil() + 2.0);
            let limit = DVec2::from_array(own.map(f64::from));
            let (low, high) = (low.clamp(DVec2::ZERO, limit), high.clamp(DVec2::ZERO, limit));
            let (low, high) = (low.as_uvec2(), high.as_uvec2());
            Window { x: low.x, y: low.y, width: high.x - low.x, height: high.y - low.y }
        };
        let mut window = window_of(level, factor);
        while level + 1 < self.image.levels() {
            let next = of_level(level + 1);
            let is_too_large = window.samples() as u64 > MOST_PX;
            if next.max_element() > pixels_per_texel * 1.001 && !is_too_large {
                break;
            }
            (level, factor) = (level + 1, next);
            window = window_of(level, factor);
        }
        if window.width == 0 || window.height == 0 {
            return Ok(());
        }
        let pixels = self.image.read(level, window)?;
        let pixels: Vec<Premultiplied> = pixels.into_iter().map(Premultiplied::of).collect();
        let own = DVec2::from_array(self.image.level_size(level).map(f64::from));
        let at = |x: i64, y: i64| {
            let x = (x - i64::from(window.x)).clamp(0, i64::from(window.width) - 1);
            let y = (y - i64::from(window.y)).clamp(0, i64::from(window.height) - 1);
            pixels[y as usize * window.width as usize + x as usize]
        };
        let points = (pixels_per_texel / factor.max_element()).ceil().clamp(1.0, MOST_POINTS);
        let weight = (1.0 / (points * points)) as f32;
        for (index, sum) in sums.iter_mut().enumerate() {
            let texel = DVec2::new((index as u32 % TILE_STRIDE).into(), (index as u32 / TILE_STRIDE).into());
            let mut mean = Premultiplied::default();
            for point in 0..(points * points) as u32 {
                let points = points as u32;
                let within = (DVec2::new((point % points).into(), (point / points).into()) + 0.5) / f64::from(points);
                let place = (lattice.at((texel + within) / f64::from(TILE_STRIDE)) + 0.5) / factor - 0.5;
                // Beyond the outer edges of the outer pixels there is nothing; what is unknown is NaN.
                if !(place.cmpge(DVec2::splat(-0.5)).all() && place.cmple(own - 0.5).all()) {
                    continue;
                }
                let (whole, part) = (place.floor(), (place - place.floor()).as_vec2());
                let (x, y) = (whole.x as i64, whole.y as i64);
                for (corner, share) in [
                    (at(x, y), (1.0 - part.x) * (1.0 - part.y)),
                    (at(x + 1, y), part.x * (1.0 - part.y)),
                    (at(x, y + 1), (1.0 - part.x) * part.y),
                    (at(x + 1, y + 1), part.x * part.y),
                ] {
                    mean.add(corner, share * weight);
                }
            }
            if mean.alpha() > 0.0 {
                *sum = mean.over(*sum);
            }
        }
        Ok(())
    }
}

/// The pixels of an image at points of a tile.
struct Lattice {
    pixels: Vec<DVec2>,
}

impl Lattice {
    /// Computes the lattice of a mapping of parts of the tile, 0 to 1.
    fn new(pixel: impl Fn(DVec2) -> DVec2) -> Self {
        let side = INTERVALS + 1;
        let part = |index: usize| DVec2::new((index % side) as f64, (index / side) as f64) / INTERVALS as f64;
        Self { pixels: (0..side * side).map(|index| pixel(part(index))).collect() }
    }

    /// Returns the pixel at a part of the tile, 0 to 1; NaN where it is unknown.
    fn at(&self, part: DVec2) -> DVec2 {
        let place = part * INTERVALS as f64;
        let cell = place.floor().clamp(DVec2::ZERO, DVec2::splat((INTERVALS - 1) as f64));
        let f = place - cell;
        let first = cell.y as usize * (INTERVALS + 1) + cell.x as usize;
        let row = |first: usize| self.pixels[first].lerp(self.pixels[first + 1], f.x);
        row(first).lerp(row(first + INTERVALS + 1), f.y)
    }

    /// Returns the smallest and the largest coordinates of pixels that are known.
    fn extent(&self) -> Option<[DVec2; 2]> {
        let known = || self.pixels.iter().filter(|pixel| pixel.is_finite());
        let low = known().copied().reduce(DVec2::min)?;
        Some([low, known().copied().fold(low, DVec2::max)])
    }

    /// Returns how many pixels there are per texel, in the middle of the tile; `otherwise` if it is unknown.
    fn step(&self, otherwise: f64) -> f64 {
        let middle = self.pixels.len() / 2;
        let [across, down] = [1, INTERVALS + 1].map(|next| self.pixels[middle + next] - self.pixels[middle]);
        let texels = f64::from(TILE_STRIDE) / INTERVALS as f64;
        let step = across.length().max(down.length()) / texels;
        if step.is_finite() && step > 0.0 { step } else { otherwise }
    }
}
