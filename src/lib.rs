//! hachure draws real terrain of any size in real time as ink, pencil, wash or print.
//!
//! The modules are listed in the order in which data flows. A module uses only modules above it.
//!
//! ```text
//! source ─▶ pyramid ─▶ tiles ─▶ surface ─▶ lines, tones ─▶ composite ─▶ picture, window, headset
//! ```
//!
//! `ARCHITECTURE.md` follows one frame and one tile through the modules. `docs/decisions` has one page for each design
//! decision, with its reasons.

#![warn(clippy::print_stdout, clippy::print_stderr, reason = "these macros panic on a closed pipe: use file::standard")]

pub mod file;
pub mod gpu;
pub mod remote;
pub mod source;
pub mod pyramid;
pub mod mesh;
pub mod scene;
pub mod forest;
pub mod style;
pub mod tiles;
pub mod world;
pub mod surface;
pub mod lines;
pub mod tones;
pub mod composite;
pub mod frame;
pub mod lettering;
pub mod vector;
pub mod picture;
pub mod measure;
#[cfg(feature = "window")]
pub mod window;
#[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
pub mod headset;
pub mod commands;

#[cfg(test)]
extern crate self as hachure;
#[cfg(test)]
mod tests;
