//! The window: flies over a world and shows what its drawing costs.
//!
//! [`Windowing`] connects to the window system first, so that a machine without a display reports that before anything
//! else is opened. [`Windowing::run`] then flies until the window is closed. `app` handles winit's events, `flight`
//! holds the state of a flight and draws its frames, and `input` turns events into actions; the other modules do not
//! depend on a window.

mod app;
mod background;
mod browse;
mod camera_history;
mod camera_moves;
mod clipboard;
mod cost;
mod divider;
mod dock;
mod event_parts;
mod export;
mod flight;
pub(crate) mod fly_camera;
mod gallery;
mod gamepad;
mod help;
mod input;
mod inspector;
mod keys;
mod labels;
mod land_panel;
mod layer_picking;
mod light;
mod open_dialog;
mod opening;
mod other_world;
mod overlay;
mod panel;
mod path_flight;
mod path_panel;
mod picture_viewer;
mod pictures;
mod place_picking;
mod places;
mod probe;
mod questions;
pub(crate) mod remembered;
mod reopening;
mod scene_history;
mod screen;
mod screen_reader;
mod screenshot;
mod settings;
mod statistics;
mod status;
mod toasts;
mod welcome;
mod works;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use winit::event_loop::EventLoop;

pub(crate) use self::labels::LabelOptions;
use self::land_panel::LandPanel;
use self::remembered::Remembered;
use crate::file::FileError;
use crate::frame::{Antialias, Light};
use crate::gpu::device::AdapterWish;
use crate::gpu::{Gpu, GpuError};
use crate::ladder::Quality;
use crate::measure::quality::Front;
use crate::picture::imprint::More;
use crate::pyramid::TileStore;
use crate::scene::camera::Camera;
use crate::scene::reach::Reach;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::{Forest, Scene, Sun};
use crate::style::StyleError;
use crate::world::{OpenWorld, Surfaces};

