//! Levels of heights as surfaces: the registration of their samples, the filling of no-data, the bicubic surface
//! between samples, and the statistics of tiles and mesh patches.
//!
//! Everything here works on heights in memory, or on any `fill::HeightLevels`, and knows nothing of files. The modules
//! are listed in order of dependency: each uses only those above it.
//!
//! Why: `docs/decisions/one-surface.md`, `docs/decisions/voids.md`.

pub(crate) mod levels;
pub(crate) mod bicubic;
pub(crate) mod statistics;
pub(super) mod cell_errors;
pub(crate) mod occluder_minima;
pub(crate) mod loaded_tile;
pub(crate) mod tile_height;
pub(super) mod fill;
pub(super) mod field;
pub(super) mod overview;
pub(super) mod served;
