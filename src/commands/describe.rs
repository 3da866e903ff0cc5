//! Descriptions of height files and pyramids in numbers, for `info` and `bake`.

mod highest;

use std::fmt::Write as _;
use std::sync::Arc;

use glam::DVec2;
use serde::Serialize;

use self::highest::{HighestPoint, highest_of, highest_point};
use crate::pyramid::format::{LevelSummary, sidecar_path};
use crate::pyramid::store::{DataArea, data_bounds};
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, TileAddress, is_void};
use crate::pyramid::{LevelSize, Pyramid, TileStore};
use crate::source::georeference::Georeference;
use crate::source::lon_lat::GridOnWgs84;
use crate::source::{GeoreferenceError, GroundScale, HeightReader, ScaleRange, Statistics, WorldMapping};

/// Lowest and highest heights on the Earth, in metres, with some room.
const EARTH_M: [f32; 2] = [-11_100.0, 9000.0];

/// Properties of a grid of heights.
#[derive(Serialize)]
pub(super) struct Heights {
    /// Samples per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Distance between neighbouring columns and between rows, in the middle of the grid.
    pub spacing_m: [f64; 2],
    /// Extent to the east and to the north.
    pub extent_m: [f64; 2],
    /// Coordinate reference system, and its projection to metres.
    pub crs: String,
    /// Scale of the file's projection and of the world's against the ground; absent if the projection is unknown.
    pub scale: Option<GroundScale>,
    /// Lowest height in the file, in metres.
    pub min_m: f32,
    /// Highest height in the file, in metres.
    pub max_m: f32,
    /// Number of samples without data; `None` if not all were read.
    pub void_samples: Option<u64>,
    /// Share of samples without data, 0 to 1; of a file on a server, that of a coarse level.
    pub void_share: f64,
    /// First column and row that have heights, and the last; `None` if all have, or if it is not known.
    pub data_samples: Option<[[u32; 2]; 2]>,
    /// Extent of the samples that have heights, in the world: west, south, east, north.
    pub data_extent_m: [f64; 4],
    /// Number of no-data samples that are filled when the file is drawn or baked; 0 for a pyramid, which is not filled
    /// again.
    pub filled_samples: u64,
    /// Number of samples next to no-data that are then replaced because they differ too much from their neighbours.
    pub spike_samples: u64,
    /// Lowest and highest height with filled samples, if some are filled.
    pub filled_range_m: Option<[f32; 2]>,
    /// Longitudes and latitudes of the extent in WGS 84: west, south, east, north; west is larger than east across the
    /// antimeridian. Absent if the projection is unknown.
    pub bounds_deg: Option<[f64; 4]>,
    /// The origin of the world in the coordinate reference system of the file.
    pub origin_crs: [f64; 2],
    /// The highest point; absent if it is not known.
    pub highest: Option<HighestPoint>,
}

/// Properties of a pyramid in addition to those of its heights.
#[derive(Serialize)]
pub(super) struct Levels {
    /// Levels, finest first.
    pub levels: Vec<Level>,
    /// Number of tiles in all levels.
    pub tiles: u64,
    /// Number of mesh patches of all strides.
    pub patches: u64,
    /// The bake's `--max-error`, in metres; 0 is lossless.
    pub max_error_m: f64,
    /// Size of the GeoTIFF.
    pub tif_bytes: u64,
    /// Size of the sidecar file with the tile statistics.
    pub sidecar_bytes: u64,
    /// Bits of the whole GeoTIFF, overviews included, per sample of the finest level.
    pub bits_per_sample: f64,
}

/// A level of a pyramid.
#[derive(Serialize)]
pub(super) struct Level {
    /// Samples per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Number of tiles in this level.
    pub tiles: u64,
    /// Largest difference between a tile of this level and the baked heights.
    pub largest_error_m: f32,
    /// Bits of this level's tiles in the GeoTIFF, per sample of the level.
    pub bits_per_sample: f64,
}

impl Heights {
    /// Describes the grid of a reader, given the statistics of its heights.
    pub(super) fn of_reader(reader: &dyn HeightReader, statistics: Statistics) -> Result<Self, GeoreferenceError> {
        let [width, height] = reader.size();
        let Statistics { min_m, max_m, highest, void_samples, bounds, filled, filled_m } = statistics;
        let size = LevelSize { width, height };
        let data = bounds.filter(|_| void_samples > 0);
        let mut heights = Self::new(reader.georeference(), size, [min_m, max_m], void_samples, data)?;
        if let Some(sample) = highest {
            heights.highest = highest_point(reader.georeference(), size, sample, max_m, true);
        }
        Ok(Self { filled_samples: filled.voids, spike_samples: filled.spikes, filled_range_m: filled_m, ..heights })
    }

