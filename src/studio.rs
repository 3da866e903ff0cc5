//! The part of the studio that needs no window: a style and a camera path that are being edited, with history and
//! files.
//!
//! [`document`] holds the text of a style with everything that follows from it, and is the only way to change it.
//! [`camera_path`] does the same for a camera path. [`controls`] moves several parameters at once, [`export`] makes
//! command lines of exports, [`favourites`] is part of the settings file, [`folder`] finds style files, [`history`]
//! keeps the steps that can be undone, [`neighbours`] finds the styles in which one edit switches something,
//! [`file_kind`] recognises the kind of a dropped file, [`recent`] lists the files that were opened last, [`rows`]
//! lists what an inspector shows, [`swatch`] draws small pictures of recipes, [`unsaved`] keeps edits over a crash,
//! [`views`] are the views of a world that the user has named, and [`watch`] reports when files change outside of the
//! program.

pub(crate) mod file_kind;
pub(crate) mod camera_path;
mod controls;
pub(crate) mod document;
pub(crate) mod export;
pub(crate) mod favourites;
pub(crate) mod folder;
pub(crate) mod history;
pub(crate) mod neighbours;
pub(crate) mod recent;
pub(crate) mod rows;
mod saving;
pub(crate) mod settings_file;
pub(crate) mod swatch;
pub(crate) mod unsaved;
pub(crate) mod views;
#[cfg(feature = "window")]
pub(crate) mod watch;

#[cfg(test)]
mod tests;
