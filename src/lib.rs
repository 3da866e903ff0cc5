//! hachure draws real terrain of any size in real time as ink, pencil, wash or print.
//!
//! The modules are listed in the order in which data flows. A module uses only modules above it.
//!
//! ```text
//! source ─▶ pyramid ─▶ tiles ─▶ surface ─▶ lines, tones ─▶ composite ─▶ picture, window, headset
//! ```
//!
//! The public items are the API: open a world ([`world`], [`source`], [`pyramid`], [`remote`]), describe a view and a
//! style ([`scene`], [`style`]), draw ([`gpu`], [`frame`], [`picture`]), read and write files ([`mod@file`]), and
//! measure ([`measure`]). All other modules are internal. `examples/heights_in_memory.rs` draws a picture in fifty
//! lines.
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
mod peaks;
mod features;
mod mesh;
pub mod scene;
mod forest;
pub mod style;
mod tiles;
mod land_mesh;
mod drainage;
mod draped;
mod imagery;
pub mod world;
mod surface;
mod lines;
mod tones;
mod composite;
pub mod frame;
mod lettering;
mod labels;
mod vector;
pub mod picture;
pub(crate) mod governor;
pub mod measure;
#[cfg(any(feature = "window", feature = "headset"))]
mod ladder;
#[cfg(any(feature = "window", feature = "headset"))]
mod studio;
#[cfg(feature = "window")]
mod window;
#[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
pub mod headset;
#[doc(hidden)]
pub mod commands;

/// Internals that the program, and the programs in `tests`, `benches` and `examples` of this repository, use. They are
/// not part of the API.
#[doc(hidden)]
pub mod internals {
    pub use crate::commands::bench::portable::{page as portable_figures, passes as portable_passes};
    pub use crate::commands::render::like::check_like;
    pub use crate::file::cache_folder::open as own_cache_folder;
    pub use crate::file::message::{chain, one_line, printable};
    pub use crate::file::open_files::raise_file_limit;
    pub use crate::file::standard::print_to_stderr;
    pub use crate::gpu::readback::read;
    #[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
    pub use crate::headset::session::{Headset, SessionPhase, VIEWS};
    pub use crate::lines::strokes::texture;
    pub use crate::measure::lod_error::largest_px as largest_lod_error_px;
    pub use crate::measure::memory::rss_bytes;
    pub use crate::mesh::obj;
    pub use crate::picture::imprint::Imprint;
    pub use crate::picture::sheets::{Place, SheetWriter, Sheets, Wish, sheet_path};
    pub use crate::pyramid::format::sidecar_path;
    pub use crate::remote::blocks::BLOCK_BYTES;
    pub use crate::remote::disk::inspect;
    pub use crate::remote::file::RemoteFile;
    pub use crate::scene::mesh_list::read as read_mesh_list;
    pub use crate::source::folder::{Kind, kind_of, members};
    pub use crate::source::statistics::statistics;
    pub use crate::style::parameters::document;
    pub use crate::tiles::budget::max_patches;
    pub use crate::tiles::grid_projection::GridProjection;
    pub use crate::tiles::patches::AllPatches;
    pub use crate::tiles::select::{select, select_within};
    pub use crate::tiles::selection::Viewpoint;
    pub use crate::world::given_water::GivenWater;

    /// Returns the names of the five controls that every style has.
    #[cfg(any(feature = "window", feature = "headset"))]
    pub fn control_names() -> [&'static str; 5] {
        crate::style::controls::Control::ALL.map(crate::style::controls::Control::name)
    }

    /// Returns a style after one of its five controls was moved in the studio.
    ///
    /// # Errors
    /// The style cannot be read, or it would be invalid after the change.
    #[cfg(any(feature = "window", feature = "headset"))]
    pub fn with_control(style: &str, control: &str, to: i8) -> Result<crate::style::Style, crate::style::StyleError> {
        let mut document = crate::studio::document::StyleDocument::open(style)?;
        for known in crate::style::controls::Control::ALL {
            if known.name() == control {
                document.set_control(known, to)?;
            }
        }
        Ok(document.style().clone())
    }

    /// Reads the files that a scene names, for a world with this place and size, without a GPU.
    ///
    /// # Errors
    /// The first file that is invalid.
    pub fn read_scene_files(
        scene: &crate::scene::Scene,
        place: &crate::source::georeference::Georeference,
        samples: [u32; 2],
    ) -> Result<(), crate::world::WorldError> {
        crate::world::OpenWorld::read_files(scene, place, samples)
    }

    /// Returns the view for which the terrain selects tiles and patches, for a single eye.
    pub fn terrain_view(view: &crate::scene::view::View) -> crate::tiles::terrain::TerrainView {
        crate::frame::terrain_view_of(&crate::scene::view::Rig::mono(*view), 0.0)
    }
}

#[cfg(test)]
extern crate self as hachure;
#[cfg(test)]
mod tests;
