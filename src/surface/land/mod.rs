//! The land: patches of the terrain's mesh, and the bicubic surface that they follow.

pub(crate) mod edges;
pub(crate) mod horizons;
pub(crate) mod raster;
pub(crate) mod resolve;
pub(crate) mod vertices;
