//! Meridians and parallels, or lines of a projected grid, as features.

use glam::DVec2;

use crate::features::OnLand;
use crate::scene::Graticule;
use crate::source::WorldMapping;
use crate::source::georeference::{Crs, Georeference};
use crate::source::lon_lat::GridOnWgs84;

/// Largest number of lines.
const MAX_LINES: f64 = 1000.0;
/// Number of straight parts of a line: a parallel is curved on most maps.
const PARTS: u32 = 256;
/// A line whose coordinate differs from the border of the land by less than this part of a step is drawn.
const ROUNDING: f64 = 1e-6;

/// A line of equal coordinates, in columns and rows of the land, with the attributes `kind` and `value`.
pub(super) struct GridLine {
    pub kind: &'static str,
    pub value: f64,
    pub line: Vec<DVec2>,
}

/// Returns the lines of a graticule on land with the georeference `place` and `samples` columns and rows.
///
/// # Errors
/// Returns why the land has no such lines, as a clause.
pub(super) fn lines(graticule: Graticule, place: &Georeference, samples: [u32; 2]) -> Result<Vec<GridLine>, String> {
    match graticule {
        Graticule::Degrees(step) => {
            let land = OnLand::of_degrees(place, samples)?;
            let [west, south, mut east, north] = GridOnWgs84::new(place, samples)?
                .bounds_deg()
                .ok_or_else(|| "the sides of the land have no longitudes".to_owned())?;
            if east < west {
                east += 360.0;
            }
            let on_grid = |at: DVec2| land.grid(&[at.x, at.y, 0.0]);
            ruled(
                [DVec2::new(west, south), DVec2::new(east, north)],
                step,
                ["meridian", "parallel"],
                on_grid,
                |axis, value| rounded(if axis == 0 && value > 180.0 { value - 360.0 } else { value }),
            )
        }
        Graticule::Metres(step_m) => {
            let Crs::Projected { metres_per_unit, .. } = &place.crs else {
                return Err("the heights have no projected grid; give degrees, such as 0.1, or project the heights with gdalwarp".to_owned());
            };
            let mapping = WorldMapping::new(place, samples[0], samples[1]).map_err(|error| error.to_string())?;
            let last = DVec2::from_array(samples.map(|count| f64::from(count) - 1.0));
            let corners = [DVec2::ZERO, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y), last]
                .map(|grid| mapping.crs_from_world(mapping.world_from_grid(grid.x, grid.y)));
            let bounds = corners.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], corner| {
                [low.min(*corner), high.max(*corner)]
            });
            let on_grid = |at: DVec2| mapping.grid_from_world(mapping.world_from_crs(at));
            ruled(bounds, step_m / metres_per_unit, ["easting", "northing"], on_grid, |_, value| {
                rounded(value * metres_per_unit)
            })
        }
    }
}

/// Returns a coordinate without the noise of multiplication, so that conditions can name it.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Returns the lines of whole multiples of a step between two corners.
fn ruled(
    [low, high]: [DVec2; 2],
    step: f64,
    kinds: [&'static str; 2],
    on_grid: impl Fn(DVec2) -> DVec2,
    value_of: impl Fn(usize, f64) -> f64,
) -> Result<Vec<GridLine>, String> {
    let first = (low / step - ROUNDING).ceil();
    let last = (high / step + ROUNDING).floor();
    let counts = last - first + 1.0;
    if counts.max(DVec2::ZERO).element_sum() > MAX_LINES {
        let [x, y] = counts.to_array();
        return Err(format!("it would have {:.0} lines; at most {MAX_LINES} are drawn, so give a larger step", x + y));
    }
    let mut lines = Vec::new();
    for (axis, kind) in kinds.into_iter().enumerate() {
        let other = 1 - axis;
        for number in 0..counts[axis].max(0.0) as u32 {
            let value = (first[axis] + f64::from(number)) * step;
            // Rounding must not take a line on the border off the land.
            let place = value.clamp(low[axis], high[axis]);
            let at = |part: u32| {
                let mut at = DVec2::splat(place);
                at[other] = low[other] + (high[other] - low[other]) * f64::from(part) / f64::from(PARTS);
                on_grid(at)
            };
            let value = value_of(axis, value);
            lines.push(GridLine { kind, value, line: (0..=PARTS).map(at).collect() });
        }
    }
    Ok(lines)
}
