//! A tile as a store gives it away: its heights with all that is known of them.

use std::sync::Arc;

use super::occluder_minima::OccluderMinima;
use super::statistics::{PatchPage, TileStatistics};
use crate::pyramid::tile::Tile;

/// A tile with all that is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTile {
    /// The heights, voids filled and flagged.
    pub tile: Tile,
    /// Range, errors and voids of the tile.
    pub statistics: TileStatistics,
    /// Range, mesh error and voids of the mesh patches that come with it.
    pub patches: PatchPage,
    /// How low its land can be, by blocks: what it surely hides.
    pub occluder_minima: Arc<OccluderMinima>,
}

impl LoadedTile {
    /// From the heights and their statistics; the occluder minima follow from these.
    pub fn new(tile: Tile, statistics: TileStatistics, patches: PatchPage) -> Self {
        let occluder_minima = Arc::new(OccluderMinima::of(&tile, &statistics));
        Self { tile, statistics, patches, occluder_minima }
    }
}
