//! The window: fly over a world, and see what its drawing costs.
//!
//! [`Windowing`] asks the system for a window first, so that a machine without a display says so before anything is
//! opened. [`Windowing::run`] then flies until the window is closed. `app` speaks with winit, `flight` holds the state
//! of a flight and draws its frames, `input` turns events into wishes; the rest are parts without a window in them.

mod app;
mod clipboard;
mod flight;
pub mod fly_camera;
mod gamepad;
mod input;
mod keys;
mod overlay;
mod panel;
mod screen;
mod screenshot;
mod settings;
mod statistics;
mod toasts;

use winit::event_loop::EventLoop;

use crate::file::FileError;
use crate::frame::{Antialias, Light};
use crate::gpu::device::AdapterWish;
use crate::gpu::{Gpu, GpuError};
use crate::scene::Sun;
use crate::scene::camera::Camera;
use crate::scene::stereo::{Eyes, Pair};
use crate::style::StyleError;
use crate::world::Surfaces;

/// Why there is no flight, or why it ended.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// The system has no display for this program.
    #[error("there is no display to open a window on ({cause}); `hachure render` draws into a file without one")]
    NoDisplay {
        /// What the system said.
        cause: String,
    },
    /// The window was not made.
    #[error("cannot open a window: {0}")]
    Window(#[from] winit::error::OsError),
    /// The system's events stopped.
    #[error("the window system failed: {0}")]
    Events(#[from] winit::error::EventLoopError),
    /// The GPU cannot show pictures in a window.
    #[error("cannot draw into the window: {0}")]
    Surface(#[from] wgpu::CreateSurfaceError),
    /// Nor can this one.
    #[error("{adapter} cannot draw into this window")]
    NoPresent {
        /// The GPU.
        adapter: String,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The style does not hold.
    #[error(transparent)]
    Style(#[from] StyleError),
    /// What `--frames` tells cannot be written.
    #[error(transparent)]
    Output(#[from] FileError),
    /// The world does not open.
    #[error(transparent)]
    World(anyhow::Error),
}

/// What is flown over.
pub struct FlightWorld {
    /// For the window's title.
    pub name: String,
    /// The land and what stands on it.
    pub surfaces: Surfaces,
    /// The air; its sun is [`FlightWorld::sun`].
    pub light: Light,
    /// Where the light comes from.
    pub sun: Sun,
    /// Where the flight begins; its z is in the world's frame.
    pub start: Camera,
}

/// How to fly.
#[derive(Clone, Debug)]
pub struct FlightOptions {
    /// A preset or a style file.
    pub style: String,
    /// Of the window, to begin with.
    pub size_px: [u32; 2],
    /// How frames smooth their edges, to begin with.
    pub antialias: Antialias,
    /// Which GPU.
    pub adapter: AdapterWish,
    /// Render without rest, and quit after so many pictures.
    pub frames: Option<u64>,
    /// Which eyes are shown, to begin with.
    pub eyes: Eyes,
    /// How two eyes stand to each other, to begin with.
    pub pair: Pair,
    /// Whether they stand apart by the nearest land.
    pub follows_land: bool,
}

/// Opens a world on the GPU that the window chose.
pub type OpenWorldFn = Box<dyn FnOnce(&Gpu) -> anyhow::Result<FlightWorld>>;

/// The connection to the window system.
pub struct Windowing {
    events: EventLoop<()>,
}

impl Windowing {
    /// Connects.
    ///
    /// # Errors
    /// [`WindowError::NoDisplay`].
    pub fn new() -> Result<Self, WindowError> {
        let events = app::event_loop().map_err(|cause| WindowError::NoDisplay { cause })?;
        Ok(Self { events })
    }

    /// The system's events, for a window that is not a flight's.
    #[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
    pub(crate) fn into_events(self) -> EventLoop<()> {
        self.events
    }

    /// Flies until the window is closed.
    ///
    /// # Errors
    /// When the window, the GPU or the world does not open, or the GPU fails on the way.
    pub fn run(self, options: FlightOptions, open: OpenWorldFn) -> Result<(), WindowError> {
        app::run(self.events, options, open)
    }
}
