//! Levels of heights as surfaces: how their samples lie over one another, what stands where a void is, the one bicubic
//! surface between samples, and what is known of tiles and mesh patches without looking at them again.
//!
//! Everything here works on heights in memory, or on whatever is a `fill::HeightLevels`, and knows no file. The modules
//! are listed in order: each uses only those above it.
//!
//! Why: `docs/decisions/one-surface.md`, `docs/decisions/voids.md`.

pub mod levels;
pub mod bicubic;
pub mod statistics;
pub(super) mod cell_errors;
pub mod occluder_minima;
pub mod loaded_tile;
pub mod tile_height;
pub(super) mod fill;
pub(super) mod field;
pub(super) mod overview;
pub(super) mod served;
