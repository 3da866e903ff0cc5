//! `fly` in a build with a window.

use std::path::Path;

use super::FlyArgs;
use crate::commands::{arguments, progress};
use crate::gpu::device::AdapterWish;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::window::{FlightOptions, FlightWorld, Windowing};
use crate::world::{self, OpenWorld};

/// Runs the command.
///
/// # Errors
/// Fails if there is no display, if an input is invalid, or if the GPU fails.
pub fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    // Report errors before a window opens.
    args.stereo.check()?;
    arguments::style(&args.style)?;
    args.world.check()?;
    let windowing = Windowing::new()?;
    let options = FlightOptions {
        style: args.style.clone(),
        size_px: args.size,
        adapter: adapter.clone(),
        frames: args.frames,
        eyes: args.stereo.eyes(),
        antialias: args.antialias,
        // The usual distance between human eyes until land is loaded.
        pair: args.stereo.pair(f64::INFINITY).unwrap_or_default(),
        follows_land: args.stereo.asks_for_nearest(),
    };
    // Also before the window opens: a DEM that is opened for the first time takes a while to bake.
    let scene = args.world.scene()?;
    let store = world::open_store(&scene, &progress::Bar::default())?;
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu| {
        let (lod_error_px, tile_memory_bytes) = (args.lod_error, args.tile_memory << 20);
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let mut world = OpenWorld::on_gpu_with(gpu, scene, store, options, &progress::Bar::default())?;
        let start = args.camera.unwrap_or_else(|| world.default_camera());
        args.world.light.beside(&mut world.scene.sun, &start);
        let start = start.on_ground(|east_m, north_m| world.ground_m(east_m, north_m));
        if let Err(error) = world.ground_was_read() {
            tracing::warn!("{error}");
        }
        Ok(FlightWorld {
            name: title(args.world.name()),
            light: world.light(),
            sun: world.scene.sun,
            start,
            surfaces: world.surfaces,
        })
    };
    Ok(windowing.run(options, Box::new(open))?)
}

/// Returns the title of the window: the name of the world's file without its folder.
fn title(world: Option<&str>) -> String {
    let Some(world) = world else { return "the embedded world".to_owned() };
    Path::new(world).file_name().map_or_else(|| world.to_owned(), |name| name.to_string_lossy().into_owned())
}