    /// Describes the finest level of a pyramid.
    pub(super) fn of_pyramid(pyramid: &Arc<Pyramid>) -> anyhow::Result<Self> {
        let range_m = [pyramid.min_m(), pyramid.max_m()];
        let data = match pyramid.void_samples() {
            0 => None,
            _ => data_bounds(&(Arc::clone(pyramid) as Arc<dyn TileStore>))?,
        };
        let heights = Self::new(pyramid.georeference(), pyramid.levels()[0], range_m, pyramid.void_samples(), data)?;
        Ok(Self { highest: highest_of(&(Arc::clone(pyramid) as Arc<dyn TileStore>))?, ..heights })
    }

    /// Describes a store from a few of its tiles; heights are bounds.
    pub(super) fn of_store(store: &Arc<dyn TileStore>) -> anyhow::Result<Self> {
        let top = TileAddress { level: store.levels().len() as u32 - 1, x: 0, y: 0 };
        let size = store.levels()[top.level as usize];
        let tile = Arc::clone(store).load(top)?.tile;
        let own = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x)));
        let at = |(y, x): (u32, u32)| ((y + TILE_BORDER) * TILE_STRIDE + x + TILE_BORDER) as usize;
        let voids = own.filter(|place| is_void(tile.samples[at(*place)])).count();
        let area = DataArea::of(store)?;
        let finest = store.levels()[0];
        let data = area.bounds().filter(|_| !area.is_whole).map(|[low, high]| {
            let column = |c: f64| (c.max(0.0).round() as u32).min(finest.width - 1);
            let row = |c: f64| (c.max(0.0).round() as u32).min(finest.height - 1);
            [[column(low[0]), row(low[1])], [column(high[0]), row(high[1])]]
        });
        let heights = Self::new(store.georeference(), finest, store.range_m(), 0, data)?;
        let void_share = voids as f64 / (f64::from(size.width) * f64::from(size.height));
        Ok(Self { void_samples: None, void_share, highest: highest_of(store)?, ..heights })
    }

    fn new(
        georeference: &Georeference,
        size: LevelSize,
        [min_m, max_m]: [f32; 2],
        void_samples: u64,
        data_samples: Option<[[u32; 2]; 2]>,
    ) -> Result<Self, GeoreferenceError> {
        let LevelSize { width, height } = size;
        let mapping = WorldMapping::new(georeference, width, height)?;
        let on_wgs84 = GridOnWgs84::new(georeference, [width, height]).ok();
        let last = DVec2::new(f64::from(width - 1), f64::from(height - 1));
        let place = |grid: DVec2| mapping.world_from_grid(grid.x, grid.y);
        let middle = last * 0.5;
        let step = |along: DVec2| (place(middle + along * 0.5) - place(middle - along * 0.5)).length();
        let corners = [DVec2::ZERO, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y), last].map(place);
        let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        let [first, end] = data_samples.map_or([DVec2::ZERO, last], |ends| {
            ends.map(|[column, row]| DVec2::new(f64::from(column), f64::from(row)))
        });
        let corners = [first, DVec2::new(end.x, first.y), DVec2::new(first.x, end.y), end].map(place);
        let data_low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let data_high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        Ok(Self {
            width,
            height,
            spacing_m: [step(DVec2::X), step(DVec2::Y)],
            extent_m: (high - low).to_array(),
            crs: mapping.describe(),
            scale: mapping.ground_scale().copied(),
            min_m,
            max_m,
            void_samples: Some(void_samples),
            void_share: void_samples as f64 / (f64::from(width) * f64::from(height)),
            data_samples,
            data_extent_m: [data_low.x, data_low.y, data_high.x, data_high.y],
            filled_samples: 0,
            spike_samples: 0,
            filled_range_m: None,
            bounds_deg: on_wgs84.as_ref().and_then(GridOnWgs84::bounds_deg),
            origin_crs: mapping.origin_crs().to_array(),
            highest: None,
        })
    }

    /// Returns the number of filled samples, as text; empty if none are.
    fn filled_text(&self) -> String {
        match (self.filled_samples, self.spike_samples) {
            (0, 0) => String::new(),
            (filled, 0) => format!("; {filled} are filled (--voids)"),
            (filled, spikes) => format!("; {filled} are filled, and {spikes} spikes next to them removed (--voids)"),
        }
    }

    /// Returns what is implausible about the heights on the Earth, as a sentence: they vary by more than the land is
    /// wide, or they are higher or deeper than any land.
    pub(super) fn doubt(&self) -> Option<String> {
        let (relief_m, wide_m) = (f64::from(self.max_m - self.min_m), self.extent_m[0].max(self.extent_m[1]));
        let [low_m, high_m] = EARTH_M;
        if relief_m > wide_m {
            return Some(format!(
                "its heights vary by {relief_m:.0} m within {wide_m:.0} m; check the distance between samples \
                 (spacing_m, a world file) and the unit of heights (--height-unit)"
            ));
        }
        (self.max_m > high_m || self.min_m < low_m).then(|| {
            format!(
                "its heights of {:.0} to {:.0} m do not occur on the Earth; if they are feet, --height-unit ft converts \
                 them",
                self.min_m, self.max_m
            )
        })
    }

    /// Returns the description as lines of text.
    pub(super) fn lines(&self) -> String {
        let Self { width, height, spacing_m: [dx_m, dy_m], extent_m: [east_m, north_m], .. } = self;
        let voids = match self.void_samples {
            None if self.void_share == 0.0 => "none found in the coarsest tile".to_owned(),
            None => format!("about {:.1} %, from the coarsest tile", 100.0 * self.void_share),
            Some(0) => "none".to_owned(),
            Some(count) => format!("{count} samples, {:.3} %{}", 100.0 * self.void_share, self.filled_text()),
        };
        let is_part = |ends: &[[u32; 2]; 2]| *ends != [[0, 0], [width - 1, height - 1]];
        let data = self.data_samples.filter(is_part).map(|[first, last]| {
            let [west, south, east, north] = self.data_extent_m;
            format!(
                "data      columns {} to {}, rows {} to {}: {west:.0} to {east:.0} m east, {south:.0} to {north:.0} m \
                 north of the centre\n",
                first[0], last[0], first[1], last[1]
            )
        });
        let data = data.unwrap_or_default();
        let bounds = self.bounds_deg.map(|[west, south, east, north]| {
            format!("bounds    longitude {west:.4} to {east:.4}°, latitude {south:.4} to {north:.4}°\n")
        });
        let is_wider = |[low_m, high_m]: &[f32; 2]| *low_m < self.min_m || *high_m > self.max_m;
        let filled = self.filled_range_m.filter(is_wider);
        let filled = filled.map(|[low_m, high_m]| format!("; with filled holes {low_m:.2} to {high_m:.2} m"));
        format!(
            "samples   {width} × {height}, {dx_m:.3} × {dy_m:.3} m apart\n\
             extent    {:.3} × {:.3} km\n\
             place     {}\n{}\
             scale     {}\n\
             heights   {:.2} to {:.2} m{}\n{}\
             no-data   {voids}\n{data}",
            east_m / 1000.0,
            north_m / 1000.0,
            self.crs,
            bounds.unwrap_or_default(),
            self.scale.as_ref().map_or_else(|| "unknown; lengths are those of the file".to_owned(), scale_text),
            self.min_m,
            self.max_m,
            filled.unwrap_or_default(),
            self.highest.as_ref().map(HighestPoint::text).unwrap_or_default(),
        )
    }
}

