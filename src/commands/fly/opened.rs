//! The world of a flight, opened before its window or headset and put onto the GPU that these use.

use std::sync::Arc;

use glam::DVec2;

use super::FlyArgs;
use crate::commands::place_args::{self, MapPlaceArgs};
use crate::gpu::Gpu;
use crate::pyramid::TileStore;
use crate::scene::camera::Camera;
use crate::scene::{Forest, Scene};
use crate::source::Progress;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::world::{self, OpenWorld};

/// A scene with the tiles of its land.
pub(super) struct OpenedWorld {
    scene: Scene,
    /// The scene's forest without `--trees`.
    #[cfg_attr(not(feature = "window"), expect(dead_code, reason = "only a window plants another forest"))]
    own_forest: Option<Forest>,
    /// The tiles without exaggeration.
    heights: Arc<dyn TileStore>,
    store: Arc<dyn TileStore>,
    /// The place to look at: east and north in metres.
    looked_at_m: Option<DVec2>,
}

impl OpenedWorld {
    /// Opens the world of the arguments. A DEM that is opened for the first time takes a while to bake.
    pub(super) fn new(args: &FlyArgs, progress: &dyn Progress) -> anyhow::Result<Self> {
        let (scene, own_forest) = args.world.scene_and_forest()?;
        place_args::check_procedural(&args.look, &MapPlaceArgs::default(), args.world.name(), &scene.world)?;
        let true_to_scale = Scene { vertical_exaggeration: 1.0, ..scene.clone() };
        let heights = world::open_store(&true_to_scale, progress).map_err(|error| args.world.or_drawing(error))?;
        let store = world::exaggerated(Arc::clone(&heights), scene.vertical_exaggeration);
        let looked_at_m = args.look.place_m(args.world.name(), &*store)?;
        Ok(Self { scene, own_forest, heights, store, looked_at_m })
    }

    /// Returns the tiles without exaggeration.
    #[cfg(feature = "window")]
    pub(super) fn heights(&self) -> Arc<dyn TileStore> {
        Arc::clone(&self.heights)
    }

    /// Returns the scene's forest without `--trees`.
    #[cfg(feature = "window")]
    pub(super) fn own_forest(&self) -> Option<Forest> {
        self.own_forest.clone()
    }

    /// Puts the world onto a GPU, and returns it with the camera at the start.
    pub(super) fn on_gpu(
        self,
        args: &FlyArgs,
        gpu: &Gpu,
        progress: &dyn Progress,
    ) -> anyhow::Result<(OpenWorld, Camera)> {
        let (lod_error_px, tile_memory_bytes) = (args.lod_error, args.tile_memory << 20);
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let mut world = OpenWorld::on_gpu_with(gpu, self.scene, self.store, options, progress)?;
        let [width, height] = args.size.unwrap_or(super::SIZE_PX);
        let aspect = f64::from(width) / f64::from(height);
        let start = match (args.camera, self.looked_at_m) {
            (Some(camera), _) => camera,
            (None, Some(place_m)) => args.look.camera(place_m, &world, aspect)?,
            (None, None) => world.start_camera(aspect),
        };
        args.world.light.place_sun(&mut world.scene.sun, &start);
        let start = start.on_ground(|east_m, north_m| world.ground_m(east_m, north_m));
        if let Err(error) = world.ground_was_read() {
            tracing::warn!("{error}");
        }
        Ok((world, start))
    }
}
