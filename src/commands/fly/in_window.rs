//! `fly` in a build with a window.

use super::opened::OpenedWorld;
use super::{FlyArgs, SIZE_PX, STYLE};
use crate::commands::arguments;
use crate::commands::progress::Bar;
use crate::commands::render::{self, like, names};
use crate::gpu::device::AdapterWish;
use crate::scene::reach::Reach;
use crate::window::remembered::Remembered;
use crate::window::{FlightOptions, FlightWorld, LabelOptions, Lasting, Windowing};
use crate::world::title;

/// Runs the command.
///
/// # Errors
/// Fails if there is no display, if an input is invalid, or if the GPU fails.
pub(super) fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    fly(args, adapter, None)
}

/// Runs the command with the world of the last flight. If that cannot be opened any more, a warning says why, and the
/// built-in world is opened.
///
/// # Errors
/// The errors of [`run`].
pub(super) fn run_again(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    fly(args, adapter, Remembered::open().world)
}

/// Flies; `last_world` is opened in place of the world of the arguments if it can be.
fn fly(args: &FlyArgs, adapter: &AdapterWish, last_world: Option<String>) -> anyhow::Result<()> {
    // Report errors before a window opens.
    args.stereo.check()?;
    if let Some(style) = &args.style {
        arguments::style(style)?;
    }
    args.world.check()?;
    if let Some(path) = &args.path {
        arguments::camera_path(path)?;
    }
    // The pictures of a run with a number of frames depend on its arguments alone.
    let remembered = if args.frames.is_none() { Remembered::open() } else { Remembered::default() };
    // The file of the last style may be gone.
    let last_style = remembered.style.clone().filter(|style| arguments::style(style).is_ok());
    let size_px = args.size.or(remembered.size_px).unwrap_or(SIZE_PX);
    let args = &FlyArgs { size: Some(size_px), ..args.clone() };
    let (quality, fronts) =
        super::quality::at_start(args, args.style.as_deref().or(last_style.as_deref()).unwrap_or(STYLE))?;
    let windowing = Windowing::new()?;
    // The world, too, is opened before the window: it may take a while.
    let (args, opened) = opened(args, last_world)?;
    let labels = LabelOptions {
        peaks: args.labels.peaks.filter(|peaks| *peaks > 0).map(|peaks| peaks as usize),
        places: names::places(&args.labels, &*opened.heights(), true)?,
    };
    let options = FlightOptions {
        quality,
        fronts,
        name: title(args.world.name()),
        labels,
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
    let (heights, own_forest) = (opened.heights(), opened.own_forest());
    let mut more = like::of_world(&args.world);
    more.tile_memory = Some(args.tile_memory).filter(|mib| *mib != render::TILE_MEMORY_MIB);
    let open = move |gpu: &crate::gpu::Gpu| {
        let (world, start) = opened.on_gpu(&args, gpu, &Bar::default())?;
        Ok(FlightWorld::new(world, start, args.world.name.clone(), more, Lasting { heights, own_forest }))
    };
    Ok(windowing.run(options, Box::new(open))?)
}

/// Opens the last world, or, if there is none or it cannot be opened, that of the arguments. Returns the arguments with
/// the name of the world.
fn opened(args: &FlyArgs, last_world: Option<String>) -> anyhow::Result<(FlyArgs, OpenedWorld)> {
    let mut again = args.clone();
    if last_world.is_some() {
        again.world.name = last_world;
        match again.world.check().and_then(|()| OpenedWorld::new(&again, &Bar::default())) {
            Ok(opened) => return Ok((again, opened)),
            Err(error) => tracing::warn!("{error:#}; that was the last world, so the built-in world is opened"),
        }
    }
    let opened = OpenedWorld::new(args, &Bar::default())?;
    Ok((args.clone(), opened))
}
