//! What a height file or a pyramid is, in numbers: what `info` and `bake` tell.

use std::fmt::Write as _;

use glam::DVec2;
use serde::Serialize;

use crate::pyramid::format::{LevelSummary, sidecar_path};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::pyramid::{LevelSize, Pyramid};
use crate::source::georeference::Georeference;
use crate::source::{GeoreferenceError, HeightReader, Statistics, WorldMapping};

/// A field of heights.
#[derive(Serialize)]
pub struct Heights {
    /// Samples per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Between neighbouring columns and rows, in the middle of the field.
    pub spacing_m: [f64; 2],
    /// East and north.
    pub extent_m: [f64; 2],
    /// The reference system, and how it is brought to metres.
    pub crs: String,
    /// The lowest.
    pub min_m: f32,
    /// The highest.
    pub max_m: f32,
    /// Samples without a height.
    pub void_samples: u64,
    /// Their share, 0 to 1.
    pub void_share: f64,
    /// How many of these are filled when the file is drawn or baked; none of a pyramid, whose voids stay.
    pub filled_samples: u64,
    /// Samples beside voids that get another height then, because they stand far out of their neighbours.
    pub spike_samples: u64,
}

/// A pyramid beyond its heights.
#[derive(Serialize)]
pub struct Levels {
    /// Finest first.
    pub levels: Vec<Level>,
    /// Tiles of all levels.
    pub tiles: u64,
    /// Mesh patches of all strides.
    pub patches: u64,
    /// What the bake allowed, in metres; 0 = lossless.
    pub max_error_m: f64,
    /// Of the GeoTIFF.
    pub tif_bytes: u64,
    /// Of the tile statistics beside it.
    pub sidecar_bytes: u64,
    /// Of the GeoTIFF, overviews included, for each sample of the finest level.
    pub bits_per_sample: f64,
}

/// A level of a pyramid.
#[derive(Serialize)]
pub struct Level {
    /// Samples per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Tiles in this level.
    pub tiles: u64,
    /// How far its worst tile is from the heights that were baked.
    pub largest_error_m: f32,
    /// Of its tiles in the GeoTIFF, for each of its samples.
    pub bits_per_sample: f64,
}

impl Heights {
    /// Of a grid and what its heights are.
    pub fn of_reader(reader: &dyn HeightReader, statistics: Statistics) -> Result<Self, GeoreferenceError> {
        let [width, height] = reader.size();
        let Statistics { min_m, max_m, void_samples, filled } = statistics;
        let heights = Self::new(reader.georeference(), LevelSize { width, height }, [min_m, max_m], void_samples)?;
        Ok(Self { filled_samples: filled.voids, spike_samples: filled.spikes, ..heights })
    }

    /// Of the finest level of a pyramid.
    pub fn of_pyramid(pyramid: &Pyramid) -> Result<Self, GeoreferenceError> {
        let range_m = [pyramid.min_m(), pyramid.max_m()];
        Self::new(pyramid.georeference(), pyramid.levels()[0], range_m, pyramid.void_samples())
    }

