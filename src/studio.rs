//! The studio, as far as it needs no window: a style that is being edited, with its history and its file.
//!
//! [`document`] holds the text of a style with everything that follows from it, and is the only way to change it.
//! [`controls`] moves several parameters at once, [`favourites`] is part of the settings file, [`folder`] finds style
//! files, [`history`] keeps the steps that can be undone, [`rows`] lists what an inspector shows, [`unsaved`] keeps edits over a
//! crash, and [`watch`] reports when files change outside of the program.

mod controls;
pub(crate) mod document;
pub(crate) mod favourites;
pub(crate) mod folder;
mod history;
pub(crate) mod rows;
mod saving;
pub(crate) mod unsaved;
pub(crate) mod watch;

#[cfg(test)]
mod tests;
