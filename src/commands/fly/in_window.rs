//! `fly` in a build with a window.

use std::path::Path;

use glam::DVec2;

use super::opened::OpenedWorld;
use super::{FlyArgs, SIZE_PX, STYLE};
use crate::commands::arguments;
use crate::commands::render::{self, like};
use crate::gpu::device::AdapterWish;
use crate::window::remembered::Remembered;
use crate::window::{FlightOptions, FlightWorld, Windowing};

/// Runs the command.
///
/// # Errors
/// Fails if there is no display, if an input is invalid, or if the GPU fails.
pub(super) fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    // Report errors before a window opens.
    args.stereo.check()?;
    if let Some(style) = &args.style {
        arguments::style(style)?;
    }
    args.world.check()?;
    // What a run with a number of frames draws depends on its arguments alone.
    let remembered = if args.frames.is_none() { Remembered::open() } else { Remembered::default() };
    // The file of the last style may be gone.
    let last_style = remembered.style.clone().filter(|style| arguments::style(style).is_ok());
    let size_px = args.size.or(remembered.size_px).unwrap_or(SIZE_PX);
    let args = &FlyArgs { size: Some(size_px), ..args.clone() };
    let windowing = Windowing::new()?;
    let options = FlightOptions {
        name: title(args.world.name()),
        style: args.style.clone().or(last_style).unwrap_or_else(|| STYLE.to_owned()),
        size_px,
        adapter: adapter.clone(),
        frames: args.frames,
        remembered,
        eyes: args.stereo.eyes(),
        antialias: args.antialias,
        // The usual distance between human eyes until land is loaded.
        pair: args.stereo.pair(f64::INFINITY).unwrap_or_default(),
        follows_land: args.stereo.requests_nearest(),
    };
    // Also before the window opens: it may take a while.
    let opened = OpenedWorld::new(args)?;
    let heights = opened.heights();
    let mut more = like::of_world(&args.world);
    more.tile_memory = Some(args.tile_memory).filter(|mib| *mib != render::TILE_MEMORY_MIB);
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu| {
        let (world, start) = opened.on_gpu(&args, gpu)?;
        let data_m = world.data_extent_m();
        let data_corners_m = data_m
            .map(|[west, south, east, north]| [DVec2::new(west, south), DVec2::new(east, north)])
            .unwrap_or_else(|| world.surfaces.terrain.corners_m());
        Ok(FlightWorld {
            data_corners_m,
            world: args.world.name.clone(),
            more,
            heights,
            scene: world.scene.clone(),
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
    let Some(world) = world else { return "the built-in world".to_owned() };
    Path::new(world).file_name().map_or_else(|| world.to_owned(), |name| name.to_string_lossy().into_owned())
}
