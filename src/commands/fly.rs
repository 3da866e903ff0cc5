//! `hachure fly`, and `hachure` alone: a window to fly over a world in.

#[cfg(feature = "window")]
mod in_window;

use clap::Args;

use super::arguments;
use super::height_args::HeightArgs;
use super::render::parse_size;
use super::stereo_args::StereoArgs;
use crate::scene::camera::Camera;

/// Arguments of `fly`.
#[derive(Clone, Debug, Args)]
pub struct FlyArgs {
    /// Scene file, DEM, baked pyramid, or a scene inside hachure (continent, hut); without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
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
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: f64,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Render without rest, print the frame times, and quit after this many pictures
    #[arg(long, hide = true, value_parser = arguments::whole::<u64>(1, u64::MAX))]
    pub frames: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When there is no display, an input does not hold, or the GPU fails.
#[cfg(feature = "window")]
pub use in_window::run;

/// Runs nothing.
///
/// # Errors
/// Always: a window is not part of this build.
#[cfg(not(feature = "window"))]
pub fn run(_args: &FlyArgs, _adapter: &crate::gpu::device::AdapterWish) -> anyhow::Result<()> {
    anyhow::bail!("this hachure was built without a window (the feature `window`); `hachure render` draws into a file")
}
