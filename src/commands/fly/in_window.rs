//! `fly` in a build with a window.

use super::opened::OpenedWorld;
use super::{FlyArgs, SIZE_PX, STYLE};
use crate::commands::arguments;
use crate::commands::progress::Bar;
use crate::commands::render::{self, like};
use crate::gpu::device::AdapterWish;
use crate::scene::reach::Reach;
use crate::window::remembered::Remembered;
use crate::window::{FlightOptions, FlightWorld, Windowing};
use crate::world::title;

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
    if let Some(path) = &args.path {
        arguments::camera_path(path)?;
    }
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
        path: args.path.as_ref().map(|path| path.to_string_lossy().into_owned()),
        size_px,
        adapter: adapter.clone(),
        frames: args.frames,
        remembered,
        eyes: args.stereo.eyes(),
        antialias: args.antialias,
        // The usual distance between human eyes until land is loaded.
        pair: args.stereo.pair(f64::INFINITY).unwrap_or_default(),
        follows_land: args.stereo.requests_nearest(),
        reach: Reach::trusting(args.world.trust_scene),
    };
    // Also before the window opens: it may take a while.
    let opened = OpenedWorld::new(args, &Bar::default())?;
    let heights = opened.heights();
    let mut more = like::of_world(&args.world);
    more.tile_memory = Some(args.tile_memory).filter(|mib| *mib != render::TILE_MEMORY_MIB);
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu| {
        let (world, start) = opened.on_gpu(&args, gpu, &Bar::default())?;
        Ok(FlightWorld::new(world, start, args.world.name.clone(), more, heights))
    };
    Ok(windowing.run(options, Box::new(open))?)
}
