//! Which tiles a view needs, and how urgently.
//!
//! A tile is needed where the surface's level (`surface_level` in `shaders/shared/terrain.wgsl`) may reach down to it:
//! the footprint of a pixel is finer than its parent's samples, or its parent's error would be seen. Parents are always
//! needed too, so a tile that is not there has an ancestor that stands in. Of a tile that has not come yet only the
//! footprint is known, and that is enough to ask for its children at the same time: a jump does not wait for one level
//! after the other.

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::statistics::{TileStatistics, Voids};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::pyramid::{LevelSize, TileAddress, TileStore};
use crate::scene::frustum::{Bounds, Frustum};

/// How the surface chooses its level; shared with the shader.
#[derive(Clone, Debug)]
pub struct LevelRule {
    /// The camera's place in the world, in metres.
    pub camera_m: DVec3,
    /// What is in view.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian in the middle of the picture.
    pub focal_px: f64,
    /// Height error that the choice of the level may add, in pixels.
    pub error_px: f64,
    /// The curvature of the earth around this camera.
    pub earth_curvature: EarthCurvature,
}

/// A tile that a view needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed {
    /// The tile.
    pub address: TileAddress,
    /// How many times the allowed error is seen, about, while its parent stands in; more in the middle of the view.
    /// Never more than its parent's.
    pub urgency: f32,
}

/// Places of tiles in the world: worked out once.
#[derive(Default)]
pub struct TilePlaces {
    places: FxHashMap<TileAddress, (DVec2, DVec2)>,
}

/// More than any view needs; then it starts anew.
const MOST_PLACES: usize = 1 << 16;

impl TilePlaces {
    fn of(&mut self, levels: &[LevelSize], grid_projection: &GridProjection, tile: TileAddress) -> (DVec2, DVec2) {
        if self.places.len() > MOST_PLACES {
            self.places.clear();
        }
        *self.places.entry(tile).or_insert_with(|| {
            let (finest, size) = (levels[0], levels[tile.level as usize]);
            let scale = DVec2::new(
                f64::from(finest.width) / f64::from(size.width),
                f64::from(finest.height) / f64::from(size.height),
            );
            let last = DVec2::new(f64::from(finest.width - 1), f64::from(finest.height - 1));
            let side = f64::from(TILE_SAMPLES);
            let first = DVec2::new(f64::from(tile.x), f64::from(tile.y)) * side * scale - 1.0;
            let end = (first + side * scale + 2.0).min(last);
            grid_projection.bounds(first.clamp(DVec2::ZERO, last), end)
        })
    }
}

/// The land that a view is held against.
pub struct Land<'a> {
    /// Where its tiles come from.
    pub store: &'a dyn TileStore,
    /// Where its samples lie in the world.
    pub grid_projection: &'a GridProjection,
}

/// The tiles that `rule` needs, coarse levels first. `known` tells what is known of a tile that has come.
pub fn needed<'a>(
    land: &Land<'_>,
    places: &mut TilePlaces,
    known: impl Fn(TileAddress) -> Option<&'a TileStatistics>,
    rule: &LevelRule,
) -> Vec<Needed> {
    let levels = land.store.levels();
    let mut needed = Vec::new();
    let top = levels.len() as u32 - 1;
    let mut wave =
        vec![(Needed { address: TileAddress { level: top, x: 0, y: 0 }, urgency: f32::MAX }, land.store.range_m())];
    while !wave.is_empty() {
        needed.extend(wave.iter().map(|(tile, _)| *tile));
        let mut next = Vec::new();
        // Neighbours count when they are needed themselves: what is known of others changes as they come and go.
        let met: FxHashSet<TileAddress> = wave.iter().map(|(tile, _)| tile.address).collect();
        let known_and_met = |address| known(address).filter(|_| met.contains(&address));
        for (tile, range_m) in wave {
            let statistics = known(tile.address);
            let range_m = statistics.map_or(range_m, |known| [known.min_m, known.max_m]);
            let error_m = statistics
                .map_or(0.0, |statistics| error_around_m(land.store, &known_and_met, tile.address, statistics));
            if statistics.is_some_and(|known| known.voids == Voids::All) {
                continue;
            }
            let Some(urgency) = urgency_below(land, places, rule, tile.address, error_m, range_m) else { continue };
            let urgency = urgency.min(tile.urgency);
            let finer = children(levels, tile.address).filter(|child| land.store.has_tile(*child));
            next.extend(finer.map(|address| (Needed { address, urgency }, range_m)));
        }
        wave = next;
    }
    needed
}

