//! A store of tiles with altered heights: exaggerated, or rounded as a lossy pyramid rounds them.

use std::sync::Arc;

use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::{TileAddress, flagged, is_void};
use crate::source::georeference::Georeference;

/// A change of the heights of a store.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Alteration {
    /// They are multiplied by a factor above 0, and so are their errors.
    Exaggerated(f32),
    /// They are rounded to the middles of steps that are twice this error in metres, as LERC does with the largest error of
    /// `hachure bake --max-error`. (LERC counts the steps of each block of samples from its lowest height.)
    Rounded(f32),
}

impl Alteration {
    fn height_m(self, height_m: f32) -> f32 {
        match self {
            Self::Exaggerated(factor) => height_m * factor,
            Self::Rounded(error_m) => 2.0 * error_m * (height_m / (2.0 * error_m)).round(),
        }
    }

    /// Returns the largest error of an altered height whose error was `error_m`.
    fn error_m(self, error_m: f32) -> f32 {
        match self {
            Self::Exaggerated(factor) => error_m * factor,
            Self::Rounded(more_m) => error_m + more_m,
        }
    }

    fn patch(self, patch: &mut PatchStatistics) {
        patch.min_m = self.height_m(patch.min_m);
        patch.max_m = self.height_m(patch.max_m);
        // Rounding leaves the distance of a patch's triangles from the heights about as it is.
        if let Self::Exaggerated(factor) = self {
            patch.mesh_error_m *= factor;
        }
    }
}

/// Another store with every height altered.
pub(crate) struct Altered {
    inner: Arc<dyn TileStore>,
    alteration: Alteration,
    coarse_patches: Vec<Vec<PatchStatistics>>,
}

impl Altered {
    /// Multiplies the heights of `inner` by a factor above 0; returns `inner` itself if the factor is 1.
    pub(crate) fn exaggerated(inner: Arc<dyn TileStore>, factor: f64) -> Arc<dyn TileStore> {
        if factor == 1.0 { inner } else { Self::over(inner, Alteration::Exaggerated(factor as f32)) }
    }

    /// Rounds the heights of `inner`, so that none changes by more than `error_m`; returns `inner` itself if that is 0.
    pub(crate) fn rounded(inner: Arc<dyn TileStore>, error_m: f64) -> Arc<dyn TileStore> {
        if error_m == 0.0 { inner } else { Self::over(inner, Alteration::Rounded(error_m as f32)) }
    }

    fn over(inner: Arc<dyn TileStore>, alteration: Alteration) -> Arc<dyn TileStore> {
        let mut coarse_patches = inner.coarse_patches().to_vec();
        coarse_patches.iter_mut().flatten().for_each(|patch| alteration.patch(patch));
        Arc::new(Self { inner, alteration, coarse_patches })
    }
}

impl TileStore for Altered {
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
        self.inner.range_m().map(|height_m| self.alteration.height_m(height_m))
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
        let alteration = self.alteration;
        Ok(Box::new(move || {
            let LoadedTile { mut tile, mut statistics, mut patches, .. } = decode()?;
            for sample in &mut tile.samples {
                *sample = flagged(alteration.height_m(*sample), is_void(*sample));
            }
            statistics.min_m = alteration.height_m(statistics.min_m);
            statistics.max_m = alteration.height_m(statistics.max_m);
            statistics.error_m = alteration.error_m(statistics.error_m);
            statistics.corner_errors_m = statistics.corner_errors_m.map(|error_m| alteration.error_m(error_m));
            patches.patches_mut().iter_mut().for_each(|patch| alteration.patch(patch));
            Ok(LoadedTile::new(tile, statistics, patches))
        }))
    }
}