    fn new(
        georeference: &Georeference,
        size: LevelSize,
        [min_m, max_m]: [f32; 2],
        void_samples: u64,
    ) -> Result<Self, GeoreferenceError> {
        let LevelSize { width, height } = size;
        let mapping = WorldMapping::new(georeference, width, height)?;
        let last = DVec2::new(f64::from(width - 1), f64::from(height - 1));
        let place = |grid: DVec2| mapping.world_from_grid(grid.x, grid.y);
        let middle = last * 0.5;
        let step = |along: DVec2| (place(middle + along * 0.5) - place(middle - along * 0.5)).length();
        let corners = [DVec2::ZERO, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y), last].map(place);
        let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        Ok(Self {
            width,
            height,
            spacing_m: [step(DVec2::X), step(DVec2::Y)],
            extent_m: (high - low).to_array(),
            crs: mapping.describe(),
            min_m,
            max_m,
            void_samples,
            void_share: void_samples as f64 / (f64::from(width) * f64::from(height)),
            filled_samples: 0,
            spike_samples: 0,
        })
    }

    /// What is filled, if anything is.
    fn filled_text(&self) -> String {
        match (self.filled_samples, self.spike_samples) {
            (0, 0) => String::new(),
            (filled, 0) => format!("; {filled} are filled (--voids)"),
            (filled, spikes) => format!("; {filled} are filled, and {spikes} spikes beside them removed (--voids)"),
        }
    }

    /// For people, a line for each.
    pub fn lines(&self) -> String {
        let Self { width, height, spacing_m: [dx_m, dy_m], extent_m: [east_m, north_m], .. } = self;
        let voids = match self.void_samples {
            0 => "none".to_owned(),
            count => format!("{count} samples, {:.3} %{}", 100.0 * self.void_share, self.filled_text()),
        };
        format!(
            "samples   {width} × {height}, {dx_m:.3} × {dy_m:.3} m apart\n\
             extent    {:.3} × {:.3} km\n\
             place     {}\n\
             heights   {:.2} to {:.2} m\n\
             voids     {voids}\n",
            east_m / 1000.0,
            north_m / 1000.0,
            self.crs,
            self.min_m,
            self.max_m,
        )
    }
}

impl Levels {
    /// Of an open pyramid.
    pub fn of(pyramid: &Pyramid) -> anyhow::Result<Self> {
        let levels: Vec<Level> =
            pyramid.levels().iter().zip(pyramid.summaries()).map(|(size, summary)| of_level(*size, summary)).collect();
        let patches = (0..pyramid.patch_levels()).map(|j| pyramid.patch_counts(j));
        let bytes = |path: &std::path::Path| std::fs::metadata(path).map(|metadata| metadata.len());
        let tif_bytes = bytes(pyramid.path())?;
        let finest = pyramid.levels()[0];
        Ok(Self {
            tiles: levels.iter().map(|level| level.tiles).sum(),
            patches: patches.map(|(x, y)| u64::from(x) * u64::from(y)).sum(),
            max_error_m: pyramid.max_error_m(),
            tif_bytes,
            sidecar_bytes: bytes(&sidecar_path(pyramid.path()))?,
            bits_per_sample: tif_bytes as f64 * 8.0 / (f64::from(finest.width) * f64::from(finest.height)),
            levels,
        })
    }

    /// For people, a line for each.
    pub fn lines(&self) -> String {
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let kept = match self.max_error_m {
            0.0 => "lossless".to_owned(),
            error_m => format!("within {error_m} m"),
        };
        let mut lines = format!(
            "stored    {:.2} MiB, {:.2} bits per sample, {kept}; {:.2} MiB of statistics beside it\n\
             pyramid   {} levels, {} tiles of {TILE_SAMPLES} × {TILE_SAMPLES}, {} mesh patches\n",
            mebibytes(self.tif_bytes),
            self.bits_per_sample,
            mebibytes(self.sidecar_bytes),
            self.levels.len(),
            self.tiles,
            self.patches,
        );
        for (number, level) in self.levels.iter().enumerate() {
            let Level { width, height, tiles, largest_error_m, bits_per_sample } = level;
            let plural = if *tiles == 1 { "" } else { "s" };
            // Writing to a String cannot fail.
            let _ = writeln!(
                lines,
                "level {number:<3} {width} × {height}, {tiles} tile{plural}, {bits_per_sample:.2} bits per sample, \
                 largest error {largest_error_m} m"
            );
        }
        lines
    }
}

fn of_level(size: LevelSize, summary: &LevelSummary) -> Level {
    Level {
        width: size.width,
        height: size.height,
        tiles: size.tiles(),
        largest_error_m: summary.largest_error_m,
        bits_per_sample: summary.bytes as f64 * 8.0 / (f64::from(size.width) * f64::from(size.height)),
    }
}