/// The largest error of a tile and its neighbours: the shader's continuous bound reaches that far.
fn error_around_m<'a>(
    store: &dyn TileStore,
    known: &impl Fn(TileAddress) -> Option<&'a TileStatistics>,
    tile: TileAddress,
    statistics: &TileStatistics,
) -> f32 {
    if store.is_measured() {
        return statistics.corner_errors_m.into_iter().fold(statistics.error_m, f32::max);
    }
    // Estimates know only their own tile.
    let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
    let beside = around.filter_map(|(dx, dy)| {
        let (x, y) = (tile.x.checked_add_signed(dx)?, tile.y.checked_add_signed(dy)?);
        known(TileAddress { x, y, ..tile })
    });
    beside.fold(statistics.error_m, |error_m, beside| error_m.max(beside.error_m))
}

/// How urgently the children of a tile are needed; none if they are not.
fn urgency_below(
    land: &Land<'_>,
    places: &mut TilePlaces,
    rule: &LevelRule,
    tile: TileAddress,
    error_m: f32,
    range_m: [f32; 2],
) -> Option<f32> {
    if tile.level == 0 {
        return None;
    }
    let (low, high) = places.of(land.store.levels(), land.grid_projection, tile);
    let (low, high) = (low - rule.camera_m.truncate(), high - rule.camera_m.truncate());
    // The surface overshoots its samples.
    let slack_m = f64::from(OVERSHOOT * (range_m[1] - range_m[0])).max(0.0);
    let at_height = |z_m: f32, slack_m: f64| f64::from(z_m) + slack_m - rule.camera_m.z;
    let bounds = Bounds {
        low_m: low.extend(at_height(range_m[0], -slack_m)),
        high_m: high.extend(at_height(range_m[1], slack_m)),
    };
    let bounds = rule.earth_curvature.bend_bounds(&bounds)?;
    if !rule.frusta.iter().any(|view| view.may_see(&bounds)) {
        return None;
    }
    // As the vertex shader does: in height, only the whole terrain's range is known.
    let flat = DVec2::ZERO.clamp(low, high);
    let [min_m, max_m] = land.store.range_m().map(f64::from);
    let dz_m = 0_f64.clamp(min_m - rule.camera_m.z, max_m - rule.camera_m.z);
    let pixel_m = flat.extend(dz_m).length() / rule.focal_px;
    let wanted = (pixel_m / land.grid_projection.spacing_m()).log2();
    let seen = f64::from(error_m) / (rule.error_px * pixel_m);
    if wanted >= f64::from(tile.level) && seen <= 1.0 {
        return None;
    }
    let coarser = (f64::from(tile.level) - wanted.max(0.0)).exp2();
    let aside = rule.frusta.iter().map(|view| view.aside(&bounds)).fold(f64::INFINITY, f64::min);
    Some((seen.max(coarser) * (0.5 + 0.5 * aside.cos())).min(1e30) as f32)
}

/// The tiles of the next finer level whose samples lie in a tile.
pub(super) fn children(levels: &[LevelSize], tile: TileAddress) -> impl Iterator<Item = TileAddress> + use<> {
    let fine = levels[tile.level as usize - 1];
    let range = |t: u32, count: u32| 2 * t..(2 * t + 2).min(count);
    let (columns, rows) = (range(tile.x, fine.tiles_x()), range(tile.y, fine.tiles_y()));
    rows.flat_map(move |y| columns.clone().map(move |x| TileAddress { level: tile.level - 1, x, y }))
}
