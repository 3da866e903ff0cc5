//! The tiles that a view needs, and how urgently.
//!
//! A tile is needed where the surface's level (`surface_level` in `shaders/shared/terrain.wgsl`) may be as fine as the
//! tile's: the footprint of a pixel is finer than its parent's samples, or its parent's error would be visible. Parents
//! are always needed too, so that a missing tile has an ancestor that can be drawn instead. For a tile that has not
//! been loaded yet only the footprint is known, which is enough to request its children at the same time: after a jump,
//! levels are not loaded one after the other.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use super::skyline::Skyline;
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
    /// The height error that the choice of the level may add, in pixels: half of the allowed error of the mesh.
    pub error_px: f64,
    /// The curvature of the earth around this camera.
    pub earth_curvature: EarthCurvature,
    /// Distance in metres that the camera may move before a tile is needed that was not found.
    pub margin_m: f64,
}

/// A tile that a view needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Needed {
    pub address: TileAddress,
    /// Visible error of the parent that is drawn instead, approximately, in multiples of the allowed error; higher in
    /// the middle of the view. At most the parent's urgency.
    pub urgency: f32,
    /// Factor of the width of a pixel from which on the tile is not needed ([`super::memory_factor`]). At most the
    /// parent's factor.
    pub factor: f32,
    /// Whether the statistics of all tiles above it are known; otherwise it may turn out that the view does not need it.
    pub is_certain: bool,
}

impl Needed {
    /// Returns a tile that is needed at every factor, because the mesh or a map requests it.
    pub(super) fn requested(address: TileAddress, urgency: f32) -> Self {
        Self { address, urgency, factor: 1.0, is_certain: true }
    }
}

/// Cached bounds of tiles in the plane: the south-western and the north-eastern corner, in metres east and north.
#[derive(Default)]
pub(crate) struct TileBounds {
    bounds: FxHashMap<TileAddress, (DVec2, DVec2)>,
}

/// The number of tiles at which the cache of their bounds is cleared: more than any view needs.
const MAX_CACHED_TILES: usize = 1 << 16;

