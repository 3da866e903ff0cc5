//! Flights in a headset: draws a world for both eyes, through OpenXR on Vulkan.
//!
//! [`Runtime::connect`] looks for the loader, the runtime and the headset first, so that anything missing is reported
//! before the world is opened. [`fly`] then flies until the runtime or the user ends it. `binding` connects OpenXR,
//! Vulkan and wgpu, and contains all unsafe code; `session` follows the session's states, `swapchains` holds the images
//! that the runtime shows, `hands` reads the controllers, `stage` and `travel` place the room in the world, and
//! `flight` draws the frames. `opening` opens the world in the background. `panel` draws what the panel in the room
//! shows, `quad` hands it to the runtime, `menu` says which page it has, `controllers` lists the controls of each
//! controller, and `styles` holds the styles to choose from. `mirror` shows the left eye in a window, with the feature
//! `window`.
//!
//! Why: `docs/decisions/headset.md`.

mod binding;
mod controllers;
mod error;
mod flight;
mod hands;
mod hidden;
mod menu;
#[cfg(feature = "window")]
mod mirror;
#[cfg(not(feature = "window"))]
mod no_mirror;
mod opening;
mod panel;
mod quad;
pub(crate) mod session;
mod show;
pub(crate) mod stage;
mod styles;
pub(crate) mod swapchains;
pub(crate) mod travel;

#[cfg(not(feature = "window"))]
use no_mirror as mirror;

pub use error::HeadsetError;
pub(crate) use session::Headset;
pub use session::Runtime;

use crate::frame::{Antialias, Light};
use crate::gpu::Gpu;
use crate::ladder::Quality;
use crate::measure::quality::Front;
use crate::scene::camera::Camera;
use crate::source::Progress;
use crate::world::Surfaces;

/// The world that the flight shows.
pub struct HeadsetWorld {
    /// Land, models and trees.
    pub surfaces: Surfaces,
    /// Sun and haze.
    pub light: Light,
    /// Camera at the start; its z is absolute, in the world's frame. The pitch is ignored: it comes from the head.
    pub start: Camera,
}

/// Options of a flight in a headset.
#[derive(Clone, Debug)]
pub(crate) struct HeadsetOptions {
    /// The name of the world, for the panel in the headset.
    pub name: String,
    /// A preset or a style file.
    pub style: String,
    /// Smoothing of edges.
    pub antialias: Antialias,
    /// Allowed error of the land, in pixels.
    pub lod_error_px: f64,
    /// The exactness with which the style is drawn.
    pub quality: Quality,
    /// Measured settings of styles, for [`HeadsetOptions::quality`], in place of those of presets.
    pub fronts: Vec<Front>,
    /// Print the frame times, and end after this many frames.
    pub frames: Option<u64>,
}

/// Opens a world on the headset's GPU. It is called on another thread, reports its progress, and ends soon with an error
/// when the progress says so.
pub type OpenFn = Box<dyn FnOnce(&Gpu, &dyn Progress) -> anyhow::Result<HeadsetWorld> + Send>;

/// Opens the headset of a runtime, and flies over the world that `open` opens while the session already runs.
///
/// # Errors
/// Returns a [`HeadsetError`] if something cannot be opened or fails later.
pub(crate) fn fly(runtime: Runtime, options: HeadsetOptions, open: OpenFn) -> Result<(), HeadsetError> {
    flight::fly(Headset::open(runtime)?, options, open)
}
