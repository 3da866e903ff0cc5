//! `hachure fly`, and `hachure` alone: flies over a world in a window, or with `--vr` in a headset.

#[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
mod in_headset;
#[cfg(feature = "window")]
mod in_window;
#[cfg(any(feature = "window", all(feature = "headset", any(target_os = "linux", target_os = "windows"))))]
mod opened;
#[cfg(any(feature = "window", all(feature = "headset", any(target_os = "linux", target_os = "windows"))))]
mod quality;

use std::path::PathBuf;

use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use super::place_args::LookArgs;
use super::quality_args::QualityArgs;
use super::render::names::NamesArgs;
use super::render::parse_size;
use super::stereo_args::StereoArgs;
use super::world_args::WorldArgs;
use crate::frame::Antialias;
use crate::gpu::device::AdapterWish;
use crate::scene::camera::Camera;
use crate::scene::ranges;
use crate::scene::stereo::Eyes;

/// Arguments of `fly`.
#[derive(Clone, Debug, Args)]
pub(crate) struct FlyArgs {
    /// The world that is drawn.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Preset (`hachure styles` lists them) or style file [default: the style of the last flight, at first ink]
    #[arg(long)]
    pub style: Option<String>,
    /// Camera at the start: x,y,z,yaw,pitch,fov. x, y: metres east and north of the centre of the world; z: height in
    /// metres, or +h above the ground; yaw: degrees clockwise from north; pitch: degrees above the horizon; fov: vertical
    /// field of view in degrees [default: the scene's, or a view of the most prominent summit]
    #[arg(long, allow_hyphen_values = true)]
    pub camera: Option<Camera>,
    /// Fly along a camera path at the start: a CSV file with the header t,x,y,z,yaw,pitch,fov, or a built-in path (tour,
    /// valley, teleport, ascent)
    #[arg(long, conflicts_with = "vr")]
    pub path: Option<PathBuf>,
    /// The place that the camera looks at in the beginning.
    #[command(flatten)]
    pub look: LookArgs,
    /// Size of the window in pixels [default: that of the last flight, at first 1280x720]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Which eyes are drawn.
    #[command(flatten)]
    pub stereo: StereoArgs,
    /// Smoothing of edges: none, or temporal (the mean of consecutive frames)
    #[arg(long, default_value = "temporal")]
    pub antialias: Antialias,
    /// Largest error of the drawn surface, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::within(ranges::LOD_ERROR_PX), allow_hyphen_values = true)]
    pub lod_error: f64,
    /// The labels over the picture; a key shows and hides them.
    #[command(flatten)]
    pub labels: NamesArgs,
    /// How exactly the picture is drawn.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// Hold the time of a frame on the GPU, in milliseconds (11.1 for 90 frames a second): with the most expensive setting of
    /// the style's measured front that is predicted to fit, or, for a style without one, with a lower resolution
    #[arg(long, value_name = "MS", conflicts_with = "quality", value_parser = arguments::budget_ms, allow_hyphen_values = true)]
    pub budget: Option<f64>,
    /// Memory for heights on the GPU, and as much again in main memory, in MiB; styles with shadows or water need a
    /// quarter more on the GPU for maps of the same tiles, and styles with both a half more
    #[arg(long, default_value_t = 512, value_parser = arguments::whole_within::<u64>(ranges::TILE_MEMORY_MIB))]
    pub tile_memory: u64,
    /// Fly in a headset, through OpenXR, which then determines the size and the GPU
    #[arg(long)]
    pub vr: bool,
    /// Render continuously, print the frame times, and quit after this many frames
    #[arg(long, hide = true, value_parser = arguments::whole::<u64>(1, u64::MAX))]
    pub frames: Option<u64>,
}

/// The style of the first flight.
const STYLE: &str = "ink";
/// The size of the window of the first flight.
const SIZE_PX: [u32; 2] = [1280, 720];

/// Runs the command.
///
/// # Errors
/// Fails if there is no display or no headset, if an input is invalid, or if the GPU fails.
pub(crate) fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    args.labels.check()?;
    if args.vr && !args.labels.is_empty() {
        let option = args.labels.option();
        return Err(Misuse(format!("{option}: a headset has no labels yet; leave out the option or --vr")).into());
    }
    if !args.labels.is_empty() && matches!(args.stereo.eyes(), Eyes::Anaglyph | Eyes::GreyAnaglyph) {
        let option = args.labels.option();
        tracing::warn!(
            "{option}: an anaglyph in a window has no labels; they appear when Eyes in the panel is set to another pair"
        );
    }
    if args.vr { in_headset::run(args) } else { in_window::run(args, adapter) }
}

/// Runs `hachure` alone. If the arguments name no world and have no option that is for one world, the world of the last
/// flight is opened; otherwise this is [`run`].
///
/// # Errors
/// The errors of [`run`].
pub(crate) fn run_again(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let has_place = args.camera.is_some() || args.path.is_some() || args.look.look_at.is_some();
    let again =
        args.world.name.is_none() && args.labels.names.is_none() && !has_place && !args.vr && args.frames.is_none();
    if again { in_window::run_again(args, adapter) } else { run(args, adapter) }
}

/// Replaces `in_window` in a build without a window.
#[cfg(not(feature = "window"))]
mod in_window {
    /// Returns an error.
    ///
    /// # Errors
    /// Always fails: this build has no window.
    pub(super) fn run(_args: &super::FlyArgs, _adapter: &super::AdapterWish) -> anyhow::Result<()> {
        anyhow::bail!(
            "this build of hachure has no window (feature `window`); use `hachure render` to draw into a file"
        )
    }

    pub(super) use run as run_again;
}

/// Replaces `in_headset` in a build without a headset.
#[cfg(not(all(feature = "headset", any(target_os = "linux", target_os = "windows"))))]
mod in_headset {
    /// Returns an error.
    ///
    /// # Errors
    /// Always fails: this build has no headset.
    pub(super) fn run(_args: &super::FlyArgs) -> anyhow::Result<()> {
        anyhow::bail!(
            "--vr: this build of hachure has no headset (feature `headset`, Linux and Windows only); use `hachure \
             render --eyes side-by-side` to draw both eyes into a file"
        )
    }
}