impl TileBounds {
    fn of(&mut self, levels: &[LevelSize], grid_projection: &GridProjection, tile: TileAddress) -> (DVec2, DVec2) {
        if self.bounds.len() > MAX_CACHED_TILES {
            self.bounds.clear();
        }
        *self.bounds.entry(tile).or_insert_with(|| {
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

/// Returns the tiles that `rule` needs, coarse levels first. `known` returns the statistics of loaded tiles. The error of
/// other tiles counts as `guess` times their parent's: with 0, their children are needed only if the footprint of a pixel
/// requires it.
pub(crate) fn needed<'a>(
    land: &Land<'_>,
    tile_bounds: &mut TileBounds,
    known: impl Fn(TileAddress) -> Option<&'a TileStatistics>,
    rule: &LevelRule,
    guess: f32,
) -> Vec<Needed> {
    let levels = land.store.levels();
    let mut needed = Vec::new();
    let top = levels.len() as u32 - 1;
    let is_measured = land.store.is_measured();
    let mut wave = vec![(
        Needed {
            address: TileAddress { level: top, x: 0, y: 0 },
            urgency: f32::MAX,
            factor: f32::MAX,
            is_certain: true,
        },
        land.store.range_m(),
        0.0,
    )];
    while !wave.is_empty() {
        needed.extend(wave.iter().map(|(tile, ..)| *tile));
        let mut next = Vec::new();
        // Only neighbours that are needed themselves count: the statistics of others appear and disappear.
        let of_tile = |(tile, ..): &(Needed, _, _)| Some((tile.address, known(tile.address)?.error_m));
        let errors_m: FxHashMap<TileAddress, f32> = match is_measured {
            true => FxHashMap::default(),
            false => wave.iter().filter_map(of_tile).collect(),
        };
        for (tile, range_m, guessed_m) in wave {
            let statistics = known(tile.address);
            let range_m = statistics.map_or(range_m, |known| [known.min_m, known.max_m]);
            if statistics.is_some_and(|known| known.voids == Voids::All) {
                continue;
            }
            let error_m = || statistics.map_or(guessed_m, |known| error_around_m(&errors_m, tile.address, known));
            let below = urgency_below(land, tile_bounds, rule, tile.address, error_m, range_m);
            let Some(below) = below else { continue };
            let (urgency, factor) = (below.urgency.min(tile.urgency), below.factor.min(tile.factor));
            let finer = children(levels, tile.address).filter(|child| land.store.has_tile(*child));
            let guessed_m = if guess > 0.0 { guess * error_m() } else { 0.0 };
            let is_certain = tile.is_certain && statistics.is_some();
            next.extend(finer.map(|address| (Needed { address, urgency, factor, is_certain }, range_m, guessed_m)));
        }
        wave = next;
    }
    needed
}

/// Returns whether a view needs a tile, as seen from its parent, which is loaded and has these statistics. `factor` is the
/// factor of the width of a pixel ([`Needed::factor`]).
pub(crate) fn is_needed(
    land: &Land<'_>,
    tile_bounds: &mut TileBounds,
    rule: &LevelRule,
    parent: (TileAddress, &TileStatistics),
    factor: f64,
) -> bool {
    let (parent, statistics) = parent;
    let error_m = || statistics.corner_errors_m.into_iter().fold(statistics.error_m, f32::max);
    let range_m = [statistics.min_m, statistics.max_m];
    urgency_below(land, tile_bounds, rule, parent, error_m, range_m)
        .is_some_and(|below| f64::from(below.factor) > factor)
}

/// Returns the largest error of a tile and its neighbours, because the shader's continuous bound extends that far.
/// `errors_m` has the errors of the neighbours if they are estimates, which consider only their own tile; measured errors
/// consider the corners.
fn error_around_m(errors_m: &FxHashMap<TileAddress, f32>, tile: TileAddress, statistics: &TileStatistics) -> f32 {
    if errors_m.is_empty() {
        return statistics.corner_errors_m.into_iter().fold(statistics.error_m, f32::max);
    }
    let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
    let neighbours = around.filter_map(|(dx, dy)| {
        let (x, y) = (tile.x.checked_add_signed(dx)?, tile.y.checked_add_signed(dy)?);
        errors_m.get(&TileAddress { x, y, ..tile })
    });
    neighbours.fold(statistics.error_m, |error_m, neighbour_m| error_m.max(*neighbour_m))
}

/// Returns the box of a tile's land on the flat map, relative to the camera, with the rule's margin. `range_m` is the
/// range of its heights.
fn flat_bounds(
    land: &Land<'_>,
    tile_bounds: &mut TileBounds,
    rule: &LevelRule,
    tile: TileAddress,
    range_m: [f32; 2],
) -> Bounds {
    let (low, high) = tile_bounds.of(land.store.levels(), land.grid_projection, tile);
    // The surface may exceed its samples.
    let slack_m = f64::from(OVERSHOOT * (range_m[1] - range_m[0])).max(0.0);
    let low_m = low.extend(f64::from(range_m[0]) - slack_m) - rule.camera_m - rule.margin_m;
    let high_m = high.extend(f64::from(range_m[1]) + slack_m) - rule.camera_m + rule.margin_m;
    Bounds { low_m, high_m }
}

/// Returns whether nearer land hides a tile whose heights are known, from anywhere within the rule's margin, even if it
/// looked higher by `slack`, in height per distance. `skyline` is layered.
pub(crate) fn is_hidden(
    land: &Land<'_>,
    tile_bounds: &mut TileBounds,
    rule: &LevelRule,
    tile: TileAddress,
    range_m: [f32; 2],
    skyline: &Skyline,
    slack: f64,
) -> bool {
    let flat = flat_bounds(land, tile_bounds, rule, tile, range_m);
    rule.earth_curvature.bend_bounds(&flat).is_none_or(|bounds| skyline.hides_behind(&bounds, slack))
}

/// The urgency with which the children of a tile are needed.
struct Below {
    urgency: f32,
    /// Factor from which on the children are not needed ([`Needed::factor`]).
    factor: f32,
}

/// Returns how urgently the children of a tile are needed, or `None` if they are not. `error_m` returns the error of the
/// tile.
fn urgency_below(
    land: &Land<'_>,
    tile_bounds: &mut TileBounds,
    rule: &LevelRule,
    tile: TileAddress,
    error_m: impl FnOnce() -> f32,
    range_m: [f32; 2],
) -> Option<Below> {
    if tile.level == 0 {
        return None;
    }
    let flat = flat_bounds(land, tile_bounds, rule, tile, range_m);
    let (low, high) = (flat.low_m.truncate(), flat.high_m.truncate());
    let bounds = rule.earth_curvature.bend_bounds(&flat)?;
    if !rule.frusta.iter().any(|view| view.may_see(&bounds)) {
        return None;
    }
    // As in the vertex shader: of heights, only the whole terrain's range is known.
    let nearest = DVec2::ZERO.clamp(low, high);
    let [min_m, max_m] = land.store.range_m().map(f64::from);
    let dz_m = 0_f64.clamp(min_m - rule.margin_m - rule.camera_m.z, max_m + rule.margin_m - rule.camera_m.z);
    let pixel_m = nearest.extend(dz_m).length() / rule.focal_px;
    // Width of a pixel and of the tile's samples, in samples of the finest level.
    let (pixel, samples) = (pixel_m / land.grid_projection.spacing_m(), f64::from(1_u32 << tile.level.min(31)));
    let seen = f64::from(error_m()) / (rule.error_px * pixel_m);
    let factor = (samples / pixel).max(seen);
    if factor <= 1.0 {
        return None;
    }
    let coarser = samples / pixel.max(1.0);
    let aside = rule.frusta.iter().map(|view| view.aside(&bounds)).fold(f64::INFINITY, f64::min);
    let urgency = (seen.max(coarser) * (0.5 + 0.5 * aside.cos())).min(1e30) as f32;
    Some(Below { urgency, factor: factor.min(1e30) as f32 })
}

/// Returns the tiles of the next finer level whose samples are in a tile.
pub(super) fn children(levels: &[LevelSize], tile: TileAddress) -> impl Iterator<Item = TileAddress> + use<> {
    let fine = levels[tile.level as usize - 1];
    let range = |t: u32, count: u32| 2 * t..(2 * t + 2).min(count);
    let (columns, rows) = (range(tile.x, fine.tiles_x()), range(tile.y, fine.tiles_y()));
    rows.flat_map(move |y| columns.clone().map(move |x| TileAddress { level: tile.level - 1, x, y }))
}
