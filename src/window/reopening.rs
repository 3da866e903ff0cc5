//! Reads the land again with another exaggeration, or with trees whose files have not been read, in the background,
//! while the window shows the current land.

use std::sync::Arc;

use super::background::{Background, NoResult};
use super::other_world::settle;
use crate::frame::Light;
use crate::gpu::Gpu;
use crate::pyramid::TileStore;
use crate::scene::view::Rig;
use crate::scene::{Forest, Scene};
use crate::source::Silent;
use crate::style::Style;
use crate::tiles::terrain::TerrainOptions;
use crate::world::{OpenWorld, Surfaces, exaggerated};

/// The window and the view for which the land is read.
pub(super) struct LandToRead {
    /// The device of the window.
    pub gpu: Gpu,
    /// The scene, with the new exaggeration and forest.
    pub scene: Scene,
    /// The tiles without exaggeration.
    pub heights: Arc<dyn TileStore>,
    /// The options of the window's terrain.
    pub options: TerrainOptions,
    /// The view whose tiles are loaded.
    pub rig: Rig,
    /// The style in which it is drawn.
    pub style: Style,
    /// The light in which it is drawn.
    pub light: Light,
}

/// A land that is being read.
pub(super) struct Reopening {
    /// The exaggeration of the land: the factor on its heights.
    pub factor: f64,
    /// The forest of the scene, without exaggeration.
    pub forest: Option<Forest>,
    done: Background<Result<Surfaces, String>>,
}

impl Reopening {
    /// Begins to read the land, and calls `wake` when it has been read.
    pub(super) fn start(to_read: LandToRead, wake: impl Fn() + Send + 'static) -> Self {
        let factor = to_read.scene.vertical_exaggeration;
        let forest = to_read.scene.forest.clone();
        Self { factor, forest, done: Background::start("heights", move || read(to_read), wake) }
    }

    /// Takes the land, or why it could not be read; `None` while it is being read.
    pub(super) fn take(&self) -> Option<Result<Surfaces, String>> {
        let done = self.done.take()?;
        Some(done.unwrap_or_else(|NoResult| Err("the heights could not be read again".to_owned())))
    }
}

fn read(to_read: LandToRead) -> Result<Surfaces, String> {
    let LandToRead { gpu, scene, heights, options, rig, style, light } = to_read;
    let store = exaggerated(heights, scene.vertical_exaggeration);
    let world = OpenWorld::on_gpu_with(&gpu, scene, store, options, &Silent).map_err(|error| error.to_string())?;
    let mut surfaces = world.surfaces;
    // The first picture must not be coarser than the last one.
    settle(&gpu, &mut surfaces, &rig, &style, &light, || false);
    Ok(surfaces)
}
