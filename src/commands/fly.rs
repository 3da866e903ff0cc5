//! `hachure fly`, and `hachure` alone: a window to fly over a world in, or with `--vr` a headset.

#[cfg(all(feature = "headset", any(target_os = "linux", target_os = "windows")))]
mod in_headset;
#[cfg(feature = "window")]
mod in_window;

use clap::Args;

use super::arguments;
use super::height_args::HeightArgs;
use super::light_args::LightArgs;
use super::render::parse_size;
use super::stereo_args::StereoArgs;
use super::water_args::WaterArgs;
use crate::frame::Antialias;
use crate::gpu::device::AdapterWish;
use crate::scene::camera::Camera;

/// Arguments of `fly`.
#[derive(Clone, Debug, Args)]
pub struct FlyArgs {
    /// Scene file, DEM, baked pyramid, or a scene inside hachure (continent, forest, hut); without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// How light falls.
    #[command(flatten)]
    pub light: LightArgs,
    /// Where water is.
    #[command(flatten)]
    pub water: WaterArgs,
    /// Let a scene file name files outside of its folder, and addresses
    #[arg(long)]
    pub trust_scene: bool,
    /// A preset or a style file
    #[arg(long, default_value = "ink")]
    pub style: String,
    /// Where to start: x,y,z,yaw,pitch,fov in metres (z as +h above ground) and degrees
    #[arg(long, allow_hyphen_values = true)]
    pub camera: Option<Camera>,
    /// Width and height of the window in pixels, like 1280x720
    #[arg(long, default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// How many eyes, and how they stand.
    #[command(flatten)]
    pub stereo: StereoArgs,
    /// How edges are smoothed: none, or temporal, by the mean of frames that follow each other
    #[arg(long, default_value = "temporal")]
    pub antialias: Antialias,
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: f64,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Fly in a headset, through OpenXR; --size and --adapter are the headset's then
    #[arg(long)]
    pub vr: bool,
    /// Render without rest, print the frame times, and quit after this many pictures
    #[arg(long, hide = true, value_parser = arguments::whole::<u64>(1, u64::MAX))]
    pub frames: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When there is no display or no headset, an input does not hold, or the GPU fails.
pub fn run(args: &FlyArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    if args.vr { in_headset::run(args) } else { in_window::run(args, adapter) }
}

/// A build without a window.
#[cfg(not(feature = "window"))]
mod in_window {
    /// Runs nothing.
    ///
    /// # Errors
    /// Always: a window is not part of this build.
    pub fn run(_args: &super::FlyArgs, _adapter: &super::AdapterWish) -> anyhow::Result<()> {
        anyhow::bail!(
            "this hachure was built without a window (the feature `window`); `hachure render` draws into a file"
        )
    }
}

/// A build without a headset.
#[cfg(not(all(feature = "headset", any(target_os = "linux", target_os = "windows"))))]
mod in_headset {
    /// Runs nothing.
    ///
    /// # Errors
    /// Always: a headset is not part of this build.
    pub fn run(_args: &super::FlyArgs) -> anyhow::Result<()> {
        anyhow::bail!(
            "--vr: this hachure was built without a headset (the feature `headset`, for Linux and Windows); `hachure \
             render --eyes side-by-side` draws both eyes into a file"
        )
    }
}
