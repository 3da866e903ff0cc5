//! Images on the land: orthophotos, scanned maps and thematic rasters that a scene lists or `--drape` names.
//!
//! ```text
//! images ─▶ resample: tiles on the grid of heights ─▶ choose: tiles of a view ─▶ resident: on the GPU ─▶ surface/draped_image
//! ```
//!
//! Images have a quadtree of tiles of their own, on the grid of the heights, so they may be much finer or coarser than
//! these. A tile has 256 × 256 texels and two texels of border on each side. Texels of level 0 are a power of two of the
//! samples of the heights, and 0.84 to 1.68 times as fine as the pixels of the finest image.
//!
//! Why: `docs/decisions/draped-images.md`.

mod choose;
mod loader;
mod resample;
mod resident;
#[cfg(test)]
pub(crate) mod tests;

use std::path::{Path, PathBuf};

use glam::DVec2;

pub(crate) use self::resident::ResidentImagery;
use crate::file::message::{named, printable};
use crate::gpu::wgsl::surface::draped_image as shader;
use crate::scene::ImageFile;
use crate::source::alignment::{Alignment, Misaligned, border};
use crate::source::color_image::ColorImage;
use crate::source::georeference::{Crs, Georeference};
use crate::source::{SourceError, WorldMapping};

/// Texels of a tile along a side, without its border.
const TILE_TEXELS: u32 = shader::TILE_TEXELS as u32;
/// Texels of border on each side of a tile.
const BORDER: u32 = shader::BORDER as u32;
/// Texels of a tile along a side.
const TILE_STRIDE: u32 = TILE_TEXELS + 2 * BORDER;
/// Largest number of levels.
const MOST_LEVELS: u32 = shader::MOST_LEVELS as u32;
/// Points along each border of an image, for computing its extent.
const BORDER_PLACES: u32 = 32;
/// Part of a level by which the texels of level 0 may be coarser than the pixels of the image.
const COARSER: f64 = 0.25;

/// Why an image cannot be on the land. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] SourceError),
    /// The world has no reference system, but the image has one.
    #[error("{}: cannot be aligned with the world, which has no coordinate reference system", named(path))]
    WorldNowhere {
        /// Path of the image.
        path: PathBuf,
    },
    /// The image has coordinates without a reference system.
    #[error(
        "{}: has no coordinate reference system, so it cannot be aligned with the world; assign one with gdal_edit -a_srs",
        named(path)
    )]
    Nowhere {
        /// Path of the image.
        path: PathBuf,
    },
    /// There is no transformation between the reference systems.
    #[error("{}: cannot be aligned with the world: {cause}", named(path))]
    NoWay {
        /// Path of the image.
        path: PathBuf,
        /// The reason, as a clause.
        cause: String,
    },
    /// The image is somewhere else.
    #[error("{}: does not overlap the world", named(path))]
    OutsideWorld {
        /// Path of the image.
        path: PathBuf,
    },
}

/// An image with its place on the grid of heights.
struct PlacedImage {
    image: ColorImage,
    way: Alignment,
    /// The samples of the heights around it, or a larger rectangle.
    low: DVec2,
    high: DVec2,
    /// Pixels per sample of the heights, in the middle of its place.
    per_sample: f64,
}

/// A tile: its level, 0 being the finest, its column and its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ImageTile {
    pub level: u32,
    pub x: u32,
    pub y: u32,
}

/// The images of a world.
pub(crate) struct Imagery {
    images: Vec<PlacedImage>,
    /// Columns and rows of the heights.
    samples: [u32; 2],
    /// Texels of level 0 per sample of the heights: a power of two.
    texels_per_sample: f64,
    /// The level that has one tile.
    top: u32,
}

impl Imagery {
    /// Opens the images of a world whose heights have the georeference `place` and `samples` columns and rows. The last
    /// image is drawn over the others.
    ///
    /// # Errors
    /// The first image that cannot be read, or cannot be aligned with the world.
    pub(crate) fn open(files: &[ImageFile], place: &Georeference, samples: [u32; 2]) -> Result<Self, ImageError> {
        let images: Vec<_> =
            files.iter().map(|file| PlacedImage::open(&file.path, place, samples)).collect::<Result<_, _>>()?;
        let finest = images.iter().map(|image| image.per_sample).fold(f64::MIN_POSITIVE, f64::max);
        let longest = f64::from(samples[0].max(samples[1]));
        // The levels above level 0 until one tile is enough.
        let top = |texels: f64| (longest * texels / f64::from(TILE_TEXELS)).log2().ceil().max(0.0);
        let mut texels_per_sample = (finest.log2() - COARSER).ceil().exp2();
        while top(texels_per_sample) >= f64::from(MOST_LEVELS) {
            texels_per_sample *= 0.5;
        }
        Ok(Self { images, samples, texels_per_sample, top: top(texels_per_sample) as u32 })
    }

