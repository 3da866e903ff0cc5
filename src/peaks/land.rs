//! The summits of land: heights of a reader or of a pyramid, and where summits are on the Earth.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

use super::{Heights, Peak, Rules, Spacing, peaks};
use crate::pyramid::store::{TileStore, tile_heights_m};
use crate::pyramid::tile::{TILE_SAMPLES, TileAddress};
use crate::pyramid::{LevelSize, PyramidError};
use crate::source::georeference::{Crs, Georeference};
use crate::source::lon_lat::GridOnWgs84;
use crate::source::{GeoreferenceError, HeightReader, Progress, SourceError, Window, WorldMapping};

/// A summit of land.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Summit {
    /// Height in metres.
    pub height_m: f32,
    /// Height above the key saddle in metres: the lowest point on the best way to something higher.
    pub prominence_m: f32,
    /// The least prominence that the summit can have, if the key saddle may be outside of the data; otherwise equal to
    /// `prominence_m`.
    pub certain_prominence_m: f32,
    /// Height of the key saddle in metres; `None` for the highest summit of connected land.
    pub saddle_m: Option<f32>,
    /// East and north of the key saddle from the centre of the world, in metres.
    pub saddle_world_m: Option<[f64; 2]>,
    /// Distance from the nearest higher sample in metres; `None` if nothing in the data is higher.
    pub isolation_m: Option<f64>,
    /// Distance from the nearest place outside of the data in metres, if that is nearer: the isolation is at least this
    /// much.
    pub outside_m: Option<f64>,
    /// Column and row of the sample.
    pub sample: [usize; 2],
    /// East and north of the centre of the world, in metres.
    pub world_m: [f64; 2],
    /// Latitude and longitude in WGS 84, in degrees; `None` if the projection is unknown.
    pub latitude_longitude_deg: Option<[f64; 2]>,
}

/// Why there are no summits.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SummitsError<E> {
    /// The georeference is invalid.
    #[error(transparent)]
    Georeference(#[from] GeoreferenceError),
    /// The heights cannot be read.
    #[error(transparent)]
    Heights(E),
}

/// Which summits are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wanted {
    /// Largest number of summits.
    pub most: usize,
    /// Least prominence in metres.
    pub least_prominence_m: f64,
    /// Lowest height of the land in metres, or a bound. Deeper than any dry land is a sea floor, which counts as the sea.
    pub lowest_m: f32,
    /// Whether isolations are found, which reads the surroundings of each summit again.
    pub has_isolation: bool,
}

/// Lowest dry land on the Earth, with some room, in metres.
const LOWEST_DRY_M: f32 = -450.0;

/// Heights whose sea floor is raised to the level of the sea.
struct Flooded<H> {
    heights: H,
    has_sea_floor: bool,
}

impl<H: Heights> Heights for Flooded<H> {
    type Error = H::Error;

    fn size(&self) -> [usize; 2] {
        self.heights.size()
    }

    fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), H::Error> {
        self.heights.read(first, size, into)?;
        if self.has_sea_floor {
            // `max` would replace NaN.
            into.iter_mut().filter(|height_m| **height_m < 0.0).for_each(|height_m| *height_m = 0.0);
        }
        Ok(())
    }
}

/// The heights of a reader.
struct OfReader<'a>(&'a dyn HeightReader);

impl Heights for OfReader<'_> {
    type Error = SourceError;

    fn size(&self) -> [usize; 2] {
        self.0.size().map(|side| side as usize)
    }

    fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), SourceError> {
        let [x, y, width, height] = [first[0], first[1], size[0], size[1]].map(|number| number as u32);
        *into = self.0.read(Window { x, y, width, height })?;
        Ok(())
    }
}

/// The heights of the finest level of a store.
struct OfStore(Arc<dyn TileStore>);

impl Heights for OfStore {
    type Error = PyramidError;

    fn size(&self) -> [usize; 2] {
        let LevelSize { width, height } = self.0.levels()[0];
        [width as usize, height as usize]
    }

    fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), PyramidError> {
        let side = TILE_SAMPLES as usize;
        let tiles_of = |k: usize| first[k] / side..(first[k] + size[k]).div_ceil(side);
        let addresses = tiles_of(1).flat_map(|y| tiles_of(0).map(move |x| [x, y]));
        let addresses: Vec<[usize; 2]> = addresses.collect();
        let store = &self.0;
        let read = |[x, y]: &[usize; 2]| tile_heights_m(store, TileAddress { level: 0, x: *x as u32, y: *y as u32 });
        let tiles = addresses.par_iter().map(read).collect::<Result<Vec<_>, _>>()?;
        into.clear();
        into.resize(size[0] * size[1], f32::NAN);
        for ([x, y], heights_m) in addresses.iter().zip(tiles) {
            // The columns and rows of the tile that are wanted.
            let part = |k: usize, tile: usize| (first[k].max(tile * side), (first[k] + size[k]).min((tile + 1) * side));
            let ((left, right), (top, bottom)) = (part(0, *x), part(1, *y));
            for row in top..bottom {
                let from = (row - y * side) * side + left - x * side;
                let to = (row - first[1]) * size[0] + left - first[0];
                into[to..to + right - left].copy_from_slice(&heights_m[from..from + right - left]);
            }
        }
        Ok(())
    }
}

