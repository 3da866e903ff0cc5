//! A store of tiles with exaggerated heights.

use std::sync::Arc;

use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::{TileAddress, flagged, is_void};
use crate::source::georeference::Georeference;

/// Another store with every height, and every error of a height, multiplied by a factor above 0.
pub(crate) struct Exaggerated {
    inner: Arc<dyn TileStore>,
    factor: f32,
    coarse_patches: Vec<Vec<PatchStatistics>>,
}

impl Exaggerated {
    /// Wraps `inner`; returns `inner` itself if `factor` is 1.
    pub(crate) fn over(inner: Arc<dyn TileStore>, factor: f64) -> Arc<dyn TileStore> {
        if factor == 1.0 {
            return inner;
        }
        let factor = factor as f32;
        let mut coarse_patches = inner.coarse_patches().to_vec();
        coarse_patches.iter_mut().flatten().for_each(|patch| exaggerate(patch, factor));
        Arc::new(Self { inner, factor, coarse_patches })
    }
}

fn exaggerate(patch: &mut PatchStatistics, factor: f32) {
    patch.min_m *= factor;
    patch.max_m *= factor;
    patch.mesh_error_m *= factor;
}

impl TileStore for Exaggerated {
    fn name(&self) -> String {
        self.inner.name()
    }

    fn levels(&self) -> &[LevelSize] {
        self.inner.levels()
    }

    fn georeference(&self) -> &Georeference {
        self.inner.georeference()
    }

    fn range_m(&self) -> [f32; 2] {
        self.inner.range_m().map(|height_m| height_m * self.factor)
    }

    fn is_measured(&self) -> bool {
        self.inner.is_measured()
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.coarse_patches
    }

    fn has_tile(&self, address: TileAddress) -> bool {
        self.inner.has_tile(address)
    }

    fn is_sparse(&self) -> bool {
        self.inner.is_sparse()
    }

    fn parallel_fetches(&self) -> usize {
        self.inner.parallel_fetches()
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let decode = Arc::clone(&self.inner).fetch(address, cancel)?;
        let factor = self.factor;
        Ok(Box::new(move || {
            let LoadedTile { mut tile, mut statistics, mut patches, .. } = decode()?;
            for sample in &mut tile.samples {
                *sample = flagged(*sample * factor, is_void(*sample));
            }
            statistics.min_m *= factor;
            statistics.max_m *= factor;
            statistics.error_m *= factor;
            statistics.corner_errors_m = statistics.corner_errors_m.map(|error_m| error_m * factor);
            patches.patches_mut().iter_mut().for_each(|patch| exaggerate(patch, factor));
            Ok(LoadedTile::new(tile, statistics, patches))
        }))
    }
}
