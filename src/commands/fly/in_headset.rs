//! `fly --vr` in a build with OpenXR.

use super::FlyArgs;
use super::opened::OpenedWorld;
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::headset::{self, HeadsetOptions, HeadsetWorld, Runtime};
use crate::scene::stereo::Eyes;

/// Runs the command.
///
/// # Errors
/// Fails if there is no headset, if an input is invalid, or if the GPU fails.
pub(super) fn run(args: &FlyArgs) -> anyhow::Result<()> {
    if args.stereo.eyes() != Eyes::Mono || args.stereo.ipd.is_some() || args.stereo.convergence.is_some() {
        return Err(
            Misuse("--vr: the headset determines the eyes; leave out --eyes, --ipd and --convergence".into()).into()
        );
    }
    // Report errors before the world is baked.
    let style = args.style.as_deref().unwrap_or(super::STYLE);
    arguments::style(style)?;
    args.world.check()?;
    let runtime = Runtime::connect()?;
    let opened = OpenedWorld::new(args)?;
    let options = HeadsetOptions { style: style.to_owned(), antialias: args.antialias, frames: args.frames };
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu| {
        let (world, start) = opened.on_gpu(&args, gpu)?;
        Ok(HeadsetWorld { light: world.light(), start, surfaces: world.surfaces })
    };
    Ok(headset::fly(runtime, &options, open)?)
}
