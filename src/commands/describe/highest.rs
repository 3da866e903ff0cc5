//! The highest point of a grid of heights, for `info`.

use std::sync::Arc;

use serde::Serialize;

use crate::pyramid::store::{HighestSample, highest_sample};
use crate::pyramid::{LevelSize, TileStore};
use crate::source::WorldMapping;
use crate::source::georeference::Georeference;
use crate::source::lon_lat::GridOnWgs84;

/// The highest point of a grid of heights.
#[derive(Serialize)]
pub(in crate::commands) struct HighestPoint {
    /// Height in metres; of several such samples, one of the northernmost.
    pub height_m: f32,
    /// Whether no other sample can be higher; on a server, coarse tiles may hide one.
    pub is_exact: bool,
    /// East and north of the centre of the world, as cameras count, in metres.
    pub world_m: [f64; 2],
    /// Position in the coordinate reference system of the file, in its units.
    pub crs: [f64; 2],
    /// Latitude and longitude in WGS 84, in degrees; absent if the projection is unknown.
    pub latitude_longitude_deg: Option<[f64; 2]>,
}

impl HighestPoint {
    pub(super) fn text(&self) -> String {
        let Self { height_m, is_exact, world_m: [east_m, north_m], crs: [x, y], latitude_longitude_deg } = self;
        let about = if *is_exact { "" } else { "about " };
        let place = match latitude_longitude_deg {
            Some([latitude, longitude]) => format!("latitude, longitude {latitude:.5},{longitude:.5}"),
            None => "no latitude and longitude".to_owned(),
        };
        // Degrees need more digits than metres.
        let digits = if x.abs().max(y.abs()) <= 360.0 && latitude_longitude_deg.is_some() { 6 } else { 1 };
        format!(
            "highest   {about}{height_m:.2} m at {place}; coordinates {x:.digits$}, {y:.digits$}; {east_m:.1} m east, \
             {north_m:.1} m north of the centre\n"
        )
    }
}

/// Returns the highest point of a store; exact if the statistics of its tiles were measured and it has few equal tops.
pub(super) fn highest_of(store: &Arc<dyn TileStore>) -> anyhow::Result<Option<HighestPoint>> {
    let found = highest_sample(store)?;
    let size = store.levels()[0];
    Ok(found.and_then(|HighestSample { sample, height_m, is_exact }| {
        highest_point(store.georeference(), size, sample, height_m, is_exact)
    }))
}

/// Returns the position of a sample; `None` if the georeference is invalid.
pub(super) fn highest_point(
    georeference: &Georeference,
    LevelSize { width, height }: LevelSize,
    [column, row]: [u32; 2],
    height_m: f32,
    is_exact: bool,
) -> Option<HighestPoint> {
    let mapping = WorldMapping::new(georeference, width, height).ok()?;
    let world_m = mapping.world_from_grid(f64::from(column), f64::from(row));
    let degrees = GridOnWgs84::new(georeference, [width, height]).ok().and_then(|grid| grid.degrees(world_m));
    Some(HighestPoint {
        height_m,
        is_exact,
        world_m: world_m.to_array(),
        crs: mapping.crs_from_world(world_m).to_array(),
        latitude_longitude_deg: degrees.map(|degrees| [degrees.y, degrees.x]),
    })
}
