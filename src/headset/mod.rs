//! A headset: fly over a world with two eyes in it, through OpenXR on Vulkan.
//!
//! [`Runtime::connect`] asks for the loader, the runtime and the headset first, so that what is missing is told before
//! anything is opened. [`fly`] then flies until the runtime or the user ends it. `binding` is where OpenXR, Vulkan and
//! wgpu meet, and all that is unsafe; `session` follows the session's states, `swapchains` holds the images that the
//! runtime shows, `hands` hears the controllers, `stage` and `travel` say where in the world the room stands, and
//! `flight` draws the frames. `mirror` shows the left eye in a window, with the feature `window`.
//!
//! Why: `docs/decisions/headset.md`.

mod binding;
mod error;
mod flight;
mod hands;
mod hidden;
#[cfg(feature = "window")]
mod mirror;
#[cfg(not(feature = "window"))]
mod no_mirror;
pub mod session;
mod show;
pub mod stage;
pub mod swapchains;
pub mod travel;

#[cfg(not(feature = "window"))]
use no_mirror as mirror;

pub use error::HeadsetError;
pub use session::{Headset, Runtime};

use crate::frame::{Antialias, Light};
use crate::gpu::Gpu;
use crate::scene::camera::Camera;
use crate::world::Surfaces;

/// What is flown over.
pub struct HeadsetWorld {
    /// The land and what stands on it.
    pub surfaces: Surfaces,
    /// Sun and air.
    pub light: Light,
    /// Where the flight begins; its z is in the world's frame. The head brings its own pitch.
    pub start: Camera,
}

/// How to fly.
#[derive(Clone, Debug)]
pub struct HeadsetOptions {
    /// A preset or a style file.
    pub style: String,
    /// How frames smooth their edges.
    pub antialias: Antialias,
    /// Print the frame times and end after so many pictures.
    pub frames: Option<u64>,
}

/// Opens the headset of a runtime and flies over the world that `open` opens on its GPU.
///
/// # Errors
/// [`HeadsetError`].
pub fn fly(
    runtime: Runtime,
    options: &HeadsetOptions,
    open: impl FnOnce(&Gpu) -> anyhow::Result<HeadsetWorld>,
) -> Result<(), HeadsetError> {
    flight::fly(Headset::open(runtime)?, options, open)
}
