//! A tile as a store returns it: its heights and statistics.

use std::sync::Arc;

use super::occluder_minima::OccluderMinima;
use super::statistics::{PatchPage, TileStatistics};
use crate::pyramid::tile::Tile;

/// A decoded tile with its statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTile {
    /// The heights, with no-data filled and flagged.
    pub tile: Tile,
    /// Height range, errors and no-data of the tile.
    pub statistics: TileStatistics,
    /// Height range, mesh error and no-data of the mesh patches of the tile's page.
    pub patches: PatchPage,
    /// Lower bounds of the tile's land, by blocks, for occlusion culling.
    pub occluder_minima: Arc<OccluderMinima>,
}

impl LoadedTile {
    /// Combines heights and statistics, from which it computes the occluder minima.
    pub fn new(tile: Tile, statistics: TileStatistics, patches: PatchPage) -> Self {
        let occluder_minima = Arc::new(OccluderMinima::of(&tile, &statistics));
        Self { tile, statistics, patches, occluder_minima }
    }
}
