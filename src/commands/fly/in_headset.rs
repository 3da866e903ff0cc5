//! `fly --vr` in a build with OpenXR.

use std::sync::atomic::AtomicBool;

use super::FlyArgs;
use super::opened::OpenedWorld;
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::commands::progress::Bar;
use crate::headset::{self, HeadsetOptions, HeadsetWorld, Runtime};
use crate::scene::stereo::Eyes;
use crate::source::Progress;

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
    let (quality, fronts) = super::quality::at_start(args, style)?;
    let runtime = Runtime::connect()?;
    let options = HeadsetOptions {
        name: crate::world::title(args.world.name()),
        style: style.to_owned(),
        antialias: args.antialias,
        lod_error_px: args.lod_error,
        quality,
        fronts,
        frames: args.frames,
    };
    let args = args.clone();
    let open = move |gpu: &crate::gpu::Gpu, progress: &dyn Progress| {
        let progress = &Both(Bar::default(), progress);
        let (world, start) = OpenedWorld::new(&args, progress)?.on_gpu(&args, gpu, progress)?;
        Ok(HeadsetWorld { light: world.light(), start, surfaces: world.surfaces })
    };
    Ok(headset::fly(runtime, options, Box::new(open))?)
}

/// Reports progress on the terminal and in the headset.
struct Both<'a>(Bar, &'a dyn Progress);

impl Progress for Both<'_> {
    fn report(&self, what: &str, done: f32) {
        self.0.report(what, done);
        self.1.report(what, done);
    }

    fn stop(&self) -> &AtomicBool {
        self.1.stop()
    }
}