/// Why a flight could not start, or why it ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WindowError {
    /// The system has no display for this program.
    #[error("no display to open a window on ({cause}); use `hachure render` to draw into a file")]
    NoDisplay {
        /// Message of the system.
        cause: String,
    },
    /// Creating the window failed.
    #[error("cannot open a window: {0}")]
    Window(#[from] winit::error::OsError),
    /// The event loop failed.
    #[error("the window system failed: {0}")]
    Events(#[from] winit::error::EventLoopError),
    /// The surface of the window could not be created.
    #[error("cannot draw into the window: {0}")]
    Surface(#[from] wgpu::CreateSurfaceError),
    /// The GPU cannot present to the window.
    #[error("{adapter} cannot draw into this window; choose another GPU with --adapter")]
    NoPresent {
        /// Name of the GPU.
        adapter: String,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The style is invalid.
    #[error(transparent)]
    Style(#[from] StyleError),
    /// The report of `--frames` cannot be written.
    #[error(transparent)]
    Output(#[from] FileError),
    /// The world cannot be opened.
    #[error(transparent)]
    World(anyhow::Error),
}

/// The world that the flight shows.
pub(crate) struct FlightWorld {
    /// Name for the window's title.
    pub name: String,
    /// Land, models and trees.
    pub surfaces: Surfaces,
    /// Light and haze; the sun's position is taken from [`FlightWorld::sun`].
    pub light: Light,
    /// Position of the sun.
    pub sun: Sun,
    /// Camera at the start; its z is absolute, in the world's frame.
    pub start: Camera,
    /// The world's name as it was given; `None` is the built-in world.
    pub world: Option<String>,
    /// The options of the world, for the imprints of pictures.
    pub more: More,
    /// The parts of the world that stay while exaggeration and trees change.
    pub lasting: Lasting,
    /// The scene of the world.
    pub scene: Scene,
    /// West and south, east and north of the heights, or of the model that is the world, in metres.
    pub data_corners_m: [DVec2; 2],
    /// The lowest and the highest surface of a model that is the world, in metres.
    pub model_heights_m: Option<[f64; 2]>,
}

/// The parts of a world that stay while its exaggeration and its trees change.
pub(crate) struct Lasting {
    /// The tiles without exaggeration.
    pub heights: Arc<dyn TileStore>,
    /// The forest of the scene, whether or not it is drawn.
    pub own_forest: Option<Forest>,
}

impl FlightWorld {
    /// Creates the world of a flight. `name` is the world's name as it was given, and `more` has its options; `start` is
    /// the first camera, and `lasting` is what stays while exaggeration and trees change.
    pub(crate) fn new(world: OpenWorld, start: Camera, name: Option<String>, more: More, lasting: Lasting) -> Self {
        let model_m = crate::world::lone_model::box_m(&world.scene, &world.surfaces);
        let of_data = || world.data_extent_m().map(|[west, south, east, north]| [[west, south], [east, north]]);
        let data_corners_m = match model_m {
            Some(corners_m) => corners_m.map(DVec3::truncate),
            None => {
                of_data().map_or_else(|| world.surfaces.terrain.corners_m(), |corners| corners.map(DVec2::from_array))
            }
        };
        Self {
            data_corners_m,
            model_heights_m: model_m.map(|corners_m| corners_m.map(|corner_m| corner_m.z)),
            name: crate::world::title_with_seed(name.as_deref(), more.seed),
            world: name,
            more,
            lasting,
            light: world.light(),
            sun: world.scene.sun,
            start,
            scene: world.scene,
            surfaces: world.surfaces,
        }
    }
}

impl FlightWorld {
    /// Returns the seed of the forest that is drawn, if there is one.
    fn tree_seed(&self) -> Option<u32> {
        self.scene.forest.as_ref().map(|forest| forest.seed)
    }

    /// Returns the controls of the panel for this land.
    fn land_panel(&self) -> LandPanel {
        let factor = self.surfaces.exaggeration();
        let range_m = self.surfaces.terrain.range_m().map(|height_m| f64::from(height_m) / factor);
        let refusal = self.scene.check_other_seed().err().map(|error| error.to_string());
        LandPanel::new(range_m, self.lasting.own_forest.as_ref(), refusal)
    }
}

/// Options of a flight; the panel can change most of them.
#[derive(Clone, Debug)]
pub(crate) struct FlightOptions {
    /// The name of the world for people.
    pub name: String,
    /// A preset or a style file.
    pub style: String,
    /// The camera path that is flown at the start: a file, or the name of a built-in path.
    pub path: Option<String>,
    /// The labels at the start.
    pub labels: LabelOptions,
    /// Initial size of the window.
    pub size_px: [u32; 2],
    /// The quality at the start.
    pub quality: Quality,
    /// The measured fronts that are used for their styles, in place of those of presets.
    pub fronts: Vec<Front>,
    /// Initial smoothing of edges.
    pub antialias: Antialias,
    /// The GPU to use.
    pub adapter: AdapterWish,
    /// Render continuously, and quit after this many frames.
    pub frames: Option<u64>,
    /// The settings that the last run has remembered.
    pub remembered: Remembered,
    /// Eyes shown initially.
    pub eyes: Eyes,
    /// Initial stereo pair.
    pub pair: Pair,
    /// Whether the distance between the eyes follows the distance to the nearest land.
    pub follows_land: bool,
    /// The files that a scene opened by the window may name.
    pub reach: Reach,
}

/// Opens a world on the GPU that can present to the window, on another thread than that of the window.
pub(crate) type OpenWorldFn = Box<dyn FnOnce(&Gpu) -> anyhow::Result<FlightWorld> + Send>;

/// The connection to the window system.
pub(crate) struct Windowing {
    events: EventLoop<()>,
}

impl Windowing {
    /// Connects to the window system.
    ///
    /// # Errors
    /// Returns [`WindowError::NoDisplay`] if there is none.
    pub(crate) fn new() -> Result<Self, WindowError> {
        let events = app::event_loop().map_err(|cause| WindowError::NoDisplay { cause })?;
        Ok(Self { events })
    }

    /// Returns the event loop, for a window that does not show a flight.
    #[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
    pub(crate) fn into_events(self) -> EventLoop<()> {
        self.events
    }

    /// Flies until the window is closed.
    ///
    /// # Errors
    /// Fails if the window, the GPU or the world cannot be opened, or if the GPU fails later.
    pub(crate) fn run(self, options: FlightOptions, open: OpenWorldFn) -> Result<(), WindowError> {
        app::run(self.events, options, open)
    }
}
