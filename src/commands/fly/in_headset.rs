//! `fly --vr` in a build with OpenXR.

use super::FlyArgs;
use crate::commands::misuse::Misuse;
use crate::commands::{arguments, progress};
use crate::headset::{self, HeadsetOptions, HeadsetWorld, Runtime};
use crate::scene::stereo::Eyes;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::world::{self, OpenWorld};

/// Runs the command.
///
/// # Errors
/// Fails if there is no headset, if an input is invalid, or if the GPU fails.
pub fn run(args: &FlyArgs) -> anyhow::Result<()> {
    if args.stereo.eyes() != Eyes::Mono || args.stereo.ipd.is_some() || args.stereo.convergence.is_some() {
        return Err(
            Misuse("--vr: the headset determines the eyes; leave out --eyes, --ipd and --convergence".into()).into()
        );
    }
    // Report errors before the world is baked.
    arguments::style(&args.style)?;
    args.world.check()?;
    let runtime = Runtime::connect()?;
    let scene = args.world.scene()?;
    let store = world::open_store(&scene, &progress::Bar::default())?;
    let options = HeadsetOptions { style: args.style.clone(), antialias: args.antialias, frames: args.frames };
    let (lod_error_px, tile_memory_bytes) = (args.lod_error, args.tile_memory << 20);
    let (start, light) = (args.camera, args.world.light);
    let open = move |gpu: &crate::gpu::Gpu| {
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let mut world = OpenWorld::on_gpu_with(gpu, scene, store, options, &progress::Bar::default())?;
        let start = start.unwrap_or_else(|| world.default_camera());
        light.beside(&mut world.scene.sun, &start);
        let start = start.on_ground(|east_m, north_m| world.ground_m(east_m, north_m));
        if let Err(error) = world.ground_was_read() {
            tracing::warn!("{error}");
        }
        Ok(HeadsetWorld { light: world.light(), start, surfaces: world.surfaces })
    };
    Ok(headset::fly(runtime, &options, open)?)
}
