//! hachure draws real terrain of any size in real time as ink, pencil, wash or print.
//!
//! The modules are listed in the order in which data flows. A module uses only modules above it.
//!
//! ```text
//! source ─▶ pyramid ─▶ tiles ─▶ surface ─▶ lines, tones ─▶ composite ─▶ picture, window, headset
//! ```
//!
//! What is public is the API: open a world ([`world`], [`source`], [`pyramid`], [`remote`]), describe a view and a style
//! ([`scene`], [`style`]), draw ([`gpu`], [`frame`], [`picture`]), read and write files ([`mod@file`]), and measure
//! ([`measure`]). All other modules are internal. `examples/heights_in_memory.rs` draws a picture in fifty lines.
//!
//! `ARCHITECTURE.md` follows one frame and one tile through the modules. `docs/decisions` has one page for each design
//! decision, with its reasons.

#![cfg_attr(
    not(all(feature = "window", feature = "network")),
    allow(dead_code, unused_imports, reason = "a program without window or network uses fewer of the internals")
)]
#![warn(clippy::print_stdout, clippy::print_stderr, reason = "these macros panic on a closed pipe: use file::standard")]

pub mod file;
pub mod gpu;
pub mod remote;
pub mod source;
pub mod pyramid;
mod mesh;
pub mod scene;
mod forest;
pub mod style;
mod tiles;
pub mod world;
mod surface;
mod lines;
mod tones;
mod composite;
pub mod frame;
mod lettering;
mod vector;
pub mod picture;
pub mod measure;
#[cfg(feature = "window")]
mod window;
#[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
pub mod headset;
pub mod commands;

/// Internals that the programs in `tests`, `benches` and `examples` of this repository use. They are not part of the
/// API.
#[doc(hidden)]
pub mod internals {
    pub use crate::lines::strokes::texture;
    pub use crate::mesh::obj;
    pub use crate::tiles::budget::most_patches;
    pub use crate::tiles::grid_projection::GridProjection;
    pub use crate::tiles::patches::AllPatches;
    pub use crate::tiles::select::{select, select_within};
    pub use crate::tiles::selection::Viewpoint;
}

#[cfg(test)]
extern crate self as hachure;
#[cfg(test)]
mod tests;