/// Finds the most prominent summits of a height file, most prominent first; fewer if it has fewer. Returns `None` if the
/// progress says to stop.
///
/// # Errors
/// The heights cannot be read, or the georeference is invalid.
pub(crate) fn summits_of_reader(
    reader: &dyn HeightReader,
    wanted: Wanted,
    progress: &dyn Progress,
) -> Result<Option<Vec<Summit>>, SummitsError<SourceError>> {
    let place = Place::new(reader.georeference(), reader.size())?;
    place.summits(OfReader(reader), wanted, progress).map_err(SummitsError::Heights)
}

/// Does the same as [`summits_of_reader`] for the finest level of a store.
///
/// # Errors
/// A tile cannot be read, or the georeference is invalid.
pub(crate) fn summits_of_store(
    store: &Arc<dyn TileStore>,
    wanted: Wanted,
    progress: &dyn Progress,
) -> Result<Option<Vec<Summit>>, SummitsError<PyramidError>> {
    let LevelSize { width, height } = store.levels()[0];
    let place = Place::new(store.georeference(), [width, height])?;
    place.summits(OfStore(Arc::clone(store)), wanted, progress).map_err(SummitsError::Heights)
}

/// Where the samples of a grid are.
struct Place {
    mapping: WorldMapping,
    on_wgs84: Option<GridOnWgs84>,
    spacing: Spacing,
    wraps: bool,
}

impl Place {
    fn new(georeference: &Georeference, size: [u32; 2]) -> Result<Self, GeoreferenceError> {
        let mapping = WorldMapping::new(georeference, size[0], size[1])?;
        let spacing = degrees(georeference).unwrap_or_else(|| {
            let middle = 0.5 * (DVec2::new(f64::from(size[0]), f64::from(size[1])) - 1.0);
            let at = |grid: DVec2| mapping.world_from_grid(grid.x, grid.y);
            Spacing::Metres([DVec2::X, DVec2::Y].map(|step| at(middle - 0.5 * step).distance(at(middle + 0.5 * step))))
        });
        let wraps = match spacing {
            Spacing::Degrees { step, .. } => (step[0] * f64::from(size[0]) - 360.0).abs() < 0.5 * step[0],
            Spacing::Metres(_) => false,
        };
        Ok(Self { on_wgs84: GridOnWgs84::new(georeference, size).ok(), mapping, spacing, wraps })
    }

    fn summits<H: Heights>(
        &self,
        heights: H,
        wanted: Wanted,
        progress: &dyn Progress,
    ) -> Result<Option<Vec<Summit>>, H::Error> {
        let Wanted { most, least_prominence_m, lowest_m, has_isolation } = wanted;
        let rules = Rules {
            least_prominence_m,
            most,
            wraps: self.wraps,
            has_open_gaps: true,
            has_isolation,
            ..Rules::new(self.spacing)
        };
        let mut heights = Flooded { heights, has_sea_floor: lowest_m < LOWEST_DRY_M };
        let mut report = |done: f64| {
            progress.report("finding summits", done as f32);
            !progress.stop().load(Ordering::Relaxed)
        };
        let found = peaks(&mut heights, &rules, &mut report)?;
        Ok(found.map(|peaks| peaks.iter().map(|peak| self.summit(peak)).collect()))
    }

    fn summit(&self, peak: &Peak) -> Summit {
        let world_m = self.mapping.world_from_grid(peak.column as f64, peak.row as f64);
        let degrees = self.on_wgs84.as_ref().and_then(|grid| grid.degrees(world_m));
        Summit {
            height_m: peak.height_m,
            prominence_m: peak.prominence_m,
            certain_prominence_m: peak.certain_prominence_m,
            saddle_m: peak.key_saddle.map(|saddle| saddle.height_m),
            saddle_world_m: peak
                .key_saddle
                .map(|saddle| self.mapping.world_from_grid(saddle.column as f64, saddle.row as f64).to_array()),
            isolation_m: peak.isolation.higher.map(|higher| higher.distance_m),
            outside_m: peak.isolation.outside_m,
            sample: [peak.column, peak.row],
            world_m: world_m.to_array(),
            latitude_longitude_deg: degrees.map(|degrees| [degrees.y, degrees.x]),
        }
    }
}

/// Returns the spacing of a grid of longitudes and latitudes with its north up; `None` for any other.
fn degrees(georeference: &Georeference) -> Option<Spacing> {
    let Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, .. } = &georeference.crs else {
        return None;
    };
    let [_, east, skew, north, turn, south] =
        georeference.crs_from_grid.map(|unit| (unit * radians_per_unit).to_degrees());
    let flattening = if *inverse_flattening > 0.0 { 1.0 / inverse_flattening } else { 0.0 };
    let is_plain = skew == 0.0 && turn == 0.0 && east > 0.0 && south < 0.0 && flattening < 0.1;
    let radii_m = [*semi_major_axis_m, semi_major_axis_m * (1.0 - flattening)];
    is_plain.then_some(Spacing::Degrees { north, step: [east, -south], radii_m })
}
