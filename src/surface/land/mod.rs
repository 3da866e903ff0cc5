//! The land: patches of the terrain's mesh, and the bicubic surface that they follow.

pub mod edges;
pub mod horizons;
pub mod raster;
pub mod resolve;
pub mod vertices;