impl Levels {
    /// Describes an open pyramid.
    pub(super) fn of(pyramid: &Pyramid) -> anyhow::Result<Self> {
        let mut levels: Vec<Level> =
            pyramid.levels().iter().zip(pyramid.summaries()).map(|(size, summary)| of_level(*size, summary)).collect();
        // Heights as they are drawn carry the no-data flag in their lowest bit; stored ones keep the bound.
        if let Some(finest) = levels.first_mut() {
            finest.largest_error_m = finest.largest_error_m.min(pyramid.max_error_m() as f32);
        }
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

    /// Returns the description as lines of text.
    pub(super) fn lines(&self) -> String {
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let kept = match self.max_error_m {
            0.0 => "lossless".to_owned(),
            error_m => format!("within {error_m} m"),
        };
        let mut lines = format!(
            "stored    {:.2} MiB, {:.2} bits per sample, {kept}; {:.2} MiB of statistics in the sidecar\n\
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

/// Returns scale factors as text: those of the file's projection, and how far world metres are from ground metres.
fn scale_text(scale: &GroundScale) -> String {
    let within = match scale.world.departure() {
        // No projection library is better than that, and no survey needs more.
        small if small < 1e-5 => "lengths are ground metres within 0.001 %".to_owned(),
        some if some < 0.2 => {
            let digits = (-1.0 - some.log10().floor()).clamp(0.0, 3.0) as usize;
            // A bound is rounded up.
            let unit = 0.1_f64.powi(digits as i32);
            let percent = (100.0 * some / unit - 1e-6).ceil() * unit;
            format!("lengths are ground metres within {percent:.digits$} %")
        }
        _ => {
            let factor = scale.world.max.max(1.0 / scale.world.min);
            format!("lengths are off by up to a factor of {factor:.1} toward the edges")
        }
    };
    match &scale.file {
        None => within,
        Some(ScaleRange { centre, min, max }) => {
            format!("{centre:.4} at the centre, {min:.4} to {max:.4} over the extent; {within}")
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_has_as_many_digits_as_it_needs() {
        let text = |centre: f64, departure: f64| {
            let range = |centre: f64| ScaleRange { centre, min: centre, max: centre + departure };
            scale_text(&GroundScale { file: Some(range(centre)), world: range(1.0) })
        };
        let expected =
            "1.8425 at the centre, 1.8425 to 1.8425 over the extent; lengths are ground metres within 0.001 %";
        assert_eq!(text(1.8425, 1e-9), expected);
        assert!(text(1.0, 4e-4).ends_with("within 0.040 %"), "{}", text(1.0, 4e-4));
        assert!(text(1.0, 0.0311).ends_with("within 3.2 %"), "{}", text(1.0, 0.0311));
        assert!(text(1.0, 20.0).ends_with("off by up to a factor of 21.0 toward the edges"), "{}", text(1.0, 20.0));
    }
}