    /// Returns whether there are no images.
    pub(crate) fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// Returns the distance between texels of a level, in samples of the heights.
    fn texel_samples(&self, level: u32) -> f64 {
        f64::from(level).exp2() / self.texels_per_sample
    }

    /// Returns the rectangle of a tile on the grid of heights, without its border.
    fn rectangle(&self, tile: ImageTile) -> [DVec2; 2] {
        let side = self.texel_samples(tile.level) * f64::from(TILE_TEXELS);
        // The first texel begins where the first sample does, half a sample before its centre.
        let first = DVec2::new(f64::from(tile.x), f64::from(tile.y)) * side - 0.5;
        [first, first + side]
    }
}

impl PlacedImage {
    fn open(path: &Path, place: &Georeference, samples: [u32; 2]) -> Result<Self, ImageError> {
        let image = ColorImage::open(path)?;
        let path = path.to_owned();
        let (dem, own) = ((place, samples), (image.georeference(), image.size()));
        let last = samples.map(|count| f64::from(count) - 0.5);
        let whole = [DVec2::splat(-0.5), DVec2::from_array(last)];
        if !image.is_located {
            tracing::warn!("{}: has no position, so it is stretched over the whole land", path.display());
            let [across, down] = [0, 1].map(|axis: usize| f64::from(own.1[axis]) / f64::from(samples[axis]));
            let per_sample = across.max(down);
            return Ok(Self {
                way: Alignment::stretched(dem, own.1),
                image,
                low: whole[0],
                high: whole[1],
                per_sample,
            });
        }
        let aligned = match (&place.crs, &own.0.crs) {
            (Crs::Local, Crs::Local) => Alignment::by_coordinates(dem, own),
            _ => Alignment::by_place(dem, own),
        };
        let (way, back) = match aligned {
            Ok(aligned) => aligned,
            Err(Misaligned::Raster) => return Err(ImageError::Nowhere { path }),
            Err(Misaligned::Dem) => return Err(ImageError::WorldNowhere { path }),
            Err(Misaligned::NoWay(cause)) => return Err(ImageError::NoWay { path, cause: printable(&cause, 120) }),
        };
        // Where a projection is meaningless, the image is taken to cover everything.
        let end = own.1.map(|count| f64::from(count) - 0.5);
        let mut extent = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let mut is_sure = true;
        for [column, row] in border([-0.5; 2], end, BORDER_PLACES) {
            let [x, y] = back.map(column, row);
            let again = way.map(x, y);
            is_sure &= (again[0] - column).hypot(again[1] - row) < 0.5;
            extent = [extent[0].min(DVec2::new(x, y)), extent[1].max(DVec2::new(x, y))];
        }
        let [low, high] = if is_sure { [extent[0].max(whole[0]), extent[1].min(whole[1])] } else { whole };
        if !low.cmplt(high).all() {
            return Err(ImageError::OutsideWorld { path });
        }
        let middle = 0.5 * (low + high);
        let step = 0.25 * (high - low).min(DVec2::ONE);
        let at = |by: DVec2| DVec2::from_array(way.map(middle.x + by.x, middle.y + by.y));
        let [across, down] =
            [DVec2::new(step.x, 0.0), DVec2::new(0.0, step.y)].map(|by| (at(by) - at(-by)) / (2.0 * by.length()));
        let per_sample = across.length().max(down.length());
        if !(per_sample.is_finite() && per_sample > 0.0) {
            return Err(ImageError::OutsideWorld { path });
        }
        // The sides of the image may be curved on the grid.
        let margin = 0.02 * (high - low);
        Ok(Self { image, way, low: low - margin, high: high + margin, per_sample })
    }
}

/// Checks that images can be used for a world: opens them, and resamples their coarsest tile.
///
/// # Errors
/// The errors of [`Imagery::open`], and an image that cannot be read.
pub(crate) fn check(files: &[ImageFile], place: &Georeference, samples: [u32; 2]) -> Result<(), ImageError> {
    // A world that cannot be drawn has an error of its own.
    if files.is_empty() || WorldMapping::new(place, samples[0], samples[1]).is_err() {
        return Ok(());
    }
    let imagery = Imagery::open(files, place, samples)?;
    imagery.resample(ImageTile { level: imagery.top, x: 0, y: 0 })?;
    Ok(())
}
