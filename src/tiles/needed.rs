//! The tiles that a view needs, and how urgently.
//!
//! A tile is needed where the surface's level (`surface_level` in `shaders/shared/terrain.wgsl`) may be as fine as the
//! tile's: the footprint of a pixel is finer than its parent's samples, or its parent's error would be visible. Parents
//! are always needed too, so that a missing tile has an ancestor that can be drawn instead. For a tile that has not
//! been loaded yet only the footprint is known, which is enough to request its children at the same time: after a jump,
//! levels are not loaded one after the other.

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::statistics::{TileStatistics, Voids};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::pyramid::{LevelSize, TileAddress, TileStore};
use crate::scene::frustum::{Bounds, Frustum};

/// The rule by which the surface chooses its level; shared with the shader.
#[derive(Clone, Debug)]
pub(crate) struct LevelRule {
    /// Position of the camera in the world, in metres.
    pub camera_m: DVec3,
    /// The view frusta.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian in the middle of the picture.
    pub focal_px: f64,
    /// The height error that the choice of the level may add, in pixels.
    pub error_px: f64,
    /// The curvature of the earth around this camera.
    pub earth_curvature: EarthCurvature,
}

/// A tile that a view needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Needed {
    pub address: TileAddress,
    /// Visible error of the parent that is drawn instead, approximately, in multiples of the allowed error; higher in
    /// the middle of the view. At most the parent's urgency.
    pub urgency: f32,
}

/// Cached positions of tiles in the world.
#[derive(Default)]
pub(crate) struct TilePlaces {
    places: FxHashMap<TileAddress, (DVec2, DVec2)>,
}

/// The size at which the cache is cleared: more than any view needs.
const MAX_PLACES: usize = 1 << 16;

impl TilePlaces {
    fn of(&mut self, levels: &[LevelSize], grid_projection: &GridProjection, tile: TileAddress) -> (DVec2, DVec2) {
        if self.places.len() > MAX_PLACES {
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

/// The land of a view.
pub(crate) struct Land<'a> {
    /// The source of its tiles.
    pub store: &'a dyn TileStore,
    /// The position of its samples in the world.
    pub grid_projection: &'a GridProjection,
}

/// Returns the tiles that `rule` needs, coarse levels first. `known` returns the statistics of loaded tiles.
pub(crate) fn needed<'a>(
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
        // Only neighbours that are needed themselves count: the statistics of others appear and disappear.
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

/// Returns the largest error of a tile and its neighbours, because the shader's continuous bound extends that far.
fn error_around_m<'a>(
    store: &dyn TileStore,
    known: &impl Fn(TileAddress) -> Option<&'a TileStatistics>,
    tile: TileAddress,
    statistics: &TileStatistics,
) -> f32 {
    if store.is_measured() {
        return statistics.corner_errors_m.into_iter().fold(statistics.error_m, f32::max);
    }
    // Estimates consider only their own tile.
    let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
    let neighbours = around.filter_map(|(dx, dy)| {
        let (x, y) = (tile.x.checked_add_signed(dx)?, tile.y.checked_add_signed(dy)?);
        known(TileAddress { x, y, ..tile })
    });
    neighbours.fold(statistics.error_m, |error_m, neighbours| error_m.max(neighbours.error_m))
}

/// Returns the urgency of the children of a tile, or `None` if they are not needed.
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
    // The surface may exceed its samples.
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
    // As in the vertex shader: of heights, only the whole terrain's range is known.
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

/// Returns the tiles of the next finer level whose samples are in a tile.
pub(super) fn children(levels: &[LevelSize], tile: TileAddress) -> impl Iterator<Item = TileAddress> + use<> {
    let fine = levels[tile.level as usize - 1];
    let range = |t: u32, count: u32| 2 * t..(2 * t + 2).min(count);
    let (columns, rows) = (range(tile.x, fine.tiles_x()), range(tile.y, fine.tiles_y()));
    rows.flat_map(move |y| columns.clone().map(move |x| TileAddress { level: tile.level - 1, x, y }))
}
