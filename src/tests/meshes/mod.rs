//! Tests of models on the land: their files, edges, strokes and surface.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

mod colours;
mod cull;
mod edges;
mod huge;
mod levels;
mod materials;
mod reader;
mod scene;
use crate::tests::helpers::shapes;
mod simplified;
mod strokes;
mod surface;
